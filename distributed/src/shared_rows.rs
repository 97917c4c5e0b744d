//! Rows of a matrix to which several processes contribute: each sends what it has of rows that others keep.

use crate::error::PetscError;
use crate::local_matrix::LocalMatrix;
use crate::node_rows::NodeRows;
use crate::petsc::Index;
use crate::world::World;

/// Numbers that tell the exchanges of lengths, positions and values apart from others.
const LENGTHS: u64 = u64::MAX;
const POSITIONS: u64 = u64::MAX - 1;
const VALUES: u64 = u64::MAX - 2;

/// The rows that this process has in common with some others.
#[derive(Debug, Default)]
pub(crate) struct SharedRows {
    with: Vec<Neighbour>,
}

/// Another process, with the rows that go to it and those that come from it.
#[derive(Debug)]
struct Neighbour {
    rank: usize,
    /// Rows of the local matrix that it keeps, and the number of their entries.
    sent: Vec<u32>,
    entries: usize,
    /// Its contributions to rows that this process keeps, in ascending rows: places in the lists of columns and values.
    rows: Vec<(Index, usize)>,
    columns: Vec<Index>,
    values: Vec<f64>,
}

impl SharedRows {
    /// Agreement on the positions of what goes from process to process.
    pub fn new(world: &World, nodes: &NodeRows, local: &LocalMatrix<'_>) -> Result<Self, PetscError> {
        let starts = world.gather(nodes.rows.own.start as u64)?;
        let keeper = |row: Index| starts.partition_point(|start| *start <= row as u64) - 1;
        let ranks: Vec<usize> = match &nodes.divided {
            Some(divided) => divided.neighbours(),
            None => (0..world.size()).filter(|rank| *rank != world.rank()).collect(),
        };
        let mut sent: Vec<Vec<u32>> = vec![vec![]; world.size()];
        for (row, place) in nodes.places.iter().enumerate() {
            if !nodes.rows.own.contains(&(*place as usize)) {
                sent[keeper(*place)].push(row as u32);
            }
        }
        // By place, as the process that keeps them goes through them.
        sent.iter_mut().for_each(|rows| rows.sort_unstable_by_key(|row| nodes.places[*row as usize]));
        let mut lists = vec![];
        for rank in &ranks {
            let mut words = vec![];
            for row in &sent[*rank] {
                let start = words.len();
                words.extend([nodes.places[*row as usize] as u64, 0]);
                local.visit_row(*row as usize, |column, _| words.push(nodes.places[column as usize] as u64));
                words[start + 1] = (words.len() - start - 2) as u64;
            }
            lists.push((*rank, words));
        }
        let lengths = lists.iter().map(|(rank, words)| (*rank, vec![words.len() as u64])).collect();
        let lengths = world.meetings().exchange(LENGTHS, lengths, &vec![1; ranks.len()])?;
        let lengths: Vec<usize> = lengths.into_iter().map(|length| length[0] as usize).collect();
        // Two that send nothing to each other have nothing in common.
        let common = lists.into_iter().zip(lengths).filter(|((_, words), length)| words.len() + length > 0);
        let (lists, lengths): (Vec<_>, Vec<_>) = common.unzip();
        let entries: Vec<usize> =
            lists.iter().map(|(rank, words)| words.len() - 2 * sent[*rank].len()).collect();
        let ranks: Vec<usize> = lists.iter().map(|(rank, _)| *rank).collect();
        let found = world.meetings().exchange(POSITIONS, lists, &lengths)?;
        let mut with = vec![];
        for ((rank, entries), words) in ranks.into_iter().zip(entries).zip(found) {
            let (mut rows, mut columns, mut rest) = (vec![], vec![], &words[..]);
            while let [row, count, later @ ..] = rest {
                let (own, later) = later.split_at(*count as usize);
                rows.push((*row as Index, columns.len()));
                columns.extend(own.iter().map(|column| *column as Index));
                rest = later;
            }
            let (sent, values) = (std::mem::take(&mut sent[rank]), vec![]);
            with.push(Neighbour { rank, sent, entries, rows, columns, values });
        }
        with.sort_unstable_by_key(|one| one.rank);
        Ok(SharedRows { with })
    }

    /// Sends what this process has of others' rows, and receives what others have of its own.
    pub fn exchange(&mut self, world: &World, local: &LocalMatrix<'_>) -> Result<(), PetscError> {
        let mut lists = vec![];
        for one in &self.with {
            let mut words = Vec::with_capacity(one.entries);
            for row in &one.sent {
                local.visit_row(*row as usize, |_, value| words.push(value.to_bits()));
            }
            lists.push((one.rank, words));
        }
        let lengths: Vec<usize> = self.with.iter().map(|one| one.columns.len()).collect();
        let found = world.meetings().exchange(VALUES, lists, &lengths)?;
        for (one, words) in self.with.iter_mut().zip(found) {
            one.values = words.into_iter().map(f64::from_bits).collect();
        }
        Ok(())
    }

    /// Contributions to a row from the processes that are asked for, in the order of ranks. Values are zero before the first exchange.
    pub fn visit(&self, row: Index, is_asked: impl Fn(usize) -> bool, entries: &mut Vec<(Index, f64)>) {
        for one in self.with.iter().filter(|one| is_asked(one.rank)) {
            if let Ok(found) = one.rows.binary_search_by_key(&row, |(row, _)| *row) {
                let end = one.rows.get(found + 1).map_or(one.columns.len(), |(_, start)| *start);
                let places = one.rows[found].1..end;
                let value = |place: usize| one.values.get(place).copied().unwrap_or(0.0);
                entries.extend(places.map(|place| (one.columns[place], value(place))));
            }
        }
    }
}

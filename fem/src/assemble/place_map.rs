//! Where the blocks of element matrices stand in their rows, looked up once per pair of spaces.

use std::ops::Range;

use crate::element::CellShape;
use crate::linear_algebra::BlockRows;

/// A place in a row of blocks.
pub(super) trait Place: Copy + Send + Sync + 'static {
    fn index(self) -> usize;
}

impl Place for u8 {
    fn index(self) -> usize {
        self.into()
    }
}

impl Place for u16 {
    fn index(self) -> usize {
        self.into()
    }
}

impl Place for u32 {
    fn index(self) -> usize {
        self as usize
    }
}

/// Places in the smallest type that holds those of the longest row.
#[derive(Clone, Debug)]
pub(super) enum Places {
    Bytes(Vec<u8>),
    Words(Vec<u16>),
    Long(Vec<u32>),
}

impl Places {
    fn new(count: usize, longest_row: usize) -> Self {
        match longest_row {
            0..=0x100 => Places::Bytes(vec![0; count]),
            0x101..=0x1_0000 => Places::Words(vec![0; count]),
            _ => Places::Long(vec![0; count]),
        }
    }

    fn set(&mut self, range: Range<usize>, places: impl Iterator<Item = u32>) {
        match self {
            Places::Bytes(all) => all[range].iter_mut().zip(places).for_each(|(to, place)| *to = place as u8),
            Places::Words(all) => {
                all[range].iter_mut().zip(places).for_each(|(to, place)| *to = place as u16)
            }
            Places::Long(all) => all[range].iter_mut().zip(places).for_each(|(to, place)| *to = place),
        }
    }
}

/// For cells that take part, walked in some order, and each of their pairs of a test and a trial node: the place of
/// the pair's block in the row of the test node.
#[derive(Clone, Debug)]
pub(super) struct PlaceMap {
    /// Shape after shape, `[cell in the walk of those of its shape][test node][trial node]`.
    pub places: Places,
    /// Where the places of the cells of each shape begin.
    pub starts: Vec<(CellShape, usize)>,
    /// Of each cell of the mesh, where it comes in the walk of those of its shape; [`PlaceMap::ABSENT`] for those that
    /// take no part.
    pub walk: Vec<u32>,
}

impl PlaceMap {
    pub const ABSENT: u32 = u32::MAX;

    /// Where the places of the cells of a shape begin.
    pub fn start(&self, shape: CellShape) -> usize {
        self.starts.iter().find(|(known, _)| *known == shape).map_or(0, |(_, start)| *start)
    }

    /// Bytes.
    pub fn memory(&self) -> usize {
        let places = match &self.places {
            Places::Bytes(places) => size_of_val(&places[..]),
            Places::Words(places) => size_of_val(&places[..]),
            Places::Long(places) => size_of_val(&places[..]),
        };
        places + size_of_val(&self.walk[..])
    }
}

/// Sets of test and trial nodes that are all coupled with each other.
pub(super) struct Cliques<'a> {
    /// Test nodes, set after set.
    pub rows: Vec<&'a [u32]>,
    /// Trial nodes of each set.
    pub columns: Vec<&'a [u32]>,
}

/// The blocks of the pairs in the cliques; and for the first `mapped` cliques the places of their pairs, clique after
/// clique.
pub(super) fn couple(
    cliques: &Cliques,
    (row_nodes, column_nodes): (usize, usize),
    mapped: usize,
) -> (BlockRows, Places) {
    if cliques.rows.is_empty() {
        return (BlockRows::default(), Places::new(0, 0));
    }
    // The cliques of each row node, with the node's place in them.
    let mut starts = vec![0_usize; row_nodes + 1];
    for &node in cliques.rows.iter().flat_map(|nodes| *nodes) {
        starts[node as usize + 1] += 1;
    }
    for node in 0..row_nodes {
        starts[node + 1] += starts[node];
    }
    let mut around = vec![(0_u32, 0_u32); starts[row_nodes]];
    for (clique, nodes) in cliques.rows.iter().enumerate() {
        for (place, &node) in nodes.iter().enumerate() {
            let next = &mut starts[node as usize];
            around[*next] = (clique as u32, place as u32);
            *next += 1;
        }
    }
    // Each start has moved to its successor.
    let around_node = |node: usize| {
        let start = if node == 0 { 0 } else { starts[node - 1] };
        &around[start..starts[node]]
    };
    let mut pointers = Vec::with_capacity(row_nodes + 1);
    pointers.push(0);
    let mut columns: Vec<u32> = Vec::new();
    let mut seen_by = vec![u32::MAX; column_nodes];
    for node in 0..row_nodes {
        let start = columns.len();
        for &(clique, _) in around_node(node) {
            for &column in cliques.columns[clique as usize] {
                if std::mem::replace(&mut seen_by[column as usize], node as u32) != node as u32 {
                    columns.push(column);
                }
            }
        }
        columns[start..].sort_unstable();
        pointers.push(columns.len());
    }
    columns.shrink_to_fit();
    let blocks = BlockRows::new(pointers, columns);
    // Where the places of each clique begin.
    let mut begins = Vec::with_capacity(mapped + 1);
    begins.push(0);
    for (rows, columns) in cliques.rows.iter().zip(&cliques.columns).take(mapped) {
        begins.push(begins[begins.len() - 1] + rows.len() * columns.len());
    }
    let mut places = Places::new(begins[mapped], blocks.longest_row());
    let mut place_of = seen_by;
    for node in 0..row_nodes {
        for (place, &column) in blocks.row(node).iter().enumerate() {
            place_of[column as usize] = place as u32;
        }
        for &(clique, i) in around_node(node) {
            if (clique as usize) < mapped {
                let columns = cliques.columns[clique as usize];
                let start = begins[clique as usize] + i as usize * columns.len();
                let row = columns.iter();
                places.set(start..start + columns.len(), row.map(|column| place_of[*column as usize]));
            }
        }
    }
    (blocks, places)
}

//! The positions of a block matrix: pairs of nodes, for each pair of a test and a trial space.

mod block_rows;

use std::ops::Range;
use std::sync::{Arc, LazyLock, OnceLock};

pub use block_rows::{BlockRows, NodeSet};

use super::cells::Cells;
use super::error::{LinearAlgebraError, check_size};
use super::pattern::SparsityPattern;

/// The entries that a [`super::BlockMatrix`] has: over the unknowns of some row sets and some column sets, blocks
/// of row components × column components at pairs of nodes.
#[derive(Debug)]
pub struct BlockSparsity {
    rows: Vec<NodeSet>,
    columns: Vec<NodeSet>,
    /// Row set after row set.
    pairs: Vec<BlockRows>,
    entries: usize,
    pattern: OnceLock<Arc<SparsityPattern>>,
    cells: Option<LazyLock<Arc<Cells>, MakeCells>>,
}

/// Makes cells when they are first asked for.
type MakeCells = Box<dyn FnOnce() -> Arc<Cells> + Send + Sync>;

impl PartialEq for BlockSparsity {
    fn eq(&self, other: &Self) -> bool {
        (&self.rows, &self.columns, &self.pairs) == (&other.rows, &other.columns, &other.pairs)
    }
}

impl BlockSparsity {
    /// From the row sets, the column sets, and the blocks of each pair: `pairs[row set][column set]`.
    ///
    /// # Errors
    /// If sizes disagree or pass 32 bits, a column node does not exist, or a row is not strictly ascending.
    pub fn new(
        rows: Vec<NodeSet>,
        columns: Vec<NodeSet>,
        pairs: Vec<Vec<BlockRows>>,
    ) -> Result<Self, LinearAlgebraError> {
        check_size("the list of rows of pairs", rows.len(), pairs.len())?;
        for (row, pairs) in rows.iter().zip(&pairs) {
            check_size("a row of pairs", columns.len(), pairs.len())?;
            for (column, pair) in columns.iter().zip(pairs) {
                pair.check(row, column)?;
            }
        }
        Self::of_checked(rows, columns, pairs)
    }

    /// Positions from blocks that are known to fit: as many pairs as sets, rows strictly ascending.
    ///
    /// # Errors
    /// If sizes pass 32 bits.
    #[doc(hidden)]
    pub fn of_checked(
        rows: Vec<NodeSet>,
        columns: Vec<NodeSet>,
        pairs: Vec<Vec<BlockRows>>,
    ) -> Result<Self, LinearAlgebraError> {
        let mut all = Vec::new();
        let mut entries = 0;
        for (row, pairs) in rows.iter().zip(pairs) {
            for (column, mut pair) in columns.iter().zip(pairs) {
                pair.block = row.components * column.components;
                pair.first_value = entries;
                entries += pair.blocks() * pair.block;
                all.push(pair);
            }
        }
        let pattern = OnceLock::new();
        let sparsity = BlockSparsity { rows, columns, pairs: all, entries, pattern, cells: None };
        if u32::try_from(sparsity.row_count().max(sparsity.column_count())).is_err() {
            return Err(LinearAlgebraError::TooLarge { what: "the set of rows or columns" });
        }
        Ok(sparsity)
    }

    /// These positions with the cells whose unknowns they couple.
    ///
    /// # Errors
    /// If a cell has an unknown that is none of the rows or columns.
    pub fn with_cells(self, cells: Cells) -> Result<Self, LinearAlgebraError> {
        cells.check(self.row_count().min(self.column_count()))?;
        Ok(self.with_cells_made_by(move || cells))
    }

    /// These positions with cells that are computed on first use: only orderings read them. All of their unknowns must be
    /// rows and columns.
    #[doc(hidden)]
    pub fn with_cells_made_by(self, make: impl FnOnce() -> Cells + Send + Sync + 'static) -> Self {
        let make: MakeCells = Box::new(move || Arc::new(make()));
        BlockSparsity { cells: Some(LazyLock::new(make)), ..self }
    }

    /// The cells whose unknowns are coupled, where they are known.
    pub fn cells(&self) -> Option<&Arc<Cells>> {
        self.cells.as_deref()
    }

    /// The row sets.
    #[inline]
    pub fn row_sets(&self) -> &[NodeSet] {
        &self.rows
    }

    /// The column sets.
    #[inline]
    pub fn column_sets(&self) -> &[NodeSet] {
        &self.columns
    }

    /// Number of scalar rows.
    pub fn row_count(&self) -> usize {
        self.rows.last().map_or(0, |set| set.unknowns().end)
    }

    /// Number of scalar columns.
    pub fn column_count(&self) -> usize {
        self.columns.last().map_or(0, |set| set.unknowns().end)
    }

    /// Number of stored numbers.
    pub fn entries(&self) -> usize {
        self.entries
    }

    /// The blocks of a pair of sets.
    #[inline]
    pub fn pair(&self, row_set: usize, column_set: usize) -> &BlockRows {
        &self.pairs[row_set * self.columns.len() + column_set]
    }

    /// The places of a pair's row nodes among those of all pairs, row space after row space.
    pub fn pair_rows(&self, row_set: usize, column_set: usize) -> std::ops::Range<usize> {
        let nodes = |row_set: usize| self.rows[row_set].nodes;
        let before: usize = (0..row_set).map(|row_set| nodes(row_set) * self.columns.len()).sum();
        let start = before + column_set * nodes(row_set);
        start..start + nodes(row_set)
    }

    /// The number of all of them.
    pub fn pair_rows_count(&self) -> usize {
        self.rows.iter().map(|set| set.nodes).sum::<usize>() * self.columns.len()
    }

    /// Bytes of the positions; a matrix has 8 bytes per stored number besides.
    pub fn memory(&self) -> usize {
        let bytes = |pair: &BlockRows| size_of_val(&pair.pointers[..]) + size_of_val(&pair.columns[..]);
        self.pairs.iter().map(bytes).sum()
    }

    /// The set with a scalar row (or column), its node and its component.
    fn locate(sets: &[NodeSet], unknown: usize) -> (usize, usize, usize) {
        let set = sets.partition_point(|set| set.unknowns().end <= unknown);
        let within = unknown - sets[set].offset;
        (set, within / sets[set].components, within % sets[set].components)
    }

    /// Whether two scalar rows belong to one node, so that they have the same columns.
    pub(crate) fn are_of_one_node(&self, row: usize, other: usize) -> bool {
        let node_of = |row: usize| {
            let (set, node, _) = Self::locate(&self.rows, row);
            (set, node)
        };
        node_of(row) == node_of(other)
    }

    /// The entries of a scalar row in ascending columns, each with its place in the list of values.
    ///
    /// # Panics
    /// If `row` is not below [`BlockSparsity::row_count`].
    pub fn row(&self, row: usize) -> impl Iterator<Item = (usize, usize)> {
        let mut entries = Vec::new();
        self.visit_row(row, |column, place, width| {
            entries.extend((0..width).map(|k| (column + k, place + k)));
        });
        entries.into_iter()
    }

    /// Number of entries of a scalar row.
    pub(crate) fn row_length(&self, row: usize) -> usize {
        let (set, node, _) = Self::locate(&self.rows, row);
        let blocks = |number: usize| self.pair(set, number).range(node).len();
        self.columns.iter().enumerate().map(|(number, columns)| columns.components * blocks(number)).sum()
    }

    /// Calls `visit(first column, place of the first value, number of entries)` for each run of entries of a scalar
    /// row that are adjacent, in ascending columns.
    pub(crate) fn visit_row(&self, row: usize, mut visit: impl FnMut(usize, usize, usize)) {
        let (set, node, component) = Self::locate(&self.rows, row);
        for (number, columns) in self.columns.iter().enumerate() {
            let pair = self.pair(set, number);
            let (width, range) = (columns.components, pair.range(node));
            let mut place = pair.first_value + range.start * pair.block + component * width;
            for column in &pair.columns[range] {
                visit(columns.offset + *column as usize * width, place, width);
                place += pair.block;
            }
        }
    }

    /// Calls `visit(place of the first value, number of values)` for each run of a scalar row's values that are adjacent, in
    /// ascending columns.
    pub(crate) fn visit_pieces(&self, row: usize, mut visit: impl FnMut(usize, usize)) {
        let (set, node, component) = Self::locate(&self.rows, row);
        for (number, columns) in self.columns.iter().enumerate() {
            let pair = self.pair(set, number);
            let (width, range) = (columns.components, pair.range(node));
            let first = pair.first_value + range.start * pair.block + component * width;
            // Of nodes with one component the row's blocks are one piece.
            if pair.block == width {
                visit(first, range.len() * width);
            } else {
                (0..range.len()).for_each(|block| visit(first + block * pair.block, width));
            }
        }
    }

    /// Calls `visit(row, column, place)` for the entries at some places, given as ranges of whole blocks.
    pub(crate) fn visit_places(&self, places: &[Range<usize>], mut visit: impl FnMut(usize, usize, usize)) {
        for range in places {
            let mut place = range.start;
            while place < range.end {
                let number = self.pairs.partition_point(|pair| pair.values().end <= place);
                let Some(pair) = self.pairs.get(number) else { return };
                let rows = &self.rows[number / self.columns.len()];
                let columns = &self.columns[number % self.columns.len()];
                let first = (place - pair.first_value) / pair.block;
                let end = (range.end.min(pair.values().end) - pair.first_value).div_ceil(pair.block);
                let mut node = pair.pointers.partition_point(|start| *start <= first) - 1;
                for block in first..end {
                    while pair.pointers[node + 1] <= block {
                        node += 1;
                    }
                    let row = rows.offset + node * rows.components;
                    let column = columns.offset + pair.columns[block] as usize * columns.components;
                    for entry in 0..pair.block {
                        let (a, b) = (entry / columns.components, entry % columns.components);
                        visit(row + a, column + b, pair.first_value + block * pair.block + entry);
                    }
                }
                place = pair.first_value + end * pair.block;
            }
        }
    }

    /// The place of an entry in the list of values, if it is stored.
    pub fn find(&self, row: usize, column: usize) -> Option<usize> {
        if row >= self.row_count() || column >= self.column_count() {
            return None;
        }
        let (row_set, row_node, row_component) = Self::locate(&self.rows, row);
        let (column_set, column_node, column_component) = Self::locate(&self.columns, column);
        let pair = self.pair(row_set, column_set);
        let block = pair.first_value + pair.place(row_node, column_node as u32)? * pair.block;
        Some(block + row_component * self.columns[column_set].components + column_component)
    }

    /// These positions as a pattern of scalars. Made at the first call.
    pub fn pattern(&self) -> &Arc<SparsityPattern> {
        self.pattern.get_or_init(|| {
            let mut pointers = Vec::with_capacity(self.row_count() + 1);
            pointers.push(0);
            let mut indices: Vec<u32> = Vec::with_capacity(self.entries);
            for (set, rows) in self.rows.iter().enumerate() {
                for node in 0..rows.nodes {
                    let start = indices.len();
                    for (number, columns) in self.columns.iter().enumerate() {
                        for &column in self.pair(set, number).row(node) {
                            let first = columns.offset + column as usize * columns.components;
                            indices.extend((first..first + columns.components).map(|column| column as u32));
                        }
                    }
                    let end = indices.len();
                    pointers.push(end);
                    for _ in 1..rows.components {
                        indices.extend_from_within(start..end);
                        pointers.push(indices.len());
                    }
                }
            }
            let (rows, columns) = (self.row_count(), self.column_count());
            let cells = self.cells().cloned();
            Arc::new(SparsityPattern::of_checked(rows, columns, pointers, indices, cells))
        })
    }
}

impl From<&Arc<SparsityPattern>> for BlockSparsity {
    /// Blocks of one entry over one set of rows and one of columns.
    fn from(pattern: &Arc<SparsityPattern>) -> Self {
        let mut pair = BlockRows::new(pattern.row_pointers().to_vec(), pattern.column_indices().to_vec());
        pair.block = 1;
        let cells = pattern.cells().cloned();
        BlockSparsity {
            rows: NodeSet::in_a_row([(pattern.rows(), 1)]),
            columns: NodeSet::in_a_row([(pattern.columns(), 1)]),
            pairs: vec![pair],
            entries: pattern.entries(),
            pattern: OnceLock::from(pattern.clone()),
            cells: cells.map(|cells| LazyLock::new(Box::new(move || cells) as MakeCells)),
        }
    }
}

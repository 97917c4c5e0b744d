//! The blocks of a matrix to which the motion of moving segments' points adds: in the row of a test node those of the nodes that move a unit's feet.

use forms_core::contract::Side;

use super::group_nodes::{Reading, seen_places};
use crate::assemble::BlockPattern;
use crate::assemble::block_pattern::block_index::BlockIndex;
use crate::assemble::groups::Group;
use crate::linear_algebra::BlockRows;
use crate::space::Space;

/// Finds the blocks of a group's units: those that the pattern knows of cells and pairs of facets, others by a search.
pub(in crate::assemble) struct MotionBlocks<'a> {
    blocks: &'a BlockRows,
    /// Those of the nodes of each side's cell.
    known: [Option<KnownBlocks<'a>>; 2],
}

/// Blocks of the test nodes that are seen, with the nodes of one side's cell.
struct KnownBlocks<'a> {
    map: &'a BlockIndex,
    /// Of each unit the start of its places.
    starts: Vec<usize>,
    /// The row of each test node that is seen, and how long a row is.
    rows: Vec<usize>,
    length: usize,
    /// By a node's place in the cell its place in a row, if it is there.
    columns: Vec<Option<usize>>,
}

impl KnownBlocks<'_> {
    #[inline]
    fn slot(&self, unit: usize, test: usize, node: usize) -> Option<usize> {
        let column = (*self.columns.get(node)?)?;
        Some(self.map.places.at(self.starts[unit] + self.rows[test] * self.length + column))
    }
}

impl<'a> MotionBlocks<'a> {
    /// The blocks of a group for test and trial functions with the given numbers. The test functions live on a side of the group, and are seen at some places.
    pub fn new<const D: usize>(
        pattern: &'a BlockPattern<D>,
        (blocks, [test_number, trial_number]): (&'a BlockRows, [usize; 2]),
        group: &Group<D>,
        (test, side, seen, reading): (&Space<D>, usize, &[usize], Reading),
        trial: &Space<D>,
    ) -> Self {
        let map = pattern.map(test_number, trial_number);
        let on_cells = test.facet_region().is_none() && trial.facet_region().is_none();
        let known = [0, 1].map(|column_side: usize| {
            let (map, cells) = (map.filter(|_| on_cells)?, &group.sides[column_side].cells);
            let all = trial.nodes_at(*cells.first()?, None).len();
            if column_side == side {
                let each = test.nodes_at(cells[0], None).len() * all;
                let first = map.start(group.sides[side].shape);
                let starts = cells.iter().map(|cell| Some(first + map.start_of(*cell, each)?));
                let columns = (0..all).map(Some).collect();
                return Some(KnownBlocks {
                    map,
                    starts: starts.collect::<Option<_>>()?,
                    rows: seen.to_vec(),
                    length: all,
                    columns,
                });
            }
            let facets = &group.pairs()?.group.facets;
            let sides = [side, column_side].map(|side| if side == 0 { Side::This } else { Side::Other });
            [Reading::Values, Reading::Derivatives].into_iter().find_map(|of_trial| {
                let places = seen_places(group, column_side, trial, of_trial);
                let places = places.unwrap_or_else(|| (0..all).collect());
                let (length, rows) = (places.len(), (0..seen.len()).collect());
                let starts = map.starts_of_pairs(sides, [reading, of_trial], facets, seen.len() * length)?;
                let columns = (0..all).map(|node| places.iter().position(|place| *place == node)).collect();
                Some(KnownBlocks { map, starts, rows, length, columns })
            })
        });
        MotionBlocks { blocks, known }
    }

    /// The place of the block in a row of a unit's test node, by its number among those that are seen. A column has its node, and if it is one of the
    /// unit's two cells, the side and the place there.
    #[inline]
    pub fn place(
        &self,
        (unit, test, row): (usize, usize, usize),
        (node, of_cell): (u32, Option<[usize; 2]>),
    ) -> Option<usize> {
        let known = of_cell.and_then(|[side, place]| self.known[side].as_ref()?.slot(unit, test, place));
        match known {
            Some(slot) => Some(self.blocks.pointers()[row] + slot),
            None => self.blocks.place(row, node),
        }
    }
}

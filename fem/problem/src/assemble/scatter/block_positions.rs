//! The places of an element matrix's blocks in their rows: looked up before, or searched for in the matrix.

use std::ops::Range;

use super::MatrixScatter;
use crate::assemble::block_pattern::block_index::{BlockIndex, Slot};

/// Ways to find the blocks of an element matrix.
pub(in crate::assemble) enum BlockPlaces<'a> {
    /// By its cell, where test and trial functions live on the same one.
    OfCells(&'a BlockIndex),
    /// By the starts of each unit's places, where they live on the two sides of contact pairs.
    OfPairs(&'a BlockIndex, Vec<usize>),
    /// By a search in the matrix.
    Unknown,
}

/// Finds the places of the blocks of an element matrix.
pub(in crate::assemble) trait Finder {
    type Slot: Slot;
    /// Whether the rows of the next entities are asked for ahead. Those of contact pairs are far apart, unlike those of neighbouring
    /// cells, and come from memory one pass after the other.
    fn ahead(&self) -> bool;
    /// Those of an entity, test node after test node; `None`: one is not in the pattern.
    fn find(&mut self, entity: usize) -> Option<&[Self::Slot]>;
    /// Looks up those of some entities, which are asked for next.
    fn look_up(&mut self, entities: Range<usize>) -> Option<()>;
}

/// Slots of a cell's nodes, looked up before.
pub(in crate::assemble) struct Known<'a, P> {
    cells: &'a [u32],
    map: &'a BlockIndex,
    /// From the first cell of the group's shape on.
    places: &'a [P],
    /// Pairs of nodes of a cell.
    size: usize,
}

impl<'a, P: Slot> Known<'a, P> {
    pub fn new(scatter: &'a MatrixScatter<'a>, map: &'a BlockIndex, places: &'a [P]) -> Self {
        let [tests, trials] = scatter.nodes;
        Known { cells: scatter.tests.cells, map, places, size: tests * trials }
    }
}

impl<P: Slot> Finder for Known<'_, P> {
    type Slot = P;

    #[inline(always)]
    fn ahead(&self) -> bool {
        false
    }

    #[inline(always)]
    fn find(&mut self, entity: usize) -> Option<&[P]> {
        let start = self.map.start_of(self.cells[entity], self.size)?;
        Some(&self.places[start..][..self.size])
    }

    #[inline(always)]
    fn look_up(&mut self, _: Range<usize>) -> Option<()> {
        Some(())
    }
}

/// Some pairs of the nodes of a cell.
pub(in crate::assemble) struct ChosenPairs {
    /// Their places among all pairs of the cell, test node after test node.
    pub places: Vec<u32>,
    /// The number of all.
    pub among: usize,
}

impl ChosenPairs {
    /// The pairs of the nodes at some places among a cell's `all`; where there is no list, of every node. None if all are chosen.
    pub fn new(chosen: [Option<&[usize]>; 2], all: [usize; 2]) -> Option<Self> {
        if chosen == [None; 2] {
            return None;
        }
        let [tests, trials] =
            [0, 1].map(|k| chosen[k].map_or_else(|| (0..all[k]).collect(), <[usize]>::to_vec));
        let pairs = tests.iter().flat_map(|i| trials.iter().map(move |j| (i * all[1] + j) as u32));
        Some(ChosenPairs { places: pairs.collect(), among: all[0] * all[1] })
    }
}

/// Slots of any kind, copied: of some of a cell's nodes, of nodes on the two sides of contact pairs, in long rows, and those that are
/// searched for in the matrix.
pub(in crate::assemble) struct Copied<'a, 'p> {
    scatter: &'a MatrixScatter<'a>,
    known: &'p mut CopiedPlaces,
}

/// Places that were copied of some entities that follow each other.
#[derive(Default)]
pub(in crate::assemble) struct CopiedPlaces {
    first: usize,
    /// Entity after entity.
    found: Vec<u32>,
}

impl<'a, 'p> Copied<'a, 'p> {
    pub fn new(scatter: &'a MatrixScatter<'a>, known: &'p mut CopiedPlaces) -> Self {
        Copied { scatter, known }
    }

    /// Places of an entity after those that are there.
    fn copy(&mut self, entity: usize) -> Option<()> {
        let MatrixScatter { tests, trials, blocks, nodes, map, chosen, .. } = self.scatter;
        let size = nodes[0] * nodes[1];
        let found = &mut self.known.found;
        match map {
            BlockPlaces::OfCells(map) => {
                let size = chosen.as_ref().map_or(size, |pairs| pairs.among);
                let start = map.start(tests.shape) + map.start_of(tests.cells[entity], size)?;
                match chosen {
                    Some(pairs) => map.places.copy_some(start, &pairs.places, found),
                    None => map.places.copy(start..start + size, found),
                }
            }
            BlockPlaces::OfPairs(map, starts) => {
                map.places.copy(starts[entity]..starts[entity] + size, found);
            }
            BlockPlaces::Unknown => {
                for row in tests.of(entity) {
                    let known = blocks.row(*row as usize);
                    for node in trials.of(entity) {
                        found.push(known.binary_search(node).ok()? as u32);
                    }
                }
            }
        }
        Some(())
    }
}

impl Finder for Copied<'_, '_> {
    type Slot = u32;

    fn ahead(&self) -> bool {
        !matches!(
            (&self.scatter.map, &self.scatter.chosen),
            (BlockPlaces::Unknown, _) | (BlockPlaces::OfCells(_), None)
        )
    }

    #[inline]
    fn find(&mut self, entity: usize) -> Option<&[u32]> {
        let size = self.scatter.nodes[0] * self.scatter.nodes[1];
        let known = self.known.first..self.known.first + self.known.found.len() / size.max(1);
        if !known.contains(&entity) {
            self.look_up(entity..entity + 1)?;
        }
        Some(&self.known.found[(entity - self.known.first) * size..][..size])
    }

    #[inline(never)]
    fn look_up(&mut self, entities: Range<usize>) -> Option<()> {
        self.known.first = entities.start;
        self.known.found.clear();
        for entity in entities {
            self.copy(entity)?;
        }
        Some(())
    }
}

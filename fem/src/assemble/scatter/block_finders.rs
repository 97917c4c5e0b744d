//! The places of an element matrix's blocks in their rows: looked up before, or searched for in the matrix.

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
    const AHEAD: bool = false;
    /// Those of an entity, test node after test node; `None`: one is not in the pattern.
    fn find(&mut self, entity: usize) -> Option<&[Self::Slot]>;
}

/// Slots looked up before.
pub(in crate::assemble) struct Known<'a, P> {
    cells: &'a [u32],
    map: &'a BlockIndex,
    /// From the first cell of the group's shape on.
    places: &'a [P],
    /// Pairs of nodes of a cell.
    size: usize,
}

impl<'a, P: Slot> Known<'a, P> {
    pub fn new<const D: usize>(
        scatter: &'a MatrixScatter<'a, D>,
        map: &'a BlockIndex,
        places: &'a [P],
        size: usize,
    ) -> Self {
        Known { cells: scatter.tests.cells, map, places, size }
    }

    #[inline(always)]
    fn of(&self, entity: usize) -> Option<&'a [P]> {
        let place = *self.map.walk.get(self.cells[entity] as usize)?;
        if place == BlockIndex::ABSENT {
            return None;
        }
        Some(&self.places[place as usize * self.size..][..self.size])
    }
}

impl<P: Slot> Finder for Known<'_, P> {
    type Slot = P;

    #[inline(always)]
    fn find(&mut self, entity: usize) -> Option<&[P]> {
        self.of(entity)
    }
}

/// Slots of nodes on the two sides of contact pairs, looked up before.
pub(in crate::assemble) struct KnownPairs<'a, P> {
    /// The start of each unit's places.
    pub starts: &'a [usize],
    pub places: &'a [P],
    /// Pairs of nodes of a unit.
    pub size: usize,
}

impl<P: Slot> Finder for KnownPairs<'_, P> {
    type Slot = P;
    const AHEAD: bool = true;

    #[inline(always)]
    fn find(&mut self, entity: usize) -> Option<&[P]> {
        Some(&self.places[self.starts[entity]..][..self.size])
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
    /// Those of the nodes at some places among a cell's `all`; where there is no list, of every node. None if all are chosen.
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

/// Some of the slots looked up before.
pub(in crate::assemble) struct Chosen<'a, P> {
    pub known: Known<'a, P>,
    pub pairs: &'a [u32],
    pub found: Vec<P>,
}

impl<P: Slot> Finder for Chosen<'_, P> {
    type Slot = P;
    const AHEAD: bool = true;

    #[inline(always)]
    fn find(&mut self, entity: usize) -> Option<&[P]> {
        let all = self.known.of(entity)?;
        self.found.clear();
        self.found.extend(self.pairs.iter().map(|pair| all[*pair as usize]));
        Some(&self.found)
    }
}

/// Slots searched for in the matrix.
pub(in crate::assemble) struct Search<'a, const D: usize> {
    scatter: &'a MatrixScatter<'a, D>,
    found: Vec<u32>,
}

impl<'a, const D: usize> Search<'a, D> {
    pub fn new(scatter: &'a MatrixScatter<'a, D>) -> Self {
        Search { scatter, found: vec![0; scatter.nodes[0] * scatter.nodes[1]] }
    }
}

impl<const D: usize> Finder for Search<'_, D> {
    type Slot = u32;

    fn find(&mut self, entity: usize) -> Option<&[u32]> {
        let MatrixScatter { tests, trials, blocks, nodes, .. } = self.scatter;
        for (row, found) in tests.of(entity).iter().zip(self.found.chunks_exact_mut(nodes[1])) {
            let known = blocks.row(*row as usize);
            for (found, node) in found.iter_mut().zip(trials.of(entity)) {
                *found = known.binary_search(node).ok()? as u32;
            }
        }
        Some(&self.found)
    }
}

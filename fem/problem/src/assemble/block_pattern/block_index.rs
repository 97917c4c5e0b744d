//! Slots of the blocks of element matrices in their rows, looked up once per pair of spaces.

use std::ops::Range;

use forms_core::contract::Side;

use crate::assemble::scatter::group_nodes::Reading;
use crate::element::CellShape;
use crate::mesh::Facet;

/// A place in a row of blocks.
pub(in crate::assemble) trait Slot: Copy + Send + Sync + 'static {
    /// No row of more blocks can be described.
    const LONGEST_ROW: usize;
    /// A place below [`Slot::LONGEST_ROW`].
    fn new(place: u32) -> Self;
    fn index(self) -> usize;
}

impl Slot for u8 {
    const LONGEST_ROW: usize = 0x100;
    #[inline(always)]
    fn new(place: u32) -> Self {
        place as u8
    }
    #[inline(always)]
    fn index(self) -> usize {
        self.into()
    }
}

impl Slot for u16 {
    const LONGEST_ROW: usize = 0x1_0000;
    #[inline(always)]
    fn new(place: u32) -> Self {
        place as u16
    }
    #[inline(always)]
    fn index(self) -> usize {
        self.into()
    }
}

impl Slot for u32 {
    const LONGEST_ROW: usize = usize::MAX;
    #[inline(always)]
    fn new(place: u32) -> Self {
        place
    }
    #[inline(always)]
    fn index(self) -> usize {
        self as usize
    }
}

/// Slots in the smallest type that holds those of the longest row.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::assemble) enum Slots {
    Bytes(Vec<u8>),
    Words(Vec<u16>),
    Long(Vec<u32>),
}

impl Slots {
    /// One of the slots.
    #[inline]
    pub fn at(&self, place: usize) -> usize {
        match self {
            Slots::Bytes(places) => places[place].index(),
            Slots::Words(places) => places[place].index(),
            Slots::Long(places) => places[place].index(),
        }
    }

    /// A run of the slots, added to a list.
    pub fn copy(&self, run: Range<usize>, to: &mut Vec<u32>) {
        match self {
            Slots::Bytes(places) => to.extend(places[run].iter().map(|place| u32::from(*place))),
            Slots::Words(places) => to.extend(places[run].iter().map(|place| u32::from(*place))),
            Slots::Long(places) => to.extend_from_slice(&places[run]),
        }
    }

    /// The slots at some distances from a start, added to a list.
    pub fn copy_some(&self, start: usize, distances: &[u32], to: &mut Vec<u32>) {
        let at = |distance: &u32| start + *distance as usize;
        match self {
            Slots::Bytes(places) => to.extend(distances.iter().map(|some| u32::from(places[at(some)]))),
            Slots::Words(places) => to.extend(distances.iter().map(|some| u32::from(places[at(some)]))),
            Slots::Long(places) => to.extend(distances.iter().map(|some| places[at(some)])),
        }
    }
}

/// For cells that take part, walked in some order, and each of their pairs of a test and a trial node: the place of
/// the pair's block in the row of the test node. The same for nodes on different sides of contact pairs.
#[derive(Clone, Debug)]
pub(in crate::assemble) struct BlockIndex {
    /// Shape after shape, `[cell in the walk of those of its shape][test node][trial node]`; then
    /// `[pair of facets][test node][trial node]` of each list in `across`.
    pub places: Slots,
    /// Starts of the places of each shape's cells.
    pub starts: Vec<(CellShape, usize)>,
    /// Of each cell of the mesh, where it comes in the walk of those of its shape; [`BlockIndex::ABSENT`] for those that
    /// take no part.
    pub walk: Vec<u32>,
    /// Facets whose nodes on one side are coupled with those on the other.
    pub across: Vec<Across>,
}

/// Pairs of an own and an opposite facet whose places are known.
#[derive(Clone, Debug)]
pub(in crate::assemble) struct Across {
    /// The sides of test and trial nodes.
    pub sides: [Side; 2],
    /// The nodes that count.
    pub reading: [Reading; 2],
    /// The pairs as [`Across::key`] writes them, ascending.
    pub keys: Vec<u128>,
    /// The starts of their places, and the end.
    pub starts: Vec<usize>,
}

impl Across {
    /// A pair of facets as a number, in their order.
    pub fn key(facets: &[Facet; 2]) -> u128 {
        let [own, opposite] = facets.map(|facet| u128::from(facet.cell) << 8 | u128::from(facet.local));
        own << 64 | opposite
    }

    /// The place of a key, looked for first after one that may be near.
    fn place_near(&self, near: usize, key: u128) -> Option<usize> {
        const AHEAD: usize = 64;
        let end = self.keys.len().min(near + AHEAD);
        let run = self.keys.get(near..end).unwrap_or_default();
        if let (Some(first), Some(last)) = (run.first(), run.last())
            && (*first..=*last).contains(&key)
        {
            return run.binary_search(&key).ok().map(|place| near + place);
        }
        self.keys.binary_search(&key).ok()
    }
}

impl BlockIndex {
    pub const ABSENT: u32 = u32::MAX;

    /// The start of the places of a shape's cells.
    pub fn start(&self, shape: CellShape) -> usize {
        self.starts.iter().find(|(known, _)| *known == shape).map_or(0, |(_, start)| *start)
    }

    /// The start of the places of a cell after those of its shape's first one, the given number for each; `None` if it takes no part.
    #[inline(always)]
    pub fn start_of(&self, cell: u32, each: usize) -> Option<usize> {
        let place = *self.walk.get(cell as usize)?;
        (place != BlockIndex::ABSENT).then(|| place as usize * each)
    }

    /// The starts of the places of some pairs of facets, of the given number of blocks each; none unless all are known.
    pub fn starts_of_pairs(
        &self,
        sides: [Side; 2],
        reading: [Reading; 2],
        pairs: &[[Facet; 2]],
        blocks: usize,
    ) -> Option<Vec<usize>> {
        let suited = |across: &&Across| across.sides == sides && across.reading == reading;
        let lists: Vec<&Across> = self.across.iter().filter(suited).collect();
        // Units that follow each other are mostly near each other in the lists.
        let mut last = 0;
        let mut start = |facets: &[Facet; 2]| {
            let key = Across::key(facets);
            let mut in_list = |across: &&Across| {
                let place = across.place_near(last, key)?;
                last = place;
                let (start, end) = (across.starts[place], across.starts[place + 1]);
                (end - start == blocks).then_some(start)
            };
            lists.iter().find_map(&mut in_list)
        };
        pairs.iter().map(&mut start).collect()
    }

    /// Bytes.
    pub fn memory(&self) -> usize {
        let places = match &self.places {
            Slots::Bytes(places) => size_of_val(&places[..]),
            Slots::Words(places) => size_of_val(&places[..]),
            Slots::Long(places) => size_of_val(&places[..]),
        };
        let of_pairs = |across: &Across| size_of_val(&across.keys[..]) + size_of_val(&across.starts[..]);
        places + size_of_val(&self.walk[..]) + self.across.iter().map(of_pairs).sum::<usize>()
    }
}

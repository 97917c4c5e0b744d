//! Slots of the blocks of element matrices in their rows, looked up once per pair of spaces.

use crate::element::CellShape;

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
#[derive(Clone, Debug)]
pub(in crate::assemble) enum Slots {
    Bytes(Vec<u8>),
    Words(Vec<u16>),
    Long(Vec<u32>),
}

impl Slots {
    /// Zeros, of one byte each.
    pub fn new(count: usize) -> Self {
        Slots::Bytes(vec![0; count])
    }

    /// The same in the next larger type.
    pub fn widened(self) -> Self {
        match self {
            Slots::Bytes(places) => Slots::Words(places.into_iter().map(u16::from).collect()),
            Slots::Words(places) => Slots::Long(places.into_iter().map(u32::from).collect()),
            Slots::Long(places) => Slots::Long(places),
        }
    }
}

/// For cells that take part, walked in some order, and each of their pairs of a test and a trial node: the place of
/// the pair's block in the row of the test node.
#[derive(Clone, Debug)]
pub(in crate::assemble) struct BlockIndex {
    /// Shape after shape, `[cell in the walk of those of its shape][test node][trial node]`.
    pub places: Slots,
    /// Starts of the places of each shape's cells.
    pub starts: Vec<(CellShape, usize)>,
    /// Of each cell of the mesh, where it comes in the walk of those of its shape; [`BlockIndex::ABSENT`] for those that
    /// take no part.
    pub walk: Vec<u32>,
}

impl BlockIndex {
    pub const ABSENT: u32 = u32::MAX;

    /// The start of the places of a shape's cells.
    pub fn start(&self, shape: CellShape) -> usize {
        self.starts.iter().find(|(known, _)| *known == shape).map_or(0, |(_, start)| *start)
    }

    /// Bytes.
    pub fn memory(&self) -> usize {
        let places = match &self.places {
            Slots::Bytes(places) => size_of_val(&places[..]),
            Slots::Words(places) => size_of_val(&places[..]),
            Slots::Long(places) => size_of_val(&places[..]),
        };
        places + size_of_val(&self.walk[..])
    }
}

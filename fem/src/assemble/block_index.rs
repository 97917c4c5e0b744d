//! Where the blocks of element matrices stand in their rows, looked up once per pair of spaces.

use crate::element::CellShape;

/// A place in a row of blocks.
pub(super) trait Place: Copy + Send + Sync + 'static {
    /// No row of more blocks can be described.
    const LONGEST_ROW: usize;
    /// A place below [`Place::LONGEST_ROW`].
    fn new(place: u32) -> Self;
    fn index(self) -> usize;
}

impl Place for u8 {
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

impl Place for u16 {
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

impl Place for u32 {
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

/// Places in the smallest type that holds those of the longest row.
#[derive(Clone, Debug)]
pub(super) enum Places {
    Bytes(Vec<u8>),
    Words(Vec<u16>),
    Long(Vec<u32>),
}

impl Places {
    /// Zeros, of one byte each.
    pub fn new(count: usize) -> Self {
        Places::Bytes(vec![0; count])
    }

    /// The same in the next larger type.
    pub fn widened(self) -> Self {
        match self {
            Places::Bytes(places) => Places::Words(places.into_iter().map(u16::from).collect()),
            Places::Words(places) => Places::Long(places.into_iter().map(u32::from).collect()),
            Places::Long(places) => Places::Long(places),
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

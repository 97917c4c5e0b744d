//! Blocks of lane values that are written into matrices at places of their own.

use super::SimdLane;

/// Places of the blocks of pairs in a square matrix, whose rows and columns are two per node.
#[derive(Clone, Debug, Default)]
pub(crate) struct PairPlaces {
    /// Of each pair: the place of the block's first entry, and of its mirror image's (the same where there is none). No block ends beyond
    /// the matrix.
    places: Vec<[u32; 2]>,
    /// Numbers per row.
    width: usize,
}

impl PairPlaces {
    /// Places in matrices of `width` rows.
    ///
    /// # Panics
    /// When a block ends beyond the matrix.
    pub fn new(places: Vec<[u32; 2]>, width: usize) -> Self {
        let inside = |place: &u32| *place as usize + width + 2 <= width * width;
        assert!(places.as_flattened().iter().all(inside), "a block ends beyond its matrix");
        PairPlaces { places, width }
    }
}

/// Matrices of all lanes, one after the other, and the places of their blocks.
pub(crate) struct PlacedBlocks<'a> {
    /// As long as the matrices of all lanes of the type that it was made for.
    target: &'a mut [f64],
    places: &'a [[u32; 2]],
    width: usize,
}

impl<'a> PlacedBlocks<'a> {
    /// Matrices of `width` rows of the lanes of a type.
    ///
    /// # Panics
    /// When `target` is shorter than these, or the places are those in other matrices.
    #[inline(always)]
    pub fn new<L: SimdLane>(target: &'a mut [f64], places: &'a PairPlaces, width: usize) -> Self {
        // A constant, where the caller has one: distances from lane to lane are then part of the instructions.
        assert!(places.places.is_empty() || places.width == width);
        PlacedBlocks { target: &mut target[..L::WIDTH * width * width], places: &places.places, width }
    }

    /// The block of a pair, written two numbers of a row after the other, and its mirror image.
    ///
    /// # Panics
    /// When there are fewer pairs.
    #[inline(always)]
    pub fn put<L: SimdLane>(&mut self, pair: usize, block: [L; 4]) {
        let (width, size) = (self.width, self.width * self.width);
        let [direct, mirrored] = self.places[pair];
        assert!(self.target.len() == L::WIDTH * size);
        // SAFETY: a block ends inside of its matrix (`PairPlaces::new`), and there is a matrix for each lane. To check that again for
        // each pair of rows would take as many instructions as the stores.
        unsafe {
            let target = self.target.as_mut_ptr();
            let row = target.add(direct as usize);
            L::store_few_from([block[0], block[1]], row, size);
            L::store_few_from([block[2], block[3]], row.add(width), size);
            if mirrored != direct {
                let row = target.add(mirrored as usize);
                L::store_few_from([block[0], block[2]], row, size);
                L::store_few_from([block[1], block[3]], row.add(width), size);
            }
        }
    }
}

//! Cells that couple a matrix's unknowns, and the places where they are.

use super::error::LinearAlgebraError;
use super::large_pages::room;

/// Cells whose unknowns a matrix couples with each other, with their centres: what a nested dissection by places has to
/// know. Unknowns may belong to several cells or to none, and a matrix may couple unknowns that no cell has in common.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cells {
    /// Coordinates \[length\], zero beyond the dimension.
    centres: Vec<[f64; 3]>,
    /// End of each cell's unknowns.
    ends: Vec<usize>,
    unknowns: Vec<u32>,
}

impl Cells {
    /// One more cell, with the coordinates of its centre \[length\], zero beyond the dimension, and its unknowns.
    pub fn add(&mut self, centre: [f64; 3], unknowns: impl IntoIterator<Item = u32>) {
        self.add_by(centre, |own| own.extend(unknowns));
    }

    /// One more cell, by a function that appends the cell's unknowns to those of all cells before it.
    #[doc(hidden)]
    #[inline]
    pub fn add_by(&mut self, centre: [f64; 3], append: impl FnOnce(&mut Vec<u32>)) {
        self.centres.push(centre);
        append(&mut self.unknowns);
        self.ends.push(self.unknowns.len());
    }

    /// No cells yet, with room for the given numbers of cells and of unknowns on all of them.
    #[doc(hidden)]
    pub fn with_room(cells: usize, unknowns: usize) -> Self {
        Cells { centres: room(cells), ends: room(cells), unknowns: room(unknowns) }
    }

    /// Number of cells.
    pub fn count(&self) -> usize {
        self.ends.len()
    }

    /// Centre of each cell \[length\], zero beyond the dimension.
    pub fn centres(&self) -> &[[f64; 3]] {
        &self.centres
    }

    /// Unknowns of a cell. Panics if there is no such cell, as indexing does.
    pub fn unknowns(&self, cell: usize) -> &[u32] {
        let start = if cell == 0 { 0 } else { self.ends[cell - 1] };
        &self.unknowns[start..self.ends[cell]]
    }

    /// These cells with other numbers for their unknowns: `visit` is called with an unknown and with a function that takes
    /// each number in its place; there may be several or none.
    pub fn renumbered(&self, numbers: impl Fn(u32, &mut dyn FnMut(u32))) -> Self {
        let mut cells = Cells { centres: self.centres.clone(), ..Cells::default() };
        cells.unknowns.reserve(self.unknowns.len());
        for cell in 0..self.count() {
            for &unknown in self.unknowns(cell) {
                numbers(unknown, &mut |number| cells.unknowns.push(number));
            }
            cells.ends.push(cells.unknowns.len());
        }
        cells
    }

    /// An error unless all unknowns are below the given number.
    pub(super) fn check(&self, size: usize) -> Result<(), LinearAlgebraError> {
        match self.unknowns.iter().max() {
            Some(&index) if index as usize >= size => Err(LinearAlgebraError::IndexOutOfRange {
                what: "unknown of a cell",
                index: index as usize,
                size,
            }),
            _ => Ok(()),
        }
    }
}

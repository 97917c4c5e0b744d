//! An unstructured grid, as either format gives it.

use std::collections::HashMap;

use super::array::RawArray;
use super::error::VtkProblem;
use crate::mesh::imported::shortened;

/// Points, cells and data of a file.
#[derive(Clone, Debug, Default)]
pub(super) struct Grid {
    pub(super) points: Vec<[f64; 3]>,
    /// Numbers of points, cell after cell.
    pub(super) connectivity: Vec<i64>,
    /// For each cell where its points end in the connectivity.
    pub(super) ends: Vec<i64>,
    /// VTK's code of each cell.
    pub(super) types: Vec<i64>,
    pub(super) point_data: Vec<RawArray>,
    pub(super) cell_data: Vec<RawArray>,
    /// Written in a version of the format older than VTK 9.
    pub(super) before_9: bool,
}

impl Grid {
    /// The points of a cell.
    pub(super) fn cell(&self, cell: usize) -> Result<&[i64], VtkProblem> {
        let start = if cell == 0 { 0 } else { self.ends[cell - 1] };
        let (end, length) = (self.ends[cell], self.connectivity.len());
        let range = usize::try_from(start).ok().zip(usize::try_from(end).ok());
        let points = range.and_then(|(start, end)| self.connectivity.get(start..end));
        points.ok_or(VtkProblem::Connectivity { cell, start, end, length })
    }

    /// Cells name, of points at one place, the first one.
    pub(super) fn join_points(&mut self) {
        let mut known = HashMap::with_capacity(self.points.len());
        let first: Vec<i64> = (0..)
            .zip(&self.points)
            .map(|(place, position)| *known.entry(bits(position)).or_insert(place))
            .collect();
        for point in &mut self.connectivity {
            // What does not exist is reported later.
            if let Some(&place) = usize::try_from(*point).ok().and_then(|point| first.get(point)) {
                *point = place;
            }
        }
    }
}

/// A position as a key: 0 and −0 are one place.
pub(super) fn bits<const D: usize>(position: &[f64; D]) -> [u64; D] {
    position.map(|x| (x + 0.0).to_bits())
}

/// An error with the first characters of the file.
pub(super) fn not_vtk(bytes: &[u8]) -> VtkProblem {
    let line = bytes.split(|&byte| byte == b'\n').next().unwrap_or_default();
    VtkProblem::NotVtk { start: shortened(line) }
}

//! Checks of a batch's geometry: positive weights, and facets whose two sides lie on each other.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lane values are plain.
#![allow(clippy::needless_range_loop)]

use std::ops::Range;

use super::{Batch, Cells};
use crate::assemble::AssemblyError;
use crate::assemble::groups::OwnPoints;
use crate::assemble::groups::cut_groups::CutTables;
use crate::assemble::groups::pair_groups::PairTables;
use crate::instantiate::instantiate;
use crate::lanes::{SimdLane, WIDEST};
use crate::mesh::Mesh;
use crate::mesh::small_matrices::determinant;
use crate::pairs::PairGroup;

/// The two sides of an interior facet see a point at the same place up to this part of h.
const SAME_PLACE: f64 = 1e-10;

impl<L: SimdLane, const D: usize> Batch<'_, L, D> {
    /// The check that the weights of all points so far were positive; `range` holds the group's entities that have been loaded. A
    /// mesh has proved it of its cells; cells that a caller lists are taken as they are.
    ///
    /// # Errors
    /// A weight that is not positive, with its entity.
    pub fn check_weights(&self, range: Range<usize>) -> Result<(), AssemblyError> {
        let mut least = [f64::INFINITY; WIDEST];
        self.least.store(&mut least);
        match self.cells {
            Cells::Mesh(mesh) if least.iter().any(|determinant| *determinant <= 0.0) => {
                self.find_weight(mesh, range)
            }
            _ => Ok(()),
        }
    }

    #[cold]
    #[inline(never)]
    fn find_weight(&self, mesh: &Mesh<D>, range: Range<usize>) -> Result<(), AssemblyError> {
        for index in range {
            match &self.group.own {
                None => {}
                Some(OwnPoints::Pairs(pairs)) => {
                    self.find_in_pairs(mesh, index, pairs)?;
                    continue;
                }
                Some(OwnPoints::Cut(cut)) => {
                    self.find_in_pieces(mesh, index, cut)?;
                    continue;
                }
            }
            for side in &self.group.sides {
                let cell = side.cells[index] as usize;
                let tables = &side.geometry;
                for q in 0..self.group.points() {
                    let (mut jacobian, mut position) = ([[0.0; D]; D], [0.0; D]);
                    for (node, &number) in mesh.cell(cell).iter().enumerate() {
                        let x = &mesh.nodes()[number as usize];
                        let entry = q * tables.nodes + node;
                        for i in 0..D {
                            position[i] += tables.value[entry] * x[i];
                            for j in 0..D {
                                jacobian[i][j] += tables.gradient[entry][j] * x[i];
                            }
                        }
                    }
                    self.check_map(cell, &position, &jacobian)?;
                }
            }
        }
        Ok(())
    }

    /// The same among the points of a unit of contact pairs.
    fn find_in_pairs(&self, mesh: &Mesh<D>, unit: usize, pairs: &PairTables<D>) -> Result<(), AssemblyError> {
        let length = pairs.group.count * PairGroup::<D>::STRIDE;
        for point in pairs.group.points[unit * length..][..length].chunks(PairGroup::<D>::STRIDE) {
            for (number, side) in self.group.sides.iter().enumerate() {
                let cell = side.cells[unit] as usize;
                let reference: [f64; D] = std::array::from_fn(|k| point[number * D + k]);
                let (position, jacobian) = mesh.map(cell, &reference);
                self.check_map(cell, &position, &jacobian)?;
            }
        }
        Ok(())
    }

    /// The same among the points of pieces of a cell.
    fn find_in_pieces(&self, mesh: &Mesh<D>, index: usize, cut: &CutTables<D>) -> Result<(), AssemblyError> {
        let cell = self.group.sides[0].cells[index] as usize;
        for point in cut.points_of(index) {
            let (position, jacobian) = mesh.map(cell, &point);
            self.check_map(cell, &position, &jacobian)?;
        }
        Ok(())
    }

    /// Check that a cell's map keeps its orientation at a place.
    fn check_map(
        &self,
        cell: usize,
        position: &[f64; D],
        jacobian: &[[f64; D]; D],
    ) -> Result<(), AssemblyError> {
        let determinant = determinant(jacobian);
        if determinant > 0.0 {
            return Ok(());
        }
        let (form, place) = (self.binding.name, self.group.place.clone());
        Err(AssemblyError::Weight { form, place, cell, determinant, position: position.to_vec() })
    }

    /// Both sides of an interior facet must see its q-th point at one place.
    #[inline(always)]
    pub(super) fn check_facing(&self, q: usize, position: &[L; D]) -> Result<(), AssemblyError> {
        let other = self.buffers.sides[1].position(&self.tables[1], q);
        let mut square = L::splat(0.0);
        for axis in 0..D {
            let gap = other[axis] - position[axis];
            square = gap.multiply_add(gap, square);
        }
        let mut gaps = [0.0; WIDEST];
        square.sqrt().store(&mut gaps);
        for lane in 0..self.filled {
            let distance = gaps[lane];
            if distance <= SAME_PLACE * self.tolerance[lane] {
                continue;
            }
            let cells = [self.cells(0)[lane], self.cells(1)[lane]];
            let mut lanes = [[0.0; WIDEST]; D];
            for axis in 0..D {
                position[axis].store(&mut lanes[axis]);
            }
            return Err(self.mismatch(cells, &lanes, lane, distance));
        }
        Ok(())
    }

    #[cold]
    fn mismatch(
        &self,
        cells: [u32; 2],
        position: &[[f64; WIDEST]; D],
        lane: usize,
        distance: f64,
    ) -> AssemblyError {
        let position = position.iter().map(|lanes| lanes[lane]).collect();
        AssemblyError::FacetMismatch { form: self.binding.name, cells, position, distance }
    }
}

instantiate!(checks in lanes: Batch::<L, D>::find_weight);

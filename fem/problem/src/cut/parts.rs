//! Parts of a cut body that no cell connects: islands that nothing may hold.

use std::sync::Arc;

use super::pieces::SimplexPieces;
use super::{Cut, CutError, CutSide};
use crate::instantiate::instantiate;
use crate::mesh::small_matrices::determinant;

/// A part of a body: active cells that are connected over facets on which the body is.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyPart<const D: usize> {
    /// Its active cells, ascending.
    pub cells: Vec<u32>,
    /// Its volume, with whole cells as simplices between their vertices \[length^D\].
    pub volume: f64,
    /// The centre of its first cell, to find it \[length\].
    pub place: [f64; D],
}

impl<const D: usize> Cut<D> {
    /// The parts of the body, the largest first. More than one is a body with islands.
    ///
    /// ```
    /// use forms_fem::cut::Cut;
    /// use forms_fem::prelude::*;
    ///
    /// let mesh = rectangle([-1.0; 2], [1.0; 2], [20, 20], CellShape::Triangle, 1)?;
    /// let discs = |x: &[f64; 2]| ((x[0] + 0.5).hypot(x[1]) - 0.35).min((x[0] - 0.6).hypot(x[1]) - 0.2);
    /// let cut = Cut::by(&Field::interpolate(&Space::scalar(&mesh, 1)?, discs)?)?;
    /// let parts = cut.parts();
    /// assert!(parts.len() == 2 && parts[0].volume > parts[1].volume);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[inline(never)]
    pub fn parts(&self) -> Vec<BodyPart<D>> {
        self.sorted(self.components())
    }

    fn sorted(&self, components: Vec<Vec<u32>>) -> Vec<BodyPart<D>> {
        let mut parts: Vec<BodyPart<D>> = components.into_iter().map(|cells| self.part(cells)).collect();
        // Of equal ones the one that comes first.
        parts.sort_by(|a, b| b.volume.total_cmp(&a.volume));
        parts
    }

    /// The cut without the parts that touch none of some regions of exterior facets, and those parts. Their cells count as outside.
    ///
    /// # Errors
    /// [`CutError`]: a region that the mesh does not have, and regions that no part touches.
    #[inline(never)]
    pub fn without_islands(&self, held: &[&str]) -> Result<(Arc<Self>, Vec<BodyPart<D>>), CutError> {
        let mut touched = vec![false; self.sides.len()];
        for name in held {
            let facets =
                self.mesh.facet_region(name).map_err(|error| CutError::Mesh { text: error.to_string() })?;
            for facet in facets {
                touched[facet.cell as usize] |= self.side_of_facet(*facet) != CutSide::Outside;
            }
        }
        let parts = self.sorted(self.components());
        let (kept, islands): (Vec<_>, Vec<_>) =
            parts.into_iter().partition(|part| part.cells.iter().any(|cell| touched[*cell as usize]));
        if kept.is_empty() {
            let names: Vec<String> = held.iter().map(|name| format!("\"{name}\"")).collect();
            return Err(CutError::NoPart { names: names.join(", ") });
        }
        let mut cut = self.clone();
        for cell in islands.iter().flat_map(|part| &part.cells) {
            cut.sides[*cell as usize] = CutSide::Outside;
        }
        cut.list();
        Ok((Arc::new(cut), islands))
    }

    /// Connected active cells.
    fn components(&self) -> Vec<Vec<u32>> {
        let is_active = |cell: u32| self.sides[cell as usize] != CutSide::Outside;
        // Each cell points to one of its component with a lower number.
        let mut leaders: Vec<u32> = (0..self.sides.len() as u32).collect();
        fn leader(leaders: &mut [u32], mut cell: u32) -> u32 {
            while leaders[cell as usize] != cell {
                leaders[cell as usize] = leaders[leaders[cell as usize] as usize];
                cell = leaders[cell as usize];
            }
            cell
        }
        for [a, b] in self.mesh.interior_facets() {
            if is_active(a.cell) && is_active(b.cell) && self.side_of_facet(*a) != CutSide::Outside {
                let ends = [a, b].map(|facet| leader(&mut leaders, facet.cell));
                leaders[ends[0].max(ends[1]) as usize] = ends[0].min(ends[1]);
            }
        }
        let mut lists: Vec<Vec<u32>> = vec![vec![]; self.sides.len()];
        for cell in (0..self.sides.len() as u32).filter(|cell| is_active(*cell)) {
            lists[leader(&mut leaders, cell) as usize].push(cell);
        }
        lists.retain(|cells| !cells.is_empty());
        lists
    }

    fn part(&self, cells: Vec<u32>) -> BodyPart<D> {
        let of_piece = |cell: u32, places: [[f64; D]; 4]| {
            let at = |k: usize| self.mesh.map(cell as usize, &places[k]).0;
            let origin = at(0);
            let edges: [[f64; D]; D] = std::array::from_fn(|i| {
                let end = at(i + 1);
                std::array::from_fn(|k| end[k] - origin[k])
            });
            determinant(&edges).abs() / if D == 2 { 2.0 } else { 6.0 }
        };
        let of_cell = |cell: &u32| -> f64 {
            let of_simplex = |simplex: &SimplexPieces<f64, D>| -> f64 {
                simplex.cut.inside.iter().map(|piece| of_piece(*cell, simplex.places(piece))).sum()
            };
            self.simplices_of(*cell).iter().map(of_simplex).sum()
        };
        let volume = cells.iter().map(of_cell).sum();
        let place = self.mesh.cell_centre(cells[0] as usize);
        BodyPart { cells, volume, place }
    }
}

instantiate!(cut_parts: Cut::<D>::parts, Cut::<D>::without_islands);

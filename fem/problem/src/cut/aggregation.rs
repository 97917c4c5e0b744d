//! Aggregation: unknowns that only badly cut cells have, given by those of a well-posed cell. It does the work of a ghost penalty without
//! one, and keeps the polynomials of the space (S. Badia, F. Verdugo, A. F. Martín, Comput. Methods Appl. Mech. Engrg. 336 (2018)).

use std::collections::BTreeMap;
use std::sync::Arc;

use super::{Cut, CutError};
use crate::constraints::{Constraints, ConstraintsError};
use crate::instantiate::instantiate;
use crate::mesh::small_matrices::inverse;

/// Basis functions below this are zero except for rounding.
const NOTHING: f64 = 1e-13;

impl<const D: usize> Cut<D> {
    /// The cut with aggregates in place of ghost facets. Each badly cut cell, with its middle outside, belongs to the well-posed cell to which ghost
    /// facets would tie it. [`Cut::hold_outside`] relates the unknowns that no well-posed cell has to those of this cell, by its polynomial
    /// outside of itself. A ghost penalty finds no facets then, and is not needed for any θ.
    ///
    /// Coefficients grow with the degree k and with the distance, to 8 and more for k = 2, and rows of the matrix become longer. A band
    /// ([`Cut::band`]) has ghost facets all the same.
    ///
    /// ```
    /// use forms_fem::cut::Cut;
    /// use forms_fem::prelude::*;
    ///
    /// let mesh = rectangle([-1.0; 2], [1.0; 2], [16, 16], CellShape::Triangle, 1)?;
    /// let phi = Field::interpolate(&Space::scalar(&mesh, 1)?, |x| x[0].hypot(x[1]) - 0.7)?;
    /// let cut = Cut::by(&phi)?.aggregated()?;
    /// let mut constraints = Constraints::new(&Space::vector(&mesh, 2)?);
    /// cut.hold_outside(&mut constraints)?;
    /// assert!(cut.ghost_facets().is_empty() && !constraints.relations().is_empty());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`CutError::Band`] for a cut within a band.
    #[inline(never)]
    pub fn aggregated(&self) -> Result<Arc<Self>, CutError> {
        if self.band.is_some() {
            return Err(CutError::Band);
        }
        let mut cut = self.clone();
        cut.roots = Some(BTreeMap::new());
        cut.list();
        Ok(Arc::new(cut))
    }

    /// The well-posed cell of each badly cut one, along its ties, which come in the order in which cells were reached.
    pub(super) fn roots_of(&self, ties: &[[u32; 2]]) -> BTreeMap<u32, u32> {
        let mut roots: BTreeMap<u32, u32> = BTreeMap::new();
        for &[a, b] in ties {
            let is_from_a = match (roots.contains_key(&a), roots.contains_key(&b)) {
                (true, _) => true,
                (_, true) => false,
                // If neither is tied yet, the deeper one is the root.
                _ => self.rank(a) > self.rank(b),
            };
            let (from, next) = if is_from_a { (a, b) } else { (b, a) };
            let root = roots.get(&from).copied().unwrap_or(from);
            roots.insert(next, root);
        }
        roots
    }

    /// Relations of the unknowns that only badly cut cells have. Prescribed unknowns, and those that are given already, stay as they are.
    pub(super) fn relate_aggregates(&self, constraints: &mut Constraints<D>) -> Result<(), CutError> {
        let Some(roots) = &self.roots else { return Ok(()) };
        let space = constraints.space().clone();
        let (mesh, components) = (&self.mesh, space.components());
        let mut own = vec![false; space.node_count()];
        for cell in
            (0..mesh.cell_count() as u32).filter(|cell| self.is_active(*cell) && !roots.contains_key(cell))
        {
            space.cell_nodes(cell as usize).iter().for_each(|node| own[*node as usize] = true);
        }
        // The deepest of the cells around a node decides.
        let mut tied: Vec<u32> = roots.keys().copied().collect();
        tied.sort_unstable_by_key(|cell| std::cmp::Reverse(self.rank(*cell)));
        let (maps, failed) =
            (mesh.affine_maps(), |error: ConstraintsError| CutError::Constraints { text: error.to_string() });
        for cell in tied {
            let root = roots[&cell] as usize;
            for &node in space.cell_nodes(cell as usize) {
                if std::mem::replace(&mut own[node as usize], true) {
                    continue;
                }
                let curved = || CutError::CurvedAggregate { position: mesh.cell_centre(root).to_vec() };
                let (centre, jacobian) = mesh.map(root, &mesh.cell_shape(root).centre());
                let inverse = inverse(&jacobian).filter(|_| maps.of_cell(root)).ok_or_else(curved)?;
                let x = &space.positions()[node as usize];
                let middle = mesh.cell_shape(root).centre::<D>();
                let reference: [f64; D] = std::array::from_fn(|i| {
                    middle[i] + (0..D).map(|j| inverse[i][j] * (x[j] - centre[j])).sum::<f64>()
                });
                let basis = space.cell_element(root).tabulate(&[reference]).value;
                let terms: Vec<(usize, f64)> = space
                    .cell_nodes(root)
                    .iter()
                    .zip(basis)
                    .filter(|(_, weight)| weight.abs() > NOTHING)
                    .map(|(node, weight)| (*node as usize, weight))
                    .collect();
                for component in 0..components {
                    let unknown = node as usize * components + component;
                    if constraints.is_prescribed(unknown) || constraints.relations().contains_key(&unknown) {
                        continue;
                    }
                    let of_component: Vec<(usize, f64)> =
                        terms.iter().map(|(node, weight)| (node * components + component, *weight)).collect();
                    constraints.relate("aggregation", unknown, &of_component, 0.0).map_err(failed)?;
                }
            }
        }
        Ok(())
    }
}

instantiate!(cut_aggregation: Cut::<D>::aggregated, Cut::<D>::relate_aggregates, Cut::<D>::roots_of);

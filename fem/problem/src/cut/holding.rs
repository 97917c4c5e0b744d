//! Unknowns that belong to no active cell: integrals do not reach them, and a matrix would be singular.

use super::{Cut, CutError};
use crate::constraints::{Constraints, ConstraintsError};
use crate::element::{ElementError, Lagrange};
use crate::instantiate::instantiate;

impl<const D: usize> Cut<D> {
    /// Zero for all unknowns of a space that no active cell has. Those that are prescribed or given by relations already stay as they are. In
    /// cells of a band without body and without ghost facets, unknowns between vertices are interpolated from those at the vertices. With
    /// [aggregates](Cut::aggregated) it relates unknowns that only badly cut cells have to those of well-posed ones.
    ///
    /// # Errors
    /// [`CutError`]: constraints of a space on another mesh or on facets, aggregates of curved cells.
    #[inline(never)]
    pub fn hold_outside(&self, constraints: &mut Constraints<D>) -> Result<(), CutError> {
        let space = constraints.space().clone();
        if !space.mesh().is_same(self.mesh()) {
            return Err(CutError::OtherMesh);
        }
        if space.facet_region().is_some() {
            return Err(CutError::OnFacets);
        }
        self.relate_aggregates(constraints)?;
        let mut active = vec![false; space.node_count()];
        // Cells that carry rigid surfaces are no part of the background.
        let carriers = self.mesh().body_cells().end..self.mesh().cell_count();
        let own = (0..self.mesh().cell_count() as u32)
            .filter(|cell| self.is_active(*cell) || carriers.contains(&(*cell as usize)));
        for cell in own {
            space.cell_nodes(cell as usize).iter().for_each(|node| active[*node as usize] = true);
        }
        let components = space.components();
        let failed = |error: ConstraintsError| CutError::Constraints { text: error.to_string() };
        let mut give = |node: usize, weights: &[(usize, f64)]| -> Result<(), CutError> {
            for component in 0..components {
                let unknown = node * components + component;
                if constraints.is_prescribed(unknown) || constraints.relations().contains_key(&unknown) {
                    continue;
                }
                let terms = weights.iter().map(|(vertex, weight)| (vertex * components + component, *weight));
                match weights.is_empty() {
                    true => constraints.fix_node(node, component, 0.0),
                    false => constraints.relate("band", unknown, &terms.collect::<Vec<_>>(), 0.0),
                }
                .map_err(failed)?;
            }
            Ok(())
        };
        for node in (0..active.len()).filter(|node| !active[*node]) {
            give(node, &[])?;
        }
        if space.degree() < 2 {
            return Ok(());
        }
        let mut known = vec![false; space.node_count()];
        let is_tied = |cell: &u32| self.untied.binary_search(cell).is_err() && self.is_active(*cell);
        for cell in (0..self.mesh().cell_count() as u32).filter(is_tied) {
            space.cell_nodes(cell as usize).iter().for_each(|node| known[*node as usize] = true);
        }
        for &cell in &self.untied {
            let (shape, nodes) = (self.mesh().cell_shape(cell as usize), space.cell_nodes(cell as usize));
            let of_mesh = |error: ElementError| CutError::Mesh { text: error.to_string() };
            let linear = Lagrange::new(shape, 1).map_err(of_mesh)?;
            let points = space.element_of(shape).node_points::<D>();
            let weights = linear.tabulate(&points);
            let vertices: Vec<usize> = linear
                .node_points::<D>()
                .iter()
                .filter_map(|vertex| points.iter().position(|point| point == vertex))
                .map(|place| nodes[place] as usize)
                .collect();
            for (node, weights) in nodes.iter().zip(weights.value.chunks_exact(vertices.len())) {
                if !std::mem::replace(&mut known[*node as usize], true) {
                    let terms = vertices.iter().copied().zip(weights.iter().copied());
                    give(*node as usize, &terms.filter(|(_, weight)| *weight != 0.0).collect::<Vec<_>>())?;
                }
            }
        }
        Ok(())
    }
}

instantiate!(cut_holding: Cut::<D>::hold_outside);

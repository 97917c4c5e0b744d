//! Dirichlet conditions on the normal component: bodies that slide along a plane or a curved boundary.

use super::{Constraints, ConstraintsError};
use crate::element::PerShape;
use crate::space::Scope;

impl<const D: usize> Constraints<D> {
    /// Prescribed u · n on a region, with the normal n at each node as given (of any length but zero); tangential
    /// components stay free.
    ///
    /// # Errors
    /// A space without vectors of D components, an unknown region, a normal that is zero or not finite, a value that
    /// is not finite, or one that contradicts earlier conditions.
    pub fn slide(
        &mut self,
        region: &str,
        normal: impl Fn(&[f64; D]) -> [f64; D],
        value: impl Fn(&[f64; D]) -> f64,
    ) -> Result<(), ConstraintsError> {
        let place = format!("region \"{region}\"");
        self.check_vectors(&place)?;
        let nodes = self.nodes_on(region, &place)?;
        let normals = nodes.iter().map(|&node| normal(&self.space.positions()[node as usize])).collect();
        self.slide_on(&place, &nodes, normals, value)
    }

    /// Prescribed u · n on a region of facets, with the mean of the outward normals of the facets around each node,
    /// weighted by their area elements there: on a smooth boundary. Where it has an edge or corner, state one
    /// condition for each smooth part. On a part of a mesh each process has the region whole (`part.with_surfaces(..)`).
    ///
    /// # Errors
    /// As [`Constraints::slide`]; also a region that is not whole, one of cells or interior facets, or a space that is not continuous.
    pub fn slide_along(
        &mut self,
        region: &str,
        value: impl Fn(&[f64; D]) -> f64,
    ) -> Result<(), ConstraintsError> {
        let place = format!("region \"{region}\"");
        self.check_vectors(&place)?;
        let nodes = self.nodes_to_relate(region, &place)?;
        let space = self.space.clone();
        if *space.scope() != Scope::Nodes {
            let (elements, scope) = (space.elements().clone(), space.scope().clone());
            return Err(ConstraintsError::NoNodes { place, elements, scope });
        }
        let mesh = space.mesh();
        let of_shape = |shape| (shape, space.element_of(shape).node_points::<D>());
        let points: PerShape<_> = mesh.shapes().into_iter().map(of_shape).collect();
        let mut normals = vec![[0.0; D]; nodes.len()];
        for facet in mesh.facets_of_surface(region)? {
            let shape = mesh.cell_shape(facet.cell as usize);
            let corners = shape.facet_vertices(facet.local.into());
            let corner = |place: usize| shape.vertex_points()[corners[place]];
            for local in space.element_of(shape).facet_nodes(facet.local.into()) {
                let (_, jacobian) = mesh.map(facet.cell as usize, &points[shape][local]);
                let tangent = |place: usize| -> [f64; 3] {
                    let (from, to) = (corner(0), corner(place));
                    std::array::from_fn(|i| {
                        if i < D { (0..D).map(|k| jacobian[i][k] * (to[k] - from[k])).sum() } else { 0.0 }
                    })
                };
                let s = tangent(1);
                // In two dimensions the second tangent points out of the plane.
                let t = if D == 2 { [0.0, 0.0, 1.0] } else { tangent(corners.len() - 1) };
                let n = [s[1] * t[2] - s[2] * t[1], s[2] * t[0] - s[0] * t[2], s[0] * t[1] - s[1] * t[0]];
                let node = space.cell_nodes(facet.cell as usize)[local];
                if let Ok(index) = nodes.binary_search(&node) {
                    normals[index].iter_mut().zip(n).for_each(|(sum, n)| *sum += n);
                }
            }
        }
        self.slide_on(&place, &nodes, normals, value)
    }

    #[doc(hidden)]
    pub fn slide_on(
        &mut self,
        place: &str,
        nodes: &[u32],
        normals: Vec<[f64; D]>,
        value: impl Fn(&[f64; D]) -> f64,
    ) -> Result<(), ConstraintsError> {
        let mut changed = self.clone();
        for (&node, normal) in nodes.iter().zip(normals) {
            let position = self.space.positions()[node as usize];
            let length = normal.iter().map(|n| n * n).sum::<f64>().sqrt();
            if !(length > 0.0 && length.is_finite()) {
                let (place, position) = (place.to_owned(), position.to_vec());
                return Err(ConstraintsError::Normal { place, position, normal: normal.to_vec() });
            }
            let value = value(&position);
            if !value.is_finite() {
                let (place, position) = (place.to_owned(), position.to_vec());
                return Err(ConstraintsError::NotFinite { place, component: 0, position, value });
            }
            let terms: Vec<(usize, f64)> =
                (0..D).map(|k| (node as usize * D + k, normal[k] / length)).filter(|t| t.1 != 0.0).collect();
            changed.add_equation(place, &terms, value)?;
        }
        *self = changed;
        Ok(())
    }

    pub(super) fn check_vectors(&self, place: &str) -> Result<(), ConstraintsError> {
        if self.space.shape() == [D] {
            return Ok(());
        }
        let (place, space) = (place.to_owned(), self.space.components());
        Err(ConstraintsError::Components { place, space, value: D })
    }
}

//! Structured meshes: a grid of logical coordinates on \[0,1\]^D, mapped by a closure.

use super::{Facet, Mesh, MeshError};
use crate::element::{CellShape, Lagrange};
use crate::instantiate;

/// A structured grid. Its blocks are squares or cubes; triangles split each square along the diagonal
/// from (0,0) to (1,1), tetrahedra each cube into the six around the diagonal from (0,0,0) to (1,1,1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid<const D: usize> {
    /// Number of blocks per direction.
    pub divisions: [usize; D],
    /// Directions in which the grid closes on itself; these need at least three blocks.
    pub periodic: [bool; D],
    /// Names of the facet regions at the lower and upper end of each direction that is not periodic.
    pub sides: [[&'static str; 2]; D],
    /// Shape of the cells.
    pub shape: CellShape,
    /// Degree of the geometry, 1 or 2.
    pub degree: usize,
}

/// A structured mesh of the unit square or cube, mapped: `map` takes logical coordinates on \[0,1\]^D to
/// positions. Facet regions: left and right (first coordinate), bottom and top (last), in three dimensions
/// also front and back (second).
///
/// # Errors
/// [`MeshError::Parameter`] names a count of divisions that is zero; a map that folds or turns cells gives
/// [`MeshError::Inverted`]; further those of [`Mesh::from_parts`].
pub fn structured<const D: usize>(
    divisions: [usize; D],
    shape: CellShape,
    degree: usize,
    map: impl Fn([f64; D]) -> [f64; D],
) -> Result<Mesh<D>, MeshError> {
    let sides = std::array::from_fn(|k| match k {
        0 => ["left", "right"],
        _ if k + 1 == D => ["bottom", "top"],
        _ => ["front", "back"],
    });
    Grid { divisions, periodic: [false; D], sides, shape, degree }.mesh(map)
}

impl<const D: usize> Grid<D> {
    /// The mesh. Cells and nodes are numbered with the first direction fastest. Node i of n in a direction
    /// has the logical coordinate i/n.
    ///
    /// # Errors
    /// As [`structured`].
    pub fn mesh(&self, map: impl Fn([f64; D]) -> [f64; D]) -> Result<Mesh<D>, MeshError> {
        self.mapped(&map)
    }

    #[inline(never)]
    fn mapped(&self, map: &dyn Fn([f64; D]) -> [f64; D]) -> Result<Mesh<D>, MeshError> {
        let element = Lagrange::geometry(self.shape, self.degree)?;
        if self.shape.dimension() != D {
            return Err(MeshError::Dimension { shape: self.shape, dimension: D });
        }
        let counts = self.node_counts()?;
        let total: usize = counts.iter().product();
        let mut nodes = room("nodes", total, 1)?;
        // Known before any node is made.
        let cells = self.cells(&element, &counts)?;
        nodes.extend((0..total).map(|node| map(self.logical(self.unpack(node, &counts)))));
        let mut mesh = Mesh::from_parts(self.shape, self.degree, nodes, cells)?;
        for direction in (0..D).filter(|&direction| !self.periodic[direction]) {
            for (end, name) in self.sides[direction].into_iter().enumerate() {
                let place = if end == 0 { 0 } else { counts[direction] - 1 };
                let facets = mesh.boundary_facets().iter().copied();
                let facets = facets.filter(|&facet| self.lies_at(&mesh, facet, &counts, direction, place));
                let facets = facets.collect();
                mesh.insert_facets(name, facets)?;
            }
        }
        Ok(mesh)
    }

    // Number of different nodes per direction.
    fn node_counts(&self) -> Result<[usize; D], MeshError> {
        let mut total = 1_usize;
        let mut counts = [0; D];
        for (k, count) in counts.iter_mut().enumerate() {
            let (divisions, least) = (self.divisions[k], if self.periodic[k] { 3 } else { 1 });
            if divisions < least {
                return Err(MeshError::Parameter {
                    parameter: "divisions",
                    value: format!("{:?}", self.divisions),
                    requirement: "each direction needs at least 1, a periodic one at least 3",
                });
            }
            let too_large = MeshError::TooLarge { what: "nodes" };
            let steps = divisions.checked_mul(self.degree).ok_or(too_large.clone())?;
            *count = steps.checked_add(usize::from(!self.periodic[k])).ok_or(too_large.clone())?;
            total = total.checked_mul(*count).ok_or(too_large.clone())?;
            if u32::try_from(total).is_err() {
                return Err(too_large);
            }
        }
        Ok(counts)
    }

    fn unpack(&self, mut index: usize, counts: &[usize; D]) -> [usize; D] {
        counts.map(|count| {
            let digit = index % count;
            index /= count;
            digit
        })
    }

    fn logical(&self, place: [usize; D]) -> [f64; D] {
        std::array::from_fn(|k| place[k] as f64 / (self.divisions[k] * self.degree) as f64)
    }

    fn cells(&self, element: &Lagrange, counts: &[usize; D]) -> Result<Vec<u32>, MeshError> {
        let templates = self.templates(element);
        let blocks: usize = self.divisions.iter().product();
        let count = blocks.checked_mul(templates.len()).filter(|count| u32::try_from(*count).is_ok());
        let count = count.ok_or(MeshError::TooLarge { what: "cells" })?;
        let mut cells = room("cells", count, element.nodes())?;
        for block in 0..blocks {
            let corner = self.unpack(block, &self.divisions).map(|place| place * self.degree);
            for template in &templates {
                for steps in template {
                    let node = (0..D).rev().fold(0, |node, k| {
                        // Only a periodic direction wraps.
                        node * counts[k] + (corner[k] + steps[k]) % counts[k]
                    });
                    cells.push(node as u32);
                }
            }
        }
        Ok(cells)
    }

    // For each cell of a block: the places of its nodes, in steps of 1/degree block.
    fn templates(&self, element: &Lagrange) -> Vec<Vec<[usize; D]>> {
        let points = element.node_points::<D>();
        let degree = self.degree as f64;
        // Half steps are exact in floating point.
        let steps = |x: [f64; D]| x.map(|coordinate| (degree * coordinate).round() as usize);
        if !self.shape.is_simplex() {
            return vec![points.into_iter().map(steps).collect()];
        }
        // A path from corner 0 to the opposite one per order of the directions; every second one has its
        // last two vertices swapped, so that all are positively oriented.
        let paths: &[[usize; 3]] = if D == 2 {
            &[[0, 1, 2], [1, 0, 2]]
        } else {
            &[[0, 1, 2], [1, 2, 0], [2, 0, 1], [1, 0, 2], [0, 2, 1], [2, 1, 0]]
        };
        let simplex = |(index, path): (usize, &[usize; 3])| {
            let mut vertices = vec![[0.0; D]];
            let mut vertex = [0.0; D];
            for &direction in &path[..D] {
                vertex[direction] = 1.0;
                vertices.push(vertex);
            }
            if index >= paths.len() / 2 {
                vertices.swap(D - 1, D);
            }
            let place = |point: &[f64; D]| {
                let first = 1.0 - point.iter().sum::<f64>();
                steps(std::array::from_fn(|k| {
                    first * vertices[0][k] + (0..D).map(|v| point[v] * vertices[v + 1][k]).sum::<f64>()
                }))
            };
            points.iter().map(place).collect()
        };
        paths.iter().enumerate().map(simplex).collect()
    }

    fn lies_at(
        &self,
        mesh: &Mesh<D>,
        facet: Facet,
        counts: &[usize; D],
        direction: usize,
        place: usize,
    ) -> bool {
        let nodes = mesh.cell(facet.cell as usize);
        let vertices = self.shape.facet_vertices(usize::from(facet.local));
        vertices.iter().all(|&v| self.unpack(nodes[v] as usize, counts)[direction] == place)
    }
}

/// Memory for a list of the given number of nodes or cells, each of `length` parts. Too little memory is an error, not an abort.
fn room<T>(what: &'static str, count: usize, length: usize) -> Result<Vec<T>, MeshError> {
    let mut list = Vec::new();
    let parts = count.saturating_mul(length);
    match list.try_reserve_exact(parts) {
        Ok(()) => Ok(list),
        Err(_) => {
            let bytes = parts.saturating_mul(size_of::<T>());
            Err(MeshError::NoMemory { what, count, bytes })
        }
    }
}

instantiate!(structured: Grid::<D>::mapped);

#[cfg(test)]
mod tests {
    use super::*;

    /// Counts that no list can have are refused before anything is made.
    #[test]
    fn absurd_counts_are_refused_at_once() {
        let nothing = |_: [f64; 3]| -> [f64; 3] { panic!("a node was made") };
        // 1.0·10⁹ nodes can be numbered, 6·10⁹ tetrahedra cannot.
        let mesh = structured([1000; 3], CellShape::Tetrahedron, 1, nothing);
        assert_eq!(mesh.err(), Some(MeshError::TooLarge { what: "cells" }));
        let mesh = structured([usize::MAX / 2, 3, 3], CellShape::Hexahedron, 2, nothing);
        assert_eq!(mesh.err(), Some(MeshError::TooLarge { what: "nodes" }));
        let refused = room::<[f64; 2]>("nodes", usize::MAX / 32, 1).map(|list| list.len());
        let message = refused.err().map(|error| error.to_string()).unwrap_or_default();
        assert!(
            message.starts_with("there is not enough memory for 576460752303423487 nodes, "),
            "{message}"
        );
    }
}

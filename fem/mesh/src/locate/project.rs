//! The point of a cell's boundary that is nearest to a given point.

use crate::element::CellShape;
use crate::mesh::small_matrices::inverse;
use crate::mesh::{Facet, Mesh};

// A facet, edge or vertex of the reference cell: origin + Σ s_k tangents[k].
struct Entity<const D: usize> {
    origin: [f64; D],
    tangents: [[f64; D]; 2],
    // Dimension: 2 a face, 1 an edge, 0 a vertex.
    dimension: usize,
}

/// The reference coordinates of the boundary point of a cell that is nearest to `point`, and its distance
/// \[length\]. Exact on straight facets; on curved ones a stationary point of the distance, which is the
/// nearest one as long as the distance is small against the radius of curvature.
pub(super) fn project<const D: usize>(mesh: &Mesh<D>, cell: usize, point: &[f64; D]) -> ([f64; D], f64) {
    let shape = mesh.cell_shape(cell);
    let mut best = ([0.0; D], f64::INFINITY);
    for entity in entities::<D>(shape) {
        if let Some(reference) = stationary(mesh, cell, point, &entity, 0.0) {
            let distance = super::distance(point, &mesh.map(cell, &reference).0);
            if distance < best.1 {
                best = (reference, distance);
            }
        }
    }
    best
}

fn entities<const D: usize>(shape: CellShape) -> Vec<Entity<D>> {
    let corner = |vertex: usize| -> [f64; D] { std::array::from_fn(|k| shape.vertex_points()[vertex][k]) };
    let tangent = |from: usize, to: usize| -> [f64; D] {
        let (from, to) = (corner(from), corner(to));
        std::array::from_fn(|k| to[k] - from[k])
    };
    let mut result = Vec::new();
    if D == 3 {
        result.extend((0..shape.facets()).map(|local| on_facet(shape, local)));
    }
    for &[a, b] in shape.edges() {
        result.push(Entity { origin: corner(a), tangents: [tangent(a, b), [0.0; D]], dimension: 1 });
    }
    for vertex in 0..shape.vertices() {
        result.push(Entity { origin: corner(vertex), tangents: [[0.0; D]; 2], dimension: 0 });
    }
    result
}

/// The point of a facet that is nearest to a given point, in reference coordinates of its cell, and its distance \[length\], where
/// the nearest point of the facet's surface lies on the facet, enlarged by `tolerance` in the facet's reference coordinates; `None`
/// otherwise. As exact as `project`.
pub fn nearest_on_facet<const D: usize>(
    mesh: &Mesh<D>,
    facet: Facet,
    point: &[f64; D],
    tolerance: f64,
) -> Option<([f64; D], f64)> {
    let cell = facet.cell as usize;
    let shape = mesh.cell_shape(cell);
    let entity = on_facet(shape, usize::from(facet.local));
    let reference = stationary(mesh, cell, point, &entity, tolerance)?;
    let distance = super::distance(point, &mesh.map(cell, &reference).0);
    Some((reference, distance))
}

// A facet: a face in space, an edge in the plane.
fn on_facet<const D: usize>(shape: CellShape, local: usize) -> Entity<D> {
    let vertices = shape.facet_vertices(local);
    let corner = |vertex: usize| -> [f64; D] { std::array::from_fn(|k| shape.vertex_points()[vertex][k]) };
    let origin = corner(vertices[0]);
    let tangent = |to: usize| std::array::from_fn(|k| corner(to)[k] - origin[k]);
    Entity {
        origin,
        tangents: [tangent(vertices[1]), tangent(vertices[vertices.len() - 1])],
        dimension: D - 1,
    }
}

// Gauss-Newton steps from the entity's centre; `None` when they leave it: then an edge or vertex is nearer.
fn stationary<const D: usize>(
    mesh: &Mesh<D>,
    cell: usize,
    point: &[f64; D],
    entity: &Entity<D>,
    tolerance: f64,
) -> Option<[f64; D]> {
    let simplex = mesh.cell_shape(cell).is_simplex();
    let at = |s: [f64; 2]| -> [f64; D] {
        std::array::from_fn(|i| {
            entity.origin[i] + s[0] * entity.tangents[0][i] + s[1] * entity.tangents[1][i]
        })
    };
    if entity.dimension == 0 {
        return Some(entity.origin);
    }
    let mut s = match entity.dimension {
        1 => [0.5, 0.0],
        _ if simplex => [1.0 / 3.0; 2],
        _ => [0.5; 2],
    };
    for _ in 0..40 {
        let (x, jacobian) = mesh.map(cell, &at(s));
        let columns = entity
            .tangents
            .map(|t| -> [f64; D] { std::array::from_fn(|i| (0..D).map(|j| jacobian[i][j] * t[j]).sum()) });
        let product = |a: &[f64; D], b: &[f64; D]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let residual: [f64; D] = std::array::from_fn(|i| point[i] - x[i]);
        let right = columns.map(|column| product(&column, &residual));
        let step = if entity.dimension == 1 {
            [right[0] / product(&columns[0], &columns[0]), 0.0]
        } else {
            let inverse = inverse(&columns.map(|a| columns.map(|b| product(&a, &b))))?;
            inverse.map(|row| row[0] * right[0] + row[1] * right[1])
        };
        let length = step[0].abs().max(step[1].abs());
        if !length.is_finite() {
            return None;
        }
        let factor = 1.0 / length.max(1.0);
        s = [s[0] + factor * step[0], s[1] + factor * step[1]];
        if length < 1e-13 {
            break;
        }
    }
    let reference =
        if simplex && entity.dimension == 2 { CellShape::Triangle } else { CellShape::Quadrilateral };
    reference.contains(&s, tolerance).then(|| at(s))
}

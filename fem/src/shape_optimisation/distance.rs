//! The distance between the boundaries of two shapes.

use crate::locate::PieceTree;
use crate::mesh::{Mesh, MeshError};

/// Straight pieces for each facet.
const PIECES: usize = 16;

/// Distances between a boundary and another shape's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundaryDistance {
    /// The largest distance of a node of one boundary to the other curve \[length\].
    pub largest: f64,
    /// Their mean.
    pub mean: f64,
    /// The largest distance between the two places of a node, where both shapes have the same cells: what slides along the
    /// curve counts, too.
    pub largest_of_nodes: Option<f64>,
}

/// From the nodes on a region of facets of one shape to the same region of another shape, in the plane.
///
/// # Errors
/// A region that does not exist.
pub fn boundary_distance(from: &Mesh<2>, to: &Mesh<2>, region: &str) -> Result<BoundaryDistance, MeshError> {
    let mut nodes: Vec<u32> = Vec::new();
    for facet in from.facet_region(region)? {
        let local = from.cell_element(facet.cell as usize).facet_nodes(facet.local.into());
        nodes.extend(local.iter().map(|&node| from.cell(facet.cell as usize)[node]));
    }
    let mut segments = Vec::new();
    for facet in to.facet_region(region)? {
        let (cell, shape) = (facet.cell as usize, to.cell_shape(facet.cell as usize));
        let [a, b] = shape.edges()[usize::from(facet.local)].map(|vertex| shape.vertex_points()[vertex]);
        let point = |k: usize| {
            let t = k as f64 / PIECES as f64;
            to.map(cell, &std::array::from_fn(|i| (1.0 - t) * a[i] + t * b[i])).0
        };
        segments.extend((0..PIECES).map(|k| [point(k), point(k + 1)]));
    }
    let segments = PieceTree::new(segments);
    nodes.sort_unstable();
    nodes.dedup();
    let (mut largest, mut sum, mut of_nodes) = (0.0_f64, 0.0, 0.0_f64);
    let same_cells = from.cells() == to.cells();
    for &node in &nodes {
        let x = from.nodes()[node as usize];
        let nearest = segments.distance(&x);
        largest = largest.max(nearest);
        sum += nearest;
        if same_cells {
            let other = to.nodes()[node as usize];
            of_nodes = of_nodes.max((x[0] - other[0]).hypot(x[1] - other[1]));
        }
    }
    let largest_of_nodes = same_cells.then_some(of_nodes);
    Ok(BoundaryDistance { largest, mean: sum / nodes.len() as f64, largest_of_nodes })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::CellShape;
    use crate::mesh::annulus;

    #[test]
    fn a_circle_that_turns_and_grows() {
        let ring = annulus(1.0, 2.0, 1, 16, CellShape::Quadrilateral, 2).unwrap();
        let (sine, cosine) = 0.05_f64.sin_cos();
        let moved = ring.nodes().iter().map(|x| {
            let scale = if x[0].hypot(x[1]) > 1.9 { 1.01 } else { 1.0 };
            [scale * (cosine * x[0] - sine * x[1]), scale * (sine * x[0] + cosine * x[1])]
        });
        let moved = ring.with_nodes(moved.collect()).unwrap();
        let outer = boundary_distance(&ring, &moved, "outer").unwrap();
        // Parabolas and their 16 pieces miss the circle by less than 10⁻³ of its radius.
        assert!((outer.largest - 0.02).abs() < 1e-3 && (outer.mean - 0.02).abs() < 1e-3, "{outer:?}");
        let chord = (2.0_f64.powi(2) + 2.02_f64.powi(2) - 2.0 * 2.0 * 2.02 * cosine).sqrt();
        assert!((outer.largest_of_nodes.unwrap() - chord).abs() < 1e-12);
        let inner = boundary_distance(&ring, &moved, "inner").unwrap();
        assert!(inner.largest < 1e-3 && inner.largest_of_nodes.unwrap() > 0.04);
        assert!(boundary_distance(&ring, &moved, "nowhere").is_err());
    }
}

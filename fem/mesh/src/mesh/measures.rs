//! Volumes of meshes and measures of regions, for tests.

use super::geometry::determinant;
use super::{Mesh, MeshError};
use crate::quadrature::{cell_rule, facet_rule};

/// The volume, or area in the plane.
pub(super) fn volume<const D: usize>(mesh: &Mesh<D>) -> f64 {
    let of_cell = |cell| {
        let rule = cell_rule::<D>(mesh.cell_shape(cell), 8).expect("degree 8 exists");
        let points = rule.points.iter().zip(&rule.weights);
        points.map(|(x, w)| w * determinant(&mesh.map(cell, x).1)).sum::<f64>()
    };
    (0..mesh.cell_count()).map(of_cell).sum()
}

/// The region's measure, and the integral of x·n over it.
pub(super) fn surface<const D: usize>(mesh: &Mesh<D>, region: &str) -> Result<(f64, f64), MeshError> {
    let (mut area, mut flux) = (0.0, 0.0);
    for facet in mesh.sides_of(region)?.iter().map(|sides| sides[0]) {
        let rule = facet_rule::<D>(mesh.cell_shape(facet.cell as usize), facet.local.into(), 8)
            .expect("degree 8 exists");
        for (point, weight) in rule.points.iter().zip(&rule.weights) {
            let (x, jacobian) = mesh.map(facet.cell as usize, point);
            let [s, t] = rule.tangents.map(|tangent| -> [f64; D] {
                std::array::from_fn(|i| (0..D).map(|j| jacobian[i][j] * tangent[j]).sum())
            });
            let normal: [f64; D] = std::array::from_fn(|i| match (D, i) {
                (2, 0) => s[1],
                (2, _) => -s[0],
                _ => s[(i + 1) % D] * t[(i + 2) % D] - s[(i + 2) % D] * t[(i + 1) % D],
            });
            area += weight * normal.iter().map(|n| n * n).sum::<f64>().sqrt();
            flux += weight * normal.iter().zip(&x).map(|(n, x)| n * x).sum::<f64>();
        }
    }
    Ok((area, flux))
}

pub(super) fn close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance * b.abs().max(1.0), "{a} is not {b}");
}

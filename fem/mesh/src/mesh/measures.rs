//! Volumes of meshes, measures of regions and places of parts, for tests.

use std::collections::BTreeMap;

use super::small_matrices::determinant;
use super::{INTERIOR, Mesh, MeshError, Nesting};
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
    for sides in mesh.sides_of(region)? {
        let (facet, sign) = match sides[..] {
            // Seen from the first side, at the points of the smaller one.
            [first, second] => {
                let smaller = mesh.smaller_side(&[first, second]);
                (smaller, if smaller == first { 1.0 } else { -1.0 })
            }
            _ => (sides[0], 1.0),
        };
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
            flux += sign * weight * normal.iter().zip(&x).map(|(n, x)| n * x).sum::<f64>();
        }
    }
    Ok((area, flux))
}

pub(super) fn close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance * b.abs().max(1.0), "{a} is not {b}");
}

/// Regions of the first mesh with their measures.
pub(super) fn measures<const D: usize>(mesh: &Mesh<D>) -> Result<BTreeMap<String, [f64; 2]>, MeshError> {
    let mut found = BTreeMap::new();
    for name in mesh.facet_region_names().chain(mesh.interior_facet_region_names()) {
        if name != INTERIOR {
            let (area, flux) = surface(mesh, name)?;
            found.insert(name.to_owned(), [area, flux]);
        }
    }
    for name in mesh.cell_region_names() {
        let cells =
            mesh.cell_region(name)?.iter().flat_map(|cell| mesh.cell(*cell as usize).to_vec()).collect();
        let alone = Mesh::of_sound_cells(mesh.degree, mesh.nodes.clone(), vec![(mesh.cell_shape(0), cells)])?;
        found.insert(name.to_owned(), [volume(&alone), 0.0]);
    }
    Ok(found)
}

/// Asserts that the parts of cells lie where the nesting says.
pub(super) fn check_nesting<const D: usize>(coarse: &Mesh<D>, fine: &Mesh<D>, nesting: &Nesting<D>) {
    assert_eq!(nesting.coarse_cell_count(), coarse.cell_count());
    assert_eq!(nesting.fine_cell_count(), fine.cell_count());
    // A bisection halves a cell once, a division into 2^D parts D times.
    let simplex = fine.cell_shape(0).is_simplex();
    let halvings = if simplex { 1 } else { D };
    for cell in 0..fine.cell_count() {
        let parent = nesting.coarse_cell(cell);
        assert!(nesting.fine_cells(parent).contains(&cell));
        for point in [[0.0; D], [0.25; D], std::array::from_fn(|k| if k == 0 { 0.5 } else { 0.125 })] {
            let here = fine.map(cell, &point).0;
            let there = coarse.map(parent, &nesting.to_coarse(cell, &point)).0;
            here.iter().zip(&there).for_each(|(x, y)| close(*x, *y, 1e-13));
        }
        let volume = 0.5_f64.powi((nesting.divisions(cell) * halvings) as i32);
        let vertices = nesting.vertices(cell);
        let ends: [usize; 3] = match (simplex, D) {
            (true, _) => [1, 2, 3],
            (false, 2) => [1, 3, 3],
            (false, _) => [1, 3, 4],
        };
        let edges: [[f64; D]; D] =
            std::array::from_fn(|j| std::array::from_fn(|i| vertices[ends[j]][i] - vertices[0][i]));
        assert_eq!(determinant(&edges), volume);
    }
}

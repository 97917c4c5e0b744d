//! Refined meshes compared with their parents and with circles.

use super::*;
use crate::mesh::measures::{close, surface, volume};
use crate::mesh::small_matrices::inverse;
use crate::mesh::{INTERIOR, annulus, cuboid, rectangle, structured};

// Regions with their measures, and how many facets there are, before and after.
fn check<const D: usize>(coarse: &Mesh<D>) -> Result<Mesh<D>, MeshError> {
    let fine = coarse.refined()?;
    assert_eq!((fine.shapes(), fine.degree()), (coarse.shapes(), coarse.degree()));
    assert_eq!(fine.cell_count(), coarse.cell_count() << D);
    close(volume(&fine), volume(coarse), 1e-12);
    let small = 1 << (D - 1);
    assert_eq!(fine.boundary_facets().len(), coarse.boundary_facets().len() * small);
    // A facet between cells gives 2^(D-1); inside a cell there are 3, 4, 8 and 12.
    let inside = match coarse.cell_shape(0) {
        CellShape::Triangle => 3,
        CellShape::Quadrilateral => 4,
        CellShape::Tetrahedron => 8,
        CellShape::Hexahedron => 12,
    };
    let between = coarse.interior_facets().len() * small + coarse.cell_count() * inside;
    assert_eq!(fine.interior_facets().len(), between);
    assert_eq!(fine.cell_regions.keys().collect::<Vec<_>>(), coarse.cell_regions.keys().collect::<Vec<_>>());
    let exterior = coarse.facet_region_names().chain(coarse.interior_facet_region_names());
    for name in exterior {
        if name == INTERIOR {
            continue;
        }
        assert_eq!(fine.sides_of(name)?.len(), coarse.sides_of(name)?.len() * small, "{name}");
        let ((area, flux), (old_area, old_flux)) = (surface(&fine, name)?, surface(coarse, name)?);
        // The measure of what is curved is no integral of a polynomial.
        let tolerance = if coarse.is_affine() { 1e-12 } else { 1e-6 };
        close(area, old_area, tolerance);
        close(flux, old_flux, 1e-12);
    }
    // Every node is used, and none occurs twice.
    let mut used = vec![false; fine.node_count()];
    fine.cells().iter().for_each(|&node| used[node as usize] = true);
    assert!(used.iter().all(|&used| used));
    let mut sorted: Vec<_> = fine.nodes().to_vec();
    sorted.sort_by(|a, b| a.partial_cmp(b).expect("finite"));
    assert!(sorted.windows(2).all(|pair| pair[0] != pair[1]));
    Ok(fine)
}

#[test]
fn regions_and_volumes_stay() -> Result<(), MeshError> {
    for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
        for degree in 1..=2 {
            let mut mesh = rectangle([0.0; 2], [3.0, 2.0], [3, 2], shape, degree)?;
            mesh.name_cells("left part", |centre| centre[0] < 1.0)?;
            mesh.name_cells("right part", |centre| centre[0] > 1.0)?;
            mesh.name_interface("seam", "right part", "left part")?;
            let fine = check(&check(&mesh)?)?;
            assert_eq!(fine.cell_region("left part")?.len(), mesh.cell_region("left part")?.len() * 16);
            // The first side is the same as before.
            for [first, second] in fine.interior_facet_region("seam")? {
                assert!(fine.cell_centre(first.cell as usize)[0] > 1.0);
                assert!(fine.cell_centre(second.cell as usize)[0] < 1.0);
            }
            check(&check(&annulus(1.0, 2.0, 1, 5, shape, degree)?)?)?;
        }
    }
    for shape in [CellShape::Tetrahedron, CellShape::Hexahedron] {
        for degree in 1..=2 {
            let mut mesh = cuboid([0.0; 3], [1.0, 2.0, 3.0], [1, 2, 1], shape, degree)?;
            mesh.name_interior_facets("middle", INTERIOR, |centre| (centre[1] - 1.0).abs() < 1e-12)?;
            check(&check(&mesh)?)?;
            let twist = |[r, s, t]: [f64; 3]| {
                let (sine, cosine) = (0.5 * t).sin_cos();
                [cosine * r - sine * s, sine * r + cosine * s, t + 0.1 * r * s]
            };
            check(&structured([2, 1, 1], shape, degree, twist)?)?;
        }
    }
    Ok(())
}

// A refined grid is the finer grid.
#[test]
fn the_nodes_are_those_of_the_finer_grid() -> Result<(), MeshError> {
    let sorted = |mesh: Mesh<2>| {
        let mut nodes = mesh.nodes().to_vec();
        nodes.sort_by(|a, b| a.partial_cmp(b).expect("finite"));
        nodes
    };
    for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
        for degree in 1..=2 {
            let coarse = rectangle([0.0; 2], [4.0, 2.0], [2, 2], shape, degree)?;
            let fine = rectangle([0.0; 2], [4.0, 2.0], [4, 4], shape, degree)?;
            assert_eq!(sorted(coarse.refined()?), sorted(fine));
        }
    }
    Ok(())
}

// Children of a cell lie in it, in their places.
#[test]
fn children_lie_in_their_parents() -> Result<(), MeshError> {
    let mesh = cuboid([0.0; 3], [1.0; 3], [2, 1, 1], CellShape::Tetrahedron, 1)?;
    let fine = mesh.refined()?;
    for cell in 0..fine.cell_count() {
        let (origin, jacobian) = mesh.map(cell / 8, &[0.0; 3]);
        let inverse = inverse(&jacobian).expect("the cell is not degenerate");
        let centre = fine.cell_centre(cell);
        let reference: [f64; 3] =
            std::array::from_fn(|i| (0..3).map(|j| inverse[i][j] * (centre[j] - origin[j])).sum());
        assert!(mesh.cell_shape(cell).contains(&reference, 0.0), "{cell} {reference:?}");
    }
    Ok(())
}

// Chords: order 2 in h. Parabolas: order 4.
#[test]
fn nodes_moved_onto_circles_make_the_area_converge() -> Result<(), MeshError> {
    let onto = |radius: f64| move |x: &[f64; 2]| x.map(|k| k * radius / x[0].hypot(x[1]));
    let (inner, outer) = (onto(1.0), onto(2.0));
    let surfaces: [Surface<2>; 2] = [("inner", &inner), ("outer", &outer)];
    for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
        for (degree, order) in [(1, 2.0), (2, 4.0)] {
            let mut mesh = annulus(1.0, 2.0, 1, 6, shape, degree)?;
            let mut errors = vec![];
            for _ in 0..4 {
                errors.push((volume(&mesh) - 3.0 * std::f64::consts::PI).abs());
                mesh = mesh.refined_onto(&surfaces)?;
            }
            let rate = (errors[2] / errors[3]).log2();
            assert!((rate - order).abs() < 0.1, "{shape:?} {degree}: order {rate}");
            for facet in mesh.facet_region("outer")? {
                for node in mesh.cell_element(facet.cell as usize).facet_nodes(facet.local.into()) {
                    let x = mesh.nodes()[mesh.cell(facet.cell as usize)[node] as usize];
                    assert!((x[0].hypot(x[1]) - 2.0).abs() < 1e-15 * 4.0);
                }
            }
        }
    }
    Ok(())
}

// The tetrahedra of a cube have children like themselves (Freudenthal); others do not degenerate.
#[test]
fn tetrahedra_keep_their_shape() -> Result<(), MeshError> {
    let mut mesh = cuboid([0.0; 3], [1.0; 3], [1; 3], CellShape::Tetrahedron, 1)?;
    let start = mesh.quality();
    for _ in 0..3 {
        mesh = mesh.refined()?;
        for (found, expected) in mesh.quality().scaled_jacobian().into_iter().zip(start.scaled_jacobian()) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
    }
    let nodes = vec![[0.0; 3], [1.0, 0.1, 0.3], [0.2, 0.9, -0.1], [0.4, 0.2, 1.3]];
    let mut mesh = Mesh::from_parts(CellShape::Tetrahedron, 1, nodes, vec![0, 1, 2, 3])?;
    let first = mesh.refined()?.quality().scaled_jacobian()[0];
    for _ in 0..5 {
        mesh = mesh.refined()?;
    }
    let last = mesh.quality().scaled_jacobian()[0];
    assert!(last > 0.999 * first, "{last} {first}");
    Ok(())
}

#[test]
fn mistakes_are_named() -> Result<(), MeshError> {
    let mesh = annulus(1.0, 2.0, 1, 6, CellShape::Quadrilateral, 2)?;
    let message = |region: &str, map: &dyn Fn(&[f64; 2]) -> [f64; 2]| {
        mesh.refined_onto(&[(region, map)]).err().map(|error| error.to_string()).unwrap_or_default()
    };
    assert!(message("rim", &|x| *x).starts_with("there is no region \"rim\""));
    assert!(message("outer", &|_| [f64::NAN; 2]).contains("has a coordinate that is not finite"));
    assert!(message("outer", &|x| x.map(|x| 0.1 * x)).contains("is inverted or degenerate"));
    Ok(())
}

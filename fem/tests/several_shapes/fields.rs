//! Fields on two shapes: places are found, values and gradients read, meshes compared and moved, conditions imposed.

use forms_fem::locate::Locator;
use forms_fem::norms::{Comparison, errors_between};
use forms_fem::prelude::*;

use super::{patchwork, rough};

#[forms(dimension = 2)]
mod derived {
    pub fn slope(u: Scalar) -> Vector {
        grad(u)
    }
    pub fn square(u: Scalar) -> Scalar {
        u * u
    }
    pub fn outward() -> Vector {
        n
    }
    pub fn leap(u: Scalar) -> Scalar {
        jump(u)
    }
}

/// Points all over the unit square.
fn points() -> Vec<[f64; 2]> {
    (0..200).map(|k| [(f64::from(k) * 0.618_034).fract(), (f64::from(k) * 0.754_877).fract()]).collect()
}

#[test]
fn every_point_is_found_in_its_cell() {
    for geometry in 1..=2 {
        let mesh = patchwork(7, geometry);
        let locator = Locator::new(&mesh);
        let mut shapes = Vec::new();
        for point in points() {
            let (cell, reference) = locator.find(&point).unwrap();
            shapes.push(mesh.cell_shape(cell));
            assert!(mesh.cell_shape(cell).contains(&reference, 1e-9));
            let x = mesh.map(cell, &reference).0;
            assert!((x[0] - point[0]).hypot(x[1] - point[1]) < 1e-12);
        }
        assert!(shapes.contains(&CellShape::Triangle) && shapes.contains(&CellShape::Quadrilateral));
        assert!(locator.find(&[1.1, 0.5]).is_none());
        let nearest = locator.find_nearest(&[1.05, 0.5], 0.1).unwrap();
        assert!((nearest.distance - 0.05).abs() < 1e-12);
    }
}

#[test]
fn values_and_gradients_are_those_of_the_function() {
    let mesh = patchwork(6, 1);
    let assembler = Assembler::new(&mesh);
    let value = |x: &[f64; 2]| x[0] * x[0] - 3.0 * x[0] * x[1] + x[1];
    let slope = |x: &[f64; 2]| [2.0 * x[0] - 3.0 * x[1], 1.0 - 3.0 * x[0]];
    for degree in 2..=4 {
        let u = Field::interpolate(&Space::scalar(&mesh, degree).unwrap(), value).unwrap();
        let points = points();
        let sampled = assembler.at_points(&derived::slope(&u), &points).unwrap();
        for (point, sampled) in points.iter().zip(&sampled.values) {
            assert!((u.evaluate(point).unwrap()[0] - value(point)).abs() < 1e-12);
            for found in [u.gradient(point).unwrap(), sampled.clone()] {
                assert!(found.iter().zip(slope(point)).all(|(a, b)| (a - b).abs() < 1e-11));
            }
        }
        // Region by region, each cell with its own rule.
        for region in ["all", "squares", "triangles", "every other"] {
            let found =
                assembler.at_quadrature_points(&derived::slope(&u), Entity::Cells, region, 4).unwrap();
            for (x, found) in found.positions.iter().zip(&found.values) {
                assert!(found.iter().zip(slope(x)).all(|(a, b)| (a - b).abs() < 1e-11));
            }
        }
        let jumps = assembler.along_facets_uniformly(&derived::leap(&u), "seam", 5).unwrap();
        assert!(jumps.iter().all(|sample| sample.value[0].abs() < 1e-13));
        let square = assembler.project(&derived::square(&u), &Space::scalar(&mesh, 4).unwrap()).unwrap();
        for point in &points {
            assert!((square.evaluate(point).unwrap()[0] - value(point).powi(2)).abs() < 1e-10);
        }
        let slopes = assembler
            .at_facet_nodes(&derived::slope(&u), "top", &Space::vector(&mesh, degree).unwrap())
            .unwrap();
        for &node in &slopes.space().nodes_on("top").unwrap() {
            let x = slopes.space().positions()[node as usize];
            assert!(slopes.at_node(node as usize).iter().zip(slope(&x)).all(|(a, b)| (a - b).abs() < 1e-11));
        }
    }
}

#[test]
fn normals_point_outward() {
    let mesh = patchwork(6, 2);
    let assembler = Assembler::new(&mesh);
    for (region, expected) in
        [("left", [-1.0, 0.0]), ("right", [1.0, 0.0]), ("bottom", [0.0, -1.0]), ("top", [0.0, 1.0])]
    {
        for sample in assembler.along_facets_uniformly(&derived::outward(), region, 3).unwrap() {
            assert!(sample.value.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{sample:?}");
        }
    }
}

#[test]
fn norms_and_comparisons_between_meshes() {
    let coarse = patchwork(3, 1);
    let fine = coarse.refined().unwrap();
    let value = |x: &[f64; 2]| x[0] * x[0] - x[1];
    let on = |mesh: &Mesh<2>| Field::interpolate(&Space::scalar(mesh, 2).unwrap(), value).unwrap();
    let (a, b) = (on(&fine), on(&coarse));
    let assembler = Assembler::new(&fine);
    assert!(errors_between(&assembler, &a, &b).unwrap().h1 < 1e-12);
    // ∫ (x² − y)² over the unit square = 1/5 − 1/3 + 1/3.
    assert!((norms::l2_norm(&assembler, &a).unwrap().powi(2) - 0.2).abs() < 1e-12);
    assert!((norms::mean(&assembler, &a).unwrap()[0] - (1.0 / 3.0 - 0.5)).abs() < 1e-13);
    let zero = Field::zero(&Space::scalar(&coarse, 1).unwrap());
    let comparison = Comparison::new(&assembler, zero.space(), 6).unwrap();
    assert!((comparison.errors(&a, &zero).unwrap().l2.powi(2) - 0.2).abs() < 1e-12);
}

#[test]
fn meshes_move_along_fields() {
    for geometry in 1..=2 {
        let mesh = patchwork(5, geometry);
        let along = Field::interpolate(&Space::of_geometry(&mesh).unwrap(), |x| [0.5 * x[1], x[0]]).unwrap();
        let moved = along.move_mesh(0.5).unwrap();
        assert_eq!((moved.blocks(), moved.cells()), (mesh.blocks(), mesh.cells()));
        for (before, after) in mesh.nodes().iter().zip(moved.nodes()) {
            let expected = [before[0] + 0.25 * before[1], before[1] + 0.5 * before[0]];
            assert!((0..2).all(|k| (after[k] - expected[k]).abs() < 1e-14));
        }
        // Coefficients go along, and cells that fold are named.
        let u = rough(&Space::scalar(&mesh, 3).unwrap());
        let carried = u.carried_to(&Space::scalar(&moved, 3).unwrap()).unwrap();
        assert_eq!(carried.values(), u.values());
        assert!(along.move_mesh(2.0).unwrap_err().to_string().contains("is inverted"));
        // The rate of the diameters against a difference.
        let (step, rate) = (1e-6, along.rate_of_diameter().unwrap());
        let [forth, back] = [step, -step].map(|step| along.move_mesh(step).unwrap());
        for cell in 0..mesh.cell_count() {
            let difference = (forth.diameter(cell) - back.diameter(cell)) / (2.0 * step);
            let node = rate.space().cell_nodes(cell)[0] as usize;
            assert!((rate.values()[node] - difference).abs() < 1e-8);
        }
    }
}

#[test]
fn bodies_slide_along_facets_of_both_shapes() {
    for degree in 1..=3 {
        let mesh = patchwork(6, 1);
        let space = Space::vector(&mesh, degree).unwrap();
        let mut constraints = Constraints::new(&space);
        constraints.slide_along("bottom", |x| 2.0 * x[0]).unwrap();
        let mut values = vec![7.0; space.unknowns()];
        constraints.apply(&mut values);
        for node in space.nodes_on("bottom").unwrap() {
            // u · n with n = (0, −1).
            let (x, node) = (space.positions()[node as usize], node as usize);
            assert!((values[2 * node + 1] + 2.0 * x[0]).abs() < 1e-13 && values[2 * node] == 7.0);
        }
    }
}

//! Hexahedra, and level set functions of degree 2: measures, Gauss's theorem, parts, bodies that are drawn, functions that nodes do not show.

use std::f64::consts::PI;

use forms_fem::cut::{Cut, CutSide};
use forms_fem::prelude::*;

use crate::areas::{check_cells, check_gauss, check_threads, measures};
use crate::{cut, cut_curved, levels, square};

fn of_cells<const D: usize>(body: &Assembler<D>) -> f64
where
    Dim: Dimension<D>,
{
    body.functional(&measures::volume(&measures::Omega::on("all"))).unwrap()
}

fn of_interface<const D: usize>(body: &Assembler<D>) -> f64
where
    Dim: Dimension<D>,
{
    body.functional(&measures::surface(&measures::Gamma::on("all"))).unwrap()
}

fn of_rim<const D: usize>(body: &Assembler<D>) -> f64
where
    Dim: Dimension<D>,
{
    body.functional(&measures::rim(&measures::Outer::on("boundary"))).unwrap()
}

fn cube(cells: usize) -> Mesh<3> {
    cuboid([-1.0; 3], [1.0; 3], [cells; 3], CellShape::Hexahedron, 1).unwrap()
}

/// The distance to the circle of the tests, as a polynomial.
fn disc(x: &[f64; 2]) -> f64 {
    (x[0] - 0.013).powi(2) + (x[1] + 0.021).powi(2) - 0.49
}

fn ball(x: &[f64; 3]) -> f64 {
    (x[0] - 0.013).powi(2) + (x[1] + 0.021).powi(2) + (x[2] - 0.007).powi(2) - 0.49
}

/// The distance to the sphere.
fn away(x: &[f64; 3]) -> f64 {
    (ball(x) + 0.49).sqrt() - 0.7
}

fn orders(errors: &[[f64; 2]]) -> [f64; 2] {
    let last = errors[errors.len() - 1];
    [0, 1].map(|k| (errors[0][k] / last[k]).log2() / (errors.len() - 1) as f64)
}

#[test]
fn circle_of_degree_2_has_the_order_of_its_rule() {
    // φ is exact: n points per axis give errors of order 2n.
    for (points, bounds) in [(3, [2e-8, 4e-8]), (4, [3e-10, 3e-9])] {
        let errors = [8, 16, 32].map(|cells| {
            let body = cut_curved(&square(cells, CellShape::Quadrilateral), disc)
                .with_quadrature(Quadrature::Degree(points - 1));
            [(of_cells(&body) - 0.49 * PI).abs(), (of_interface(&body) - 1.4 * PI).abs()]
        });
        let found = orders(&errors);
        println!("{points} points: {errors:?} orders {found:.2?}");
        let last = errors[2];
        assert!(last[0] < bounds[0] && last[1] < bounds[1], "{errors:?}");
        assert!(found.iter().all(|order| *order > 2.0 * points as f64 - 1.0), "{found:?} of {errors:?}");
    }
    // A distance is no polynomial: the order is that of its interpolation, 3 at least. Positions of the circle count equally.
    let errors = [8, 16, 32].map(|cells| {
        let mesh = square(cells, CellShape::Quadrilateral);
        let mut sums = [0.0_f64; 2];
        for k in 0..12 {
            let shift = [0.618_034, 0.754_878].map(|step| ((k as f64 + 0.5) * step).fract() * 0.25);
            let body = cut_curved(&mesh, |x| (x[0] - shift[0]).hypot(x[1] - shift[1]) - 0.7)
                .with_quadrature(Quadrature::Degree(5));
            sums[0] += (of_cells(&body) - 0.49 * PI).powi(2);
            sums[1] += (of_interface(&body) - 1.4 * PI).powi(2);
        }
        sums.map(|sum| (sum / 12.0).sqrt())
    });
    let found = orders(&errors);
    println!("distance: {errors:?} orders {found:.2?}");
    assert!(found.iter().all(|order| *order > 2.9), "{found:?} of {errors:?}");
}

#[test]
fn sphere_in_hexahedra_has_order_2_and_with_degree_2_that_of_its_rule() {
    let exact = [1.436_755_040_241_732, 6.157_521_601_035_994];
    let errors = [8, 16].map(|cells| {
        let body = cut(&cube(cells), away);
        [(of_cells(&body) - exact[0]).abs(), (of_interface(&body) - exact[1]).abs()]
    });
    let found = orders(&errors);
    println!("degree 1: {errors:?} orders {found:.2?}");
    assert!(found.iter().all(|order| (order - 2.0).abs() < 0.2), "{found:?} of {errors:?}");
    let errors = [8, 16].map(|cells| {
        let body = cut_curved(&cube(cells), ball);
        [(of_cells(&body) - exact[0]).abs(), (of_interface(&body) - exact[1]).abs()]
    });
    let found = orders(&errors);
    println!("degree 2: {errors:?} orders {found:.2?}");
    assert!(found.iter().all(|order| *order > 4.0), "{found:?} of {errors:?}");
}

#[test]
fn planes_are_exact() {
    let (a, b) = (0.3, 0.17);
    let heights = [-1.0, 1.0].map(|x: f64| a * x + b + 1.0);
    let body = cut_curved(&square(7, CellShape::Quadrilateral), |x| x[1] - a * x[0] - b);
    assert!((of_cells(&body) - heights[0] - heights[1]).abs() < 1e-14);
    assert!((of_interface(&body) - 2.0 * (1.0_f64 + a * a).sqrt()).abs() < 1e-14);
    assert!((of_rim(&body) - 2.0 - heights[0] - heights[1]).abs() < 1e-14);
    let mesh = cuboid([0.0; 3], [1.0; 3], [3; 3], CellShape::Hexahedron, 1).unwrap();
    let corner = |x: &[f64; 3]| x[0] + x[1] + x[2] - 0.77;
    let edge: f64 = 0.77;
    for bodies in [
        [cut(&mesh, corner), cut(&mesh, |x| -corner(x))],
        [cut_curved(&mesh, corner), cut_curved(&mesh, |x| -corner(x))],
    ] {
        let [inside, outside] = &bodies;
        assert!((of_cells(inside) - edge.powi(3) / 6.0).abs() < 1e-14);
        assert!((of_cells(outside) - 1.0 + edge.powi(3) / 6.0).abs() < 1e-14);
        assert!((of_interface(inside) - 0.75_f64.sqrt() * edge * edge).abs() < 1e-14);
        assert!((of_rim(inside) - 1.5 * edge * edge).abs() < 1e-14);
        assert!((of_rim(outside) - 6.0 + 1.5 * edge * edge).abs() < 1e-14);
    }
}

#[test]
fn inside_and_outside_make_the_cell() {
    let mesh = square(12, CellShape::Quadrilateral);
    check_cells(&mesh, [cut_curved(&mesh, disc), cut_curved(&mesh, |x| -disc(x))], 1e-13);
    let mesh = cube(5);
    let shape = |x: &[f64; 3]| x[0] * x[0] + x[1] * x[1] + 2.0 * x[2] * x[2] - 0.51;
    check_cells(&mesh, [cut(&mesh, shape), cut(&mesh, |x| -shape(x))], 1e-13);
    check_cells(&mesh, [cut_curved(&mesh, shape), cut_curved(&mesh, |x| -shape(x))], 1e-13);
}

#[test]
fn gauss_theorem_holds_on_curved_parts() {
    // A body that the boundary clips, and its complement.
    let off = |x: &[f64; 2]| (x[0] - 0.6).powi(2) + (x[1] + 0.55).powi(2) - 0.504;
    let mesh = square(9, CellShape::Quadrilateral);
    for body in [cut_curved(&mesh, disc), cut_curved(&mesh, off), cut_curved(&mesh, |x| -off(x))] {
        check_gauss((&mesh, &body.with_quadrature(Quadrature::Degree(14))), &[2], [1e-12, 2e-12]);
    }
    let mesh = cube(3);
    let off = |x: &[f64; 3]| (x[0] - 0.5).powi(2) + x[1].powi(2) + (x[2] + 0.6).powi(2) - 0.64;
    for body in [cut(&mesh, off), cut_curved(&mesh, off)] {
        check_gauss((&mesh, &body.with_quadrature(Quadrature::Degree(17))), &[2], [1e-12, 2e-12]);
    }
}

#[test]
fn bubbles_that_no_node_shows_are_found() {
    // A disc inside one cell, off its nodes, and a hole of the same shape.
    let mesh = square(2, CellShape::Quadrilateral);
    let bubble = |x: &[f64; 2]| (x[0] - 0.27).powi(2) + (x[1] - 0.24).powi(2) - 0.04;
    let body = cut_curved(&mesh, bubble).with_quadrature(Quadrature::Degree(11));
    assert!((of_cells(&body) - 0.04 * PI).abs() < 1e-10 && (of_interface(&body) - 0.4 * PI).abs() < 1e-9);
    let cut = body.cut().unwrap();
    assert_eq!((cut.inside_cells().len(), cut.cut_cells().len()), (0, 1));
    assert!(cut.side_of_facet(mesh.facet_region("boundary").unwrap()[0]) != CutSide::Cut);
    let hole = cut_curved(&mesh, |x| -bubble(x)).with_quadrature(Quadrature::Degree(11));
    assert!((of_cells(&hole) - 4.0 + 0.04 * PI).abs() < 1e-10, "{}", of_cells(&hole));
    assert_eq!(hole.cut().unwrap().inside_cells().len(), 3);
    // Coefficients of both signs without a zero: the values at nodes are positive, and so is the function.
    let low = |x: &[f64; 2]| (x[0] - 0.27).powi(2) + (x[1] - 0.24).powi(2) + 0.01;
    let phi = levels(&mesh, 2, low);
    assert!(Cut::by(&phi).is_err());
}

#[test]
fn zeros_at_nodes_are_moved() {
    for body in [
        cut_curved(&square(8, CellShape::Quadrilateral), |x| x[0]),
        // A line through the middle nodes of cells, and a parabola that touches the line between others.
        cut_curved(&square(8, CellShape::Quadrilateral), |x| x[0] - 0.125),
    ] {
        let moved = body.cut().unwrap().moved_nodes().len();
        assert_eq!(moved, 17);
        let at = if body.cut().unwrap().inside_cells().len() == 32 { 0.125 } else { 0.0 };
        assert!((of_cells(&body) - 2.0 - 2.0 * at).abs() < 1e-11, "{}", of_cells(&body));
        assert!((of_interface(&body) - 2.0).abs() < 1e-11);
    }
    let touching = cut_curved(&square(8, CellShape::Quadrilateral), |x| x[1] - x[0] * x[0])
        .with_quadrature(Quadrature::Degree(11));
    assert!((of_cells(&touching) - 2.0 - 2.0 / 3.0).abs() < 1e-11, "{}", of_cells(&touching));
    let body = cut(&cube(4), |x| x[2]);
    assert!((of_cells(&body) - 4.0).abs() < 1e-10 && (of_interface(&body) - 4.0).abs() < 1e-10);
    // Cells on the other side are outside.
    assert_eq!(body.cut().unwrap().inside_cells().len() + body.cut().unwrap().cut_cells().len(), 32);
}

#[test]
fn parts_are_found_and_drawn() {
    let mesh = square(20, CellShape::Quadrilateral);
    let space = Space::scalar(&mesh, 2).unwrap();
    let discs = |x: &[f64; 2]| {
        ((x[0] + 0.5).powi(2) + x[1].powi(2) - 0.1225).min((x[0] - 0.6).powi(2) + x[1].powi(2) - 0.04)
    };
    let cut = Cut::by(&Field::interpolate(&space, discs).unwrap()).unwrap();
    let parts = cut.parts();
    assert_eq!(parts.len(), 2);
    assert!((parts[0].volume - 0.1225 * PI).abs() < 4e-3 && (parts[1].volume - 0.04 * PI).abs() < 4e-3);
    // Each badly cut cell is tied to one with enough of the body.
    assert!(!cut.ghost_facets().is_empty());
    let drawn = cut.body().unwrap();
    let area =
        Assembler::new(drawn.mesh()).functional(&measures::volume(&measures::Omega::on("all"))).unwrap();
    assert!((area - 0.1625 * PI).abs() < 6e-3, "{area}");
    for (degree, miss) in [(1, 0.08), (2, 0.02)] {
        let mesh = cube(10);
        let phi = levels(&mesh, degree, away);
        let cut = Cut::by(&phi).unwrap();
        let drawn = cut.body().unwrap();
        let volume =
            Assembler::new(drawn.mesh()).functional(&measures::volume(&measures::Omega::on("all"))).unwrap();
        assert!((volume / 1.436_755_040_2 - 1.0).abs() < miss, "{volume}");
        let u = Field::interpolate(&Space::scalar(&mesh, 2).unwrap(), |x| x[0] * x[1] - x[2]).unwrap();
        let own = drawn.field(&u).unwrap();
        let worst = own
            .space()
            .positions()
            .iter()
            .enumerate()
            .map(|(node, x)| (own.at_node(node)[0] - (x[0] * x[1] - x[2])).abs());
        assert!(worst.fold(0.0, f64::max) < 1e-12);
        // Corners of the pieces are near the sphere.
        for corner in cut.interface().as_flattened() {
            assert!(away(corner).abs() < miss, "{corner:?}");
        }
        let distance = cut.distance(&phi).unwrap();
        assert!((distance.evaluate(&[0.0; 3]).unwrap()[0] - away(&[0.0; 3])).abs() < miss);
    }
}

#[test]
fn bands_keep_cells_and_ghost_facets() {
    let mesh = square(16, CellShape::Quadrilateral);
    let space = Space::scalar(&mesh, 2).unwrap();
    let disc = |radius: f64| Field::interpolate(&space, |x| x[0].hypot(x[1]) - radius).unwrap();
    let cut = Cut::by(&disc(0.7)).unwrap();
    let band = cut.band(0.05);
    let [larger, smaller] = [0.74, 0.66].map(|radius| Cut::within(&disc(radius), &band).unwrap());
    assert_eq!(larger.ghost_facets(), smaller.ghost_facets());
    assert!(larger.ghost_facets().len() > cut.ghost_facets().len());
    assert!(Cut::within(&disc(0.9), &band).is_err());
    // Unknowns of the cells that are kept are not held.
    let displacements = Space::vector(&mesh, 2).unwrap();
    let held = [&larger, &smaller].map(|cut| {
        let mut held = Constraints::new(&displacements);
        cut.hold_outside(&mut held).unwrap();
        held.free().len()
    });
    assert!(held[0] == held[1] && held[0] > 0, "{held:?}");
}

#[test]
fn threads_do_not_show() {
    let mesh = square(30, CellShape::Quadrilateral);
    let body = cut_curved(&mesh, |x| (x[0] - 0.6).powi(2) + (x[1] + 0.55).powi(2) - 0.504);
    check_threads(&mesh, &body, &[2, 5]);
}

//! The forces of a constant pressure on moving segments at the nodes of both sides: the integrals of their functions over the cover.

use forms_fem::contract::PairQuadrature;
use forms_fem::mesh::structured;
use forms_fem::prelude::*;

use crate::shape::pressed;
use crate::space::two_bodies;

#[forms]
mod constant {
    #[pairs]
    pub struct Touch;
    #[facets]
    pub struct Surface;

    pub fn forces(u: State<Vector>, v: Test<Vector>) -> Form {
        integral(Touch(u), dot(toward, jump(v)))
    }
    /// A pressure with the value 1 at each function.
    pub fn forces_of_multipliers(u: State<Vector>, p: State<Scalar>, v: Test<Vector>) -> Form {
        integral(Touch(u), this(p) * dot(toward, jump(v)))
    }
    pub fn loads(v: Test<Vector>) -> Form {
        integral(Surface, dot(n, v))
    }
}

fn segments(own: &str, opposite: &str) -> constant::Touch {
    constant::Touch::on(Pairing::onto(own, opposite).at(PairQuadrature::Pieces))
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// ∫ N_i dx of the functions on a straight surface along the first axis, over the part between two places, as the second component of a vector over the
/// unknowns. Polynomials of degree 2 by three points on each piece.
fn integrals(space: &Arc<Space<2>>, surface: &str, [from, to]: [f64; 2]) -> Vec<f64> {
    let mut found = vec![0.0; space.unknowns()];
    let root = 0.6_f64.sqrt();
    for facet in space.mesh().facet_region(surface).unwrap() {
        let cell = facet.cell as usize;
        let local = space.cell_element(cell).facet_nodes(usize::from(facet.local));
        let nodes: Vec<usize> = local.iter().map(|place| space.cell_nodes(cell)[*place] as usize).collect();
        let places: Vec<f64> = nodes.iter().map(|node| space.positions()[*node][0]).collect();
        let low = places.iter().copied().fold(f64::INFINITY, f64::min).max(from);
        let high = places.iter().copied().fold(f64::NEG_INFINITY, f64::max).min(to);
        for (place, weight) in [(-root, 5.0), (0.0, 8.0), (root, 5.0)] {
            let x = 0.5 * (low + high) + 0.5 * (high - low) * place;
            for (node, own) in nodes.iter().zip(&places) {
                let others = places.iter().filter(|place| *place != own);
                let value: f64 = others.map(|other| (x - other) / (own - other)).product();
                found[2 * node + 1] += weight / 18.0 * (high - low).max(0.0) * value;
            }
        }
    }
    found
}

/// A square that is moved along a longer layer in 20 steps: the forces on both are those of the pressure 1, over either surface.
#[test]
fn forces_while_a_square_slides_are_integrals_over_the_cover() {
    for (shape, degree) in [
        (CellShape::Quadrilateral, 1),
        (CellShape::Quadrilateral, 2),
        (CellShape::Triangle, 1),
        (CellShape::Triangle, 2),
    ] {
        let lower = rectangle([-1.0, 0.0], [2.0, 1.0], [21, 7], shape, 1).unwrap();
        let upper = rectangle([0.0, 1.0], [1.0, 2.0], [5, 5], shape, 1).unwrap();
        let mesh = Mesh::of_bodies(&[("lower", &lower), ("upper", &upper)]).unwrap();
        let (space, assembler) = (Space::vector(&mesh, degree).unwrap(), Assembler::new(&mesh));
        let mut worst = [0.0_f64; 2];
        for step in 0..=20 {
            let aside = 0.05 * f64::from(step);
            let u = pressed(Field::zero(&space), "upper", [aside, 0.0]);
            // The forces push the bodies apart.
            let (below, above) = (
                integrals(&space, "lower top", [aside, 1.0 + aside]),
                integrals(&space, "upper bottom", [0.0, 1.0]),
            );
            let expected: Vec<f64> = below.iter().zip(&above).map(|(below, above)| below - above).collect();
            for (own, opposite) in [("lower top", "upper bottom"), ("upper bottom", "lower top")] {
                let touch = segments(own, opposite);
                let at_points = constant::forces(&touch, &u);
                let found = assembler.residual(&at_points, &[], &[&space]).unwrap();
                worst[0] = worst[0].max(largest_difference(&found, &expected));
                let mut of_functions = vec![Elements::Bernstein(degree), Elements::Dual];
                of_functions.extend((degree == 2).then_some(Elements::DualOfBernstein));
                for elements in of_functions {
                    let traces = Space::of(&mesh, elements, Scope::Facets(own.to_owned()), &[]).unwrap();
                    let one = Field::from_values(&traces, vec![1.0; traces.unknowns()]).unwrap();
                    let form = constant::forces_of_multipliers(&touch, &u, &one);
                    let found = assembler.residual(&form, &[], &[&space]).unwrap();
                    worst[1] = worst[1].max(largest_difference(&found, &expected));
                }
            }
        }
        println!("{shape:?} {degree}: {:.1e}, with multipliers {:.1e}", worst[0], worst[1]);
        assert!(worst[0] < 1e-14 && worst[1] < 1e-14, "{shape:?} {degree}: {worst:?}");
    }
}

/// The errors of the forces on the own and on the opposite side between flat surfaces that cover each other, 2 × 2 on 3 × 3 cells, relative to a facet's
/// force; the map moves their nodes in the plane.
fn errors_of_loads(
    (shape, degree): (CellShape, usize),
    map: impl Fn(f64, f64) -> [f64; 2] + Copy,
    rule: Option<usize>,
) -> [f64; 2] {
    let body = |cells: usize, low: f64| {
        let place = |[s, t, r]: [f64; 3]| {
            let [x, y] = map(s, t);
            [x, y, low + 0.5 * r]
        };
        structured([cells, cells, 1], shape, 1, place).unwrap()
    };
    let mesh = two_bodies(&body(2, -0.5), &body(3, 0.0));
    let space = Space::vector(&mesh, degree).unwrap();
    let assembler = Assembler::new(&mesh);
    let assembler = match rule {
        Some(rule) => assembler.with_quadrature(Quadrature::Degree(rule)),
        None => assembler,
    };
    let (own, opposite) = ("lower top", "upper bottom");
    let forces = constant::forces(&segments(own, opposite), Field::zero(&space));
    let found = assembler.residual(&forces, &[], &[&space]).unwrap();
    [own, opposite].map(|surface| {
        let loads = constant::loads(&constant::Surface::on(surface));
        let expected = Assembler::new(&mesh)
            .with_quadrature(Quadrature::Degree(8))
            .residual(&loads, &[], &[&space])
            .unwrap();
        let of_surface = found.iter().zip(&expected).filter(|(_, expected)| **expected != 0.0);
        of_surface.map(|(found, expected)| (found - expected).abs()).fold(0.0, f64::max) * 4.0
    })
}

/// Exact on straight triangles and on parallelograms. On quadrilaterals whose nodes are moved by up to 0.3 of their size the own side is exact, and the
/// opposite one is as near as edges that are straight in the own coordinates, whatever the rule.
#[test]
fn forces_in_space_are_those_of_the_pressure() {
    let moved = |s: f64, t: f64| {
        let along = |s: f64, t: f64| 0.15 * (std::f64::consts::PI * s).sin() * (3.0 * t + 1.0).cos();
        [s + along(s, t), t + along(t, 0.7 * s)]
    };
    let sheared = |s: f64, t: f64| [s + 0.3 * t, 0.8 * t - 0.1 * s];
    for (name, shape, degree, found) in [
        ("triangles", CellShape::Tetrahedron, 1, errors_of_loads((CellShape::Tetrahedron, 1), moved, None)),
        ("triangles", CellShape::Tetrahedron, 2, errors_of_loads((CellShape::Tetrahedron, 2), moved, None)),
        (
            "parallelograms",
            CellShape::Hexahedron,
            1,
            errors_of_loads((CellShape::Hexahedron, 1), sheared, None),
        ),
        (
            "parallelograms",
            CellShape::Hexahedron,
            2,
            errors_of_loads((CellShape::Hexahedron, 2), sheared, None),
        ),
    ] {
        println!("{name}, {shape:?} {degree}: {found:?}");
        assert!(found.iter().all(|error| *error < 1e-14), "{name} {degree}: {found:?}");
    }
    let distorted = [4, 8].map(|rule| errors_of_loads((CellShape::Hexahedron, 1), moved, Some(rule)));
    println!("quadrilaterals, rules of degree 4 and 8: {distorted:?}");
    for [of_own, of_opposite] in distorted {
        assert!(of_own < 1e-14 && of_opposite < 2e-5, "{of_own:e} {of_opposite:e}");
    }
}

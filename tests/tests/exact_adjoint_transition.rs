//! Problem B: the adjoint state p = O(r^{1/2}) at a contact transition, solved by (22) with the contact zone
//! of problem A's discrete solution. p ∈ H^{3/2−ε}: H¹ order 1/2.

use crate::closed_forms::{HalfPlaneField, Potential};
use crate::convergence::{digits, order};
use crate::half_plane::{INTENSITY, error, material, on_sides, solved_direct};
use crate::loaded_adjoint::adjoint;
use forms_fem::prelude::*;

const SHAPES: [CellShape; 2] = [CellShape::Triangle, CellShape::Quadrilateral];
const THETAS: [f64; 3] = [-1.0, 0.0, 1.0];

fn h1_order(shape: CellShape, degree: usize, theta: f64, divisions: &[usize]) -> f64 {
    let exact = HalfPlaneField { material: material(), potential: Potential::AdjointTransition(INTENSITY) };
    let mut h1 = vec![];
    for &divisions in divisions {
        let (problem, u) = solved_direct(shape, divisions, degree, theta);
        let data = adjoint::data_from(problem.law.data.clone())
            // N′ = −σ(p) n on the sides, and only there.
            .slope(Given::function(move |x| on_sides(x, exact).map(|component| -component)));
        let form = adjoint::consistent(
            &data,
            &adjoint::Omega::on("all"),
            &adjoint::GammaC::on("bottom"),
            &adjoint::Boundary::on("boundary"),
            &u,
        );
        let mut constraints = Constraints::new(&problem.space);
        constraints.fix("top", |x| exact.displacement(x)).unwrap();
        let equations = Problem::new(&form, &problem.space).assembler(&problem.assembler);
        let p = equations.constrained(&constraints).solve().unwrap().into_field();
        h1.push(error(&problem.assembler, &p, exact).h1);
    }
    let order = order(divisions, &h1);
    println!("{shape:?} k={degree} θ={theta}: n {divisions:?} H¹ {} order {order:.3}", digits(&h1));
    assert!(h1.is_sorted_by(|a, b| a > b), "{h1:?}");
    order
}

fn check(degree: usize, shapes: &[CellShape], thetas: &[f64], divisions: &[usize]) {
    for &shape in shapes {
        for &theta in thetas {
            let order = h1_order(shape, degree, theta, divisions);
            assert!((0.45..0.55).contains(&order), "{shape:?} k={degree} θ={theta}: H¹ order {order}");
        }
    }
}

/// On triangles with θ = −1; FORMS_SWEEPS=1: both shapes and each θ.
fn check_degree_2(divisions: &[usize]) {
    let all = std::env::var_os("FORMS_SWEEPS").is_some();
    let (shapes, thetas) = if all { (&SHAPES[..], &THETAS[..]) } else { (&SHAPES[..1], &THETAS[..1]) };
    check(2, shapes, thetas, divisions);
}

#[test]
fn degree_2_with_the_transition_at_a_node() {
    check_degree_2(&[6, 12, 24, 48]);
}

#[test]
fn degree_2_with_the_transition_in_a_facet() {
    check_degree_2(&[7, 13, 25, 49]);
}

#[test]
fn degree_1_with_the_transition_at_a_node() {
    check(1, &SHAPES, &THETAS, &[6, 12, 24, 48]);
}

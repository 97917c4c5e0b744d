//! Problem C: a smooth adjoint state with contact on all of y = 0, which tells the consistent adjoint (22) from
//! the discrete one (21). (22) has the full H¹ order k for every θ. (21) is the transpose of (14)'s tangent: it
//! imposes p_n = 0 by a method that for θ ≠ 1 is not consistent with the continuous adjoint.

use crate::closed_forms::{HalfPlaneField, Potential};
use crate::convergence::{digits, order};
use crate::half_plane::{direct_problem, error, material, mesh, on_sides};
use crate::loaded_adjoint::adjoint;
use forms_fem::prelude::*;

const SHAPES: [CellShape; 2] = [CellShape::Triangle, CellShape::Quadrilateral];
const THETAS: [f64; 3] = [-1.0, 0.0, 1.0];

fn solve(form: &Form<2>, assembler: &Assembler<2>, constraints: &Constraints<2>) -> Field<2> {
    let equations = Problem::new(form, constraints.space()).assembler(assembler);
    equations.constrained(constraints).solve().unwrap().into_field()
}

/// H¹ errors along a sequence of meshes.
struct Errors {
    divisions: Vec<usize>,
    /// Of (22).
    consistent: Vec<f64>,
    /// Of (21).
    discrete: Vec<f64>,
}

fn h1_errors(shape: CellShape, degree: usize, theta: f64, divisions: &[usize]) -> Errors {
    let exact = HalfPlaneField { material: material(), potential: Potential::Smooth };
    let (mut consistent, mut discrete) = (vec![], vec![]);
    for &divisions in divisions {
        let mesh = mesh(shape, divisions);
        let problem = direct_problem(&mesh, degree, theta);
        let data = adjoint::data_from(problem.law.data.clone())
            // N′ = −σ(p) n on the sides, and only there.
            .slope(Given::function(move |x| on_sides(x, exact).map(|component| -component)));
        let (omega, gamma_c) = (adjoint::Omega::on("all"), adjoint::GammaC::on("bottom"));
        let boundary = adjoint::Boundary::on("boundary");
        // Pushed into the obstacle without stress: contact everywhere, H = 1.
        let u = Field::interpolate(&problem.space, |_| [0.0, -1.0]).unwrap();
        let mut constraints = Constraints::new(&problem.space);
        constraints.fix("top", |x| exact.displacement(x)).unwrap();
        let form = adjoint::consistent(&data, &omega, &gamma_c, &boundary, &u);
        let p = solve(&form, &problem.assembler, &constraints);
        consistent.push(error(&problem.assembler, &p, exact).h1);
        let form = adjoint::discrete(&data, &omega, &gamma_c, &boundary, &u);
        let p = solve(&form, &problem.assembler, &constraints);
        discrete.push(error(&problem.assembler, &p, exact).h1);
    }
    println!(
        "{shape:?} k={degree} θ={theta}: n {divisions:?} (22) H¹ {} order {:.3}; (21) H¹ {} order {:.3}",
        digits(&consistent),
        order(divisions, &consistent),
        digits(&discrete),
        order(divisions, &discrete)
    );
    Errors { divisions: divisions.to_vec(), consistent, discrete }
}

/// On triangles; FORMS_SWEEPS=1: on quadrilaterals, too.
#[test]
fn degree_2_tells_the_adjoints_apart() {
    let all = std::env::var_os("FORMS_SWEEPS").is_some();
    for &shape in if all { &SHAPES[..] } else { &SHAPES[..1] } {
        for theta in THETAS {
            let errors = h1_errors(shape, 2, theta, &[12, 24, 48, 96]);
            let consistent = order(&errors.divisions, &errors.consistent);
            assert!((1.95..2.05).contains(&consistent), "{shape:?} θ={theta}: (22) has order {consistent}");
            if theta == 1.0 {
                for (consistent, discrete) in errors.consistent.iter().zip(&errors.discrete) {
                    assert!((consistent - discrete).abs() < 1e-8 * consistent, "{consistent} {discrete}");
                }
            } else {
                // The smooth part, of order 2, is still seen on coarse meshes: the last step counts.
                let last = order(&errors.divisions[2..], &errors.discrete[2..]);
                assert!((0.45..0.55).contains(&last), "{shape:?} θ={theta}: (21) has order {last}");
                assert!(errors.discrete[3] > 10.0 * errors.consistent[3]);
            }
        }
    }
}

#[test]
fn degree_1_has_order_1_with_the_consistent_adjoint() {
    for shape in SHAPES {
        for theta in THETAS {
            let errors = h1_errors(shape, 1, theta, &[6, 12, 24, 48]);
            let consistent = order(&errors.divisions, &errors.consistent);
            assert!((0.95..1.05).contains(&consistent), "{shape:?} θ={theta}: (22) has order {consistent}");
        }
    }
}

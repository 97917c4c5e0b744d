//! Saddle points of forms: incompressible bodies, multipliers and floating bodies, compared with LU.

use crate::linear_algebra::vector::norm;
use crate::prelude::*;
use crate::solve::{NewtonFailure, SolverError, SolverPath};

#[forms]
mod saddle {
    pub struct Data {
        force: Given<Vector>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Side;

    /// An incompressible body.
    pub fn incompressible(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        integral(Omega, 2 * inner(eps(u), eps(v)) - p * div(v) - q * div(u) - dot(force, v))
    }

    /// A body that only multipliers hold.
    pub fn held(u: Unknown<Vector>, l: Unknown<Vector>, v: Test<Vector>, m: Test<Vector>) -> Form {
        integral(Omega, 2 * inner(eps(u), eps(v)) + 3 * div(u) * div(v) - dot(force, v))
            + integral(Side, dot(l, v) + dot(m, u))
    }
}

fn data() -> saddle::Data<2> {
    let force = |x: &[f64; 2]| [(3.0 * x[0] + x[1]).sin(), (2.0 * x[1] - x[0]).cos()];
    saddle::data().force(force)
}

fn values(solved: &Solved<2, 2>) -> [Vec<f64>; 2] {
    solved.fields.each_ref().map(|field| field.values().to_vec())
}

/// Compares each field with that by LU, and the bits on several threads.
fn check(solve: impl Fn(&mut dyn LinearSolver) -> Solved<2, 2>, negative: usize) {
    let expected = values(&solve(&mut LuSolver::default()));
    let mut first: Option<[Vec<f64>; 2]> = None;
    for threads in [1, 2, 3, 8] {
        let options = TangentSolverOptions { threads: Threads::new(threads), ..Default::default() };
        let mut solver = TangentSolver::new(options);
        let found = values(&solve(&mut solver));
        let report = solver.report();
        assert_eq!(report.path, Some(SolverPath::SignedCholesky));
        assert_eq!((report.lu_factorisations, report.negative_eigenvalues), (0, Some(negative)));
        for (found, expected) in found.iter().zip(&expected) {
            let difference: Vec<f64> = found.iter().zip(expected).map(|(a, b)| a - b).collect();
            let relative = norm(&difference) / norm(expected);
            assert!(relative < 1e-12, "{relative:e}");
        }
        let first = first.get_or_insert_with(|| found.clone());
        let bits =
            |values: &[Vec<f64>; 2]| values.concat().iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        assert!(bits(first) == bits(&found), "{threads} threads");
    }
}

#[test]
fn incompressible_bodies_agree_with_lu_on_any_number_of_threads() {
    for (shape, cells) in
        [(CellShape::Triangle, 3), (CellShape::Triangle, 20), (CellShape::Quadrilateral, 14)]
    {
        let mesh = rectangle([0.0; 2], [2.0, 1.0], [2 * cells, cells], shape, 1).unwrap();
        let (bodies, pressures) = (Space::vector(&mesh, 2).unwrap(), Space::scalar(&mesh, 1).unwrap());
        let form = saddle::incompressible(&data(), &saddle::Omega::on("all"));
        let mut held = Constraints::new(&bodies);
        held.fix("left", |_| [0.0; 2]).unwrap();
        let spaces = [&bodies, &pressures];
        check(
            |solver| Problem::new(&form, spaces).constrained(&held).solver(solver).solve().unwrap(),
            pressures.unknowns(),
        );
    }
}

#[test]
fn a_floating_body_that_multipliers_hold_agrees_with_lu() {
    let mesh = rectangle([0.0; 2], [2.0, 1.0], [24, 12], CellShape::Quadrilateral, 1).unwrap();
    let bodies = Space::vector(&mesh, 2).unwrap();
    let multipliers = Space::vector_on_facets(&mesh, "left", 1).unwrap();
    let form = saddle::held(&data(), &saddle::Omega::on("all"), &saddle::Side::on("left"));
    let spaces = [&bodies, &multipliers];
    check(|solver| Problem::new(&form, spaces).solver(solver).solve().unwrap(), multipliers.unknowns());
}

#[test]
fn a_saddle_point_that_is_singular_is_an_error() {
    let mesh = rectangle([0.0; 2], [1.0; 2], [9, 7], CellShape::Triangle, 1).unwrap();
    let (bodies, pressures) = (Space::vector(&mesh, 2).unwrap(), Space::scalar(&mesh, 1).unwrap());
    let form = saddle::incompressible(&data(), &saddle::Omega::on("all"));
    // The level of the pressure is open.
    let mut held = Constraints::new(&bodies);
    held.fix("boundary", |_| [0.0; 2]).unwrap();
    let error = Problem::new(&form, [&bodies, &pressures]).constrained(&held).solve().unwrap_err();
    let found =
        matches!(error.why, NewtonFailure::LinearSolver(SolverError::Undetermined { field: "p", .. }));
    assert!(found, "{error}");
    // Nothing holds the body.
    let error = Problem::new(&form, [&bodies, &pressures]).solve().unwrap_err();
    let found =
        matches!(error.why, NewtonFailure::LinearSolver(SolverError::Undetermined { field: "u", .. }));
    assert!(found, "{error}");
}

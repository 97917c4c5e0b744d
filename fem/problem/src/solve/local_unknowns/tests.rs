//! Forms with unknowns of one cell each, compared with LU of the whole matrix and with differences.

use super::*;
use crate::linear_algebra::{BlockMatrix, LinearAlgebraError};
use crate::prelude::*;
use crate::solve::{Elimination, PerUnknown, SolverPath, solve_linear_transposed};

#[forms]
mod local {
    pub struct Data {
        load: Param,
        leak: Param,
    }
    #[cells]
    pub struct Omega;

    /// A nearly incompressible body.
    pub fn pressure(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        integral(Omega, 2 * inner(eps(u), eps(v)) - p * div(v) - q * div(u) - leak * p * q - load * v[0])
    }

    /// Enhanced strains e with the mean zero, by stresses s of degree 0 (Simo and Rifai 1990).
    pub fn enhanced(
        u: Unknown<Vector>,
        e: Unknown<Tensor>,
        s: Unknown<Tensor>,
        v: Test<Vector>,
        d: Test<Tensor>,
        t: Test<Tensor>,
    ) -> Form {
        let strain = eps(u) + sym(e);
        let virtual_strain = eps(v) + sym(d);
        integral(Omega, 2 * inner(strain, virtual_strain) + 20 * tr(strain) * tr(virtual_strain))
            + integral(Omega, 0.5 * inner(e, d) + inner(s, d) + inner(t, e) - load * v[0])
    }

    /// Neo-Hooke with a mean dilatation 1 + j (Simo, Taylor and Pister 1985).
    pub fn dilatation(u: Unknown<Vector>, j: Unknown<Scalar>, p: Unknown<Scalar>) -> Energy {
        let F = I + grad(u);
        integral(
            Omega,
            inner(F, F) / 2 - D / 2 - ln(1 + j) + 50 * pow(j, 2) + p * (det(F) - 1 - j) - load * u[1],
        )
    }

    /// A membrane above an obstacle at −1 by a latent variable (proximal Galerkin).
    pub fn latent(u: Unknown<Scalar>, w: Unknown<Scalar>, v: Test<Scalar>, q: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)) + w * v + q * (u + 1) - q * exp(w) + 60 * load * v)
    }
}

fn data() -> local::Data<2> {
    local::data().load(0.005).leak(1e-3)
}

fn mesh() -> Mesh<2> {
    rectangle([0.0; 2], [2.0, 1.0], [10, 7], CellShape::Quadrilateral, 1).unwrap()
}

fn relative(a: &[f64], b: &[f64]) -> f64 {
    norm(&a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<_>>()) / norm(b)
}

/// Solves a problem by the default solver and by LU, and systems with the tangent at the solution and with its transposed.
fn check<const N: usize>(
    form: &Form<2>,
    spaces: [&Arc<Space<2>>; N],
    held: &Constraints<2>,
    counts: Counts,
    path: SolverPath,
) where
    for<'s> [&'s Arc<Space<2>>; N]: PerUnknown<'s, Arc<Space<2>>, N>,
{
    let found = Problem::new(form, spaces).constrained(held).solve().unwrap();
    let report = found.report.unwrap();
    assert_eq!((report.local_unknowns, report.path), (Some(counts), Some(path)));
    let mut lu = LuSolver::default();
    let expected = Problem::new(form, spaces).constrained(held).solver(&mut lu).solve().unwrap();
    for (number, (found, expected)) in found.fields.iter().zip(&expected.fields).enumerate() {
        let difference = relative(found.values(), expected.values());
        assert!(difference < 1e-12, "field {number} of {}: {difference:e}", form.name());
    }
    // Another right-hand side, both ways, on several threads.
    let fields = found.fields.each_ref();
    let matrix =
        BlockMatrix::from(Assembler::new(held.space().mesh()).tangent(form, &fields, &spaces).unwrap());
    let free =
        spaces.map(
            |space| if space.numbers_as(held.space()) { held.homogeneous() } else { Constraints::new(space) },
        );
    let mut elimination = Elimination::of(&free.each_ref()).unwrap();
    let reduced = elimination.reduce_matrix(&matrix).unwrap();
    let groups = groups_of(&spaces, &elimination);
    let b: Vec<f64> = (0..reduced.rows()).map(|k| (k as f64 * 0.7).sin()).collect();
    lu.set_matrix(reduced.clone()).unwrap();
    for transpose in [Transpose::No, Transpose::Yes] {
        let expected = lu.solve_with(&b, 0.0, transpose).unwrap().solution;
        let mut first: Option<Vec<u64>> = None;
        for threads in [1, 2, 3, 8].map(Threads::new) {
            let options = TangentSolverOptions { threads, ..Default::default() };
            let mut solver = LocalUnknowns::around(TangentSolver::new(options)).with_threads(threads);
            solver.set_local_unknowns(groups.clone());
            solver.set_matrix(reduced.clone()).unwrap();
            let found = solver.solve_with(&b, 0.0, transpose).unwrap().solution;
            let difference = relative(&found, &expected);
            assert!(difference < 1e-12, "{} {transpose:?}: {difference:e}", form.name());
            let bits: Vec<u64> = found.iter().map(|value| value.to_bits()).collect();
            assert!(*first.get_or_insert_with(|| bits.clone()) == bits);
        }
    }
}

#[test]
fn local_unknowns_agree_with_lu_and_leave_a_positive_definite_matrix() {
    let mesh = mesh();
    let all = local::Omega::on("all");
    let bodies = Space::vector(&mesh, 2).unwrap();
    let coarse = Space::vector(&mesh, 1).unwrap();
    let [constant, linear] = [0, 1].map(|degree| Space::discontinuous_scalar(&mesh, degree).unwrap());
    let [stresses, strains] = [0, 1].map(|degree| Space::discontinuous_tensor(&mesh, degree).unwrap());
    let scalars = Space::scalar(&mesh, 2).unwrap();
    let hold = |space: &Arc<Space<2>>| {
        let mut held = Constraints::new(space);
        match space.components() {
            1 => held.fix("boundary", |_| 0.0).unwrap(),
            _ => held.fix("left", |_| [0.0; 2]).unwrap(),
        };
        held
    };
    let eliminated = |eliminated| Counts { eliminated, ..Counts::default() };
    let form = local::pressure(&data(), &all);
    check(&form, [&bodies, &constant], &hold(&bodies), eliminated(70), SolverPath::Cholesky);
    let form = local::enhanced(&data(), &all);
    check(&form, [&coarse, &strains, &stresses], &hold(&coarse), eliminated(70 * 20), SolverPath::Cholesky);
    let form = Form::from(local::dilatation(&data(), &all));
    check(&form, [&bodies, &constant, &constant], &hold(&bodies), eliminated(140), SolverPath::Cholesky);
    let form = local::latent(&data(), &all);
    check(&form, [&scalars, &linear], &hold(&scalars), eliminated(280), SolverPath::Cholesky);
}

#[test]
fn pressures_without_a_pivot_stay() {
    let mesh = mesh();
    let (bodies, constant) =
        (Space::vector(&mesh, 2).unwrap(), Space::discontinuous_scalar(&mesh, 0).unwrap());
    let mut held = Constraints::new(&bodies);
    held.fix("left", |_| [0.0; 2]).unwrap();
    let form = local::pressure(&local::data().load(1.0).leak(0.0), &local::Omega::on("all"));
    let counts = Counts { by_pivots: 70, ..Counts::default() };
    check(&form, [&bodies, &constant], &held, counts, SolverPath::SignedCholesky);
    assert_eq!(
        counts.to_string(),
        "0 local unknowns eliminated, 70 kept because a pivot is below 1e-10 of its scale"
    );
}

#[test]
fn adjoints_agree_with_differences() {
    let mesh = mesh();
    let (bodies, constant) =
        (Space::vector(&mesh, 2).unwrap(), Space::discontinuous_scalar(&mesh, 0).unwrap());
    let spaces = [&bodies, &constant, &constant];
    let mut held = Constraints::new(&bodies);
    held.fix("left", |_| [0.0; 2]).unwrap();
    let form = |load: f64| Form::from(local::dilatation(&data().load(load), &local::Omega::on("all")));
    let value = |load: f64| {
        let found = Problem::new(&form(load), spaces).constrained(&held).solve().unwrap();
        found.fields[0].values().iter().sum::<f64>()
    };
    let load = 0.005;
    let mut solver = LocalUnknowns::<TangentSolver>::default();
    let found = Problem::new(&form(load), spaces).constrained(&held).solver(&mut solver).solve().unwrap();
    let (fields, assembler) = (found.fields.each_ref(), Assembler::new(&mesh));
    let matrix = BlockMatrix::from(assembler.tangent(&form(load), &fields, &spaces).unwrap());
    let mut weights = vec![0.0; matrix.rows()];
    weights[..bodies.unknowns()].fill(1.0);
    let nothing = Constraints::new(&constant);
    let mut elimination = Elimination::of(&[&held, &nothing, &nothing]).unwrap();
    let adjoint = solve_linear_transposed(&matrix, &weights, &mut elimination, &mut solver).unwrap().solution;
    assert_eq!(
        solver.report().and_then(|report| report.local_unknowns).map(|counts| counts.eliminated),
        Some(140)
    );
    let residual = |load: f64| assembler.residual(&form(load), &fields, &spaces).unwrap();
    let slope =
        residual(1.0).iter().zip(residual(0.0)).zip(&adjoint).map(|((a, b), x)| (b - a) * x).sum::<f64>();
    let difference = |h: f64| (value(load + h) - value(load - h)) / (2.0 * h);
    let h = 2e-4;
    let expected = (4.0 * difference(h) - difference(2.0 * h)) / 3.0;
    assert!((slope / expected - 1.0).abs() < 1e-9, "{slope} is not {expected}");
}

/// A solver of what is left that always fails.
#[derive(Debug, Default)]
struct Failing(LuSolver);

impl LinearSolver for Failing {
    fn set_matrix(&mut self, matrix: CsrMatrix) -> Result<(), SolverError> {
        if matrix.rows() < 3 {
            return Err(LinearAlgebraError::Singular { unknown: 1, ratio: 0.0 }.into());
        }
        self.0.set_matrix(matrix)
    }

    fn solve_with(&mut self, b: &[f64], t: f64, transpose: Transpose) -> Result<LinearSolution, SolverError> {
        self.0.solve_with(b, t, transpose)
    }
}

#[test]
fn the_whole_matrix_is_solved_where_what_is_left_is_not() {
    let entries = [(0, 0, 2.0), (1, 1, 2.0), (2, 2, 1.0), (0, 2, 1.0), (2, 0, 1.0)];
    let matrix = CsrMatrix::from_triplets(3, 3, &entries).unwrap();
    let mut groups = Groups::default();
    groups.add(0, [2]);
    let mut solver = LocalUnknowns::around(Failing::default());
    solver.set_local_unknowns(groups.clone());
    solver.set_matrix(matrix.clone()).unwrap();
    assert_eq!(solver.solve(&[3.0, 2.0, 2.0], 0.0).unwrap().solution, [1.0, 1.0, 1.0]);
    // A matrix that is singular is named by its own unknown.
    let entries = [(0, 0, 1.0), (1, 1, 2.0), (2, 2, 1.0), (0, 2, 1.0), (2, 0, 1.0)];
    let mut solver = LocalUnknowns::<TangentSolver>::default();
    solver.set_local_unknowns(groups);
    let error = solver.set_matrix(CsrMatrix::from_triplets(3, 3, &entries).unwrap()).unwrap_err();
    assert!(
        matches!(error, SolverError::LinearAlgebra(LinearAlgebraError::Singular { unknown: 0 | 2, .. })),
        "{error}"
    );
}

//! Bad input, once for every solver: data that are not finite, a body that nothing holds, a region without cells or
//! facets. Each time an error that names the thing, never a panic, never NaN.

use forms_fem::linear_algebra::{
    CsrMatrix, Identity, KrylovError, KrylovOptions, KrylovReport, MultigridOptions, cg, minres,
};
use forms_fem::prelude::*;
use forms_fem::solve::{LinearSolution, LuSolver, SolverError};

#[forms(dimension = 3)]
mod body {
    pub struct Data {
        pub lambda: Param,
        pub mu: Param,
        /// Stiffness of a bed below that bends nothing upwards; `aside` of its pressure acts along x, which makes it
        /// unsymmetric.
        pub bed: Param,
        pub aside: Param,
        pub f: Given<Vector>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Below;

    fn stress(w: Vector) -> Tensor {
        2 * mu * eps(w) + lambda * tr(eps(w)) * I
    }
    /// A block on a bed that presses where the block sinks in by more than 0.01.
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let pressure = neg_part(u[2] + 0.01);
        integral(Omega, inner(stress(u), eps(v)) - dot(f, v))
            - integral(Below, bed * pressure * (v[2] + aside * v[0]))
    }
}

/// CG and MINRES as solvers of systems, without a preconditioner.
struct Krylov {
    minimal_residual: bool,
    matrix: Option<CsrMatrix>,
}

impl LinearSolver for Krylov {
    fn set_matrix(&mut self, matrix: CsrMatrix) -> Result<(), SolverError> {
        self.matrix = Some(matrix);
        Ok(())
    }

    fn solve_with(
        &mut self,
        b: &[f64],
        _: f64,
        _: forms_fem::solve::Transpose,
    ) -> Result<LinearSolution, SolverError> {
        let matrix = self.matrix.as_ref().ok_or(SolverError::NoMatrix)?;
        let mut x = vec![0.0; b.len()];
        let options = KrylovOptions { tolerance: 1e-9, max_iterations: 3000, ..KrylovOptions::default() };
        let found = match self.minimal_residual {
            true => minres(matrix, &mut Identity, b, &mut x, &options),
            false => cg(matrix, &mut Identity, b, &mut x, &options),
        };
        let report = found.map_err(|error| match error {
            KrylovError::BadArguments(error) => error.into(),
            error => SolverError::Krylov {
                method: if self.minimal_residual { "MINRES" } else { "conjugate gradients" },
                why: error.to_string(),
                report: error.report().cloned().unwrap_or_default(),
            },
        })?;
        let KrylovReport { iterations, relative_residual, .. } = report;
        Ok(LinearSolution { solution: x, relative_residual, iterations })
    }
}

/// Names of the solvers, whether they can do without symmetry, and the solvers.
fn solvers(constraints: &Constraints<3>) -> Vec<(&'static str, bool, Box<dyn LinearSolver>)> {
    let multigrid = MultigridOptions { direct_size: 100, ..MultigridOptions::default() };
    let multigrid = MultigridSolverOptions { multigrid, ..MultigridSolverOptions::default() };
    let krylov = |minimal_residual| Box::new(Krylov { minimal_residual, matrix: None });
    vec![
        ("Cholesky, LBLᵀ, GMRES", true, Box::new(TangentSolver::default())),
        ("condensed", true, Box::new(CondensedSolver::default())),
        ("LU", true, Box::new(LuSolver::default())),
        ("multigrid", true, Box::new(MultigridSolver::new(constraints, multigrid).unwrap())),
        ("CG", false, krylov(false)),
        ("MINRES", false, krylov(true)),
    ]
}

type Outcome = Result<Field<3>, NewtonError>;

struct Case {
    name: &'static str,
    held: bool,
    aside: f64,
    lambda: f64,
    load: fn(&[f64; 3]) -> [f64; 3],
    region: &'static str,
    /// Fragments; every error contains one.
    says: &'static [&'static str],
}

const GOOD: Case = Case {
    name: "good",
    held: true,
    aside: 0.0,
    lambda: 1.0,
    load: |_| [0.0, 0.0, -0.1],
    region: "bottom",
    says: &[],
};

fn solve(case: &Case, which: usize) -> Option<(&'static str, Outcome)> {
    let mut mesh = cuboid([0.0; 3], [1.0; 3], [3; 3], CellShape::Tetrahedron, 1).unwrap();
    mesh.name_facets("low part", "bottom", |centre| centre[0] < 0.5).unwrap();
    let space = Space::vector(&mesh, 2).unwrap();
    let mut constraints = Constraints::new(&space);
    if case.held {
        constraints.fix("left", |_| [0.0; 3]).unwrap();
    }
    let (name, unsymmetric, mut solver) = solvers(&constraints).into_iter().nth(which)?;
    if case.aside != 0.0 && !unsymmetric {
        return Some((name, Ok(Field::zero(&space))));
    }
    let f = Given::function(case.load);
    let data = body::data().lambda(case.lambda).mu(1.0).bed(50.0).aside(case.aside).f(f);
    let form = body::balance(&data, &body::Omega::on("all"), &body::Below::on(case.region));
    let problem = Problem::new(&form, &space);
    let options = NewtonOptions { relative_tolerance: 1e-8, ..NewtonOptions::default() };
    let found = problem.constrained(&constraints).solver(&mut *solver).options(options.clone()).solve();
    Some((name, found.map(Solved::into_field)))
}

fn each(case: &Case, mut check: impl FnMut(&str, Outcome)) {
    let mut which = 0;
    while let Some((name, found)) = solve(case, which) {
        check(&format!("{} by {name}", case.name), found);
        which += 1;
    }
    assert_eq!(which, 6);
}

#[test]
fn good_input_is_solved_by_all() {
    let mut first: Option<Field<3>> = None;
    each(&GOOD, |name, found| {
        let found = found.unwrap_or_else(|error| panic!("{name}: {error}"));
        let expected = first.get_or_insert_with(|| found.clone());
        let pairs = found.values().iter().zip(expected.values());
        let difference = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(difference < 1e-6, "{name}: {difference:e}");
        assert!(found.values().iter().any(|value| *value < -0.02), "{name}: the bed is not reached");
    });
    each(&Case { name: "pressure aside", aside: 0.3, ..GOOD }, |name, found| {
        assert!(found.is_ok(), "{name}: {:?}", found.err());
    });
}

/// Contact on no area at all, at the start as at the end: every solver finds what it finds without a bed.
#[test]
fn a_bed_that_is_not_reached_does_nothing() {
    let lifted: fn(&[f64; 3]) -> [f64; 3] = |_| [0.0, 0.0, 0.1];
    let mut first: Option<Field<3>> = None;
    each(&Case { name: "lifted", load: lifted, ..GOOD }, |name, found| {
        let found = found.unwrap_or_else(|error| panic!("{name}: {error}"));
        let expected = first.get_or_insert_with(|| found.clone());
        let pairs = found.values().iter().zip(expected.values());
        let difference = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(difference < 1e-6, "{name}: {difference:e}");
        let mut on_bed =
            found.space().positions().iter().zip(found.values().chunks(3)).filter(|(x, _)| x[2] == 0.0);
        assert!(on_bed.all(|(_, u)| u[2] > -0.01), "{name}: the bed is reached");
    });
}

#[test]
fn bad_input_is_an_error_that_names_it() {
    let nan: fn(&[f64; 3]) -> [f64; 3] = |x| [0.0, if x[0] > 0.6 { f64::NAN } else { 0.0 }, -0.1];
    // A load that only friction could hold.
    let aside: fn(&[f64; 3]) -> [f64; 3] = |_| [0.1, 0.0, 0.1];
    let up: fn(&[f64; 3]) -> [f64; 3] = |_| [0.0, 0.0, 0.1];
    let singular = &["singular", "not positive definite", "stagnates", "no convergence", "stopped at"];
    let cases = [
        Case { name: "a load that is not a number", load: nan, says: &["not finite", "NaN"], ..GOOD },
        Case {
            name: "λ that is not a number",
            lambda: f64::NAN,
            says: &["not finite", "NaN", "lambda"],
            ..GOOD
        },
        Case {
            name: "an infinite μ's partner",
            lambda: f64::INFINITY,
            says: &["not finite", "inf", "lambda"],
            ..GOOD
        },
        Case { name: "nothing holds the body", held: false, load: aside, says: singular, ..GOOD },
        Case {
            name: "only a bed that is not reached could hold it",
            held: false,
            load: up,
            says: singular,
            ..GOOD
        },
        Case { name: "no such region", region: "underside", says: &["underside"], ..GOOD },
    ];
    for case in &cases {
        each(case, |name, found| {
            let error = match found {
                Ok(field) => panic!("{name}: solved, {:?}", &field.values()[..6]),
                Err(error) => error.to_string(),
            };
            println!("{name}: {error}");
            assert!(case.says.iter().any(|words| error.contains(words)), "{name}: {error}");
        });
    }
}

#[test]
fn a_start_that_is_not_finite_cannot_be_made() {
    let mesh = cuboid([0.0; 3], [1.0; 3], [1; 3], CellShape::Tetrahedron, 1).unwrap();
    let space = Space::vector(&mesh, 1).unwrap();
    let error = Field::interpolate(&space, |x: &[f64; 3]| [x[0], f64::NAN, 0.0]).unwrap_err().to_string();
    assert!(error.contains("NaN"), "{error}");
}

#[test]
fn an_empty_region_cannot_be_made() {
    let mut mesh = cuboid([0.0; 3], [1.0; 3], [2; 3], CellShape::Tetrahedron, 1).unwrap();
    let error = mesh.name_facets("nothing", "bottom", |_| false).unwrap_err().to_string();
    assert!(error.contains("nothing"), "{error}");
    let error = mesh.name_cells_of_facets("cells", "no such facets").unwrap_err().to_string();
    assert!(error.contains("no such facets"), "{error}");
}

/// Matrices and loads, without a form: the same table.
#[test]
fn matrices_that_are_not_finite_or_singular() {
    let mesh = cuboid([0.0; 3], [1.0; 3], [2; 3], CellShape::Tetrahedron, 1).unwrap();
    let space = Space::scalar(&mesh, 1).unwrap();
    let constraints = Constraints::new(&space);
    let size = space.unknowns();
    // A chain; with ends that are held it is regular.
    let chain = |ends: f64, spoilt: Option<f64>| {
        let mut triplets = vec![(0, 0, ends), (size - 1, size - 1, ends)];
        for i in 1..size {
            triplets.extend([(i, i, 1.0), (i - 1, i - 1, 1.0), (i, i - 1, -1.0), (i - 1, i, -1.0)]);
        }
        triplets.extend(spoilt.map(|value| (3, 3, value)));
        CsrMatrix::from_triplets(size, size, &triplets).unwrap()
    };
    let b: Vec<f64> = (0..size).map(|i| 1.0 + (i as f64).sin()).collect();
    let mut nan = b.clone();
    nan[5] = f64::NAN;
    for (name, _, mut solver) in solvers(&constraints) {
        assert!(matches!(solver.solve(&b, 0.0), Err(SolverError::NoMatrix)), "{name}");
        let mut run = |matrix: CsrMatrix, b: &[f64]| -> Result<LinearSolution, SolverError> {
            solver.set_matrix(matrix)?;
            solver.solve(b, 0.0)
        };
        let found = run(chain(1.0, None), &b).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(found.relative_residual < 1e-8, "{name}");
        for (case, matrix, b) in [
            ("NaN in the load", chain(1.0, None), &nan),
            ("a short load", chain(1.0, None), &b[1..].to_vec()),
            ("NaN in the matrix", chain(1.0, Some(f64::NAN)), &b),
            ("an infinite entry", chain(1.0, Some(f64::INFINITY)), &b),
            ("a singular matrix", chain(0.0, None), &b),
        ] {
            match run(matrix, b) {
                Ok(found) => panic!("{name}, {case}: solved with residual {:e}", found.relative_residual),
                Err(error) => println!("{name}, {case}: {error}"),
            }
        }
        assert!(run(chain(1.0, None), &b).is_ok(), "{name} does not recover");
    }
}

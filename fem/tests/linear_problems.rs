//! Linear problems that are solved together: each solution has the bits that it has by itself, by every solver.

use forms_fem::linear_algebra::CsrMatrix;
use forms_fem::prelude::*;
use forms_fem::solve::{LinearSolution, SolverError, SolverPath, Transpose};

#[forms(dimension = 2)]
mod bodies {
    pub struct Data {
        pub stiffness: Param,
        pub aside: Param,
        pub load: Given<Vector>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Floor;

    fn body(u: Vector, v: Vector) -> Form {
        integral(Omega, inner(sym(grad(u)), grad(v)) - dot(load, v))
    }
    /// Rests on the floor.
    pub fn resting(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        body(u, v) + integral(Floor, stiffness * neg_part(u[1] + 0.001) * (aside * v[0] - v[1]))
    }
    /// Its tangent at a state as a linear problem, for another load.
    pub fn linearised(w: State<Vector>, u: Unknown<Vector>, v: Test<Vector>) -> Form {
        body(u, v) + integral(Floor, stiffness * heaviside(-w[1] - 0.001) * u[1] * (v[1] - aside * v[0]))
    }
    /// The same, transposed.
    pub fn adjoint(w: State<Vector>, u: Unknown<Vector>, v: Test<Vector>) -> Form {
        body(u, v) + integral(Floor, stiffness * heaviside(-w[1] - 0.001) * v[1] * (u[1] - aside * u[0]))
    }
    /// On springs: another matrix for another stiffness, and a floating body without them.
    pub fn springs(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        body(u, v) + integral(Floor, stiffness * dot(u, v))
    }
}

/// Mesh, space, and a load that differs with a number.
fn body(cells: usize) -> (Mesh<2>, Arc<Space<2>>) {
    let mesh = rectangle([0.0; 2], [2.0, 1.0], [2 * cells, cells], CellShape::Quadrilateral, 2).unwrap();
    let space = Space::vector(&mesh, 2).unwrap();
    (mesh, space)
}

fn model(stiffness: f64, aside: f64, load: usize) -> bodies::Model<2> {
    let rate = load as f64;
    let load =
        Given::function(move |x: &[f64; 2]| [(rate * x[0]).sin() / 9.0, -0.1 - (rate * x[1]).cos() / 50.0]);
    let regions = bodies::Regions::default().floor("bottom");
    bodies::Model { data: bodies::data().stiffness(stiffness).aside(aside).load(load), regions }
}

fn bits(field: &Field<2>) -> Vec<u64> {
    field.values().iter().map(|value| value.to_bits()).collect()
}

fn tangent(threads: usize) -> TangentSolver {
    let threads = Threads::new(threads);
    TangentSolver::new(TangentSolverOptions { threads, ..Default::default() })
}

fn norm(values: impl Iterator<Item = f64>) -> f64 {
    values.map(|value| value * value).sum::<f64>().sqrt()
}

/// A residual of another way is that of the first, up to the rounding of its terms.
fn compare(found: &Solved<2>, expected: &Solved<2>) {
    assert_eq!(bits(found.field()), bits(expected.field()));
    let difference = found.residual.iter().zip(&expected.residual).map(|(a, b)| a - b);
    let size = norm(expected.residual.iter().copied());
    assert!(size > 1e-4 && norm(difference) < 1e-11 * size, "{size:e}");
    assert_eq!(found.history.len(), 2);
    let [found, expected] = [found, expected].map(|solved| solved.history[1].step.unwrap());
    assert_eq!(found, expected);
}

/// Several loads of one matrix, then another matrix, then the first one again: three systems, two of them factored anew. Prescribed values are not zero.
#[test]
fn right_hand_sides_of_equal_matrices_have_the_bits_of_each_on_any_number_of_threads() {
    let (_, space) = body(24);
    let mut held = Constraints::new(&space);
    held.fix("left", |x| [0.02 * x[1], -0.01]).unwrap();
    let forms: Vec<Form<2>> = [(3.0, 1), (3.0, 2), (3.0, 3), (40.0, 1), (3.0, 4)]
        .map(|(k, load)| model(k, 0.0, load).springs())
        .into();
    let problem = |form: &Form<2>| Problem::new(form, &space).constrained(&held);
    let expected: Vec<Solved<2>> =
        forms.iter().map(|form| problem(form).threads(Threads::ONE).solve().unwrap()).collect();
    for threads in [1, 2, 3, 7, 16] {
        let mut solver = tangent(threads);
        let problems = forms.iter().map(|form| problem(form).threads(Threads::new(threads)));
        let found = LinearProblems::of(problems).solver(&mut solver).solve().unwrap();
        assert_eq!(found.len(), forms.len());
        found.iter().zip(&expected).for_each(|(found, expected)| compare(found, expected));
        let report = solver.report();
        assert_eq!((report.factorisations, report.solves, report.path), (3, 5, Some(SolverPath::Cholesky)));
        // Fewer columns, in another order, and by the first problem's own solver.
        for some in [&[1][..], &[2, 0], &[4, 2, 1, 0]] {
            let problems = some.iter().map(|k| problem(&forms[*k]).threads(Threads::new(threads)));
            let found = LinearProblems::of(problems).solve().unwrap();
            some.iter().zip(&found).for_each(|(k, found)| compare(found, &expected[*k]));
        }
    }
    assert!(LinearProblems::<2>::of([]).solve().unwrap().is_empty());
}

/// States of a body that rests on a floor: their matrices differ from the linear part on the floor, each in its own way, and the factor of the direct problem
/// serves all of them.
#[test]
fn matrices_that_differ_where_contact_changes_them_share_the_factor_of_the_linear_part() {
    let (_, space) = body(24);
    let mut held = Constraints::new(&space);
    held.fix("left", |_| [0.0; 2]).unwrap();
    for (threads, aside) in [(1, 0.0), (1, 0.4), (2, 0.4), (3, 0.4), (7, 0.4), (16, 0.4)] {
        let model_of = |load: usize| model(20.0, aside, load);
        let direct = |solver: &mut CondensedSolver| {
            let form = model_of(1).resting();
            let solved = Problem::new(&form, &space).constrained(&held).solver(solver).solve().unwrap();
            assert!(solved.history[0].active_points != solved.history.last().unwrap().active_points);
            solved.into_field()
        };
        let options = TangentSolverOptions { threads: Threads::new(threads), ..Default::default() };
        let mut solvers = [CondensedSolver::new(options.clone()), CondensedSolver::new(options)];
        let [u, again] = solvers.each_mut().map(direct);
        assert_eq!(bits(&u), bits(&again));
        // Contact at other places: the second state is that of a smaller load.
        let smaller = Field::interpolate(&space, |x| [0.0, if x[0] > 1.4 { -0.1 } else { 0.1 }]).unwrap();
        let wider = Field::interpolate(&space, |_| [0.0, -0.1]).unwrap();
        let forms: Vec<Form<2>> = vec![
            model_of(2).linearised(&u),
            model_of(3).linearised(&u),
            model_of(2).adjoint(&u),
            model_of(4).linearised(&smaller),
            // It touches more unknowns than the factor holds: the systems that wait are solved before there is another one.
            model_of(5).adjoint(&wider),
            model_of(6).linearised(&u),
        ];
        let problem = |form: &Form<2>| Problem::new(form, &space).homogeneous(&held);
        let [together, alone] = &mut solvers;
        let found = LinearProblems::of(forms.iter().map(problem)).solver(together).solve().unwrap();
        for (form, found) in forms.iter().zip(&found) {
            let mut own = Problem::new(form, &space).homogeneous(&held).solver(alone);
            compare(found, &own.solve().unwrap());
        }
        let [together, alone] = solvers.each_ref().map(|solver| solver.report());
        assert_eq!(together.factorisations, alone.factorisations);
        assert_eq!((together.solves, together.path), (alone.solves, Some(SolverPath::Condensed)));
    }
}

/// A solver of someone else, which knows of one right-hand side at a time.
#[derive(Default)]
struct Plain(LuSolver);

impl LinearSolver for Plain {
    fn set_matrix(&mut self, matrix: CsrMatrix) -> Result<(), SolverError> {
        self.0.set_matrix(matrix)
    }

    fn solve_with(&mut self, b: &[f64], t: f64, transpose: Transpose) -> Result<LinearSolution, SolverError> {
        self.0.solve_with(b, t, transpose)
    }
}

#[test]
fn every_solver_solves_several_right_hand_sides_and_names_the_one_that_fails() {
    let size = 700;
    let mut entries = vec![];
    for i in 0..size {
        entries.push((i, i, 4.0 + (i as f64).sin()));
        if i > 0 {
            entries.extend([(i, i - 1, -1.0), (i - 1, i, -1.0)]);
        }
    }
    let symmetric = CsrMatrix::from_triplets(size, size, &entries).unwrap();
    entries[2] = (1, 0, -0.5);
    entries[302] = (101, 100, 0.25);
    let unsymmetric = CsrMatrix::from_triplets(size, size, &entries).unwrap();
    // Rows of different size, so that the matrix is scaled.
    let scale = |i: usize| if i < 300 { 1.0 } else { 1e5 };
    let scaled: Vec<_> =
        entries.iter().filter(|(i, j, _)| i == j).map(|(i, j, v)| (*i, *j, v * scale(*i))).collect();
    let scaled = CsrMatrix::from_triplets(size, size, &scaled).unwrap();
    let load = |k: usize| -> Vec<f64> { (0..size).map(|i| ((i * (k + 1)) as f64 * 0.3).cos()).collect() };
    let loads: Vec<Vec<f64>> = (0..3).map(load).chain([vec![0.0; size]]).collect();
    let sides: Vec<&[f64]> = loads.iter().map(Vec::as_slice).collect();
    for matrix in [symmetric, unsymmetric, scaled] {
        let kinds: [fn() -> Box<dyn LinearSolver>; 4] = [
            || Box::new(TangentSolver::default()),
            || Box::new(LuSolver::default()),
            || Box::new(CondensedSolver::default()),
            || Box::new(Plain::default()),
        ];
        for kind in kinds {
            let ready = || {
                let mut solver = kind();
                solver.set_matrix(matrix.clone()).unwrap();
                solver
            };
            let mut solver = ready();
            for transpose in [Transpose::No, Transpose::Yes] {
                let each = solver.solve_each(&sides, 0.0, transpose).unwrap();
                for (b, found) in sides.iter().zip(&each) {
                    assert_eq!(*found, ready().solve_with(b, 0.0, transpose).unwrap());
                    let product = match transpose {
                        Transpose::No => matrix.multiply(&found.solution).unwrap(),
                        Transpose::Yes => matrix.multiply_transposed(&found.solution).unwrap(),
                    };
                    let rest = norm(product.iter().zip(*b).map(|(a, b)| a - b));
                    assert!(rest <= 1e-12 * norm(b.iter().copied()), "{rest:e}");
                }
            }
            assert!(solver.solve_each(&[], 0.0, Transpose::No).unwrap().is_empty());
            let mut bad = loads[1].clone();
            bad[7] = f64::NAN;
            let error = solver.solve_each(&[&loads[0], &bad, &loads[2]], 0.0, Transpose::No).unwrap_err();
            assert!(matches!(error, SolverError::OfSeveral { number: 1, count: 3, .. }), "{error}");
            assert!(error.to_string().starts_with("right-hand side 2 of 3: "), "{error}");
            let short = solver.solve_each(&[&loads[0], &[1.0]], 0.0, Transpose::No).unwrap_err();
            assert!(matches!(short, SolverError::OfSeveral { number: 1, count: 2, .. }), "{short}");
            let only = solver.solve_each(&[&bad], 0.0, Transpose::No).unwrap_err();
            assert!(!matches!(only, SolverError::OfSeveral { .. }), "{only}");
            // What failed leaves nothing behind.
            assert_eq!(solver.solve_each(&sides[..1], 0.0, Transpose::No).unwrap().len(), 1);
        }
    }
}

/// The number and the form of the problem that failed, whatever the reason is.
#[test]
fn the_problem_that_fails_is_named() {
    let (_, space) = body(3);
    let mut held = Constraints::new(&space);
    held.fix("left", |_| [0.0; 2]).unwrap();
    let (good, floating) = (model(3.0, 0.0, 1).springs(), model(0.0, 0.0, 2).springs());
    let mut absent = model(3.0, 0.0, 2);
    absent.regions = bodies::Regions::default().floor("nowhere");
    let absent = absent.springs();
    let held_at = |form: &Form<2>| Problem::new(form, &space).constrained(&held);
    let free = |form: &Form<2>| Problem::new(form, &space);
    let failures = [
        (
            vec![held_at(&good), free(&floating), held_at(&good)],
            "this is number 2 of 3 problems, `springs`",
            "nothing determines",
        ),
        (
            vec![held_at(&good), held_at(&good), held_at(&absent)],
            "this is number 3 of 3 problems, `springs`",
            "nowhere",
        ),
    ];
    for (problems, named, reason) in failures {
        let error = LinearProblems::of(problems).solve().err().unwrap().to_string();
        assert!(error.contains(named) && error.contains(reason), "{error}");
    }
    // One by itself needs no number.
    let error = LinearProblems::of([free(&floating)]).solve().err().unwrap().to_string();
    assert!(!error.contains("problems"), "{error}");
    // With a condensed solver that waits for the others, which then solves the next ones.
    let mut solver = CondensedSolver::default();
    let resting = model(20.0, 0.0, 1).resting();
    let u =
        Problem::new(&resting, &space).constrained(&held).solver(&mut solver).solve().unwrap().into_field();
    let linearised = model(20.0, 0.0, 2).linearised(&u);
    let problems = [held_at(&linearised), held_at(&absent)];
    let error = LinearProblems::of(problems).solver(&mut solver).solve().err().unwrap().to_string();
    assert!(error.contains("number 2 of 2 problems"), "{error}");
    let found =
        LinearProblems::of([held_at(&linearised), held_at(&linearised)]).solver(&mut solver).solve().unwrap();
    assert_eq!(bits(found[0].field()), bits(found[1].field()));
}

/// A nonlinear problem among linear ones is solved in its place, and so are those with bounds.
#[test]
fn what_is_no_linear_system_is_solved_by_itself() {
    let (_, space) = body(6);
    let mut held = Constraints::new(&space);
    held.fix("left", |_| [0.0; 2]).unwrap();
    let mut bounds = Bounds::new(&space);
    bounds.at_least("right", |_| [-1.0, -0.01]).unwrap();
    let forms: Vec<Form<2>> =
        vec![model(3.0, 0.0, 1).springs(), model(20.0, 0.0, 1).resting(), model(3.0, 0.0, 2).springs()];
    let problem = |form: &Form<2>| Problem::new(form, &space).constrained(&held);
    let mut problems: Vec<_> = forms.iter().map(problem).collect();
    problems.push(problem(&forms[2]).bounded(&bounds));
    let found = LinearProblems::of(problems).solve().unwrap();
    let expected: Vec<_> = forms.iter().map(|form| problem(form).solve().unwrap()).collect();
    assert_eq!(bits(found[0].field()), bits(expected[0].field()));
    assert_eq!(bits(found[2].field()), bits(expected[2].field()));
    assert!(found[1].history.len() > 2);
    let bounded = problem(&forms[2]).bounded(&bounds).solve().unwrap();
    assert!(bits(bounded.field()) != bits(expected[2].field()));
    assert_eq!(bits(found[3].field()), bits(bounded.field()));
}

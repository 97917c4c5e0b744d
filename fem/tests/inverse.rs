//! Adjoints of histories: gradients of steps of loads and of steps in time, by all kinds of controls; what does not fit is named.

use forms_fem::inverse::{
    At, ControlError, Controls, During, HistoryError, LoadHistory, MotionHistory, Observations,
    ReducedProblem, taylor_test,
};
use forms_fem::prelude::*;
use forms_fem::time::{
    BackwardDifferences, CentralDifferences, Combination, Formulas, GeneralisedAlpha, OneStepTheta, Scheme,
};

#[forms(dimension = 2)]
mod hanging {
    use forms_fem::time::operators::vector::{acceleration, displacement, velocity};

    #[extends(forms_fem::time::operators::vector::Data)]
    pub struct Data {
        pub density: Param,
        pub stiffness: Given<Scalar>,
        pub pull: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Right;

    pub fn motion(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let w = displacement(u);
        integral(
            Omega,
            density * dot(acceleration(u) + 0.3 * velocity(u), v) + stiffness * inner(eps(w), eps(v)),
        ) + integral(Omega, (0.5 + dot(w, w)) * dot(w, v))
            - integral(Right, pull * v[1])
    }
    /// As `motion`, with a hardening spring and a damper that read the unknown itself.
    pub fn sprung(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        motion(u, v) + integral(Right, (1 + 9 * dot(u, u)) * dot(2 * u + 0.4 * velocity(u), v))
    }
    pub fn sprung_rates(
        u: State<Vector>,
        p: State<Vector>,
        by_density: Test<Scalar>,
        by_stiffness: Test<Scalar>,
        by_pull: Test<Scalar>,
    ) -> Form {
        derivative(sprung(u, p), density, by_density)
            + derivative(sprung(u, p), stiffness, by_stiffness)
            + derivative(sprung(u, p), pull, by_pull)
    }
    pub fn misfit(u: Unknown<Vector>) -> Energy {
        integral(Omega, sqr(u[1] - 0.01 * x[0]) / 2)
    }
    pub fn rates(
        u: State<Vector>,
        p: State<Vector>,
        by_density: Test<Scalar>,
        by_stiffness: Test<Scalar>,
        by_pull: Test<Scalar>,
    ) -> Form {
        derivative(motion(u, p), density, by_density)
            + derivative(motion(u, p), stiffness, by_stiffness)
            + derivative(motion(u, p), pull, by_pull)
    }
}

#[forms(dimension = 2)]
mod heated {
    use forms_fem::time::operators::scalar::{rate, value};

    #[extends(forms_fem::time::operators::scalar::Data)]
    pub struct Data {
        pub conductivity: Param,
        pub bent: Param,
    }
    #[cells]
    pub struct Omega;

    pub fn balance(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        let w = value(u);
        integral(Omega, rate(u) * v + conductivity * (1 + bent * sqr(w)) * dot(grad(w), grad(v)) - v)
    }
    pub fn rates(u: State<Scalar>, p: State<Scalar>, by_conductivity: Test<Scalar>) -> Form {
        derivative(balance(u, p), conductivity, by_conductivity)
    }
    /// The same without a test function of its control.
    pub fn untested(u: State<Scalar>, p: State<Scalar>, by_bent: Test<Scalar>) -> Form {
        derivative(balance(u, p), bent, by_bent)
    }
}

/// A spring that reads what was written at quadrature points.
#[forms(dimension = 2)]
mod remembering {
    pub struct Data {
        pub stiffness: Param,
        pub rest: History<Scalar>,
    }
    #[cells]
    pub struct Omega;

    pub fn balance(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, stiffness * (u - rest) * v)
    }
    pub fn size(u: Unknown<Scalar>) -> Energy {
        integral(Omega, u * u / 2)
    }
    pub fn rates(u: State<Scalar>, p: State<Scalar>, by_stiffness: Test<Scalar>) -> Form {
        derivative(balance(u, p), stiffness, by_stiffness)
    }
}

#[test]
fn values_at_quadrature_points_are_refused() {
    let mesh = Arc::new(rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Quadrilateral, 1).unwrap());
    let space = Space::scalar(&mesh, 1).unwrap();
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(2));
    let rest = assembler.history(Entity::Cells, "all", 2, 1.0).unwrap();
    let model = |at: &At<2>| -> Result<_, ControlError> {
        Ok(remembering::Model::new(remembering::Data {
            stiffness: at.number("stiffness")?,
            rest: rest.clone(),
        }))
    };
    let mut history = LoadHistory::new(&space, 2, Controls::new().number("stiffness", 2.0))
        .step(|at| Ok(model(at)?.balance()))
        .rates(|at, u, p| Ok(model(at)?.rates(u, p)))
        .criterion(|at| Ok(model(at)?.size()))
        .assembler(&assembler);
    let error = history.gradient(&[2.0]).map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("`balance` reads the history `rest`"), "{error}");
}

/// Order two along a direction of all controls.
fn check(label: &str, problem: &mut dyn ReducedProblem<Error = HistoryError>, size: f64) {
    let m = problem.start();
    let direction: Vec<f64> = (0..m.len()).map(|k| size * (1.0 + 1.7 * k as f64).sin()).collect();
    let report = taylor_test(problem, &m, &direction, 0.2).unwrap();
    let order = report.second_order().unwrap_or_else(|error| panic!("{label}: {error}"));
    println!("{label}: {order:.3}");
    assert!((order - 2.0).abs() < 0.02, "{label}: {report}");
}

fn same(label: &str, few: &[f64], all: &[f64]) {
    let largest = all.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
    for (few, all) in few.iter().zip(all) {
        assert!((few - all).abs() <= 1e-10 * largest, "{label}: {few} is not {all}");
    }
}

fn hung(during: &During<2>) -> Result<hanging::Model<2>, ControlError> {
    let data = hanging::Data {
        base: during.into(),
        density: during.number("density")?,
        stiffness: Given::field(&during.field("stiffness")?),
        pull: during.number("pull")?,
    };
    Ok(hanging::Model { data, regions: hanging::Regions::default() })
}

/// Density, stiffness of each cell, a load per step, displacement and velocity at the start; J over all steps, and a point at the end.
#[test]
fn adjoints_of_motions_by_material_load_and_start() {
    let mesh = Arc::new(rectangle([0.0; 2], [1.0, 0.3], [4, 2], CellShape::Quadrilateral, 1).unwrap());
    let space = Space::vector(&mesh, 1).unwrap();
    let cells = Space::discontinuous_scalar(&mesh, 0).unwrap();
    let mut held = Constraints::new(&space);
    held.fix("left", |_| [0.0; 2]).unwrap();
    let stiffness = Field::interpolate(&cells, |x| 3.0 + x[0]).unwrap();
    let start = Field::interpolate(&space, |x| [0.0, 0.1 * x[0] * x[0]]).unwrap();
    let rate = Field::interpolate(&space, |x| [0.05 * x[0], 0.0]).unwrap();
    let pulls: Vec<f64> = (0..10).map(|n| 0.2 + 0.02 * f64::from(n)).collect();
    let nothing = Given::constant(0.0);
    let data = hanging::Data { base: Default::default(), density: 0.0, stiffness: nothing, pull: 0.0 };
    let criterion = hanging::Model { data, regions: hanging::Regions::default() };
    let observed = Observations::new(&space).at_point(&[0.83, 0.17], &[0.0, 0.05], 3.0).unwrap();
    for (name, scheme) in [
        ("trapezoidal", GeneralisedAlpha::trapezoidal()),
        ("mid-point", GeneralisedAlpha::mid_point()),
        ("generalised-α", GeneralisedAlpha::with_spectral_radius(0.5).unwrap()),
    ] {
        let controls = Controls::new()
            .number("density", 1.3)
            .field("stiffness", &stiffness)
            .per_step("pull", &pulls)
            .start("start", &start)
            .start_rate("rate", &rate);
        let mut motion = MotionHistory::new(&space, (10, 0.1), scheme, controls)
            .motion(|during| Ok(hung(during)?.motion()))
            .rates(|during, u, p| Ok(hung(during)?.rates(u, p)))
            .criterion(|_| Ok(criterion.misfit()))
            .observed(9, observed.clone())
            .constrained(&held)
            .options(NewtonOptions { relative_tolerance: 1e-13, ..NewtonOptions::default() });
        check(name, &mut motion, 0.02);
        let m = motion.start();
        let all = motion.gradient(&m).unwrap();
        let few = motion.stored_states(3).gradient(&m).unwrap();
        assert_eq!((all.work.steps_solved, few.work.most_stored), (10, 3));
        same(name, &few.gradient, &all.gradient);
    }
    // The unknown itself beside the operators, with schemes in which it is the value at the end of the step throughout.
    for (name, scheme) in [
        ("mid-point", Box::new(GeneralisedAlpha::mid_point()) as Box<dyn Scheme>),
        ("HHT's weights without accelerations", Box::new(Uneven)),
    ] {
        let controls = Controls::new()
            .number("density", 1.3)
            .field("stiffness", &stiffness)
            .per_step("pull", &pulls)
            .start("start", &start)
            .start_rate("rate", &rate);
        let mut motion = MotionHistory::new(&space, (10, 0.1), Chosen(scheme), controls)
            .motion(|during| Ok(hung(during)?.sprung()))
            .rates(|during, u, p| Ok(hung(during)?.sprung_rates(u, p)))
            .criterion(|_| Ok(criterion.misfit()))
            .observed(9, observed.clone())
            .constrained(&held)
            .options(NewtonOptions { relative_tolerance: 1e-13, ..NewtonOptions::default() });
        check(name, &mut motion, 0.02);
    }
}

/// A scheme that is chosen when the program runs.
#[derive(Debug)]
struct Chosen(Box<dyn Scheme>);

impl Scheme for Chosen {
    fn reads_second_rates(&self) -> bool {
        self.0.reads_second_rates()
    }
    fn formulas(&self, steps: &[f64]) -> Formulas {
        self.0.formulas(steps)
    }
}

/// Forces at three tenths of the way from the end, the rate at the end by the mid-point rule.
#[derive(Debug)]
struct Uneven;

impl Scheme for Uneven {
    fn reads_second_rates(&self) -> bool {
        false
    }
    fn formulas(&self, steps: &[f64]) -> Formulas {
        let mid_point = GeneralisedAlpha::mid_point().formulas(steps);
        let start = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(|last| Combination::new(0.0, last));
        let part = |which: usize| Combination::sum(&[(0.7, &mid_point.end[which]), (0.3, &start[which])]);
        let evaluated = [part(0), part(1), mid_point.evaluated[2].clone()];
        Formulas { evaluated, load_at: 0.7, ..mid_point }
    }
}

fn heat(during: &During<2>, bent: f64) -> Result<heated::Model<2>, ControlError> {
    let (base, conductivity) = (during.into(), during.number("conductivity")?);
    Ok(heated::Model::new(heated::Data { base, conductivity, bent }))
}

fn square() -> (Arc<Space<2>>, Constraints<2>) {
    let mesh = Arc::new(rectangle([0.0; 2], [1.0; 2], [4, 4], CellShape::Triangle, 1).unwrap());
    let space = Space::scalar(&mesh, 1).unwrap();
    let mut held = Constraints::new(&space);
    held.fix("left", |_| 0.1).unwrap();
    (space, held)
}

/// Linear ones too, whose steps and adjoints share one factor.
#[test]
fn adjoints_of_diffusion() {
    let (space, held) = square();
    let start = Field::interpolate(&space, |x| 0.1 + x[0]).unwrap();
    let measured = Field::interpolate(&space, |x| 0.2 * x[0]).unwrap();
    for (name, scheme) in [
        ("implicit Euler", OneStepTheta::implicit_euler()),
        ("Crank-Nicolson", OneStepTheta::crank_nicolson()),
    ] {
        for bent in [0.0, 0.7] {
            let controls = Controls::new().number("conductivity", 0.4).start("start", &start);
            let mut solver = TangentSolver::default();
            let mut diffusion = MotionHistory::new(&space, (8, 0.05), scheme, controls)
                .motion(|during| Ok(heat(during, bent)?.balance()))
                .rates(|during, u, p| Ok(heat(during, bent)?.rates(u, p)))
                .observed(3, Observations::new(&space).at_nodes(&measured, 0.5).unwrap())
                .observed(7, Observations::new(&space).at_nodes(&measured, 1.0).unwrap())
                .with_cost_of_controls(|m| {
                    let slopes = m.iter().enumerate().map(|(k, m)| if k == 0 { 2.0 * m } else { 0.0 });
                    (m[0] * m[0], slopes.collect())
                })
                .constrained(&held)
                .solver(&mut solver)
                .options(NewtonOptions { relative_tolerance: 1e-13, ..NewtonOptions::default() });
            let m = diffusion.start();
            diffusion.gradient(&m).unwrap();
            if bent == 0.0 {
                drop(diffusion);
                assert_eq!(solver.report().factorisations, 1, "{name}");
            } else {
                check(name, &mut diffusion, 0.05);
            }
        }
    }
}

#[test]
fn what_does_not_fit_is_named() {
    let (space, held) = square();
    let measured = Field::zero(&space);
    let message = |history: &mut dyn ReducedProblem<Error = HistoryError>, m: &[f64]| {
        history.value_and_gradient(m).unwrap_err().to_string()
    };
    fn motion<'a>(
        space: &Arc<Space<2>>,
        scheme: impl Scheme + 'a,
        controls: Controls<2>,
    ) -> MotionHistory<'a, 2> {
        MotionHistory::new(space, (2, 0.1), scheme, controls)
            .motion(|during| Ok(heat(during, 0.0)?.balance()))
            .rates(|during, u, p| Ok(heat(during, 0.0)?.rates(u, p)))
    }
    let euler = OneStepTheta::implicit_euler();
    let one = || Controls::new().number("conductivity", 0.4);
    let nodes = || Observations::new(&space).at_nodes(&measured, 1.0).unwrap();
    let ready = |controls| motion(&space, euler, controls).observed(1, nodes()).constrained(&held);
    for (label, mut history, m, expected) in [
        ("no criterion", motion(&space, euler, one()), vec![0.4], "the history has no criterion"),
        ("later", motion(&space, euler, one()).observed(2, nodes()), vec![0.4], "the last step is 1"),
        ("length", ready(one()), vec![], "the controls have 1 values, and 0 were given"),
        ("not finite", ready(one()), vec![f64::NAN], "value NaN of the control `conductivity` is not finite"),
        ("unknown", ready(Controls::new().number("k", 1.0)), vec![1.0], "no number `conductivity`"),
        ("twice", ready(one().number("conductivity", 1.0)), vec![1.0; 2], "two controls are named"),
        (
            "per step",
            ready(Controls::new().per_step("conductivity", &[1.0; 3])),
            vec![1.0; 3],
            "there are 2 steps",
        ),
        ("untested", ready(one().number("more", 1.0)), vec![1.0; 2], "no test function `by_more`"),
        (
            "other test",
            ready(one()).rates(|during, u, p| Ok(heat(during, 0.0)?.untested(u, p))),
            vec![0.4],
            "the test function `by_bent` of `untested` belongs to no control",
        ),
    ] {
        let found = message(&mut history, &m);
        assert!(found.contains(expected), "{label}: {found}");
    }
    for mut history in [
        motion(&space, BackwardDifferences::new(2).unwrap(), one()).observed(1, nodes()),
        motion(&space, CentralDifferences, one()).observed(1, nodes()),
    ] {
        let found = message(&mut history, &[0.4]);
        assert!(found.contains("has no adjoint here"), "{found}");
    }
    let vectors = Space::vector(space.mesh(), 1).unwrap();
    let cells = Space::discontinuous_scalar(vectors.mesh(), 0).unwrap();
    let stiffness = Field::interpolate(&cells, |_| 2.0).unwrap();
    let controls = Controls::new().number("density", 1.0).field("stiffness", &stiffness).number("pull", 0.1);
    let mut sprung = MotionHistory::new(&vectors, (2, 0.1), GeneralisedAlpha::trapezoidal(), controls)
        .motion(|during| Ok(hung(during)?.sprung()))
        .rates(|during, u, p| Ok(hung(during)?.rates(u, p)))
        .observed(1, Observations::new(&vectors).at_nodes(&Field::zero(&vectors), 1.0).unwrap());
    let m = sprung.start();
    let found = message(&mut sprung, &m);
    assert!(found.contains("`sprung` reads its unknown `u` itself"), "{found}");
    assert!(Observations::new(&space).at_point(&[2.0, 0.0], &[0.0], 1.0).is_err());
    assert!(Observations::new(&space).at_point(&[0.5; 2], &[0.0; 2], 1.0).is_err());
}

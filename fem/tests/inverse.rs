//! Adjoints of histories: gradients of steps of loads and of steps in time, by all kinds of controls; what does not fit is named.

use forms_fem::inverse::{
    ControlError, ControlValues, Controls, HistoryError, LoadHistory, MotionHistory, Observations,
    ReducedProblem, StepContext, taylor_test,
};
use forms_fem::prelude::*;
use forms_fem::time::{
    BackwardDifferences, CentralDifferences, Combination, Formulas, GeneralisedAlpha, OneStepTheta, Scheme,
};

use crate::swinging_body::{Body, STEPS, swung};

#[forms(dimension = 2)]
mod heated {
    use forms_fem::time::operators::scalar::{rate, value};

    #[includes(forms_fem::time::operators::scalar::Data)]
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
    pub fn sensitivities(u: State<Scalar>, p: State<Scalar>, by_conductivity: Test<Scalar>) -> Form {
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
    pub fn sensitivities(u: State<Scalar>, p: State<Scalar>, by_stiffness: Test<Scalar>) -> Form {
        derivative(balance(u, p), stiffness, by_stiffness)
    }
}

#[test]
fn values_at_quadrature_points_are_refused() {
    let mesh = rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Quadrilateral, 1).unwrap();
    let space = Space::scalar(&mesh, 1).unwrap();
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(2));
    let rest = assembler.history(Entity::Cells, "all", 2, 1.0).unwrap();
    let model = |at: &ControlValues<2>| -> Result<_, ControlError> {
        Ok(remembering::Model::new(remembering::data().stiffness(at.number("stiffness")?).rest(rest.clone())))
    };
    let mut history = LoadHistory::new(&space, 2, Controls::new().number("stiffness", 2.0))
        .step(|at| Ok(model(at)?.balance()))
        .sensitivities(|at, u, p| Ok(model(at)?.sensitivities(u, p)))
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

/// Density, stiffness of each cell, a load per step, displacement and velocity at the start; J over all steps, and a point after one: of a
/// form that reads the unknown itself next to the operators, with schemes in which it is the value at the end of the step throughout.
#[test]
fn adjoints_of_motions_that_read_the_unknown_itself() {
    let body = Body::new([4, 2]);
    let sprung = |scheme: Box<dyn Scheme>| {
        body.history((STEPS, 0.15), scheme).motion(|during| Ok(swung(during, None)?.sprung()))
    };
    check("mid-point", &mut sprung(Box::new(GeneralisedAlpha::mid_point())), 0.02);
    check("HHT's weights without accelerations", &mut sprung(Box::new(Uneven)), 0.02);
    let mut backward = sprung(Box::new(BackwardDifferences::new(2).unwrap()));
    check("BDF", &mut backward, 0.02);
    let m = backward.start();
    let all = backward.gradient(&m).unwrap();
    let few = backward.stored_states(3).gradient(&m).unwrap();
    assert_eq!((all.work.steps_solved, few.work.most_stored), (STEPS, 3));
    same("few states", &few.gradient, &all.gradient);
    let mut refused = sprung(Box::new(GeneralisedAlpha::trapezoidal()));
    let found = refused.gradient(&m).map(|_| ()).unwrap_err().to_string();
    assert!(found.contains("`sprung` reads its unknown `u` itself"), "{found}");
}

/// Reads the state before the last one in the first step, too.
#[derive(Debug)]
struct Greedy;

impl Scheme for Greedy {
    fn reads_second_rates(&self) -> bool {
        false
    }
    fn formulas(&self, steps: &[f64]) -> Formulas {
        BackwardDifferences::new(2).unwrap().formulas(&[steps[0]; 2])
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

fn heat(during: &StepContext<2>, bent: f64) -> Result<heated::Model<2>, ControlError> {
    let conductivity = during.number("conductivity")?;
    Ok(heated::Model::new(heated::data_from(during).conductivity(conductivity).bent(bent)))
}

fn square() -> (Arc<Space<2>>, Constraints<2>) {
    let mesh = rectangle([0.0; 2], [1.0; 2], [4, 4], CellShape::Triangle, 1).unwrap();
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
                .sensitivities(|during, u, p| Ok(heat(during, bent)?.sensitivities(u, p)))
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
            .sensitivities(|during, u, p| Ok(heat(during, 0.0)?.sensitivities(u, p)))
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
        ("reserved", ready(one().number("value", 1.0)), vec![1.0; 2], "a control cannot be named `value`"),
        (
            "per step",
            ready(Controls::new().per_step("conductivity", &[1.0; 3])),
            vec![1.0; 3],
            "there are 2 steps",
        ),
        ("untested", ready(one().number("more", 1.0)), vec![1.0; 2], "no test function `by_more`"),
        (
            "other test",
            ready(one()).sensitivities(|during, u, p| Ok(heat(during, 0.0)?.untested(u, p))),
            vec![0.4],
            "the test function `by_bent` of `untested` belongs to no control",
        ),
    ] {
        let found = message(&mut history, &m);
        assert!(found.contains(expected), "{label}: {found}");
    }
    let greedy = motion(&space, Greedy, one()).observed(1, nodes());
    let zero = MotionHistory::new(&space, &[0.1, 0.0][..], euler, one());
    for (mut history, expected) in [
        (greedy, "the scheme reads 2 states, and there are 1"),
        (zero, "the step size 0 is no positive number"),
    ] {
        let found = message(&mut history, &[0.4]);
        assert!(found.contains(expected), "{found}");
    }
    let body = Body::new([2, 1]);
    let mut moving = body.free_history((STEPS, 0.04), CentralDifferences).constrained_at(|time| {
        let mut moving = Constraints::new(&body.space);
        moving.fix("left", |_| [time, 0.0])?;
        Ok(moving)
    });
    let m = moving.start();
    let found = message(&mut moving, &m);
    assert!(found.contains("an explicit step keeps prescribed values as they are"), "{found}");
    assert!(Observations::new(&space).at_point(&[2.0, 0.0], &[0.0], 1.0).is_err());
    assert!(Observations::new(&space).at_point(&[0.5; 2], &[0.0; 2], 1.0).is_err());
}

/// A block under a load that turns cells inside out in whole steps of Newton's method.
#[forms(dimension = 2)]
mod pressed {
    pub struct Data {
        pub load: Param,
        pub part: Param,
        /// 1 in the step that counts.
        pub counts: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Top;

    #[controls(load, criterion = sinking)]
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let F = I + grad(u);
        let P = F - inv(transpose(F)) + ln(det(F)) * inv(transpose(F));
        integral(Omega, inner(P, grad(v))) + integral(Top, part * load * v[1])
    }
    pub fn sinking(u: Unknown<Vector>) -> Energy {
        integral(Top, counts * u[1])
    }
    pub fn volume(u: Unknown<Vector>) -> Functional {
        integral(Omega, det(I + grad(u)))
    }
}

/// Steps that lead to the last one have no past and no `by_before`; J is kept positive. The block's height s obeys s − 1/s + ln(s)/s = −load.
#[test]
fn load_steps_without_a_past_keep_a_functional_positive() {
    let mesh = rectangle([0.0; 2], [1.0; 2], [2; 2], CellShape::Quadrilateral, 1).unwrap();
    let space = Space::vector(&mesh, 1).unwrap();
    let mut held = Constraints::new(&space);
    held.fix_component("bottom", 1, |_| 0.0).unwrap();
    held.fix_component("left", 0, |_| 0.0).unwrap();
    held.fix_component("right", 0, |_| 0.0).unwrap();
    let model = |at: &ControlValues<2>| -> Result<_, ControlError> {
        let [part, counts] = [[0.5, 0.0], [1.0, 1.0]][at.step()];
        let data = pressed::data().load(at.number("load")?).part(part).counts(counts);
        Ok(pressed::Model { data, regions: pressed::Regions::default() })
    };
    let history = || {
        LoadHistory::new(&space, 2, Controls::new().number("load", 6.0))
            .step(|at| Ok(model(at)?.balance()))
            .sensitivities(|at, u, p| Ok(model(at)?.balance_sensitivities(u, p)))
            .criterion(|at| Ok(model(at)?.sinking()))
            .constrained(&held)
            .assembler(&Assembler::new(&mesh).with_quadrature(Quadrature::Degree(4)))
    };
    assert!(history().value(&[6.0]).is_err());
    let mut kept = history().keep_positive(|at| Ok(model(at)?.volume()));
    let (value, gradient) = kept.value_and_gradient(&[6.0]).unwrap();
    let s = 1.0 + value;
    assert!((s - 1.0 / s + s.ln() / s + 6.0).abs() < 1e-9, "{s}");
    let slope = -1.0 / (1.0 + (2.0 - s.ln()) / (s * s));
    assert!((gradient[0] / slope - 1.0).abs() < 1e-8, "{gradient:?}, {slope}");
    // A step that asks for the state before has a past.
    let asks = history().step(|at| at.before().and(Ok(model(at)?.balance())));
    let error = asks.keep_positive(|at| Ok(model(at)?.volume())).gradient(&[6.0]).map(|_| ()).unwrap_err();
    assert!(error.to_string().contains("no test function `by_before`"), "{error}");
}

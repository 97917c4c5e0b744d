//! Load histories of several unknowns: gradients against differences, adjoints that are exact for any number of stored states, starts as controls,
//! Hessians, what is missing by name.

use forms_fem::inverse::{
    ControlError, ControlValues, Controls, HistoryFailure, LoadHistory, Observations, ReducedProblem,
    TwiceDifferentiable, second_order_taylor_test, taylor_test,
};
use forms_fem::prelude::*;

/// Consolidation of a porous body whose permeability depends on its strain, step by step by the implicit Euler method.
#[forms(dimension = 2)]
mod porous {
    pub struct Data {
        pub size: Param,
        pub mu: Given<Scalar>,
        pub permeability: Param,
        pub load: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Top;

    #[controls(mu, permeability, load, order = 2)]
    pub fn step(
        u: Unknown<Vector>,
        p: Unknown<Scalar>,
        v: Test<Vector>,
        q: Test<Scalar>,
        u0: State<Vector>,
        p0: State<Scalar>,
    ) -> Form {
        integral(Omega, 2 * mu * inner(eps(u), eps(v)) - p * div(v))
            + integral(Omega, (div(u) - div(u0) + 0.1 * (p - p0)) * q)
            + integral(Omega, size * permeability * exp(3 * div(u)) * dot(grad(p), grad(q)))
            + integral(Top, load * dot(n, v))
    }
    /// It reads both unknowns.
    pub fn criterion(u: Unknown<Vector>, p: Unknown<Scalar>) -> Energy {
        integral(Omega, dot(u, u) + 0.2 * pow(p, 4))
    }
    /// It reads the first one only.
    pub fn settlement(u: Unknown<Vector>) -> Energy {
        integral(Omega, dot(u, u))
    }
    pub fn sensitivities(
        u: State<Vector>,
        p: State<Scalar>,
        y: State<Vector>,
        z: State<Scalar>,
        u0: State<Vector>,
        p0: State<Scalar>,
        by_before_u: Test<Vector>,
        by_before_p: Test<Scalar>,
        by_mu: Test<Scalar>,
        by_permeability: Test<Scalar>,
        by_load: Test<Scalar>,
    ) -> Form {
        let work = step(u, p, y, z, u0, p0);
        derivative(work, u0, by_before_u)
            + derivative(work, p0, by_before_p)
            + derivative(work, mu, by_mu)
            + derivative(work, permeability, by_permeability)
            + derivative(work, load, by_load)
    }
}

const STEPS: usize = 5;

struct Body {
    displacements: Arc<Space<2>>,
    pressures: Arc<Space<2>>,
    held: Constraints<2>,
    drained: Constraints<2>,
    controls: Controls<2>,
}

fn data(at: &ControlValues<2>) -> Result<porous::Data<2>, ControlError> {
    Ok(porous::data()
        .size(0.1)
        .mu(&at.field("mu")?)
        .permeability(at.number("permeability")?)
        .load(at.number("load")?))
}

fn model(at: &ControlValues<2>) -> Result<porous::Model<2>, ControlError> {
    Ok(porous::Model::new(data(at)?))
}

impl Body {
    fn new() -> Self {
        let mut body = Self::undrained(|mesh| Space::scalar(mesh, 1).unwrap());
        body.drained.fix("top", |_| 0.0).unwrap();
        body
    }

    fn undrained(pressures: impl Fn(&Mesh<2>) -> Arc<Space<2>>) -> Self {
        let mesh = rectangle([0.0; 2], [0.5, 1.0], [2, 4], CellShape::Quadrilateral, 1).unwrap();
        let (displacements, pressures) = (Space::vector(&mesh, 2).unwrap(), pressures(&mesh));
        let mut held = Constraints::new(&displacements);
        held.fix("bottom", |_| [0.0; 2]).unwrap();
        held.fix_component("left", 0, |_| 0.0).unwrap();
        let drained = Constraints::new(&pressures);
        let cells = Space::discontinuous_scalar(&mesh, 0).unwrap();
        let mu = Field::interpolate(&cells, |x| 1.0 + 0.5 * x[0] + 0.3 * x[1]).unwrap();
        let controls = Controls::new()
            .field("mu", &mu)
            .number("permeability", 0.7)
            .per_step("load", &[0.1, 0.2, 0.25, 0.2, 0.1]);
        Body { displacements, pressures, held, drained, controls }
    }

    fn bare<'h>(&self, controls: Controls<2>) -> LoadHistory<'h, 2> {
        LoadHistory::new([&self.displacements, &self.pressures], STEPS, controls)
            .step(|at| {
                let [u0, p0] = at.before_of_all()? else { unreachable!("two unknowns") };
                Ok(model(at)?.step(u0, p0))
            })
            .coupled_sensitivities(|at, states, adjoints| {
                let ([u, p], [y, z], [u0, p0]) = (states, adjoints, at.before_of_all()?) else {
                    unreachable!("two unknowns")
                };
                Ok(model(at)?.sensitivities(u, p, y, z, u0, p0))
            })
            .constrained(&self.held)
            .constrained(&self.drained)
    }

    fn history<'h>(&self) -> LoadHistory<'h, 2> {
        self.bare(self.controls.clone()).criterion(|at| Ok(model(at)?.criterion()))
    }
}

/// The largest difference of a gradient from central differences along some controls, as a part of the largest entry.
fn off(history: &mut LoadHistory<'_, 2>, m: &[f64], places: &[usize]) -> f64 {
    let (_, gradient) = history.value_and_gradient(m).unwrap();
    let largest = gradient.iter().fold(0.0_f64, |largest, entry| largest.max(entry.abs()));
    let mut worst = 0.0_f64;
    for &place in places {
        let mut at = |change: f64| {
            let mut moved = m.to_vec();
            moved[place] += change;
            history.value(&moved).unwrap()
        };
        let difference = (8.0 * (at(1e-3) - at(-1e-3)) - (at(2e-3) - at(-2e-3))) / 12e-3;
        worst = worst.max((difference - gradient[place]).abs());
    }
    worst / largest
}

#[test]
fn gradients_of_two_unknowns() {
    let body = Body::new();
    let (m, mut history) = (body.controls.values().to_vec(), body.history());
    let last = m.len() - 1;
    let worst = off(&mut history, &m, &[0, 3, 8, last - 4, last - 2, last]);
    assert!(worst < 1e-9, "{worst:e}");
    let direction: Vec<f64> = (0..m.len()).map(|k| (1.3 * k as f64 + 0.2).cos()).collect();
    taylor_test(&mut history, &m, &direction, 0.02).unwrap().second_order().unwrap();
    // With one stored state the steps are solved again, to the same gradient.
    let whole = body.history().gradient(&m).unwrap();
    let few = body.history().stored_states(1).gradient(&m).unwrap();
    let largest = whole.gradient.iter().fold(0.0_f64, |largest, entry| largest.max(entry.abs()));
    let differences = few.gradient.iter().zip(&whole.gradient).map(|(few, whole)| (few - whole).abs());
    assert!(few.work.steps_solved > STEPS && differences.fold(0.0, f64::max) < 1e-11 * largest);
}

/// An energy of the first unknown, and observations of each.
#[test]
fn criteria_of_some_unknowns() {
    let body = Body::new();
    let m = body.controls.values().to_vec();
    let mut first = body.bare(body.controls.clone()).criterion(|at| Ok(model(at)?.settlement()));
    let permeability = m.len() - STEPS - 1;
    assert!(off(&mut first, &m, &[1, permeability]) < 1e-9);
    let pressures = Observations::new(&body.pressures).at_point(&[0.2, 0.1], &[0.3], 2.0).unwrap();
    let displacements =
        Observations::new(&body.displacements).at_point(&[0.5, 1.0], &[0.0, -0.1], 1.0).unwrap();
    let mut observed =
        body.bare(body.controls.clone()).observed(2, pressures).observed(STEPS - 1, displacements);
    assert!(off(&mut observed, &m, &[1, permeability, m.len() - 1]) < 1e-9);
}

/// Pressures of cells, whose equations are eliminated in each step and each adjoint step: the gradient is that by LU of all equations.
#[test]
fn pressures_of_cells_are_eliminated() {
    let body = Body::undrained(|mesh| Space::discontinuous_scalar(mesh, 0).unwrap());
    let (m, mut history) = (body.controls.values().to_vec(), body.history());
    let last = m.len() - 1;
    let worst = off(&mut history, &m, &[0, 3, 7, last - 2, last]);
    assert!(worst < 1e-9, "{worst:e}");
    let eliminated = history.solver_report().and_then(|report| report.local_unknowns);
    assert_eq!(eliminated.map(|counts| counts.eliminated), Some(8));
    let mut lu = LuSolver::default();
    let whole = body.history().solver(&mut lu).gradient(&m).unwrap().gradient;
    let found = history.gradient(&m).unwrap().gradient;
    let largest = whole.iter().fold(0.0_f64, |largest, entry| largest.max(entry.abs()));
    for (found, whole) in found.iter().zip(&whole) {
        assert!((found - whole).abs() < 1e-11 * largest, "{found} {whole}");
    }
}

/// Starts of both unknowns as controls.
#[test]
fn gradients_by_the_starts() {
    let body = Body::new();
    let u0 = Field::interpolate(&body.displacements, |x| [0.01 * x[0] * x[1], -0.02 * x[1]]).unwrap();
    let p0 = Field::interpolate(&body.pressures, |x| 0.1 * (1.0 - x[1])).unwrap();
    let controls = body.controls.clone().start("p0", &p0).start("u0", &u0);
    let mut history = body.bare(controls.clone()).criterion(|at| Ok(model(at)?.criterion()));
    let m = controls.values().to_vec();
    let (of_p, of_u) = (controls.places("p0").unwrap(), controls.places("u0").unwrap());
    let places = [of_p.start + 1, of_p.end - 4, of_u.start + 12, of_u.end - 5];
    let worst = off(&mut history, &m, &places);
    assert!(worst < 1e-9, "{worst:e}");
    let states = history.states_of_all(&m).unwrap();
    assert!(states.len() == STEPS && states[0].len() == 2);
}

#[test]
fn what_is_missing_is_named() {
    let body = Body::new();
    let m = body.controls.values().to_vec();
    let why = |mut history: LoadHistory<'_, 2>| history.gradient(&m).unwrap_err().why;
    let one = LoadHistory::new(&body.displacements, STEPS, body.controls.clone())
        .step(|at| Ok(model(at)?.step(at.before()?, at.before()?)))
        .criterion(|at| Ok(model(at)?.settlement()));
    let found = why(one);
    assert!(matches!(found, HistoryFailure::Unknowns { found: 2, expected: 1, .. }), "{found}");
    let found = why(body.history().constrained(&body.held));
    assert!(matches!(found, HistoryFailure::Unconstrained), "{found}");
    let untested =
        body.history().coupled_sensitivities(|at, states, _| Ok(model(at)?.step(&states[0], &states[1])));
    let found = why(untested);
    assert!(matches!(found, HistoryFailure::RateOfUnknown { .. }), "{found}");
    let found = body.history().second_order(&m, &m).unwrap_err().why;
    assert!(matches!(found, HistoryFailure::Missing("second_sensitivities")), "{found}");
}

/// The whole Hessian along a direction, by starts and controls, of a criterion that reads both unknowns and of observations of the second one.
#[test]
fn the_remainder_with_the_hessian_has_order_three() {
    let body = Body::new();
    let u0 = Field::interpolate(&body.displacements, |x| [0.01 * x[0] * x[1], -0.02 * x[1]]).unwrap();
    let p0 = Field::interpolate(&body.pressures, |x| 0.1 * (1.0 - x[1])).unwrap();
    let controls = body.controls.clone().start("p0", &p0).start("u0", &u0);
    let pressures = Observations::new(&body.pressures).at_point(&[0.2, 0.1], &[0.3], 2.0).unwrap();
    let mut history = body
        .bare(controls.clone())
        .criterion(|at| Ok(model(at)?.criterion()))
        .observed(2, pressures)
        .coupled_second_sensitivities(|at, states| {
            let [u0, p0] = at.before_of_all()? else { unreachable!("two unknowns") };
            let ([u, p], [y, z]) = (states.u, states.p) else { unreachable!("two unknowns") };
            let ([du, dp], [du0, dp0]) = (states.du, states.dbefore) else { unreachable!("two unknowns") };
            let [dy, dz] = states.dp else { unreachable!("two unknowns") };
            let along = &states.along;
            let data = data(at)?
                .d_mu(&along.field("mu")?)
                .d_permeability(along.number("permeability")?)
                .d_load(along.number("load")?);
            let model = porous::Model::new(data);
            Ok(model.step_second_sensitivities(u, p, u0, p0, y, z, du, dp, du0, dp0, dy, dz))
        });
    let m = controls.values().to_vec();
    let directions = [1.3, 0.7]
        .map(|factor| (0..m.len()).map(|k| 0.3 * (factor * k as f64 + 0.2).cos()).collect::<Vec<f64>>());
    let [gradient, hessian] = second_order_taylor_test(&mut history, &m, &directions[0], 0.1).unwrap();
    println!("{gradient}{hessian}");
    assert!((gradient.second_order().unwrap() - 2.0).abs() < 0.05, "{gradient}");
    assert!((hessian.third_order().unwrap() - 3.0).abs() < 0.1, "{hessian}");
    let dot = |one: &[f64], other: &[f64]| one.iter().zip(other).map(|(one, other)| one * other).sum::<f64>();
    let [first, second] = directions.each_ref().map(|along| history.hessian(&m, along).unwrap());
    let (across, back) = (dot(&first.along, &directions[1]), dot(&second.along, &directions[0]));
    assert!((across - back).abs() < 1e-10 * across.abs(), "{across} {back}");
    let few = history.stored_states(2).hessian(&m, &directions[0]).unwrap();
    let largest = first.along.iter().fold(0.0_f64, |largest, entry| largest.max(entry.abs()));
    for (few, all) in few.along.iter().zip(&first.along) {
        assert!((few - all).abs() < 1e-11 * largest, "{few} {all}");
    }
}

//! Gradients of histories in which bodies slide on each other: pairs of the state of a step, and of the state before it, compared with
//! differences, with friction, materials and loads as controls; motions refuse such pairs.

use std::f64::consts::TAU;

use forms_contact::laws::two_bodies::data;
use forms_fem::inverse::{
    ControlError, ControlValues, Controls, LoadHistory, MotionHistory, Observations, ReducedProblem,
    taylor_test,
};
use forms_fem::prelude::*;
use forms_fem::time::OneStepTheta;

/// Large sliding with friction by Nitsche's method, with a criterion of bodies and contact.
#[forms(dimension = 2)]
mod drawn {
    pub use forms_contact::laws::sliding_bodies::{
        Data, GammaN, Omega, Touch, contact_pressure, direct, first_piola, loads,
    };
    use forms_contact::laws::two_bodies::slip_limit;
    use forms_contact::operators::friction::{augmented_traction, contact_traction};

    pub fn criterion(u: Unknown<Vector>) -> Energy {
        integral(Omega, dot(u, u) / 2 + dot(criterion_force, u))
            + integral(Touch(u), share * (sqr(contact_pressure(u)) / 500 + gap))
    }

    pub fn sensitivities(
        u: State<Vector>,
        p: State<Vector>,
        by_before: Test<Vector>,
        by_friction: Test<Scalar>,
        by_shear_modulus: Test<Scalar>,
        by_load: Test<Scalar>,
        pull: State<Vector>,
    ) -> Form {
        let work = direct(u, p);
        derivative(work, displacement_before, by_before)
            + derivative(work, friction, this(by_friction))
            + derivative(work + criterion(u), mu, by_shear_modulus)
            + derivative(work, traction, by_load * pull)
    }

    /// T on pairs of the state before: the gap and the slip since then are those of first order.
    fn lagged_traction(u: Vector, before: Vector) -> Vector {
        let moved = jump(u - before);
        let own = this(first_piola(u) * n);
        let P = augmented_traction(own, gap - dot(moved, toward), moved, this(gamma0) / this(h), toward);
        contact_traction(P, slip_limit(neg_part(dot(P, toward))), toward)
    }

    pub fn lagged(u: Unknown<Vector>, v: Test<Vector>, before: State<Vector>) -> Form {
        integral(Omega, inner(first_piola(u), grad(v)))
            - loads(v)
            - integral(Touch(before), share * dot(lagged_traction(u, before), jump(v)))
    }

    pub fn size(u: Unknown<Vector>) -> Energy {
        integral(Omega, dot(u, u) / 2 + dot(criterion_force, u))
    }

    pub fn lagged_rates(
        u: State<Vector>,
        before: State<Vector>,
        p: State<Vector>,
        by_before: Test<Vector>,
        by_friction: Test<Scalar>,
        by_shear_modulus: Test<Scalar>,
        by_load: Test<Scalar>,
        pull: State<Vector>,
    ) -> Form {
        let work = lagged(u, p, before);
        derivative(work, before, by_before)
            + derivative(work, friction, this(by_friction))
            + derivative(work, mu, by_shear_modulus)
            + derivative(work, traction, by_load * pull)
    }
}

const PULL: [f64; 2] = [1.0, -0.4];

/// A block that is pressed on a slab and drawn along it, over several of its facets.
struct Bodies {
    space: Arc<Space<2>>,
    materials: Arc<Space<2>>,
    assembler: Assembler<2>,
    pull: Field<2>,
    steps: usize,
}

impl Bodies {
    fn new(steps: usize) -> Self {
        let slab = rectangle([0.0; 2], [3.0, 0.6], [13, 3], CellShape::Quadrilateral, 1).unwrap();
        let block = rectangle([0.3, 0.62], [1.3, 1.22], [4, 3], CellShape::Quadrilateral, 1).unwrap();
        let mesh = Mesh::of_bodies(&[("slab", &slab), ("block", &block)]).unwrap();
        let space = Space::vector(&mesh, 1).unwrap();
        let materials = Space::discontinuous_scalar(&mesh, 0).unwrap();
        let pull = Field::interpolate(&space, |_| PULL).unwrap();
        let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(4));
        Bodies { space, materials, assembler, pull, steps }
    }

    /// The slab held, the block's top moved down and along.
    fn held(&self, step: usize) -> Constraints<2> {
        let along = 0.15 * (step + 1) as f64;
        let mut held = Constraints::new(&self.space);
        held.fix("slab bottom", |_| [0.0; 2]).unwrap();
        held.fix("block top", |_| [along, -0.07]).unwrap();
        held
    }

    fn controls(&self) -> Controls<2> {
        let loads: Vec<f64> = (1..=self.steps).map(|n| 0.3 * (TAU * n as f64 / 5.0).sin()).collect();
        let modulus = |x: &[f64; 2]| 10.0 + 2.0 * x[0].sin() * x[1];
        let modulus = Field::interpolate(&self.materials, modulus).unwrap();
        Controls::new().number("friction", 0.3).field("shear_modulus", &modulus).per_step("load", &loads)
    }

    fn model(
        &self,
        at: &ControlValues<2>,
        before: Given<[f64; 2], 2>,
    ) -> Result<drawn::Model<2>, ControlError> {
        let (friction, load) = (at.number("friction")?, at.number("load")?);
        Ok(self.model_of(friction, load, at.field("shear_modulus")?, before))
    }

    fn model_of(
        &self,
        friction: f64,
        load: f64,
        shear_modulus: Field<2>,
        before: Given<[f64; 2], 2>,
    ) -> drawn::Model<2> {
        let data = data()
            .lambda(15.0)
            .mu(shear_modulus)
            .gamma0(300.0)
            .friction(friction)
            .displacement_before(before)
            .traction(PULL.map(|pull| load * pull))
            .criterion_force(|x: &[f64; 2]| [0.3 + x[0], 0.5 * x[1]]);
        let touch = Pairing::between("slab top", "block bottom");
        drawn::Model { data, regions: drawn::Regions::default().touch(touch).gamma_n("block right") }
    }

    fn options() -> NewtonOptions {
        NewtonOptions {
            relative_tolerance: 1e-12,
            line_search: LineSearch::OnResidual,
            ..NewtonOptions::default()
        }
    }

    /// Pairs of the state of the step.
    fn history(&self) -> LoadHistory<'_, 2> {
        LoadHistory::new(&self.space, self.steps, self.controls())
            .step(|at| Ok(self.model(at, Given::field(at.before()?))?.direct()))
            .sensitivities(|at, u, p| {
                Ok(self.model(at, Given::field(at.before()?))?.sensitivities(u, p, &self.pull))
            })
            .criterion(|at| Ok(self.model(at, Given::constant([0.0; 2]))?.criterion()))
            .assembler(&self.assembler)
            .constrained_at(|step| Ok(self.held(step)))
            .options(Self::options())
    }

    /// Pairs of the state before the step.
    fn lagged(&self) -> LoadHistory<'_, 2> {
        let none = || Given::constant([0.0; 2]);
        LoadHistory::new(&self.space, self.steps, self.controls())
            .step(move |at| Ok(self.model(at, none())?.lagged(at.before()?)))
            .sensitivities(move |at, u, p| {
                Ok(self.model(at, none())?.lagged_rates(u, at.before()?, p, &self.pull))
            })
            .criterion(move |at| Ok(self.model(at, none())?.size()))
            .assembler(&self.assembler)
            .constrained_at(|step| Ok(self.held(step)))
            .options(Self::options())
    }
}

/// Order two, and differences of fourth order to 10⁻⁷; no point changes its state or its facet on the way.
fn check(label: &str, mut history: LoadHistory<'_, 2>) {
    let m = history.start();
    let found = history.gradient(&m).unwrap();
    let direction: Vec<f64> = (0..m.len()).map(|k| 0.1 * (1.0 + 1.7 * k as f64).sin()).collect();
    let slope: f64 = found.gradient.iter().zip(&direction).map(|(gradient, along)| gradient * along).sum();
    let report = taylor_test(&mut history, &m, &direction, 1e-3).unwrap();
    println!("{label}: {report}");
    let order = report.second_order().unwrap();
    assert!((order - 2.0).abs() < 0.02, "{label}: {report}");
    let step = report.steps.iter().filter(|step| step.same_active_set).nth(2).unwrap().step;
    let mut at = |t: f64| {
        let moved: Vec<f64> = m.iter().zip(&direction).map(|(m, along)| m + t * along).collect();
        history.sample(&moved).unwrap()
    };
    let switches = at(0.0).active_set;
    let samples = [step, -step, 2.0 * step, -2.0 * step].map(&mut at);
    assert!(samples.iter().all(|sample| sample.active_set == switches), "a point changes its state");
    let [above, below, far_above, far_below] = samples.map(|sample| sample.value[0]);
    let difference = (8.0 * (above - below) - (far_above - far_below)) / (12.0 * step);
    let error = (difference - slope).abs() / slope.abs();
    println!("{label}: {slope:.12e} and {difference:.12e} by differences: {error:.1e}");
    assert!(error < 1e-7, "{label}: {error:e}");
}

/// Over two facets of the slab; FORMS_SWEEPS=1: over five.
fn bodies() -> Bodies {
    Bodies::new(if std::env::var_os("FORMS_SWEEPS").is_some() { 8 } else { 4 })
}

#[test]
fn pairs_of_the_state_of_the_step() {
    let bodies = bodies();
    let m = bodies.history().start();
    let states = bodies.history().states(&m).unwrap();
    let touch = Pairing::between("slab top", "block bottom");
    let reports = states.iter().map(|u| bodies.assembler.pairs_at(&touch, 4, u).unwrap());
    assert!(reports.map(|report| report.deepest_overlap).all(|depth| depth > 1e-4), "they touch all the way");
    // Further along a point comes to another facet, where J has a kink.
    let along: Vec<f64> = m.iter().map(|m| m * 1.3).collect();
    let [here, there] = [&m, &along].map(|m| bodies.history().sample(m).unwrap().active_set);
    assert_ne!(here, there);
    check("own", bodies.history());
}

#[test]
fn pairs_of_the_state_before() {
    check("lagged", bodies().lagged());
}

/// Motions refuse displaced surfaces: their displacement is no weight times the unknown.
#[test]
fn motions_refuse_displaced_surfaces() {
    let bodies = bodies();
    let mut history = MotionHistory::new(
        &bodies.space,
        (bodies.steps, 0.1),
        OneStepTheta::implicit_euler(),
        bodies.controls(),
    )
    .motion(|during| {
        let (friction, load) = (during.number("friction")?, during.number("load")?);
        Ok(bodies
            .model_of(friction, load, during.field("shear_modulus")?, Given::constant([0.0; 2]))
            .direct())
    })
    .observed(1, Observations::new(&bodies.space).at_nodes(&Field::zero(&bodies.space), 1.0).unwrap());
    let m = history.start();
    let told = history.value(&m).unwrap_err().to_string();
    let expected = "step 0 of the history: `direct` has pairs of displaced surfaces";
    assert!(told.starts_with(expected), "{told}");
}

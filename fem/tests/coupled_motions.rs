//! Histories of motions of several unknowns: the states of coupled steps, gradients against differences, with rows and with tangents, Hessians by
//! Taylor tests of order three, explicit steps with lumped masses, unknowns that a form reads itself, what does not fit by name.

use forms_fem::inverse::{
    ControlError, Controls, HistoryFailure, MotionHistory, ReducedProblem, SecondOrderMotions, StepContext,
    second_order_taylor_test, taylor_test,
};
use forms_fem::prelude::*;
use forms_fem::time::{
    BackwardDifferences, CentralDifferences, GeneralisedAlpha, Mass, OneStepTheta, Scheme, State, Step,
    StepFailure, TimeLoop,
};

type Outcome = Result<(), Box<dyn std::error::Error>>;

/// A porous body with inertia, whose permeability depends on its strain.
#[forms(dimension = 2)]
mod porous {
    use forms_fem::time::operators::vector::{acceleration, displacement, velocity};
    use forms_fem::time::operators::vector_and_scalar::{rate, value};

    #[includes(forms_fem::time::operators::vector_and_scalar::Data)]
    pub struct Data {
        pub density: Param,
        pub mu: Given<Scalar>,
        pub permeability: Param,
        pub load: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Top;

    #[controls(mu, permeability, load, motion(u(value, rate, second_rate), p(value, rate)), order = 2)]
    pub fn balance(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        let w = displacement(u);
        integral(
            Omega,
            density * dot(acceleration(u), v) + 2 * mu * inner(eps(w), eps(v)) - value(p) * div(v),
        ) + integral(Omega, (div(velocity(u)) + 0.3 * rate(p)) * q)
            + integral(Omega, permeability * exp(3 * div(w)) * dot(grad(value(p)), grad(q)))
            + integral(Top, load * dot(n, v))
    }
    /// Without derivatives by what is known before the step, which are tangents then.
    pub fn sensitivities(
        u: State<Vector>,
        p: State<Scalar>,
        y: State<Vector>,
        z: State<Scalar>,
        by_mu: Test<Scalar>,
        by_permeability: Test<Scalar>,
        by_load: Test<Scalar>,
    ) -> Form {
        let work = balance(u, p, y, z);
        derivative(work, mu, by_mu)
            + derivative(work, permeability, by_permeability)
            + derivative(work, load, by_load)
    }
    /// With a source that reads the pressure itself.
    pub fn leaking(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        balance(u, p, v, q) + integral(Omega, (p + 5 * pow(p, 3)) * q)
    }
    pub fn misfit(u: Unknown<Vector>, p: Unknown<Scalar>) -> Energy {
        integral(Omega, dot(u, u) + 0.2 * pow(p, 4))
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

fn model(
    during: &StepContext<2>,
    states: Option<&SecondOrderMotions<2>>,
) -> Result<porous::Model<2>, ControlError> {
    let along = |name: &str| states.map_or(Ok(0.0), |states| states.along.number(name));
    let data = porous::data_from(during.steps::<2>()?)
        .density(0.4)
        .mu(&during.field("mu")?)
        .permeability(during.number("permeability")?)
        .load(during.number("load")?)
        .d_permeability(along("permeability")?)
        .d_load(along("load")?);
    Ok(porous::Model::new(match states {
        Some(states) => data.d_mu(&states.along.field("mu")?),
        None => data,
    }))
}

fn misfit() -> Energy<2> {
    let data = porous::data_from(forms_fem::time::operators::vector_and_scalar::Data::default());
    porous::Model::new(data.density(0.0).mu(0.0).permeability(0.0).load(0.0)).misfit()
}

impl Body {
    fn new() -> Result<Self, Box<dyn std::error::Error>> {
        let mesh = rectangle([0.0; 2], [0.5, 1.0], [2, 3], CellShape::Quadrilateral, 1)?;
        let (displacements, pressures) = (Space::vector(&mesh, 2)?, Space::scalar(&mesh, 1)?);
        let mut held = Constraints::new(&displacements);
        held.fix("bottom", |_| [0.0; 2])?;
        held.fix_component("left", 0, |_| 0.0)?;
        let mut drained = Constraints::new(&pressures);
        drained.fix("top", |_| 0.0)?;
        let cells = Space::discontinuous_scalar(&mesh, 0)?;
        let mu = Field::interpolate(&cells, |x| 1.0 + 0.5 * x[0] + 0.3 * x[1])?;
        let u0 = Field::interpolate(&displacements, |x| [0.01 * x[0] * x[1], -0.02 * x[1]])?;
        let v0 = Field::interpolate(&displacements, |x| [0.05 * x[0] * x[1], 0.1 * x[1]])?;
        let p0 = Field::interpolate(&pressures, |x| 0.1 * (1.0 - x[1]))?;
        let controls = Controls::new()
            .field("mu", &mu)
            .number("permeability", 0.7)
            .per_step("load", &[0.1, 0.2, 0.25, 0.2, 0.1])
            .start("p0", &p0)
            .start("u0", &u0)
            .start_rate("v0", &v0);
        Ok(Body { displacements, pressures, held, drained, controls })
    }

    /// Without sensitivities.
    fn bare(&self, scheme: impl Scheme + 'static) -> MotionHistory<'static, 2> {
        let spaces = [&self.displacements, &self.pressures];
        MotionHistory::new(spaces, (STEPS, 0.1), scheme, self.controls.clone())
            .motion(|during| Ok(model(during, None)?.balance()))
            .criterion(|_| Ok(misfit()))
            .constrained(&self.held)
            .constrained(&self.drained)
    }

    fn history(&self, scheme: impl Scheme + 'static) -> MotionHistory<'static, 2> {
        self.bare(scheme)
            .coupled_sensitivities(|during, unknowns, adjoints| {
                let ([u, p], [y, z]) = (unknowns, adjoints) else { unreachable!("two unknowns") };
                Ok(model(during, None)?.balance_sensitivities(u, p, y, z))
            })
            .coupled_second_sensitivities(|during, states| {
                let SecondOrderMotions { u: [u, p], p: [y, z], changes: [du, dp], dp: [dy, dz], .. } = states
                else {
                    unreachable!("two unknowns")
                };
                let model = model(during, Some(states))?;
                Ok(model
                    .balance_second_sensitivities(u, p, y, z, &du[0], &du[1], &du[2], &dp[0], &dp[1], dy, dz))
            })
    }

    /// With derivatives by what is known before the step from tangents.
    fn by_tangents(&self, scheme: impl Scheme + 'static) -> MotionHistory<'static, 2> {
        self.bare(scheme).coupled_sensitivities(|during, unknowns, adjoints| {
            let ([u, p], [y, z]) = (unknowns, adjoints) else { unreachable!("two unknowns") };
            Ok(model(during, None)?.sensitivities(u, p, y, z))
        })
    }
}

fn second_order() -> BackwardDifferences {
    BackwardDifferences::new(2).unwrap_or_else(|error| unreachable!("{error}"))
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest, value| largest.max(value.abs()))
}

/// The largest difference of a gradient from central differences along some controls, as a part of the largest entry.
fn off(
    history: &mut MotionHistory<'_, 2>,
    m: &[f64],
    places: &[usize],
) -> Result<f64, Box<dyn std::error::Error>> {
    let (_, gradient) = history.value_and_gradient(m)?;
    let mut worst = 0.0_f64;
    for &place in places {
        let mut at = |change: f64| {
            let mut moved = m.to_vec();
            moved[place] += change;
            history.value(&moved)
        };
        let difference = (8.0 * (at(1e-3)? - at(-1e-3)?) - (at(2e-3)? - at(-2e-3)?)) / 12e-3;
        worst = worst.max((difference - gradient[place]).abs());
    }
    Ok(worst / largest(&gradient))
}

/// A control of each kind: of the first and the last cell, the permeability, loads, pressures, displacements and velocities at the start.
fn some_places(controls: &Controls<2>) -> Result<Vec<usize>, ControlError> {
    let mut places = vec![];
    for name in ["mu", "permeability", "load", "p0", "u0", "v0"] {
        let own = controls.places(name)?;
        places.extend([own.start, own.start + own.len() / 2, own.end - 1]);
    }
    places.dedup();
    Ok(places)
}

/// The criterion of a history is that of the steps of a loop.
#[test]
fn states_are_those_of_coupled_steps() -> Outcome {
    let body = Body::new()?;
    let m = body.controls.values().to_vec();
    let (mu, loads) = (&m[..6], &m[7..7 + STEPS]);
    let cells = Space::discontinuous_scalar(body.displacements.mesh(), 0)?;
    let mu = Field::from_values(&cells, mu.to_vec())?;
    let field = |space: &Arc<Space<2>>, name: &str| -> Result<Field<2>, Box<dyn std::error::Error>> {
        Ok(Field::from_values(space, m[body.controls.places(name)?].to_vec())?)
    };
    let start = [
        State::new(0.0, field(&body.displacements, "u0")?, field(&body.displacements, "v0")?)?,
        State::at_rest(0.0, field(&body.pressures, "p0")?),
    ];
    let form = |steps: &[Step<2>; 2]| {
        let load = loads[((steps[0].end - 0.05) / 0.1) as usize];
        let data = porous::data_from(steps).density(0.4).mu(&mu).permeability(0.7).load(load);
        porous::Model::new(data).balance()
    };
    let (trapezoidal, euler) = (GeneralisedAlpha::trapezoidal(), OneStepTheta::implicit_euler());
    let mut steps = TimeLoop::coupled(form, trapezoidal, start)
        .scheme_of(1, euler)
        .constrained(&body.held)
        .constrained(&body.drained);
    let (assembler, mut sum) = (Assembler::new(body.displacements.mesh()), 0.0);
    for _ in 0..STEPS {
        steps.take(0.1)?;
        let [u, p] = steps.states() else { unreachable!("two unknowns") };
        sum += assembler.energy(&misfit(), &[&u.value, &p.value])?;
    }
    let mut history = body.history(GeneralisedAlpha::trapezoidal()).scheme_of(1, euler);
    let value = history.value(&m)?;
    assert!((value - sum).abs() < 1e-12 * sum, "{value:e} {sum:e}");
    Ok(())
}

fn motions(body: &Body) -> [(&'static str, MotionHistory<'static, 2>); 4] {
    let euler = OneStepTheta::implicit_euler();
    [
        ("BDF 2", body.history(second_order())),
        ("trapezoidal, Euler", body.history(GeneralisedAlpha::trapezoidal()).scheme_of(1, euler)),
        (
            "mid-point, Crank–Nicolson",
            body.history(GeneralisedAlpha::mid_point()).scheme_of(1, OneStepTheta::crank_nicolson()),
        ),
        ("trapezoidal, BDF 2", body.history(GeneralisedAlpha::trapezoidal()).scheme_of(1, second_order())),
    ]
}

#[test]
fn gradients_of_two_unknowns() -> Outcome {
    let body = Body::new()?;
    let (m, places) = (body.controls.values().to_vec(), some_places(&body.controls)?);
    for (name, mut history) in motions(&body) {
        let worst = off(&mut history, &m, &places)?;
        assert!(worst < 1e-8, "{name}: {worst:e}");
        let whole = history.gradient(&m)?;
        let few = history.stored_states(2).gradient(&m)?;
        let differences: Vec<f64> =
            few.gradient.iter().zip(&whole.gradient).map(|(few, whole)| few - whole).collect();
        assert!(few.work.steps_solved > STEPS && largest(&differences) < 1e-11 * largest(&whole.gradient));
    }
    Ok(())
}

/// Derivatives by what is known before a step, as rows of the sensitivities and as tangents.
#[test]
fn rows_and_tangents_give_one_gradient() -> Outcome {
    let body = Body::new()?;
    let m = body.controls.values().to_vec();
    let euler = OneStepTheta::implicit_euler();
    let pairs = [
        [body.history(second_order()), body.by_tangents(second_order())],
        [
            body.history(GeneralisedAlpha::trapezoidal()).scheme_of(1, euler),
            body.by_tangents(GeneralisedAlpha::trapezoidal()).scheme_of(1, euler),
        ],
    ];
    for [mut rows, mut tangents] in pairs {
        let (rows, tangents) = (rows.gradient(&m)?.gradient, tangents.gradient(&m)?.gradient);
        let differences: Vec<f64> = rows.iter().zip(&tangents).map(|(one, other)| one - other).collect();
        assert!(largest(&differences) < 1e-10 * largest(&rows), "{:e}", largest(&differences));
    }
    Ok(())
}

#[test]
fn the_remainder_with_the_hessian_has_order_three() -> Outcome {
    let body = Body::new()?;
    let m = body.controls.values().to_vec();
    let direction: Vec<f64> = (0..m.len()).map(|k| 0.3 * (1.3 * k as f64 + 0.2).cos()).collect();
    for (name, mut history) in motions(&body) {
        let [gradient, hessian] = second_order_taylor_test(&mut history, &m, &direction, 0.01)?;
        println!("{name}\n{gradient}{hessian}");
        assert!((gradient.second_order()? - 2.0).abs() < 0.05, "{name}: {gradient}");
        assert!((hessian.third_order()? - 3.0).abs() < 0.1, "{name}: {hessian}");
        let other: Vec<f64> = (0..m.len()).map(|k| 0.3 * (0.7 * k as f64).sin()).collect();
        let [first, second] = [&direction, &other].map(|along| history.hessian(&m, along));
        let dot =
            |one: &[f64], other: &[f64]| one.iter().zip(other).map(|(one, other)| one * other).sum::<f64>();
        let (across, back) = (dot(&first?.along, &other), dot(&second?.along, &direction));
        assert!((across - back).abs() < 1e-10 * across.abs(), "{name}: {across} {back}");
    }
    Ok(())
}

/// Two strings that pull at each other, in explicit steps.
#[forms(dimension = 2)]
mod strings {
    pub struct Data {
        pub value_weight: Param,
        pub second_rate_weight: Param,
        pub first: Given<Scalar>,
        pub first_acceleration: Given<Scalar>,
        pub second: Given<Scalar>,
        pub second_acceleration: Given<Scalar>,
        pub spring: Param,
        pub density: Param,
    }
    #[cells]
    pub struct Omega;

    pub fn motion(a: Unknown<Scalar>, b: Unknown<Scalar>, c: Test<Scalar>, d: Test<Scalar>) -> Form {
        let w = value_weight * a + first;
        let s = value_weight * b + second;
        let force = spring * (w - s + pow(w - s, 3));
        integral(Omega, density * (second_rate_weight * a + first_acceleration) * c + dot(grad(w), grad(c)))
            + integral(
                Omega,
                (second_rate_weight * b + second_acceleration) * d + 0.5 * dot(grad(s), grad(d)),
            )
            + integral(Omega, force * (c - d))
    }
    pub fn sensitivities(
        a: State<Scalar>,
        b: State<Scalar>,
        y: State<Scalar>,
        z: State<Scalar>,
        by_spring: Test<Scalar>,
        by_density: Test<Scalar>,
    ) -> Form {
        let work = motion(a, b, y, z);
        derivative(work, spring, by_spring) + derivative(work, density, by_density)
    }
}

#[forms(dimension = 2)]
mod squares {
    #[cells]
    pub struct Omega;

    pub fn misfit(a: Unknown<Scalar>, b: Unknown<Scalar>) -> Energy {
        integral(Omega, sqr(a) + 2 * sqr(b))
    }
}

#[test]
fn explicit_steps_with_both_masses() -> Outcome {
    let mesh = rectangle([0.0; 2], [1.0, 0.2], [6, 1], CellShape::Quadrilateral, 1)?;
    let [firsts, seconds] = [Space::scalar(&mesh, 1)?, Space::scalar(&mesh, 1)?];
    let mut ends = Constraints::new(&firsts);
    ends.fix("left", |_| 0.0)?;
    ends.fix("right", |_| 0.0)?;
    let start = Field::interpolate(&firsts, |x| 0.5 * (std::f64::consts::PI * x[0]).sin())?;
    let controls = Controls::new().number("spring", 2.0).number("density", 1.2).start("start", &start);
    let m = controls.values().to_vec();
    for mass in [Mass::Consistent, Mass::Lumped] {
        let model = |during: &StepContext<2>| -> Result<strings::Model<2>, ControlError> {
            let [first, second] = during.steps::<2>()?;
            let data = strings::data()
                .value_weight(first.weights[0])
                .second_rate_weight(first.weights[2])
                .first(&first.known[0])
                .first_acceleration(&first.known[2])
                .second(&second.known[0])
                .second_acceleration(&second.known[2]);
            let data = data.spring(during.number("spring")?).density(during.number("density")?);
            Ok(strings::Model::new(data))
        };
        let mut history =
            MotionHistory::new([&firsts, &seconds], (8, 0.03), CentralDifferences, controls.clone())
                .motion(move |during| Ok(model(during)?.motion()))
                .coupled_sensitivities(move |during, unknowns, adjoints| {
                    let ([a, b], [y, z]) = (unknowns, adjoints) else { unreachable!("two unknowns") };
                    Ok(model(during)?.sensitivities(a, b, y, z))
                })
                .criterion(|_| Ok(squares::Model::default().misfit()))
                .constrained(&ends)
                .constrained(&ends)
                .mass(mass);
        let worst = off(&mut history, &m, &[0, 1, 4, 7])?;
        assert!(worst < 1e-8, "{mass:?}: {worst:e}");
    }
    Ok(())
}

/// A pressure that is read itself, next to what the operators give.
#[test]
fn an_unknown_that_is_read_itself() -> Outcome {
    let body = Body::new()?;
    let (m, places) = (body.controls.values().to_vec(), some_places(&body.controls)?);
    let leaking = |scheme: GeneralisedAlpha, of_pressure: OneStepTheta| {
        body.by_tangents(scheme).scheme_of(1, of_pressure).motion(|during| Ok(model(during, None)?.leaking()))
    };
    let mut history = leaking(GeneralisedAlpha::mid_point(), OneStepTheta::crank_nicolson());
    let worst = off(&mut history, &m, &places)?;
    assert!(worst < 1e-8, "{worst:e}");
    let found = leaking(GeneralisedAlpha::trapezoidal(), OneStepTheta::implicit_euler()).gradient(&m);
    let Err(found) = found else { return Err("it was not refused".into()) };
    assert!(matches!(found.why, HistoryFailure::UnknownItself { unknown: "p", .. }), "{found}");
    Ok(())
}

#[test]
fn what_does_not_fit_is_named() -> Outcome {
    let body = Body::new()?;
    let m = body.controls.values().to_vec();
    let why = |mut history: MotionHistory<'_, 2>, m: &[f64]| match history.gradient(m) {
        Ok(_) => Err("it was not refused"),
        Err(error) => Ok(error.why),
    };
    let found = why(body.history(second_order()).scheme_of(2, second_order()), &m)?;
    let HistoryFailure::Step(found) = found else { return Err(found.into()) };
    assert!(matches!(*found, StepFailure::NoUnknown { unknown: 2, count: 2 }), "{found}");
    let found = why(body.history(second_order()).scheme_of(1, OneStepTheta::crank_nicolson()), &m)?;
    let HistoryFailure::Step(found) = found else { return Err(found.into()) };
    assert!(matches!(*found, StepFailure::Schemes { unknown: 1, .. }), "{found}");
    let three = body.history(second_order()).motion(|during| {
        during.steps::<3>()?;
        Ok(model(during, None)?.balance())
    });
    let found = why(three, &m)?;
    let expected = ControlError::StepsOfUnknowns { asked: 3, count: 2 };
    assert!(matches!(&found, HistoryFailure::Control(found) if *found == expected), "{found}");
    let controls = body.controls.clone().number("value_p", 0.0);
    let (spaces, longer) = ([&body.displacements, &body.pressures], controls.values().to_vec());
    let reserved = MotionHistory::new(spaces, (STEPS, 0.1), second_order(), controls)
        .motion(|during| Ok(model(during, None)?.balance()))
        .coupled_sensitivities(|during, unknowns, adjoints| {
            let ([u, p], [y, z]) = (unknowns, adjoints) else { unreachable!("two unknowns") };
            Ok(model(during, None)?.balance_sensitivities(u, p, y, z))
        })
        .criterion(|_| Ok(misfit()))
        .constrained(&body.held)
        .constrained(&body.drained);
    let found = why(reserved, &longer)?;
    let expected = ControlError::Reserved { name: "value_p".into() };
    assert!(matches!(&found, HistoryFailure::Control(found) if *found == expected), "{found}");
    // Pressures have no inertia, and the common scheme asks for their second rates.
    let found = why(body.history(GeneralisedAlpha::trapezoidal()), &m)?;
    assert!(found.to_string().contains("nothing determines `p`"), "{found}");
    let one = MotionHistory::new(&body.displacements, (STEPS, 0.1), second_order(), Controls::new())
        .motion(|during| Ok(model(during, None)?.balance()))
        .criterion(|_| Ok(misfit()));
    let found = why(one, &[])?;
    assert!(
        matches!(found, HistoryFailure::Control(ControlError::StepsOfUnknowns { count: 1, .. })),
        "{found}"
    );
    let single = body.history(second_order()).motion(|during| Ok(only(during).motion()));
    let found = why(single, &m)?;
    assert!(matches!(found, HistoryFailure::Unknowns { found: 1, expected: 2, .. }), "{found}");
    taylor_test(&mut body.history(second_order()), &m, &vec![0.1; m.len()], 0.1)?.second_order()?;
    Ok(())
}

#[forms(dimension = 2)]
mod still {
    #[includes(forms_fem::time::operators::vector::Data)]
    pub struct Data {}
    #[cells]
    pub struct Omega;

    pub fn motion(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, dot(u, v))
    }
}

fn only(during: &StepContext<2>) -> still::Model<2> {
    still::Model::new(still::data_from(during))
}

//! Criteria of histories with gradient and Hessian: a load history of one unknown, and the motion of a body that swings.

use std::error::Error;

use forms_fem::inverse::{
    ControlError, ControlValues, Controls, LoadHistory, MotionHistory, SecondOrderMotion, SecondOrderState,
    StepContext,
};
use forms_fem::prelude::*;
use forms_fem::time::{GeneralisedAlpha, Mass};

/// Steps of each history.
const STEPS: usize = 4;

/// A body that conducts better where it is hot.
#[forms(dimension = 2)]
pub mod creep {
    pub struct Data {
        /// Logarithm of the conductivity.
        pub conductivity: Param,
        /// Source \[1/time\].
        pub source: Param,
    }
    /// The body.
    #[cells]
    pub struct Omega;

    /// A step of size one.
    #[controls(conductivity, source, order = 2)]
    pub fn step(u: Unknown<Scalar>, v: Test<Scalar>, before: State<Scalar>) -> Form {
        let flow = exp(conductivity) * (1 + sqr(u)) * dot(grad(u), grad(v));
        integral(Omega, (u - before) * v + flow - source * (1 + x[0]) * v)
    }
    /// ∫ (u − x)²/2.
    pub fn misfit(u: Unknown<Scalar>) -> Energy {
        integral(Omega, sqr(u - x[0]) / 2)
    }
}

/// A damped body with hardening springs in it, pulled aside.
#[forms(dimension = 2)]
pub mod swinging {
    use forms_fem::time::operators::vector::{acceleration, displacement, velocity};

    #[includes(forms_fem::time::operators::vector::Data)]
    pub struct Data {
        /// Mass per volume.
        pub density: Param,
        /// Force per length of the right side.
        pub pull: Param,
    }
    /// The body.
    #[cells]
    pub struct Omega;
    /// The side that is pulled.
    #[facets]
    pub struct Right;

    /// Balance of forces.
    #[controls(density, pull, motion(value, rate, second_rate), order = 2)]
    pub fn motion(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let w = displacement(u);
        integral(Omega, density * dot(acceleration(u), v) + 0.3 * dot(velocity(u), v))
            + integral(Omega, inner(eps(w), eps(v)) + (0.5 + dot(w, w)) * dot(w, v))
            - integral(Right, pull * v[1])
    }
    /// ∫ u₂² + u₁².
    pub fn misfit(u: Unknown<Vector>) -> Energy {
        integral(Omega, dot(u, u))
    }
}

fn crept(at: &ControlValues<2>, along: Option<&ControlValues<2>>) -> Result<creep::Model<2>, ControlError> {
    let data = creep::data()
        .conductivity(at.number("conductivity")?)
        .source(at.number("source")?)
        .d_conductivity(along.map_or(Ok(0.0), |along| along.number("conductivity"))?)
        .d_source(along.map_or(Ok(0.0), |along| along.number("source"))?);
    Ok(creep::Model::new(data))
}

fn swung(
    during: &StepContext<2>,
    states: Option<&SecondOrderMotion<2>>,
) -> Result<swinging::Model<2>, ControlError> {
    let along = states.map(|states| states.along);
    let data = swinging::data_from(during)
        .density(during.number("density")?)
        .pull(during.number("pull")?)
        .d_density(along.map_or(Ok(0.0), |along| along.number("density"))?)
        .d_pull(along.map_or(Ok(0.0), |along| along.number("pull"))?);
    Ok(swinging::Model::new(data))
}

/// Upper corner and numbers of cells of the body.
pub const SIZE: ([f64; 2], [usize; 2]) = ([2.0, 1.0], [8, 4]);

/// A space with its conditions: zero at the left.
///
/// # Errors
/// Regions that do not exist.
pub fn held(name: &str) -> Result<Constraints<2>, Box<dyn Error>> {
    held_on(name, &rectangle([0.0; 2], SIZE.0, SIZE.1, CellShape::Quadrilateral, 1)?)
}

/// The same on this mesh, or a part of it.
///
/// # Errors
/// As [`held`].
pub fn held_on(name: &str, mesh: &Mesh<2>) -> Result<Constraints<2>, Box<dyn Error>> {
    match name {
        "creep" => {
            let mut held = Constraints::new(&Space::scalar(mesh, 2)?);
            held.fix("left", |_| 0.0)?;
            Ok(held)
        }
        "swing" | "lumped" => {
            let mut held = Constraints::new(&Space::vector(mesh, 1)?);
            held.fix("left", |_| [0.0; 2])?;
            Ok(held)
        }
        _ => Err(format!("no history is called {name}").into()),
    }
}

/// The load history, and its controls.
pub fn creeping<'a>(held: &Constraints<2>) -> (LoadHistory<'a, 2>, [f64; 2]) {
    let m = [-1.0, 0.8];
    let controls = Controls::new().number("conductivity", m[0]).number("source", m[1]);
    let history = LoadHistory::new(held.space(), STEPS, controls)
        .assembler(&Assembler::new(held.space().mesh()).with_threads(Threads::new(1)))
        .step(|at| Ok(crept(at, None)?.step(at.before()?)))
        .sensitivities(|at, u, p| Ok(crept(at, None)?.step_sensitivities(u, at.before()?, p)))
        .second_sensitivities(|at, states: &SecondOrderState<2>| {
            let &SecondOrderState { u, p, du, dbefore, dp, along } = states;
            Ok(crept(at, Some(&along))?.step_second_sensitivities(u, at.before()?, p, du, dbefore, dp))
        })
        .criterion(|at| Ok(crept(at, None)?.misfit()))
        .constrained(held);
    (history, m)
}

/// The motion by the trapezoidal rule, whose first acceleration is that of the form with a mass matrix.
///
/// # Errors
/// A criterion that does not fit.
pub fn swinging_motion<'a>(
    held: &Constraints<2>,
    mass: Mass,
) -> Result<(MotionHistory<'a, 2>, [f64; 2]), Box<dyn Error>> {
    let m = [1.3, 0.5];
    let controls = Controls::new().number("density", m[0]).number("pull", m[1]);
    let nothing = forms_fem::time::operators::vector::Data::default();
    let criterion = swinging::data_from(nothing).density(0.0).pull(0.0).d_density(0.0).d_pull(0.0);
    let criterion = swinging::Model::new(criterion);
    let history = MotionHistory::new(held.space(), (STEPS, 0.2), GeneralisedAlpha::trapezoidal(), controls)
        .assembler(&Assembler::new(held.space().mesh()).with_threads(Threads::new(1)))
        .mass(mass)
        .motion(|during| Ok(swung(during, None)?.motion()))
        .sensitivities(|during, u, p| Ok(swung(during, None)?.motion_sensitivities(u, p)))
        .second_sensitivities(|during, states| {
            let &SecondOrderMotion { u, p, changes: [dvalue, drate, dsecond], dp, .. } = states;
            Ok(swung(during, Some(states))?.motion_second_sensitivities(u, p, dvalue, drate, dsecond, dp))
        })
        .criterion(move |_| Ok(criterion.misfit()))
        .constrained(held);
    Ok((history, m))
}

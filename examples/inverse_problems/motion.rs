//! A body that swings, damped and with hardening springs in it: value and gradient of a motion in time, by one scheme after the other.

use std::error::Error;
use std::time::Instant;

use forms_fem::inverse::{ControlError, Controls, MotionHistory, ReducedProblem, StepContext};
use forms_fem::output::StandardOutput;
use forms_fem::prelude::*;
use forms_fem::time::{BackwardDifferences, CentralDifferences, GeneralisedAlpha, Mass, Scheme};

#[forms(dimension = 2)]
mod swinging {
    use forms_fem::time::operators::vector::{acceleration, displacement, velocity};

    #[includes(forms_fem::time::operators::vector::Data)]
    pub struct Data {
        pub density: Param,
        /// ln E, of each cell.
        pub stiffness: Given<Scalar>,
        /// Force per length, of each step.
        pub pull: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Right;

    #[controls(density, stiffness, pull, motion(value, rate, second_rate))]
    pub fn motion(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let w = displacement(u);
        let rate = velocity(u);
        integral(Omega, density * dot(acceleration(u) + (0.3 + dot(rate, rate)) * rate, v))
            + integral(Omega, exp(stiffness) * inner(eps(w), eps(v)) + (0.5 + dot(w, w)) * dot(w, v))
            - integral(Right, pull * v[1])
    }

    pub fn misfit(u: Unknown<Vector>) -> Energy {
        integral(Omega, pow(u[1] - 0.1 * x[0], 4) + sqr(u[0]))
    }
}

/// Times; the shortest counts.
const REPETITIONS: usize = 7;

fn model(during: &StepContext<2>) -> Result<swinging::Model<2>, ControlError> {
    Ok(swinging::Model::new(
        swinging::data_from(during)
            .density(during.number("density")?)
            .stiffness(&during.field("stiffness")?)
            .pull(during.number("pull")?),
    ))
}

/// Value and gradient by a scheme, on 120 × 36 squares for 120.
pub fn costs(cells: usize, steps: usize, out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let divisions = [cells, (3 * cells / 10).max(1)];
    let mesh = rectangle([0.0; 2], [1.0, 0.3], divisions, CellShape::Quadrilateral, 1)?;
    let space = Space::vector(&mesh, 1)?;
    let mut held = Constraints::new(&space);
    held.fix("left", |_| [0.0; 2])?;
    let stiffness = Field::interpolate(&Space::discontinuous_scalar(&mesh, 0)?, |x| 1.0 + x[0])?;
    let rate = Field::interpolate(&space, |x| [0.05 * x[0], 0.2 * x[0]])?;
    let pulls: Vec<f64> = (0..steps).map(|step| 0.4 + 0.1 * (step % 6) as f64).collect();
    let controls = Controls::new()
        .number("density", 1.3)
        .field("stiffness", &stiffness)
        .per_step("pull", &pulls)
        .start_rate("rate", &rate);
    let criterion = swinging::Model::new(
        swinging::data_from(forms_fem::time::operators::vector::Data::default())
            .density(0.0)
            .stiffness(0.0)
            .pull(0.0),
    );
    // Central differences: below 2/ω of the smallest cells.
    let (whole, explicit) = (0.15, 0.2 / cells as f64);
    let schemes: [(&str, Box<dyn Scheme>, Mass, f64); 4] = [
        ("trapezoidal", Box::new(GeneralisedAlpha::trapezoidal()), Mass::Consistent, whole),
        ("backward differences, order 2", Box::new(BackwardDifferences::new(2)?), Mass::Consistent, whole),
        ("central differences, consistent mass", Box::new(CentralDifferences), Mass::Consistent, explicit),
        ("central differences, lumped mass", Box::new(CentralDifferences), Mass::Lumped, explicit),
    ];
    out.line(format!("{} unknowns, {steps} steps", space.unknowns()));
    out.line("| scheme | seconds of a value | of value and gradient | times |\n| --- | --: | --: | --: |");
    for (name, scheme, mass, size) in schemes {
        let mut history = MotionHistory::new(&space, (steps, size), scheme, controls.clone())
            .mass(mass)
            .motion(|during| Ok(model(during)?.motion()))
            .sensitivities(|during, u, p| Ok(model(during)?.motion_sensitivities(u, p)))
            .criterion(|_| Ok(criterion.misfit()))
            .constrained(&held);
        let m = history.start();
        let mut shortest = [f64::INFINITY; 2];
        for _ in 0..REPETITIONS {
            let begun = Instant::now();
            history.value(&m)?;
            shortest[0] = shortest[0].min(begun.elapsed().as_secs_f64());
            let begun = Instant::now();
            history.value_and_gradient(&m)?;
            shortest[1] = shortest[1].min(begun.elapsed().as_secs_f64());
        }
        let [value, both] = shortest;
        out.line(format!("| {name} | {value:.4} | {both:.4} | {:.2} |", both / value));
    }
    Ok(())
}

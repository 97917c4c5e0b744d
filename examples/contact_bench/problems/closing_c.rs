//! A C that closes onto itself, with a mesh of its gap (Bluhm, Sigmund and Poulios 2021).

use forms_fem::output::Failure;
use forms_fem::prelude::*;

use crate::filled::{Filled, Step};
use crate::formulation::Formulation;
use crate::gradient::Gradient;
use crate::outcome::Refusal;
use crate::posed::Posed;
use crate::problem::Quantity;
use crate::rows::{Answer, Measured};

const MU: f64 = 5.0 / 14.0;
const LAMBDA: f64 = 5.0 / 3.0;
/// The way of the node in each step.
const WAY: f64 = 0.031;
const STEPS: usize = 20;

/// The force in each step, with that of felupe and NGSolve for cells of 1/10, which agree to 2e-11.
const FORCES: [(&str, f64); STEPS] = [
    ("F(1)", 1.33196155e-5),
    ("F(2)", 2.66139323e-5),
    ("F(3)", 3.99828558e-5),
    ("F(4)", 5.35325703e-5),
    ("F(5)", 6.73803462e-5),
    ("F(6)", 8.16621152e-5),
    ("F(7)", 9.65488546e-5),
    ("F(8)", 1.12288227e-4),
    ("F(9)", 1.29297618e-4),
    ("F(10)", 1.48316229e-4),
    ("F(11)", 1.70527732e-4),
    ("F(12)", 1.97207941e-4),
    ("F(13)", 2.28921018e-4),
    ("F(14)", 2.65918963e-4),
    ("F(15)", 3.08914658e-4),
    ("F(16)", 3.59247222e-4),
    ("F(17)", 4.18745528e-4),
    ("F(18)", 4.89670599e-4),
    ("F(19)", 5.75087835e-4),
    ("F(20)", 6.78987133e-4),
];

/// Steps whose derivatives are listed.
const DERIVATIVES: [(usize, &str, &str); 5] = [
    (1, "dF/dμ(1)", "d²F/dμ²(1)"),
    (5, "dF/dμ(5)", "d²F/dμ²(5)"),
    (10, "dF/dμ(10)", "d²F/dμ²(10)"),
    (15, "dF/dμ(15)", "d²F/dμ²(15)"),
    (20, "dF/dμ(20)", "d²F/dμ²(20)"),
];

/// A C in its box, with biquadratic cells of 1/10 or smaller.
pub struct ClosingC;

impl ClosingC {
    fn filled(level: usize, degree: usize) -> Result<Filled, Failure> {
        let cells = [11 << level, 5 << level];
        let mut mesh = rectangle([0.0; 2], [1.1, 0.5], cells, CellShape::Quadrilateral, 1)?;
        let is_medium = |x: &[f64; 2]| x[0] > 1.0 || (x[0] > 0.1 && (x[1] - 0.25).abs() < 0.15);
        mesh.name_cells("medium", is_medium)?;
        mesh.name_cells("body", |x| !is_medium(x))?;
        let space = Space::vector(&mesh, degree)?;
        let pressed = space.nearest_node(&[1.0, 0.5]).ok_or("a mesh without nodes")?;
        Ok(Filled {
            space,
            held: "left",
            pressed,
            component: 1,
            ways: (1..=STEPS).map(|step| -WAY * step as f64).collect(),
            lambda: LAMBDA,
            mu: MU,
            reference: [LAMBDA, MU],
            size: 1.0,
            options: NewtonOptions {
                prescribed_values: PrescribedValues::ByTangent,
                ..NewtonOptions::default()
            },
        })
    }

    /// dF/dμ of the last step by the adjoint, and by central differences of order 4 in μ, with the medium as it is.
    fn gradient(formulation: &dyn Formulation, filled: &Filled) -> Result<Gradient, Refusal> {
        let options = NewtonOptions { relative_tolerance: 1e-13, ..filled.options.clone() };
        let at = |part: f64| -> Result<Step, Refusal> {
            let moved = Filled { mu: MU * (1.0 + part), options: options.clone(), ..filled.clone() };
            formulation.close(&moved)?.pop().ok_or_else(|| Refusal::Failed("no step".to_owned()))
        };
        let part = 1e-4;
        let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(|count| at(count * part));
        let [a, b, c, d] = [a?.force, b?.force, c?.force, d?.force];
        let difference = -(a - 8.0 * b + 8.0 * c - d) / (12.0 * part * MU);
        Ok(Gradient { adjoint: -at(0.0)?.by_mu, difference })
    }
}

fn quantities(steps: &[Step], is_coarse: bool) -> Vec<Quantity> {
    let forces = FORCES.iter().zip(steps);
    let mut all: Vec<Quantity> = forces
        .map(|((name, exact), step)| Quantity {
            name,
            value: -step.force,
            exact: is_coarse.then_some(*exact),
        })
        .collect();
    for (step, once, twice) in DERIVATIVES {
        let Some(found) = steps.get(step - 1) else { continue };
        all.push(Quantity { name: once, value: -found.by_mu, exact: None });
        all.push(Quantity { name: twice, value: -found.by_mu_twice, exact: None });
    }
    let least = steps.iter().map(|step| step.least_volume).fold(f64::INFINITY, f64::min);
    all.push(Quantity { name: "least J", value: least, exact: None });
    all
}

impl Posed for ClosingC {
    fn name(&self) -> String {
        "closing_c".to_owned()
    }

    fn statement(&self) -> &'static str {
        "a C whose upper arm is pressed onto the lower one by a node in 20 steps, with a mesh of the gap; felupe and NGSolve, cells of 1/10"
    }

    fn answer(
        &self,
        formulation: &dyn Formulation,
        level: usize,
        degree: usize,
    ) -> Result<(usize, Answer), Failure> {
        let filled = Self::filled(level, degree)?;
        let measure = |steps: Vec<Step>, seconds| {
            let gradient = match level {
                0 => Self::gradient(formulation, &filled).map_err(|why| why.to_string()),
                _ => Err("first mesh".to_owned()),
            };
            Ok(Measured {
                seconds,
                no_gradient: gradient.clone().err(),
                gradient: gradient.ok(),
                quantities: quantities(&steps, level == 0),
                ..Measured::of_newton(steps.iter().map(|step| step.newton))
            })
        };
        let answer = Answer::timed(|| formulation.close(&filled), measure)?;
        Ok((filled.space.unknowns(), answer))
    }
}

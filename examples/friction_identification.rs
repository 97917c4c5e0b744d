//! Young's modulus and the coefficient of friction from slips: a block is pressed on a flat and pulled to and fro, and the displacements
//! of points on its lower side are "measured", on a finer mesh with another rule, with noise. Both numbers are found by the adjoint of
//! the history and L-BFGS, from several starts; examples/results.md has the results.
//!
//! `cargo run --release --bin friction_identification -- [NOISE IN PARTS OF THE LARGEST SLIP]`

use std::error::Error;
use std::f64::consts::TAU;
use std::process::ExitCode;

use forms_contact::forms;
use forms_contact::laws::frictional_nitsche as friction;
use forms_fem::inverse::{Bounds, Controls, LoadHistory, Minimise, Observations};
use forms_fem::output::{StandardOutput, program};
use forms_fem::prelude::*;

/// Coulomb's law by Nitsche's method, with the rates of a step by what is before it, by κ and by Young's modulus.
#[forms(dimension = 2)]
mod rubbed {
    pub use forms_contact::laws::frictional_nitsche::{GammaC, GammaN, Omega, direct};

    #[includes(forms_contact::laws::frictional_nitsche::Data)]
    pub struct Data {
        /// λ and μ of the true Young's modulus; the control is a multiple of it.
        pub true_lambda: Param,
        pub true_mu: Param,
    }

    pub fn sensitivities(
        u: State<Vector>,
        p: State<Vector>,
        by_before: Test<Vector>,
        by_friction: Test<Scalar>,
        by_young: Test<Scalar>,
    ) -> Form {
        let work = direct(u, p);
        derivative(work, displacement_before, by_before)
            + derivative(work, friction, by_friction)
            + derivative(work, lambda, by_young * true_lambda)
            + derivative(work, mu, by_young * true_mu)
    }
}

const YOUNG: f64 = 200.0;
const FRICTION: f64 = 0.3;
const POISSON: f64 = 0.3;
const LAMBDA: f64 = YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON));
const MU: f64 = 0.5 * YOUNG / (1.0 + POISSON);
const PULL: [f64; 2] = [1.0, -0.3];
const STEPS: usize = 24;

/// The block, held at its upper side.
struct Block {
    space: Arc<Space<2>>,
    assembler: Assembler<2>,
    held: Constraints<2>,
}

impl Block {
    fn new(cells: usize, degree: usize) -> Result<Self, Box<dyn Error>> {
        let mesh = rectangle([0.0; 2], [2.0, 1.0], [2 * cells, cells], CellShape::Quadrilateral, 1)?;
        let space = Space::vector(&mesh, 1)?;
        let mut held = Constraints::new(&space);
        held.fix_component("top", 1, |_| -0.01)?;
        held.fix_component("left", 0, |_| 0.0)?;
        let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(degree));
        Ok(Block { space, assembler, held })
    }

    fn model(&self, [young, coefficient]: [f64; 2], step: usize, before: &Field<2>) -> rubbed::Model<2> {
        let load = 1.5 * (2.0 * TAU * (step + 1) as f64 / STEPS as f64).sin();
        let base = forms::data()
            .lambda(young * LAMBDA)
            .mu(young * MU)
            .gamma0(20.0 * YOUNG)
            .obstacle_normal([0.0, -1.0])
            .gap(0.0)
            .theta(0.0)
            .traction(PULL.map(|pull| load * pull));
        let base = friction::data_from(base).friction(coefficient).displacement_before(before);
        let regions = rubbed::Regions::default().gamma_n("right").gamma_c("bottom");
        let data = rubbed::data_from(base).true_lambda(LAMBDA).true_mu(MU);
        rubbed::Model { data, regions }
    }

    /// The history from a first guess; Young's modulus is a multiple of the true one.
    fn history(&self, [young, coefficient]: [f64; 2]) -> LoadHistory<'_, 2> {
        let controls = Controls::new().number("young", young).number("friction", coefficient);
        LoadHistory::new(&self.space, STEPS, controls)
            .step(|at| {
                Ok(self
                    .model([at.number("young")?, at.number("friction")?], at.step(), at.before()?)
                    .direct())
            })
            .sensitivities(|at, u, p| {
                Ok(self
                    .model([at.number("young")?, at.number("friction")?], at.step(), at.before()?)
                    .sensitivities(u, p))
            })
            .assembler(&self.assembler)
            .constrained(&self.held)
            .options(NewtonOptions { line_search: LineSearch::OnResidual, ..NewtonOptions::default() })
    }
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let noise: f64 = std::env::args().nth(1).map_or(Ok(0.01), |part| part.parse())?;
    let points: Vec<[f64; 2]> = (1..=7).map(|k| [0.25 * f64::from(k), 0.0]).collect();

    let fine = Block::new(16, 6)?;
    let mut truth = fine.history([1.0, FRICTION]).observed(0, Observations::new(&fine.space));
    let states = truth.states(&[1.0, FRICTION])?;
    let measured = |state: &Field<2>| -> Result<Vec<Vec<f64>>, Box<dyn Error>> {
        points.iter().map(|point| Ok(state.evaluate(point)?)).collect()
    };
    let slips = states.iter().map(measured).collect::<Result<Vec<_>, _>>()?;
    let largest = slips.iter().flatten().map(|u| u[0].abs()).fold(0.0, f64::max);
    out.line(format!(
        "{STEPS} steps, {} points, largest slip {largest:.4}, noise {noise} of it",
        points.len()
    ));
    out.line("| start E, κ | found E | found κ | misfit at the start | at the end | gradients |\n| --- | --: | --: | --: | --: | --: |");

    let block = Block::new(8, 4)?;
    for start in [[0.5, 0.1], [2.0, 0.1], [0.5, 0.7], [2.0, 0.7]] {
        let mut history = block.history(start);
        let mut seed = 1_u32;
        for (step, slips) in slips.iter().enumerate() {
            let mut observed = Observations::new(&block.space);
            for (point, slip) in points.iter().zip(slips) {
                let noisy: Vec<f64> = slip
                    .iter()
                    .map(|u| {
                        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                        u + noise * largest * (f64::from(seed) / f64::from(u32::MAX) * 2.0 - 1.0)
                    })
                    .collect();
                observed = observed.at_point(point, &noisy, 1.0 / (largest * largest))?;
            }
            history = history.observed(step, observed);
        }
        let bounds = Bounds::each(vec![0.1, 0.01], vec![10.0, 1.0]);
        let minimise = Minimise { max_iterations: 60, tolerance: 1e-7, ..Minimise::default() };
        let found = minimise.run(&mut history, &bounds, |_| ())?;
        let (first, last) = (&found.history[0], &found.history[found.history.len() - 1]);
        out.line(format!(
            "| {:.0}, {} | {:.3} | {:.5} | {:.2e} | {:.3e} | {} |",
            start[0] * YOUNG,
            start[1],
            found.controls[0] * YOUNG,
            found.controls[1],
            first.value,
            found.value,
            last.evaluations
        ));
    }
    Ok(())
}

fn main() -> ExitCode {
    program(run)
}

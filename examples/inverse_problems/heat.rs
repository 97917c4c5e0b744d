//! A slab that conducts heat: the conductivity of each cell as a control.

use std::error::Error;
use std::time::Instant;

use forms_fem::inverse::{Bounds, Controls, LoadHistory, Minimise, Observations};
use forms_fem::output::StandardOutput;
use forms_fem::prelude::*;

use crate::Method;
use crate::measured::{HEADING, line};

#[forms(dimension = 3)]
mod conduction {
    pub struct Data {
        /// ρ, of each cell.
        pub density: Given<Scalar>,
        /// Conductivity where the density is zero.
        pub least: Param,
        /// q, into the slab \[power/area\].
        pub flux: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Right;

    fn conductivity() -> Scalar {
        least + (1 - least) * pow(density, 3)
    }

    #[controls(density)]
    pub fn balance(T: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, conductivity() * dot(grad(T), grad(v))) - integral(Right, flux * v)
    }

    /// ∫ q T.
    pub fn compliance(T: Unknown<Scalar>) -> Energy {
        integral(Right, flux * T)
    }
}

/// k_min, and the centres and the width of the two Gaussians that are to be found.
const LEAST: f64 = 1e-3;
const CENTRES: [[f64; 2]; 2] = [[0.6, 0.5], [1.4, 0.5]];
const WIDTH: f64 = 0.15;

/// [0, 2] × [0, 1] × [0, L_z], one layer of nx × nx/2 hexahedra.
struct Slab {
    temperatures: Arc<Space<3>>,
    densities: Arc<Space<3>>,
    held: Constraints<3>,
    flux: f64,
}

impl Slab {
    fn new(cells: usize) -> Result<Self, Box<dyn Error>> {
        let thickness = 2.0 / cells as f64;
        let divisions = [cells, (cells / 2).max(1), 1];
        let mesh = cuboid([0.0; 3], [2.0, 1.0, thickness], divisions, CellShape::Hexahedron, 1)?;
        let temperatures = Space::scalar(&mesh, 1)?;
        let mut held = Constraints::new(&temperatures);
        held.fix("left", |_| 0.0)?;
        let densities = Space::discontinuous_scalar(&mesh, 0)?;
        Ok(Slab { temperatures, densities, held, flux: 1.0 / thickness })
    }

    fn model(&self, density: Field<3>) -> conduction::Model<3> {
        let data = conduction::data().density(&density).least(LEAST).flux(self.flux);
        conduction::Model { data, regions: conduction::Regions::default() }
    }

    /// Temperatures as a function of this density.
    fn problem(&self, density: &Field<3>) -> LoadHistory<'_, 3> {
        let controls = Controls::new().field("density", density);
        LoadHistory::new(&self.temperatures, 1, controls)
            .step(|at| Ok(self.model(at.field("density")?).balance()))
            .sensitivities(|at, temperature, p| {
                Ok(self.model(at.field("density")?).balance_sensitivities(temperature, p))
            })
            .constrained(&self.held)
    }

    fn compliance(&self, density: &Field<3>) -> LoadHistory<'_, 3> {
        self.problem(density).criterion(|at| Ok(self.model(at.field("density")?).compliance()))
    }
}

/// The compliance with its gradient, on finer and finer meshes.
pub fn costs(cells: &[usize], method: Method, out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    out.line(HEADING);
    for &cells in cells {
        let slab = Slab::new(cells)?;
        let half = Field::interpolate(&slab.densities, |_| 0.5)?;
        let mut multigrid = MultigridSolver::new(&slab.held, MultigridSolverOptions::default())?;
        let mut direct = TangentSolver::new(TangentSolverOptions {
            // As for the structure: the factor's solution is checked, and not refined to the last bit.
            refinement_steps: 0,
            ..TangentSolverOptions::default()
        });
        let problem = slab.compliance(&half);
        let mut problem = match method {
            Method::Direct => problem.solver(&mut direct),
            Method::Multigrid => problem.solver(&mut multigrid),
        };
        let name = format!("{cells} × {}", cells / 2);
        line(&name, slab.temperatures.unknowns(), &mut problem, out)?;
    }
    Ok(())
}

/// The density from the temperatures at all nodes.
pub fn inversion(cells: usize, out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let slab = Slab::new(cells)?;
    let sought = Field::interpolate(&slab.densities, |x: &[f64; 3]| {
        let bumps = CENTRES.iter().map(|centre| {
            let square = (x[0] - centre[0]).powi(2) + (x[1] - centre[1]).powi(2);
            (-square / (2.0 * WIDTH * WIDTH)).exp()
        });
        bumps.sum::<f64>().clamp(LEAST, 1.0)
    })?;
    let measured = slab.compliance(&sought).states(sought.values())?.remove(0);
    let half = Field::interpolate(&slab.densities, |_| 0.5)?;
    let observations = Observations::new(&slab.temperatures).at_nodes(&measured, 1.0)?;
    let mut problem = slab.problem(&half).observed(0, observations);
    let bounds = Bounds::between(sought.values().len(), LEAST, 1.0);
    let begun = Instant::now();
    let minimise = Minimise { max_iterations: 200, tolerance: 1e-12, ..Minimise::default() };
    let mut told = vec![];
    let found = minimise.run(&mut problem, &bounds, |step| {
        if step.iteration % 25 == 0 {
            told.push(*step);
        }
    })?;
    let seconds = begun.elapsed().as_secs_f64();
    out.line("| iteration | misfit ‖T − T*‖² | evaluations |\n| --: | --: | --: |");
    for step in told {
        out.line(format!("| {} | {:.3e} | {} |", step.iteration, step.value, step.evaluations));
    }
    let norm = |values: &mut dyn Iterator<Item = f64>| values.map(|value| value * value).sum::<f64>().sqrt();
    let pairs = || found.controls.iter().zip(sought.values());
    let error =
        norm(&mut pairs().map(|(found, sought)| found - sought)) / norm(&mut sought.values().iter().copied());
    let controls = found.controls.len();
    out.line(format!(
        "{controls} controls, {:?} after {} iterations in {seconds:.2} s: misfit {:.3e}, relative error of the density {error:.3}",
        found.finish,
        found.history.len() - 1,
        found.value
    ));
    Ok(())
}

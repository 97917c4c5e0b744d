//! A cantilever of least compliance: Young's modulus of each cell by its density (SIMP).

use std::error::Error;
use std::time::Instant;

use forms_fem::inverse::{Bounds, Controls, LoadHistory, Minimise};
use forms_fem::output::StandardOutput;
use forms_fem::prelude::*;

use crate::Method;
use crate::measured::{HEADING, line};

#[forms(dimension = 3)]
mod solid {
    pub struct Data {
        /// ρ, of each cell.
        pub density: Given<Scalar>,
        /// E of nothing \[stress\].
        pub softest: Param,
        /// E of the material \[stress\].
        pub stiffest: Param,
        /// ν.
        pub poisson: Param,
        /// Force per area.
        pub traction: Given<Vector>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Right;

    fn stress(u: Vector) -> Tensor {
        let young = softest + (stiffest - softest) * pow(density, 3);
        young / (1 + poisson) * (eps(u) + poisson / (1 - 2 * poisson) * tr(eps(u)) * I)
    }

    #[controls(density)]
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v))) - integral(Right, dot(traction, v))
    }

    /// F·u.
    pub fn compliance(u: Unknown<Vector>) -> Energy {
        integral(Right, dot(traction, u))
    }
}

const STIFFEST: f64 = 70_000.0;
const SOFTEST: f64 = 70.0;
const POISSON: f64 = 0.3;
const LEAST: f64 = 1e-3;
/// Factor of (mean ρ − ½)².
const PENALTY: f64 = 50.0;

/// Cells of the benchmark's cases.
pub const DIVISIONS: [[usize; 3]; 3] = [[16, 2, 8], [16, 8, 8], [32, 8, 8]];

/// Place at the free end where the force of one acts.
#[derive(Clone, Copy)]
enum Load {
    /// Down, evenly.
    Even,
    /// Up, on the facet of one cell at the corner.
    Corner,
}

/// [0, 2] × [0, 1] × [0, 1], clamped at x = 0.
struct Cantilever {
    displacements: Arc<Space<3>>,
    densities: Arc<Space<3>>,
    held: Constraints<3>,
    facet: [f64; 2],
    load: Load,
}

impl Cantilever {
    fn new(divisions: [usize; 3], load: Load) -> Result<Self, Box<dyn Error>> {
        let mesh = cuboid([0.0; 3], [2.0, 1.0, 1.0], divisions, CellShape::Hexahedron, 1)?;
        let displacements = Space::vector(&mesh, 1)?;
        let mut held = Constraints::new(&displacements);
        held.fix("left", |_| [0.0; 3])?;
        let densities = Space::discontinuous_scalar(&mesh, 0)?;
        let facet = [1.0 / divisions[1] as f64, 1.0 / divisions[2] as f64];
        Ok(Cantilever { displacements, densities, held, facet, load })
    }

    fn model(&self, density: Field<3>) -> solid::Model<3> {
        let ([width, height], load) = (self.facet, self.load);
        let traction = Given::function(move |x: &[f64; 3]| match load {
            Load::Even => [0.0, 0.0, -1.0],
            Load::Corner if x[1] < width && x[2] < height => [0.0, 0.0, 1.0 / (width * height)],
            Load::Corner => [0.0; 3],
        });
        let density = Given::field(&density);
        let data = solid::data()
            .density(density)
            .softest(SOFTEST)
            .stiffest(STIFFEST)
            .poisson(POISSON)
            .traction(traction);
        solid::Model { data, regions: solid::Regions::default() }
    }

    /// F·u + 50 (mean ρ − ½)² from ρ = ½.
    fn problem(&self) -> Result<LoadHistory<'_, 3>, Box<dyn Error>> {
        let half = Field::interpolate(&self.densities, |_| 0.5)?;
        let controls = Controls::new().field("density", &half);
        Ok(LoadHistory::new(&self.displacements, 1, controls)
            .step(|at| Ok(self.model(at.field("density")?).balance()))
            .sensitivities(|at, u, p| Ok(self.model(at.field("density")?).balance_sensitivities(u, p)))
            .criterion(|at| Ok(self.model(at.field("density")?).compliance()))
            .with_cost_of_controls(|densities| {
                let count = densities.len() as f64;
                let excess = densities.iter().sum::<f64>() / count - 0.5;
                (PENALTY * excess * excess, vec![2.0 * PENALTY * excess / count; densities.len()])
            })
            .constrained(&self.held))
    }
}

/// Value and gradient on the meshes of the benchmark, and the density that minimises on the smallest.
pub fn costs(
    cases: &[usize],
    method: Method,
    iterations: usize,
    out: &mut StandardOutput,
) -> Result<(), Box<dyn Error>> {
    out.line(HEADING);
    for (load, name) in [(Load::Corner, "corner"), (Load::Even, "even")] {
        for &case in cases {
            let divisions = DIVISIONS[case];
            let cantilever = Cantilever::new(divisions, load)?;
            let mut multigrid = MultigridSolver::new(&cantilever.held, MultigridSolverOptions::default())?;
            let mut direct = TangentSolver::new(TangentSolverOptions {
                // As for the heat: the factor's solution is checked, and not refined to the last bit.
                refinement_steps: 0,
                ..TangentSolverOptions::default()
            });
            let problem = cantilever.problem()?;
            let mut problem = match method {
                Method::Direct => problem.solver(&mut direct),
                Method::Multigrid => problem.solver(&mut multigrid),
            };
            let [x, y, z] = divisions;
            let name = format!("{x} × {y} × {z}, {name}");
            line(&name, cantilever.displacements.unknowns(), &mut problem, out)?;
        }
    }
    if iterations == 0 {
        return Ok(());
    }
    let cantilever = Cantilever::new([16, 2, 8], Load::Even)?;
    let mut problem = cantilever.problem()?;
    let bounds = Bounds::between(cantilever.densities.unknowns(), LEAST, 1.0);
    let begun = Instant::now();
    let minimise = Minimise { max_iterations: iterations, ..Minimise::default() };
    let found = minimise.run(&mut problem, &bounds, |_| ())?;
    let mean = found.controls.iter().sum::<f64>() / found.controls.len() as f64;
    out.line(format!(
        "16 × 2 × 8, even: from {:.6e} to {:.6e} in {} iterations and {:.2} s ({:?}), mean density {mean:.4}",
        found.history[0].value,
        found.value,
        found.history.len() - 1,
        begun.elapsed().as_secs_f64(),
        found.finish
    ));
    Ok(())
}

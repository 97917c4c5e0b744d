//! A cantilever of least compliance in half of its area: densities of cells, smoothed by a filter that is a form (Lazarov and Sigmund
//! 2011, Int. J. Numer. Methods Eng. 86), and the method of moving asymptotes. It prints the numbers of examples/results.md and writes
//! pictures of the densities and of the compliance to `out`.
//!
//! `cargo run --release --bin topology -- [CELLS ALONG] [ITERATIONS]`; `bench/peers/topology_scipy.py` is the same in NumPy.

use std::error::Error;
use std::process::ExitCode;

use forms_examples::density_filter::{Filter, Filtered};
use forms_fem::inverse::{
    Bounds, Controls, HistoryError, Inequality, LoadHistory, MovingAsymptotes, ReducedProblem,
};
use forms_fem::output::picture::{Curve, FieldMap, LinePlot, Picture, Scale, Shown};
use forms_fem::output::{StandardOutput, program};
use forms_fem::prelude::*;

#[forms(dimension = 2)]
mod cantilever {
    pub struct Data {
        /// ρ̃, smooth.
        pub density: Given<Scalar>,
        /// Force per length on the end.
        pub traction: Given<Vector>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Right;

    /// Plane stress with ν = 0.3, E = 10⁻³ + (1 − 10⁻³) ρ̃³.
    fn stress(u: Vector) -> Tensor {
        let young = 0.001 + 0.999 * pow(density, 3);
        young / (1 - 0.3 * 0.3) * (0.7 * eps(u) + 0.3 * tr(eps(u)) * I)
    }
    #[controls(density)]
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v))) - integral(Right, dot(traction, v))
    }
    pub fn compliance(u: Unknown<Vector>) -> Energy {
        integral(Right, dot(traction, u))
    }
}

/// Half the height of the part of the end on which the force acts, and the filter's length.
const HALF_LOAD: f64 = 0.1;
const RADIUS: f64 = 0.02;
/// The part of the area that may be used.
const PART: f64 = 0.5;

fn model(density: Field<2>) -> cantilever::Model<2> {
    let pull = 1.0 / (2.0 * HALF_LOAD);
    let traction = Given::function(move |x: &[f64; 2]| match (x[1] - 0.5).abs() < HALF_LOAD {
        true => [0.0, -pull],
        false => [0.0; 2],
    });
    let data = cantilever::data().density(&density).traction(traction);
    cantilever::Model { data, regions: cantilever::Regions::default() }
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let counts: Vec<usize> = std::env::args().skip(1).map(|count| count.parse()).collect::<Result<_, _>>()?;
    let along = counts.first().copied().unwrap_or(120);
    let iterations = counts.get(1).copied().unwrap_or(200);

    let mesh = rectangle([0.0; 2], [2.0, 1.0], [along, along / 2], CellShape::Quadrilateral, 1)?;
    let (displacements, smooth) = (Space::vector(&mesh, 1)?, Space::scalar(&mesh, 1)?);
    let cells = Space::discontinuous_scalar(&mesh, 0)?;
    let mut held = Constraints::new(&displacements);
    held.fix("left", |_| [0.0; 2])?;
    // Two points in each direction, as is usual in this field.
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(3));
    let half = Field::interpolate(&smooth, |_| PART)?;
    let behind = LoadHistory::new(&displacements, 1, Controls::new().field("density", &half))
        .step(|at| Ok(model(at.field("density")?).balance()))
        .sensitivities(|at, u, p| Ok(model(at.field("density")?).balance_sensitivities(u, p)))
        .criterion(|at| Ok(model(at.field("density")?).compliance()))
        .assembler(&assembler)
        .constrained(&held);
    let filter = Filter { radius: RADIUS, region: "all" };
    let even = Field::interpolate(&cells, |_| PART)?;
    let mut problem = Filtered::new(behind, filter, &smooth, &even, &assembler)?;

    // All cells have one area: the mean of ρ is the part of the area that is used.
    let count = cells.unknowns();
    let volume: Box<Inequality<'_, HistoryError>> = Box::new(move |m| {
        let mean = m.iter().sum::<f64>() / count as f64;
        Ok((mean / PART - 1.0, vec![1.0 / (PART * count as f64); count]))
    });
    let start = problem.start();
    let (value, gradient) = problem.value_and_gradient(&start)?;
    let along_wave = Field::interpolate(&cells, |x| (7.0 * x[0] + 3.0 * x[1]).sin())?;
    let slope: f64 = gradient.iter().zip(along_wave.values()).map(|(slope, wave)| slope * wave).sum();
    out.line(format!(
        "{along} × {} cells; at ρ = ½ J = {value:.9}, slope along sin(7x + 3y) {slope:.9e}",
        along / 2
    ));
    out.line("| iteration | compliance | volume beside its bound | change |\n| --: | --: | --: | --: |");
    let method = MovingAsymptotes {
        max_iterations: iterations,
        move_limit: 0.2,
        tolerance: 1e-3,
        ..Default::default()
    };
    let found = method.run(&mut problem, &Bounds::between(count, 0.0, 1.0), &mut [volume], |step| {
        if [0, 1, 2, 5].contains(&step.iteration) || step.iteration % 25 == 0 {
            let (iteration, value, change) = (step.iteration, step.value, step.change);
            out.line(format!("| {iteration} | {value:.5} | {:+.1e} | {change:.1e} |", step.constraints[0]));
        }
    })?;
    let grey =
        found.controls.iter().map(|density| 4.0 * density * (1.0 - density)).sum::<f64>() / count as f64;
    out.line(format!(
        "{:?} after {} iterations: compliance {:.6}, volume beside its bound {:+.1e}, multiplier {:.4}, grey {grey:.4}",
        found.finish,
        found.history.len() - 1,
        found.value,
        found.constraints[0],
        found.multipliers[0]
    ));
    let smooth = problem.smoothed(&found.controls)?;
    FieldMap::of(&smooth, Shown::Component(0), "ρ̃")
        .range(0.0, 1.0)
        .without_mesh_lines()
        .size(420.0, 260.0)
        .title("A cantilever in half of its area")
        .write_png("out/topology.png")?;
    let (iterations, values): (Vec<f64>, Vec<f64>) =
        found.history.iter().map(|step| (step.iteration as f64, step.value)).unzip();
    LinePlot::new()
        .title("Compliance over iterations")
        .x_axis("iteration", Scale::Linear)
        .y_axis("J", Scale::Logarithmic)
        .grid()
        .curve(Curve::new("moving asymptotes", &iterations, &values).without_markers())
        .write_png("out/topology_compliance.png")?;
    out.line("pictures: out/topology.png, out/topology_compliance.png");
    Ok(())
}

fn main() -> ExitCode {
    program(run)
}

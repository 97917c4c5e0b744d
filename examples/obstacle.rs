//! A membrane on the unit disc over an obstacle, by bounds on its unknowns, compared with its closed form on finer and finer meshes.
//!
//! −Δu ≥ 0, u ≥ φ, u = 0 on the circle; φ = √(¼ − r²) up to r = 0.45, and its tangent cone beyond. Outside of the contact radius a
//! the solution is A ln r, so that the force on the obstacle is −2πA.
//!
//! Run it with `cargo run --release --bin obstacle -- [MESHES]`. Pictures are in `out/obstacle.png` and `out/obstacle_section.png`.

use std::error::Error;
use std::f64::consts::PI;
use std::process::ExitCode;

use forms_fem::output::picture::{Curve, FieldMap, LinePlot, Picture, Scale, Shown};
use forms_fem::output::{StandardOutput, program};
use forms_fem::prelude::*;
use forms_fem::solve::Solved;

#[forms(dimension = 2)]
mod membrane {
    #[cells]
    pub struct Omega;

    pub fn balance(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)))
    }
    pub fn energy(u: State<Scalar>) -> Functional {
        integral(Omega, dot(grad(u), grad(u)) / 2)
    }
    pub fn criterion(u: State<Scalar>) -> Functional {
        integral(Omega, u * u / 2 + u * u * u / 3)
    }
    /// Its residual at a held unknown is the derivative of the criterion with respect to the bound.
    pub fn adjoint(u: State<Scalar>, p: Unknown<Scalar>, q: Test<Scalar>) -> Form {
        derivative(balance(u, p), u, q) + derivative(criterion(u), u, q)
    }
    /// The same of functions of the radius x₀ only.
    pub fn radial_balance(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, x[0] * dot(grad(u), grad(v)))
    }
    pub fn radial_energy(u: State<Scalar>) -> Functional {
        integral(Omega, x[0] * dot(grad(u), grad(u)) / 2)
    }
    /// The area of each node.
    pub fn areas(v: Test<Scalar>) -> Form {
        integral(Omega, v)
    }
}

const CONTACT_RADIUS: f64 = 0.348_982_574_111_686;
const SLOPE: f64 = -0.340_129_705_945_858;
const ENERGY: f64 = 0.453_542_954_841;
const KINK: f64 = 0.45;

fn obstacle(r: f64) -> f64 {
    let top = |r: f64| (0.25 - r * r).sqrt();
    if r <= KINK { top(r) } else { top(KINK) - KINK / top(KINK) * (r - KINK) }
}

fn exact(r: f64) -> f64 {
    if r <= CONTACT_RADIUS { obstacle(r) } else { SLOPE * r.ln() }
}

fn exact_slope(x: &[f64; 2]) -> [f64; 2] {
    let r = x[0].hypot(x[1]);
    let part = if r <= CONTACT_RADIUS { -1.0 / (0.25 - r * r).sqrt() } else { SLOPE / (r * r) };
    [part * x[0], part * x[1]]
}

/// The contact radius that belongs to a force F = −2πA: φ′(a) = A/a.
fn radius_of(force: f64) -> f64 {
    let a = force / (2.0 * PI);
    // a² = −A √(¼ − a²), a quadratic equation for a².
    (0.5 * (-a * a + (a.powi(4) + a * a).sqrt())).sqrt()
}

struct Membrane {
    space: Arc<Space<2>>,
    held: Constraints<2>,
    below: Field<2>,
}

impl Membrane {
    fn new(cut: bool, core: usize, shape: CellShape, degree: usize) -> Result<Membrane, Box<dyn Error>> {
        let mesh = disc(1.0, [cut; 2], core, core, shape, degree.min(2))?;
        let space = Space::scalar(&mesh, degree)?;
        let mut held = Constraints::new(&space);
        held.fix("circle", |_| 0.0)?;
        let below = Field::interpolate(&space, |x| obstacle(x[0].hypot(x[1])))?;
        Ok(Membrane { space, held, below })
    }

    fn over(&self, below: &Field<2>) -> Result<Solved<2>, Box<dyn Error>> {
        let mut bounds = Bounds::new(&self.space);
        bounds.at_least_field(below)?;
        let form = membrane::Model::default().balance();
        let problem = Problem::new(&form, &self.space).constrained(&self.held);
        Ok(problem.bounded(&bounds).solve()?)
    }
}

/// Numbers of the whole disc, from a mesh of a quarter.
struct Row {
    unknowns: usize,
    steps: usize,
    gradient: f64,
    energy: f64,
    force: f64,
    /// The largest residual that no bound carries, as a part of the force.
    unbalanced: f64,
    least_reaction: f64,
}

fn row(core: usize, shape: CellShape, degree: usize) -> Result<Row, Box<dyn Error>> {
    let membrane = Membrane::new(true, core, shape, degree)?;
    let solved = membrane.over(&membrane.below)?;
    let assembler = Assembler::new(membrane.space.mesh()).with_quadrature(Quadrature::Degree(8));
    let norms = norms::errors(
        &assembler,
        solved.field(),
        |x, value| value[0] = exact(x[0].hypot(x[1])),
        |x, value| value.copy_from_slice(&exact_slope(x)),
    )?;
    let force = 4.0 * solved.held().iter().map(|one| one.reaction).sum::<f64>();
    let mut rest = solved.residual.clone();
    solved.held().iter().for_each(|one| rest[one.unknown] = 0.0);
    membrane.held.prescribed().keys().for_each(|unknown| rest[*unknown] = 0.0);
    Ok(Row {
        unknowns: membrane.space.unknowns(),
        steps: solved.iterations(),
        gradient: 2.0 * norms.seminorm,
        energy: 4.0 * assembler.functional(&membrane::Model::default().energy(solved.field()))?,
        force,
        unbalanced: rest.iter().fold(0.0, |most: f64, rest| most.max(rest.abs())) / force,
        least_reaction: solved.held().iter().map(|one| one.reaction).fold(f64::INFINITY, f64::min),
    })
}

fn table(
    out: &mut StandardOutput,
    name: &str,
    cores: &[usize],
    shape: CellShape,
    degree: usize,
) -> Result<(), Box<dyn Error>> {
    out.line(format!(
        "{name}, on a quarter of the disc\n\
         | unknowns | steps | error of ∇u | order | energy | order | force | order | contact radius | free rows | least reaction |\n\
         | --: | --: | --: | --: | --: | --: | --: | --: | --: | --: | --: |"
    ));
    let mut before: Option<[f64; 3]> = None;
    for core in cores {
        let row = row(*core, shape, degree)?;
        let errors = [row.gradient, (row.energy - ENERGY).abs(), (row.force + 2.0 * PI * SLOPE).abs()];
        let orders = [0, 1, 2].map(|k| match before {
            Some(before) => format!("{:.2}", (before[k] / errors[k]).log2()),
            None => String::new(),
        });
        out.line(format!(
            "| {} | {} | {:.4e} | {} | {:.9} | {} | {:.9} | {} | {:.7} | {:.0e} | {:.1e} |",
            row.unknowns,
            row.steps,
            row.gradient,
            orders[0],
            row.energy,
            orders[1],
            row.force,
            orders[2],
            radius_of(row.force),
            row.unbalanced,
            row.least_reaction
        ));
        before = Some(errors);
    }
    Ok(())
}

/// Energy and force by linear elements along a radius.
fn radial(out: &mut StandardOutput, counts: &[usize]) -> Result<(), Box<dyn Error>> {
    out.line(
        "Linear elements along a radius\n| cells | steps | energy | error | force | error | contact radius | error |\n\
         | --: | --: | --: | --: | --: | --: | --: | --: |",
    );
    for count in counts {
        let width = 1.0 / *count as f64;
        let mesh = rectangle([0.0; 2], [1.0, width], [*count, 1], CellShape::Quadrilateral, 1)?;
        let space = Space::scalar(&mesh, 1)?;
        let mut held = Constraints::new(&space);
        held.fix("right", |_| 0.0)?;
        let mut bounds = Bounds::new(&space);
        bounds.at_least("all", |x| obstacle(x[0]))?;
        let model = membrane::Model::default();
        let form = model.radial_balance();
        // The first set reaches thousands of layers beyond the contact.
        let options = NewtonOptions { max_iterations: 200, ..NewtonOptions::default() };
        let problem = Problem::new(&form, &space).constrained(&held).bounded(&bounds);
        let solved = problem.options(options).solve()?;
        let whole = 2.0 * PI / width;
        let force = whole * solved.held().iter().map(|one| one.reaction).sum::<f64>();
        let energy = whole * solved.functional(&model.radial_energy(solved.field()))?;
        let radius = radius_of(force);
        out.line(format!(
            "| {count} | {} | {energy:.12} | {:.1e} | {force:.12} | {:.1e} | {radius:.12} | {:.1e} |",
            solved.iterations(),
            (energy - ENERGY).abs(),
            (force + 2.0 * PI * SLOPE).abs(),
            (radius - CONTACT_RADIUS).abs()
        ));
    }
    Ok(())
}

/// The derivative of the criterion along a change of the obstacle, by the adjoint and by central differences.
fn derivative(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let (membrane, model) = (Membrane::new(true, 8, CellShape::Triangle, 1)?, membrane::Model::default());
    let solved = membrane.over(&membrane.below)?;
    let (adjoint, held) = (model.adjoint(solved.field()), solved.held_at_bounds()?);
    let state = Problem::new(&adjoint, &membrane.space).homogeneous(&held).solve()?;
    let moved = Field::interpolate(&membrane.space, |x| (3.0 * x[0] + x[1]).cos())?;
    let by_bound = |unknown: usize| state.residual[unknown] * moved.values()[unknown];
    let slope: f64 = solved.held().iter().map(|one| by_bound(one.unknown)).sum();
    let value = |size: f64| -> Result<f64, Box<dyn Error>> {
        let values = membrane.below.values().iter().zip(moved.values());
        let below = values.map(|(low, moved)| low + size * moved).collect();
        let solved = membrane.over(&Field::from_values(&membrane.space, below)?)?;
        Ok(solved.functional(&model.criterion(solved.field()))?)
    };
    let difference = (value(1e-4)? - value(-1e-4)?) / 2e-4;
    out.line(format!(
        "derivative of ∫ u²/2 + u³/3 along cos(3x + y) of the obstacle: {slope:.12} by the adjoint, {difference:.12} by differences \
         ({:.0e})",
        (slope / difference - 1.0).abs()
    ));
    Ok(())
}

fn pictures(core: usize) -> Result<(), Box<dyn Error>> {
    let membrane = Membrane::new(false, core, CellShape::Triangle, 1)?;
    let solved = membrane.over(&membrane.below)?;
    let areas = Assembler::new(membrane.space.mesh())
        .linear_form(&membrane::Model::default().areas(), &membrane.space)?;
    let mut pressure = vec![0.0; areas.len()];
    solved.held().iter().for_each(|one| pressure[one.unknown] = one.reaction / areas[one.unknown]);
    FieldMap::of(&Field::from_values(&membrane.space, pressure)?, Shown::Component(0), "force per area")
        .without_mesh_lines()
        .levels(20)
        .size(300.0, 270.0)
        .title("Reaction of the obstacle")
        .write_png("out/obstacle.png")?;
    let positions: Vec<f64> = (0..=200).map(|k| f64::from(k) / 200.0 - 1e-9).map(|r| r.max(0.0)).collect();
    let membrane_values: Vec<f64> = positions
        .iter()
        .map(|r| Ok(solved.field().evaluate(&[*r, 0.0])?[0]))
        .collect::<Result<_, Box<dyn Error>>>()?;
    let shown: Vec<f64> = positions.iter().copied().filter(|r| *r < 0.6).collect();
    let below: Vec<f64> = shown.iter().map(|r| obstacle(*r)).collect();
    LinePlot::new()
        .title("A membrane over an obstacle")
        .x_axis("distance from the centre", Scale::Linear)
        .y_axis("height", Scale::Linear)
        .grid()
        .curve(Curve::new("membrane", &positions, &membrane_values).without_markers())
        .curve(Curve::new("obstacle", &shown, &below).without_markers())
        .write_png("out/obstacle_section.png")?;
    Ok(())
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let meshes: u32 = std::env::args().nth(1).map_or(Ok(5), |count| count.parse())?;
    let cores: Vec<usize> = (0..meshes).map(|k| 4 << k).collect();
    table(out, "Linear triangles", &cores, CellShape::Triangle, 1)?;
    table(out, "Bilinear quadrilaterals", &cores, CellShape::Quadrilateral, 1)?;
    table(out, "Quadratic triangles", &cores[..cores.len().saturating_sub(1)], CellShape::Triangle, 2)?;
    radial(out, &[100, 1000, 10_000, 100_000])?;
    derivative(out)?;
    pictures(cores.last().copied().unwrap_or(4).min(16))?;
    out.line("pictures: out/obstacle.png, out/obstacle_section.png");
    Ok(())
}

fn main() -> ExitCode {
    program(run)
}

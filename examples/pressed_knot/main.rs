//! A trefoil knot that an STL file gives, pressed between two rigid plates without a mesh of it; the reaction is compared with a fitted mesh.
//! README.md has the problem and its results.
//!
//! `cargo run --release --bin pressed_knot -- [--cells N] [--fitted N] [--out DIRECTORY]`

mod knot;

use std::f64::consts::PI;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use clap::Parser;
use forms_contact::laws::cut_nitsche;
use forms_contact::{ContactProblem, forms};
use forms_examples::command_line::program_with_options;
use forms_examples::memory::peak_megabytes;
use forms_fem::cut::{Cut, InterfacePiece, signed_distance};
use forms_fem::mesh::RigidSurface;
use forms_fem::output::picture::{Panel, Picture, SurfaceMap};
use forms_fem::output::{Failure, StandardOutput, tell};
use forms_fem::prelude::*;
use forms_fem::shape_optimisation::level_set::measure_forms;
use forms_fem::solve::{MultigridSolver, MultigridSolverOptions};

/// λ and μ of E = 1000 and ν = 0.3.
const LAME: [f64; 2] = [1000.0 * 0.3 / (1.3 * 0.4), 1000.0 / 2.6];
/// The way by which the plates come closer.
const PRESSED: f64 = 0.1;
/// Heights of the surface above or below the middle that may touch.
const MAY_TOUCH: f64 = 0.6;

/// A knot of rubber between two plates
#[derive(Parser)]
#[command(version, name = "pressed_knot")]
struct Options {
    /// Cells of the background along a unit of length; the wire has a radius of 0.55
    #[arg(long, value_name = "N", default_value_t = 12.0)]
    cells: f64,
    /// Cells of the fitted mesh along the wire; none with 0
    #[arg(long, value_name = "N", default_value_t = 72)]
    fitted: usize,
    /// Directory of all results; created if it does not exist
    #[arg(long, value_name = "DIR", default_value = "out/pressed_knot")]
    out: PathBuf,
}

fn main() -> ExitCode {
    program_with_options(run)
}

/// The plates' distance from a point of the body, along the normal into the nearer plate.
fn gap(x: &[f64; 3]) -> f64 {
    knot::TOP - 0.5 * PRESSED - x[2].abs()
}

fn normal(x: &[f64; 3]) -> [f64; 3] {
    [0.0, 0.0, if x[2] > 0.0 { 1.0 } else { -1.0 }]
}

/// γ₀ for a degree.
fn gamma0(degree: usize) -> f64 {
    10.0 * (degree * degree) as f64 * (2.0 * LAME[1] + LAME[0])
}

/// The horizontal rigid motions, which plates without friction do not prevent: no force is needed for it.
fn hold(held: &mut Constraints<3>) -> Result<(), Failure> {
    let space = held.space().clone();
    let nearest = |place: [f64; 3]| {
        let off = |x: &[f64; 3]| (0..3).map(|k| (x[k] - place[k]).powi(2)).sum::<f64>();
        let nodes = space.positions().iter().enumerate();
        nodes.min_by(|a, b| off(a.1).total_cmp(&off(b.1))).map_or(0, |(node, _)| node)
    };
    let [outer, inner] = [0.0, PI].map(|t| nearest(knot::middle(t)));
    for (node, component) in [(outer, 0), (outer, 1), (inner, 1)] {
        held.fix_node(node, component, 0.0)?;
    }
    Ok(())
}

/// A knot on a background that knows nothing of it.
struct CutKnot {
    cut: Arc<Cut<3>>,
    u: Field<3>,
    /// Of each cell.
    pressures: Vec<f64>,
    /// On the plates, the lower one first.
    forces: [f64; 2],
}

fn solve_cut(
    surface: &RigidSurface<3>,
    options: &Options,
    out: &mut StandardOutput,
) -> Result<CutKnot, Failure> {
    let start = Instant::now();
    let counts = knot::EXTENT.map(|half| (2.0 * half * options.cells).round() as usize);
    let mut mesh = cuboid(knot::EXTENT.map(|half| -half), knot::EXTENT, counts, CellShape::Tetrahedron, 1)?;
    mesh.name_cells("lower", |x| x[2] < -MAY_TOUCH)?;
    mesh.name_cells("upper", |x| x[2] > MAY_TOUCH)?;
    mesh.name_cells("touching", |x| x[2].abs() > MAY_TOUCH)?;
    let phi = signed_distance(surface, &mesh)?;
    let distance_seconds = start.elapsed().as_secs_f64();
    let cut = Cut::by(&phi)?;
    let degree = Quadrature::Degree(4);
    let body = Assembler::new(&mesh).with_cut(&cut)?.with_quadrature(degree);
    let volume = body.functional(&form!(|| -> Functional { integral(cells("all"), 1) }))?;
    out.line(format!(
        "{} tetrahedra, {} inside, {} cut; signed distance in {distance_seconds:.1} s; volume {volume:.4} of {:.4}",
        mesh.cell_count(),
        cut.inside_cells().len(),
        cut.cut_cells().len(),
        surface.enclosed().unwrap_or(f64::NAN)
    ));
    let space = Space::vector(&mesh, 1)?;
    let mut held = Constraints::new(&space);
    hold(&mut held)?;
    cut.hold_outside(&mut held)?;
    let unknowns = (0..space.unknowns()).filter(|unknown| !held.is_prescribed(*unknown)).count();
    let data = cut_nitsche::data()
        .lambda(LAME[0])
        .mu(LAME[1])
        .gamma0(gamma0(1))
        .obstacle_normal(normal)
        .gap(gap)
        .theta(1.0);
    let law =
        cut_nitsche::Model { data, regions: cut_nitsche::regions().gamma_c("touching").gamma_n("boundary") };
    let problem = ContactProblem::new(&space, law, held).assembler(body.clone());
    // The wire is thin: multigrid takes less memory than a factor.
    let mut solver = MultigridSolver::new(&problem.constraints, MultigridSolverOptions::default())?;
    let progress =
        |step: &NewtonStep| tell(format!("step {}: residual {:.1e}", step.iteration, step.residual));
    let u = problem.direct()?.solver(&mut solver).each_step(progress).solve()?.into_field();
    let force = |region: &str| {
        let law = cut_nitsche::Model {
            data: problem.law.data.clone(),
            regions: cut_nitsche::regions().gamma_c(region).gamma_n("boundary"),
        };
        body.functional(&law.contact_force(&u))
    };
    let forces = [force("lower")?, force("upper")?];
    let constants = Space::discontinuous_scalar(&mesh, 0)?;
    let by_cell = body.linear_form(&problem.law.contact_forces(&u), &constants)?;
    let areas = body.linear_form(&measure_forms::Model::default().perimeter(), &constants)?;
    let mean = |cell: usize| {
        let node = constants.cell_nodes(cell)[0] as usize;
        if areas[node] > 0.0 { by_cell[node] / areas[node] } else { 0.0 }
    };
    let pressures = (0..mesh.cell_count()).map(mean).collect();
    out.line(row("cut", unknowns, forces, start));
    Ok(CutKnot { cut, u, pressures, forces })
}

fn row(name: &str, unknowns: usize, forces: [f64; 2], start: Instant) -> String {
    let memory = peak_megabytes().map_or_else(String::new, |peak| format!(", {peak:.0} MB at most"));
    let [lower, upper] = forces;
    let seconds = start.elapsed().as_secs_f64();
    format!("{name}: {unknowns} unknowns, forces {lower:.4} and {upper:.4}, {seconds:.1} s{memory}")
}

fn solve_fitted(along: usize, out: &mut StandardOutput) -> Result<[f64; 2], Failure> {
    let start = Instant::now();
    let mut mesh = knot::swept(along, 2)?;
    mesh.name_facets("lower", "boundary", |x| x[2] < -MAY_TOUCH)?;
    mesh.name_facets("upper", "boundary", |x| x[2] > MAY_TOUCH)?;
    mesh.name_facets("touching", "boundary", |x| x[2].abs() > MAY_TOUCH)?;
    mesh.name_facets("loaded", "boundary", |x| x[2].abs() < 0.2)?;
    let space = Space::vector(&mesh, 2)?;
    let mut held = Constraints::new(&space);
    hold(&mut held)?;
    let data = forms::data()
        .lambda(LAME[0])
        .mu(LAME[1])
        .gamma0(gamma0(2))
        .obstacle_normal(normal)
        .gap(gap)
        .theta(1.0);
    let regions = |region: &str| forms::Regions::default().gamma_n("loaded").gamma_c(region);
    let law = forms::Model { data, regions: regions("touching") };
    let problem = ContactProblem::new(&space, law, held);
    let u = problem.direct()?.solve()?.into_field();
    let force = |region: &str| {
        let law = forms::Model { data: problem.law.data.clone(), regions: regions(region) };
        problem.assembler.functional(&law.contact_force(&u))
    };
    let forces = [force("lower")?, force("upper")?];
    out.line(row(&format!("fitted, {along} along the wire"), space.unknowns(), forces, start));
    Ok(forces)
}

fn run(options: &Options, out: &mut StandardOutput) -> Result<(), Failure> {
    std::fs::create_dir_all(&options.out)?;
    let file = options.out.join("knot.stl");
    knot::write_stl(&file, 512, 64)?;
    let surface = RigidSurface::from_stl_file(&file)?;
    let found = solve_cut(&surface, options, out)?;
    let pieces = deformed(&found);
    let triangles: Vec<[[f64; 3]; 3]> = pieces.iter().map(|piece| piece.corners).collect();
    let view = |value: fn(&Piece) -> f64, label: &str, from: [f64; 3], title: &str| {
        let values: Vec<f64> = pieces.iter().map(value).collect();
        SurfaceMap::new(&triangles, &values, label).seen_from(from).title(title).size(260.0, 220.0).draw()
    };
    let panel = Panel::new(2)
        .picture(&view(|piece| piece.vertical, "vertical displacement", [0.5, -1.6, 1.3], "from above")?)?
        .picture(&view(|piece| piece.pressure, "contact pressure", [0.5, -1.6, -1.3], "from below")?)?;
    panel.write_png(options.out.join("pressed_knot.png"))?;
    if options.fitted > 0 {
        let fitted = solve_fitted(options.fitted, out)?;
        let ratio = found.forces[0] / fitted[0];
        out.line(format!("the reaction is {:.2} % off the fitted one", 100.0 * (ratio - 1.0)));
    }
    Ok(())
}

/// A piece of the deformed surface.
struct Piece {
    corners: [[f64; 3]; 3],
    vertical: f64,
    /// The mean of its cell.
    pressure: f64,
}

fn deformed(found: &CutKnot) -> Vec<Piece> {
    let piece = |InterfacePiece { cell, corners }: InterfacePiece<3>| {
        let cell = cell as usize;
        let moves = corners.map(|corner| found.u.evaluate_in(cell, &corner));
        let places = corners.map(|corner| found.cut.mesh().map(cell, &corner).0);
        let vertical = moves.iter().map(|u| u[2] / 3.0).sum();
        let corners = [0, 1, 2].map(|k| [0, 1, 2].map(|i| places[k][i] + moves[k][i]));
        Piece { corners, vertical, pressure: found.pressures[cell] }
    };
    found.cut.interface_pieces().into_iter().map(piece).collect()
}

//! The cylinder cut from rectangles: measurements on a background, and the picture of docs/cut_backgrounds.md.

use std::path::Path;
use std::time::Instant;

use forms_contact::hertz::{CutCylinder, CutMeasured, Hertz, RADIUS};
use forms_examples::memory::peak_megabytes;
use forms_fem::output::picture::{Curve, LinePlot, Marker, MeshDrawing, Panel, Picture, Scale};
use forms_fem::output::tell;
use forms_fem::prelude::*;
use forms_fem::shape_optimisation::level_set::measure_forms;

use crate::Outcome;
use crate::measurements::{Row, smallest};

/// Width and height of the part of the body that is drawn \[mm\].
const SEEN: [f64; 2] = [1.2, 0.85];
/// Width and height of each plot.
const SIZE: [f64; 2] = [250.0, 200.0];

/// Solves on a background, from the solution on the one before.
pub fn solve(problem: &CutCylinder, before: Option<&Field<2>>) -> Outcome<(Field<2>, Row)> {
    let start = Instant::now();
    let first = match before {
        Some(before) => before.onto(&problem.space).interpolated()?,
        None => Field::zero(&problem.space),
    };
    let solved = problem.direct()?.start(&first).solve()?;
    let (steps, u) = (solved.iterations(), solved.into_field());
    let seconds = start.elapsed().as_secs_f64();
    let measured = CutMeasured::of(problem, &u)?;
    let (hertz, mesh) = (Hertz::of_line(measured.force), problem.space.mesh());
    let row = Row {
        cells: mesh.cell_count(),
        unknowns: problem.space.unknowns(),
        force: measured.force,
        errors: [measured.reach / hertz.reach - 1.0, measured.middle / hertz.peak - 1.0],
        axis: None,
        recovered: None,
        profile: measured.profile,
        smallest: smallest(mesh),
        steps,
        iterations: None,
        seconds,
        memory: peak_megabytes(),
    };
    tell(format!("{row}"));
    Ok((u, row))
}

/// The body's cells where it touches, the pressure of each cell compared with Hertz's, and errors over unknowns.
pub fn draw(problem: &CutCylinder, u: &Field<2>, errors: LinePlot, file: &Path) -> Outcome<()> {
    let (body, mesh) = (&problem.assembler, problem.space.mesh());
    let cut = body.cut().ok_or("the cylinder is not cut")?;
    let pieces = cut.body()?;
    let cells = MeshDrawing::new(pieces.mesh())
        .title(&format!("Body, {} unknowns", problem.space.unknowns()))
        .length_unit("mm")
        .window([0.0, SEEN[0]], [-RADIUS - 0.02, -RADIUS + SEEN[1]])
        .size(SIZE[0], SIZE[1]);
    let constants = Space::discontinuous_scalar(mesh, 0)?;
    let forces = body.linear_form(&problem.law.contact_forces(u), &constants)?;
    let lengths = body.linear_form(&measure_forms::Model::default().perimeter(), &constants)?;
    let mut points: Vec<[f64; 2]> = vec![];
    for piece in cut.interface_pieces() {
        let cell = piece.cell as usize;
        let [one, other] = piece.corners.map(|corner| mesh.map(cell, &corner).0[0]);
        let node = constants.cell_nodes(cell)[0] as usize;
        points.push([0.5 * (one + other), forces[node] / lengths[node]]);
    }
    points.retain(|[x, _]| *x < SEEN[0]);
    points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let (x, pressures): (Vec<f64>, Vec<f64>) = points.into_iter().map(|[x, p]| (x, p)).unzip();
    let hertz = Hertz::of_line(CutMeasured::of(problem, u)?.force);
    let along: Vec<f64> = (0..=400).map(|k| f64::from(k) / 400.0 * SEEN[0]).collect();
    let exact: Vec<f64> = along.iter().map(|x| hertz.pressure(*x)).collect();
    let pressure = LinePlot::new()
        .title("Contact pressure")
        .x_axis("x [mm]", Scale::Linear)
        .y_axis("p [MPa]", Scale::Linear)
        .grid()
        .size(SIZE[0], SIZE[1])
        .curve(Curve::new("Hertz", &along, &exact).without_markers())
        .curve(Curve::new("mean of a cell", &x, &pressures).without_line().marker(Marker::Circle));
    let errors = errors.size(SIZE[0], SIZE[1]);
    Panel::new(3).picture(&cells)?.picture(&pressure)?.picture(&errors)?.write_png(file)?;
    Ok(())
}

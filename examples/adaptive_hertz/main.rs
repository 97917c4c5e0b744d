//! Hertz's contacts on meshes that follow the error compared with meshes refined everywhere: the table of docs/contact_in_space.md.
//!
//! `cargo run --release --bin adaptive_hertz -- cylinder`, `-- ball` or `-- cut-cylinder`; docs/cut_backgrounds.md has the table of the last.

mod cut_cylinder;
mod facets;
mod measurements;

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, ValueEnum};
use forms_contact::hertz::{
    Body, CONTACT, CYLINDER_PRESSED, CutCylinder, FREE, Hertz, QUARTER_PRESSED, RADIUS, background, body_on,
    cylinder_cut_from, cylinder_mesh, cylinder_on, estimate, estimate_on_cut, onto_body, quarter_mesh,
};
use forms_examples::command_line::program_with_options;
use forms_fem::adaptivity::{Adaptation, AdaptiveSolution, ErrorEstimate};
use forms_fem::output::StandardOutput;
use forms_fem::output::picture::{Curve, LinePlot, MeshDrawing, Picture, Scale};
use forms_fem::prelude::*;

use facets::facets_in_plane;
use measurements::{LinearMethod, Row, TOLERANCE, settled, solve};

/// Errors of writing files have no common type.
type Outcome<T> = Result<T, Box<dyn Error>>;

/// Cells each way of the first mesh.
const FIRST: usize = 4;
/// Width and height of the ball's pictures \[mm\]; the radius of contact is 0.65 mm.
const SEEN: f64 = 0.9;

/// The contact.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum Contact {
    /// A cylinder on a rigid flat, in the plane
    Cylinder,
    /// A ball on a rigid flat
    Ball,
    /// The cylinder, cut from a rectangle by a level set function
    CutCylinder,
}

/// Presses an elastic cylinder or ball onto a rigid flat, on adaptive meshes and on uniform ones, and compares with Hertz.
#[derive(Clone, Debug, Parser)]
#[command(version, name = "adaptive_hertz")]
struct Options {
    /// The contact
    contact: Contact,
    /// Unknowns at which the adaptive meshes end
    #[arg(long, value_name = "N", default_value_t = 12_000)]
    unknowns: usize,
    /// Most cells each way of the uniform meshes, which have 4, 8, 16 and so on; 64 in the plane and 8 in space where nothing is said
    #[arg(long, value_name = "N")]
    uniform: Option<usize>,
    /// The way of the body's top, over that by which a is an eighth or less of the body's width: a smaller contact is that of a
    /// larger body
    #[arg(long, value_name = "PART", default_value_t = 1.0)]
    way: f64,
    /// The method for Newton's linear systems
    #[arg(long, value_enum, default_value_t = LinearMethod::Condensed)]
    linear: LinearMethod,
    /// Marks cells by η_T²/r², too, r the distance from the point that touches first: for the pressure there
    #[arg(long)]
    near_axis: bool,
    /// Directory of the pictures; created if it does not exist
    #[arg(long, value_name = "DIR", default_value = "out/adaptive_hertz")]
    out: PathBuf,
}

impl Options {
    fn divisions(&self) -> impl Iterator<Item = usize> {
        let usual = if self.contact == Contact::Ball { 8 } else { 64 };
        let most = self.uniform.unwrap_or(usual);
        std::iter::successors(Some(FIRST), |n| Some(2 * n)).take_while(move |n| *n <= most)
    }
}

/// The rows of uniform meshes and of adaptive ones.
type Series = [Vec<Row>; 2];

/// The estimate by which cells are marked.
fn marked<const D: usize>(
    estimate: ErrorEstimate,
    mesh: &Mesh<D>,
    options: &Options,
) -> Outcome<ErrorEstimate> {
    if !options.near_axis {
        return Ok(estimate);
    }
    let weighted = |(cell, square): (usize, &f64)| {
        let mut from_apex = mesh.cell_centre(cell);
        from_apex[D - 1] += RADIUS;
        square / from_apex.iter().map(|x| x * x).sum::<f64>()
    };
    let squares: Vec<f64> = estimate.indicators().iter().enumerate().map(weighted).collect();
    Ok(estimate.marking_also_by(&ErrorEstimate::of_squares(&squares)?)?)
}

fn cylinder(options: &Options) -> Outcome<(Series, Mesh<2>)> {
    let way = options.way * CYLINDER_PRESSED;
    let (mut uniform, mut adaptive) = (vec![], vec![]);
    for divisions in options.divisions() {
        let problem = cylinder_on(&cylinder_mesh(divisions)?, FREE, way)?;
        uniform.push(solve(&problem, None, Hertz::of_line, options.linear)?.1);
    }
    let on_mesh = |mesh: &Mesh<2>, before: Option<&Field<2>>| -> Outcome<_> {
        let problem = cylinder_on(mesh, FREE, way)?;
        let (u, row) = solve(&problem, before, Hertz::of_line, options.linear)?;
        adaptive.push(row);
        let estimate = marked(estimate(&problem, &u)?, mesh, options)?;
        Ok(AdaptiveSolution::new(u, estimate))
    };
    let surfaces = onto_body::<2>();
    let cycle = Adaptation::to_unknowns(options.unknowns);
    let found = cycle.onto(&[("bottom", &surfaces)]).run(cylinder_mesh(FIRST)?, on_mesh, |_| ())?;
    Ok(([uniform, adaptive], found.mesh.mesh().clone()))
}

fn cut_cylinder(options: &Options) -> Outcome<(Series, CutCylinder, Field<2>)> {
    if options.linear == LinearMethod::Multigrid {
        return Err("cut-cylinder has a direct method: leave out --linear multigrid".into());
    }
    let way = options.way * CYLINDER_PRESSED;
    let (mut uniform, mut adaptive, mut last) = (vec![], vec![], None);
    for divisions in options.divisions() {
        uniform.push(cut_cylinder::solve(&cylinder_cut_from(&background(divisions)?, way)?, None)?.1);
    }
    let on_mesh = |mesh: &Mesh<2>, before: Option<&Field<2>>| -> Outcome<_> {
        let problem = cylinder_cut_from(mesh, way)?;
        let (u, row) = cut_cylinder::solve(&problem, before)?;
        adaptive.push(row);
        let estimate = marked(estimate_on_cut(&problem, &u)?, mesh, options)?;
        last = Some((problem, u.clone()));
        Ok(AdaptiveSolution::new(u, estimate))
    };
    Adaptation::to_unknowns(options.unknowns).run(background(FIRST)?, on_mesh, |_| ())?;
    let (problem, u) = last.ok_or("no mesh")?;
    Ok(([uniform, adaptive], problem, u))
}

fn ball(options: &Options) -> Outcome<(Series, Mesh<3>)> {
    let way = options.way * QUARTER_PRESSED;
    let (mut uniform, mut adaptive) = (vec![], vec![]);
    for divisions in options.divisions() {
        let mesh = quarter_mesh(Body::Ball, divisions)?;
        let problem = body_on(Body::Ball, &mesh, FREE, way)?;
        uniform.push(solve(&problem, None, Hertz::of_point, options.linear)?.1);
    }
    let on_mesh = |mesh: &Mesh<3>, before: Option<&Field<3>>| -> Outcome<_> {
        let problem = body_on(Body::Ball, mesh, FREE, way)?;
        let (u, row) = solve(&problem, before, Hertz::of_point, options.linear)?;
        adaptive.push(row);
        let estimate = marked(estimate(&problem, &u)?, mesh, options)?;
        Ok(AdaptiveSolution::new(u, estimate))
    };
    let surfaces = onto_body::<3>();
    let cycle = Adaptation::to_unknowns(options.unknowns);
    let first = quarter_mesh(Body::Ball, FIRST)?;
    let found = cycle.onto(&[("bottom", &surfaces)]).run(first, on_mesh, |_| ())?;
    Ok(([uniform, adaptive], found.mesh.mesh().clone()))
}

/// The unknowns of a uniform mesh whose cells are as small as the smallest of a mesh, by the adaptive meshes' first one, which is uniform.
fn as_uniform(contact: Contact, [first, row]: [&Row; 2]) -> f64 {
    // Uniform meshes of degree 2 have (2n + 1) nodes each way, and cells whose size is as 1/n.
    let dimension = if contact == Contact::Ball { 3 } else { 2 };
    let divisions = (FIRST as f64 * first.smallest / row.smallest).round();
    f64::from(dimension) * (2.0 * divisions + 1.0).powi(dimension)
}

fn run(options: &Options, out: &mut StandardOutput) -> Outcome<()> {
    // Before the long computation: its results can be written.
    std::fs::create_dir_all(&options.out)
        .map_err(|error| format!("the output directory {} cannot be used: {error}", options.out.display()))?;
    let mut cut = None;
    let (series, name) = match options.contact {
        Contact::Cylinder => {
            let (series, mesh) = cylinder(options)?;
            MeshDrawing::new(&mesh)
                .title(&format!("Cylinder, {} cells: where it touches", mesh.cell_count()))
                .window([0.0, 1.4], [-8.0, -7.0])
                .write_png(options.out.join("adaptive_hertz_mesh.png"))?;
            (series, "cylinder")
        }
        Contact::Ball => {
            let (series, mesh) = ball(options)?;
            for (region, [x, y], title, name) in [
                (CONTACT, [0, 1], "where it may touch, from below", "contact"),
                ("front", [0, 2], "the plane y = 0", "section"),
            ] {
                let seen = facets_in_plane(&mesh, region, [x, y])?;
                let lower = [0.0, if y == 2 { -RADIUS } else { 0.0 }];
                let drawing = MeshDrawing::new(&seen)
                    .title(&format!("Ball, {} cells: {title}", mesh.cell_count()))
                    .length_unit("mm")
                    .window([lower[0], lower[0] + SEEN], [lower[1], lower[1] + SEEN]);
                // The axes of a drawing are x and y.
                let drawing = if y == 2 { drawing.without_axes() } else { drawing };
                drawing.write_png(options.out.join(format!("adaptive_hertz_ball_{name}.png")))?;
            }
            (series, "ball")
        }
        Contact::CutCylinder => {
            let (series, problem, u) = cut_cylinder(options)?;
            cut = Some((problem, u));
            (series, "cut cylinder")
        }
    };
    out.line("| meshes | cells | unknowns | P | a | p0 | p0 on the axis | recovered | profile | smallest cell | Newton steps | iterations | s | MB so far | unknowns of a uniform mesh with such cells |");
    out.line(format!("|{}", " --- |".repeat(15)));
    let mut plot = LinePlot::new()
        .title(&format!("Hertz, {name}"))
        .x_axis("unknowns", Scale::Logarithmic)
        .y_axis("larger error of a and p0", Scale::Logarithmic)
        .grid()
        .size(360.0, 280.0);
    for (meshes, rows) in ["uniform", "adaptive"].into_iter().zip(&series) {
        for row in rows {
            let evenly = as_uniform(options.contact, [&series[1][0], row]);
            out.line(format!("| {meshes} | {row} | {evenly:.3e} |"));
        }
        let (x, y): (Vec<f64>, Vec<f64>) = rows.iter().map(|row| (row.unknowns as f64, row.larger())).unzip();
        plot = plot.curve(Curve::new(meshes, &x, &y));
    }
    out.line("");
    for (meshes, rows) in ["uniform", "adaptive"].into_iter().zip(&series) {
        let limit = 100.0 * TOLERANCE;
        out.line(match settled(rows) {
            Some(unknowns) => format!("{meshes}: a and p0 within {limit} % from {unknowns} unknowns on"),
            None => format!("{meshes}: a and p0 not within {limit} %"),
        });
    }
    match cut {
        Some((problem, u)) => {
            cut_cylinder::draw(&problem, &u, plot, &options.out.join("adaptive_hertz_cut.png"))
        }
        None => Ok(plot.write_png(options.out.join(format!("adaptive_hertz_{name}.png")))?),
    }
}

fn main() -> ExitCode {
    program_with_options(run)
}

//! A rounded rigid punch pressed into a block of rubber, with friction: in the plane by a polygon, in space by a surface of revolution that
//! is written as an STL file and read again. It prints force over depth, and draws the block in the plane.
//!
//! Run it with `cargo run --release --bin rigid_punch -- [CELLS ALONG THE BLOCK] [THE SAME IN SPACE] [STEPS]`.

use std::error::Error;
use std::f64::consts::PI;
use std::fmt::Write;
use std::process::ExitCode;

use forms_contact::ContactProblem;
use forms_contact::laws::sliding_bodies as law;
use forms_contact::laws::two_bodies::data;
use forms_fem::constraints::RigidMap;
use forms_fem::mesh::RigidSurface;
use forms_fem::output::picture::{Colour, Curve, FieldMap, LinePlot, Picture, Scale, Shown};
use forms_fem::output::{StandardOutput, program};
use forms_fem::prelude::*;

/// λ and μ \[MPa\].
const LAMBDA: f64 = 3.0;
const MU: f64 = 1.0;
const FRICTION: f64 = 0.3;
/// Depth of the punch \[mm\]; the block is 1 mm high.
const DEPTH: f64 = 0.25;
/// Half the width of the punch's flat, the radius of its edge, its height above the edge \[mm\].
const FLAT: f64 = 0.3;
const EDGE: f64 = 0.15;
const SHANK: f64 = 0.5;
/// Sides of a polygon around the edge.
const SIDES: usize = 12;

/// Half of the punch's outline, from the middle of its flat outward and up; it touches the block's top at the start.
fn profile() -> Vec<[f64; 2]> {
    let edge = (0..=SIDES).map(|k| {
        let angle = 0.5 * PI * k as f64 / SIDES as f64;
        [FLAT + EDGE * angle.sin(), 1.0 + EDGE * (1.0 - angle.cos())]
    });
    [[0.0, 1.0]].into_iter().chain(edge).chain([[FLAT + EDGE, 1.0 + EDGE + SHANK]]).collect()
}

/// The outline from left to right: its outward side is on the right of the way, below.
fn outline() -> Vec<[f64; 2]> {
    let right = profile();
    right[1..].iter().rev().map(|[x, y]| [-x, *y]).chain(right.iter().skip(1).copied()).collect()
}

/// The surface of revolution of the profile as the text of an STL file, open at the top.
fn revolved(parts: usize) -> Result<String, std::fmt::Error> {
    let mut file = "solid punch\n".to_owned();
    let at = |[r, z]: [f64; 2], k: usize| {
        let angle = 2.0 * PI * (k % parts) as f64 / parts as f64;
        [r * angle.cos(), r * angle.sin(), z]
    };
    let mut triangle = |corners: [[f64; 3]; 3]| -> std::fmt::Result {
        writeln!(file, "facet normal 0 0 0\nouter loop")?;
        for [x, y, z] in corners {
            writeln!(file, "vertex {x:e} {y:e} {z:e}")?;
        }
        writeln!(file, "endloop\nendfacet")
    };
    for pair in profile().windows(2) {
        for k in 0..parts {
            let [inner, outer] = [pair[0], pair[1]];
            triangle([at(inner, k), at(outer, k + 1), at(outer, k)])?;
            if inner[0] > 0.0 {
                triangle([at(inner, k), at(inner, k + 1), at(outer, k + 1)])?;
            }
        }
    }
    Ok(file + "endsolid punch\n")
}

/// A state with the force on the punch along its way.
struct Pressed<const D: usize> {
    u: Field<D>,
    depths: Vec<f64>,
    forces: Vec<f64>,
}

/// Presses the punch into a block whose planes of symmetry are named with the direction across them.
fn press<const D: usize>(
    out: &mut StandardOutput,
    block: &Mesh<D>,
    punch: &RigidSurface<D>,
    symmetric: &[(&str, usize)],
    steps: usize,
) -> Result<Pressed<D>, Box<dyn Error>>
where
    Dim: Dimension<D>,
{
    let mesh = block.with_rigid_surfaces(&[("punch", punch)])?;
    let space = Space::vector(&mesh, 1)?;
    out.line(format!("{D}D: {} facets of the punch, {} unknowns", punch.facets().len(), space.unknowns()));
    out.line("| depth [mm] | force | Newton steps |");
    out.line("| --: | --: | --: |");
    let (mut depths, mut forces) = (vec![0.0], vec![0.0]);
    let solve = |step: &Increment<'_, Field<D>>| -> Result<Field<D>, Box<dyn Error>> {
        let depth = step.factor;
        let mut constraints = Constraints::new(&space);
        constraints.fix("bottom", |_| [0.0; D])?;
        for (side, axis) in symmetric {
            constraints.fix_component(side, *axis, |_| 0.0)?;
        }
        let mut down = [0.0; D];
        down[D - 1] = -depth;
        constraints.move_rigidly("punch", &RigidMap::translation(down))?;
        let data = data()
            .lambda(LAMBDA)
            .mu(MU)
            .gamma0(40.0 * MU)
            .share(1.0)
            .friction(FRICTION)
            .displacement_before(step.before);
        let touch = Pairing::onto("top", "punch").within_reach(0.2);
        let regions = law::Regions::default().touch(touch).gamma_n("bottom");
        let problem = ContactProblem::new(&space, law::Model { data, regions }, constraints)
            .quadrature(Quadrature::Degree(4));
        let solved = problem.direct()?.increment(step).solve()?;
        let parts = f64::from(1_u32 << symmetric.len());
        let force = -parts * solved.reaction("punch")?[D - 1];
        out.line(format!("| {depth:.3} | {force:.5} | {} |", solved.iterations()));
        depths.push(depth);
        forces.push(force);
        Ok(solved.into_field())
    };
    let path = LoadSteps::uniform(steps, DEPTH).advance(Field::zero(&space), solve);
    let u = path.map_err(|error| error.to_string())?.state;
    Ok(Pressed { u, depths, forces })
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let counts: Vec<usize> = std::env::args().skip(1).map(|count| count.parse()).collect::<Result<_, _>>()?;
    let given = |place: usize, otherwise: usize| counts.get(place).copied().unwrap_or(otherwise).max(1);
    let [along, in_space, steps] = [given(0, 64), given(1, 12), given(2, 10)];

    let block = rectangle([-1.0, 0.0], [1.0, 1.0], [along, along.div_ceil(2)], CellShape::Quadrilateral, 1)?;
    let plane = press(out, &block, &RigidSurface::along(&outline())?, &[], steps)?;
    let pressed: Vec<[f64; 2]> = outline().iter().map(|[x, y]| [*x, y - DEPTH]).collect();
    FieldMap::of(&plane.u, Shown::Component(1), "displacement upward [mm]")
        .length_unit("mm")
        .deformed(&plane.u, 1.0)
        .line(&pressed, "punch", Colour::BLACK)
        .write_png("out/rigid_punch.png")?;

    std::fs::write("out/rigid_punch.stl", revolved(48)?)?;
    let punch = RigidSurface::from_stl_file("out/rigid_punch.stl")?;
    let cells = [in_space, in_space, in_space];
    let quarter = cuboid([0.0; 3], [1.0; 3], cells, CellShape::Hexahedron, 1)?;
    let solid = press(out, &quarter, &punch, &[("left", 0), ("front", 1)], steps)?;
    LinePlot::new()
        .x_axis("depth [mm]", Scale::Linear)
        .y_axis("force [N/mm in the plane, N in space]", Scale::Linear)
        .curve(Curve::new("plane", &plane.depths, &plane.forces))
        .curve(Curve::new("surface of revolution", &solid.depths, &solid.forces).dashed())
        .write_png("out/rigid_punch_forces.png")?;
    Ok(())
}

fn main() -> ExitCode {
    program(run)
}

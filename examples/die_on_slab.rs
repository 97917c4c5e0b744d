//! A rigid ball pressed into a slab of rubber and drawn along it with Coulomb's friction: large sliding in space. By symmetry the half
//! y > 0 is computed.
//!
//! Each step is refused unless the forces on die and base are one, and halved if points may have passed through the die.
//!
//! Run it with `cargo run --release --bin die_on_slab -- [CELLS ALONG THE SLAB] [STEPS OF PRESSING] [STEPS OF SLIDING]`. Frames for
//! ParaView are in `out/die_on_slab.pvd`.

use std::error::Error;
use std::f64::consts::PI;
use std::process::ExitCode;

use forms_contact::ContactProblem;
use forms_contact::laws::sliding_bodies as law;
use forms_examples::die_forces::{self, DieForces};
use forms_fem::constraints::RigidMap;
use forms_fem::mesh::RigidSurface;
use forms_fem::output::picture::{Colour, FieldMap, Picture, Shown};
use forms_fem::output::{StandardOutput, VtuFile, VtuSeries, program};
use forms_fem::prelude::*;

/// λ and μ \[MPa\].
const LAMBDA: f64 = 3.0;
const MU: f64 = 1.0;
const FRICTION: f64 = 0.3;
/// Length, half the width and height of the slab, the ball's radius and its place along the slab at the start \[mm\].
const LENGTH: f64 = 3.2;
const HALF_WIDTH: f64 = 0.8;
const HEIGHT: f64 = 0.6;
const RADIUS: f64 = 0.5;
const START: f64 = 0.9;
/// The way down, then along \[mm\].
const DOWN: f64 = 0.15;
const ALONG: f64 = 1.4;
/// Largest distance of opposite points \[mm\], and the degree of quadrature.
const REACH: f64 = 0.2;
const DEGREE: usize = 4;

/// A sphere that touches the slab's top.
fn die() -> Result<RigidSurface<3>, Box<dyn Error>> {
    let sphere = ball(RADIUS, [false; 3], 8, 1, CellShape::Hexahedron, 1)?;
    let surface = RigidSurface::of_boundary(&sphere, "sphere")?;
    let points = surface.points().iter().map(|[x, y, z]| [x + START, *y, z + HEIGHT + RADIUS]);
    Ok(RigidSurface::new(points.collect(), surface.facets().to_vec())?)
}

/// The die's displacement: it goes down until the way is [`DOWN`], then along.
fn motion(way: f64) -> [f64; 3] {
    [(way - DOWN).max(0.0), 0.0, -way.min(DOWN)]
}

fn problem(
    space: &Arc<Space<3>>,
    touch: &Pairing,
    before: &Field<3>,
    way: f64,
) -> Result<ContactProblem<3, law::Model<3>>, Box<dyn Error>> {
    let mut constraints = Constraints::new(space);
    constraints.fix("bottom", |_| [0.0; 3])?;
    constraints.fix_component("front", 1, |_| 0.0)?;
    constraints.move_rigidly("die", &RigidMap::translation(motion(way)))?;
    let data = law::data()
        .lambda(LAMBDA)
        .mu(MU)
        .gamma0(20.0 * MU)
        .share(1.0)
        .friction(FRICTION)
        .displacement_before(before);
    let regions = law::Regions::default().touch(touch.clone()).gamma_n("bottom");
    Ok(ContactProblem::new(space, law::Model { data, regions }, constraints)
        .quadrature(Quadrature::Degree(DEGREE)))
}

/// The plane of symmetry, deformed, with the die's outline.
fn draw(u: &Field<3>, along: usize, way: f64, path: &str) -> Result<(), Box<dyn Error>> {
    let cells = [along, along * 3 / 16];
    let section = rectangle([0.0; 2], [LENGTH, HEIGHT], cells, CellShape::Quadrilateral, 1)?;
    let space = Space::vector(&section, 1)?;
    let cut = space.positions().iter().map(|[x, z]| u.evaluate(&[*x, 0.0, *z]).map(|u| [u[0], u[2]]));
    let cut = Field::from_values(&space, cut.collect::<Result<Vec<_>, _>>()?.concat())?;
    let [right, _, up] = motion(way);
    let outline: Vec<[f64; 2]> = (0..=60)
        .map(|k| PI * (1.0 + f64::from(k) / 60.0))
        .map(|angle| [START + right + RADIUS * angle.cos(), HEIGHT + RADIUS + up + RADIUS * angle.sin()])
        .collect();
    FieldMap::of(&cut, Shown::Component(0), "displacement along [mm]")
        .length_unit("mm")
        .axes("x", "z")
        .title("The plane y = 0")
        .deformed(&cut, 1.0)
        .line(&outline, "rigid ball", Colour::BLACK)
        .write_png(path)?;
    Ok(())
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let counts: Vec<usize> = std::env::args().skip(1).map(|count| count.parse()).collect::<Result<_, _>>()?;
    let given = |place: usize, otherwise: usize| counts.get(place).copied().unwrap_or(otherwise).max(1);
    let [along, pressing, sliding] = [given(0, 32), given(1, 5), given(2, 28)];
    let cells = [along, along.div_ceil(4), (along * 3).div_ceil(16)];
    let slab = cuboid([0.0; 3], [LENGTH, HALF_WIDTH, HEIGHT], cells, CellShape::Hexahedron, 1)?;
    let mesh = slab.with_rigid_surfaces(&[("die", &die()?)])?;
    let space = Space::vector(&mesh, 1)?;
    let touch = Pairing::onto("top", "die").within_reach(REACH);
    out.line(format!("{} unknowns", space.unknowns()));
    out.line(die_forces::HEADING);

    let start = Field::zero(&space);
    let mut frames = VtuSeries::new("out/die_on_slab.pvd")?;
    frames.write(0.0, &VtuFile::new(&mesh).point_data("displacement", &start)?)?;
    let mut forces = vec![DieForces::default()];
    let solve = |step: &Increment<'_, Field<3>>| -> Result<Field<3>, Box<dyn Error>> {
        let way = step.factor;
        let problem = problem(&space, &touch, step.before, way)?;
        let mut iterations = 0;
        let count = |newton: &NewtonStep| iterations += usize::from(newton.iteration > 0);
        let solved = problem.direct()?.increment(step).each_step(count).solve()?;
        let [held, base] = [solved.reaction("die")?, solved.reaction("bottom")?];
        let unbalanced = die_forces::unbalanced(&held, &base)?;
        let forces_here = DieForces { way, down: -2.0 * held[2], along: 2.0 * held[0] };
        out.line(forces_here.row(unbalanced, iterations));
        frames.write(way, &VtuFile::new(&mesh).point_data("displacement", solved.field())?)?;
        forces.push(forces_here);
        Ok(solved.into_field())
    };
    let ways = die_forces::ways((DOWN, pressing), (ALONG, sliding));
    let path = LoadSteps::through(ways).advance(start, solve).map_err(|error| error.to_string())?;

    draw(&path.state, along, DOWN + ALONG, "out/die_on_slab.png")?;
    die_forces::draw(
        &forces,
        "way of the ball: down to 0.15 mm, then along [mm]",
        "out/die_on_slab_forces.png",
    )?;
    Ok(())
}

fn main() -> ExitCode {
    program(run)
}

//! A thin elastic half-pipe, a thousand times as stiff as the slab below it, pressed into the slab and drawn along it with Coulomb's
//! friction: large sliding of two deformable bodies in space (the measures of Puso and Laursen 2004). By symmetry the half y > 0 is
//! computed.
//!
//! Each step is refused unless the forces on die and slab are one, and halved if points may have passed through the die.
//!
//! Run it with `cargo run --release --bin elastic_die -- [CELLS ALONG THE SLAB] [STEPS OF PRESSING] [STEPS OF SLIDING]`. Frames for
//! ParaView are in `out/elastic_die.pvd`.

use std::error::Error;
use std::f64::consts::PI;
use std::process::ExitCode;

use forms_contact::ContactProblem;
use forms_contact::laws::sliding_bodies as law;
use forms_examples::die_forces::{self, DieForces};
use forms_fem::mesh::structured;
use forms_fem::output::picture::{FieldMap, Picture, Shown};
use forms_fem::output::{StandardOutput, VtuFile, VtuSeries, program};
use forms_fem::prelude::*;

/// Young's modulus of slab and die \[MPa\], and Poisson's ratio of both.
const YOUNG: [f64; 2] = [1.0, 1000.0];
const POISSON: f64 = 0.3;
const FRICTION: f64 = 0.3;
/// γ₀ of Nitsche's method, in units of the slab's modulus.
const GAMMA0: f64 = 20.0;
/// Length, half the width and height of the slab \[mm\].
const LENGTH: f64 = 9.0;
const HALF_WIDTH: f64 = 2.0;
const HEIGHT: f64 = 3.0;
/// Outer radius, half the width and thickness of the die, and its place along the slab at the start \[mm\].
const RADIUS: f64 = 3.0;
const HALF_DIE: f64 = 2.6;
const THICKNESS: f64 = 0.2;
const START: f64 = 2.5;
/// The way down, then along \[mm\].
const DOWN: f64 = 1.4;
const ALONG: f64 = 4.0;
/// The reach of contact points \[mm\], and the degree of quadrature.
const REACH: f64 = 0.6;
const DEGREE: usize = 4;

/// A point of the die's section by its angle from the lowest one and its distance from the axis.
fn of_die(angle: f64, distance: f64) -> [f64; 2] {
    [START + distance * angle.sin(), HEIGHT + RADIUS - distance * angle.cos()]
}

/// The slab, and the lower half of a pipe that touches its top.
fn bodies(along: usize) -> Result<Mesh<3>, Box<dyn Error>> {
    let cells = [along, along.div_ceil(4), along.div_ceil(3)];
    let slab = cuboid([0.0; 3], [LENGTH, HALF_WIDTH, HEIGHT], cells, CellShape::Hexahedron, 2)?;
    let die = structured([along, along.div_ceil(3), 1], CellShape::Hexahedron, 2, |[s, t, r]| {
        let [x, z] = of_die(PI * (s - 0.5), RADIUS - THICKNESS * r);
        [x, HALF_DIE * t, z]
    })?;
    Ok(Mesh::of_bodies(&[("slab", &slab), ("die", &die)])?)
}

/// The displacement of the die's upper edges: down until the way is [`DOWN`], then along.
fn motion(way: f64) -> [f64; 3] {
    [(way - DOWN).max(0.0), 0.0, -way.min(DOWN)]
}

fn problem(
    space: &Arc<Space<3>>,
    young: &Field<3>,
    before: &Field<3>,
    way: f64,
) -> Result<ContactProblem<3, law::Model<3>>, Box<dyn Error>> {
    let mut constraints = Constraints::new(space);
    constraints.fix("slab bottom", |_| [0.0; 3])?;
    for edge in ["die left", "die right"] {
        constraints.fix(edge, |_| motion(way))?;
    }
    for body in ["slab front", "die front"] {
        constraints.fix_component(body, 1, |_| 0.0)?;
    }
    let times = |factor: f64| -> Result<Given<f64, 3>, Box<dyn Error>> {
        let values = young.values().iter().map(|young| factor * young).collect();
        Ok(Given::field(&Field::from_values(young.space(), values)?))
    };
    let data = law::data()
        .lambda(times(POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON)))?)
        .mu(times(0.5 / (1.0 + POISSON))?)
        .gamma0(GAMMA0 * YOUNG[0])
        .share(1.0)
        .friction(FRICTION)
        .displacement_before(before);
    // The softer body's surface is the one that is integrated over.
    let touch = Pairing::onto("slab top", "die bottom").within_reach(REACH);
    let regions = law::Regions::default().touch(touch).gamma_n("slab bottom");
    Ok(ContactProblem::new(space, law::Model { data, regions }, constraints)
        .quadrature(Quadrature::Degree(DEGREE)))
}

/// The plane of symmetry, deformed.
fn draw(u: &Field<3>, along: usize, path: &str) -> Result<(), Box<dyn Error>> {
    // Inside of the bodies, which have the same points where they touch. The die has the nodes of its mesh: the exact circle leaves it.
    const INSIDE: f64 = 1e-6;
    let cells = [along, along.div_ceil(3)];
    let slab = rectangle([0.0; 2], [LENGTH, HEIGHT - INSIDE], cells, CellShape::Quadrilateral, 2)?;
    let die = structured([along, 1], CellShape::Quadrilateral, 2, |[s, r]| {
        of_die(PI * (s - 0.5), RADIUS - INSIDE - (THICKNESS - 2.0 * INSIDE) * r)
    })?;
    let section = Mesh::of_bodies(&[("slab", &slab), ("die", &die)])?;
    let space = Space::vector(&section, 2)?;
    let cut = space.positions().iter().map(|[x, z]| u.evaluate(&[*x, 0.0, *z]).map(|u| [u[0], u[2]]));
    let cut = Field::from_values(&space, cut.collect::<Result<Vec<_>, _>>()?.concat())?;
    FieldMap::of(&cut, Shown::Component(0), "displacement along [mm]")
        .length_unit("mm")
        .axes("x", "z")
        .title("The plane y = 0")
        .deformed(&cut, 1.0)
        .write_png(path)?;
    Ok(())
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let counts: Vec<usize> = std::env::args().skip(1).map(|count| count.parse()).collect::<Result<_, _>>()?;
    let given = |place: usize, otherwise: usize| counts.get(place).copied().unwrap_or(otherwise).max(1);
    let [along, pressing, sliding] = [given(0, 12), given(1, 14), given(2, 20)];
    let mesh = bodies(along)?;
    let space = Space::vector(&mesh, 2)?;
    // One value in each cell: where the bodies touch, a function of position would not know which of them is meant.
    let cells = Space::discontinuous_scalar(&mesh, 0)?;
    let young = Field::interpolate(&cells, |x| if x[2] < HEIGHT { YOUNG[0] } else { YOUNG[1] })?;
    out.line(format!("{} unknowns", space.unknowns()));
    out.line(die_forces::HEADING);

    let start = Field::zero(&space);
    let mut frames = VtuSeries::new("out/elastic_die.pvd")?;
    frames.write(0.0, &VtuFile::new(&mesh).point_data("displacement", &start)?)?;
    let mut forces = vec![DieForces::default()];
    let solve = |step: &Increment<'_, Field<3>>| -> Result<Field<3>, Box<dyn Error>> {
        let way = step.factor;
        let problem = problem(&space, &young, step.before, way)?;
        let mut iterations = 0;
        let count = |newton: &NewtonStep| iterations += usize::from(newton.iteration > 0);
        let solved = problem.direct()?.increment(step).each_step(count).solve()?;
        let [left, right] = [solved.reaction("die left")?, solved.reaction("die right")?];
        let base = solved.reaction("slab bottom")?;
        let held: [f64; 3] = std::array::from_fn(|axis| left[axis] + right[axis]);
        let unbalanced = die_forces::unbalanced(&held, &base)?;
        let forces_here = DieForces { way, down: 2.0 * base[2], along: 2.0 * held[0] };
        out.line(forces_here.row(unbalanced, iterations));
        frames.write(way, &VtuFile::new(&mesh).point_data("displacement", solved.field())?)?;
        forces.push(forces_here);
        Ok(solved.into_field())
    };
    let ways = die_forces::ways((DOWN, pressing), (ALONG, sliding));
    let path = LoadSteps::through(ways).advance(start, solve).map_err(|error| error.to_string())?;

    draw(&path.state, along, "out/elastic_die.png")?;
    die_forces::draw(
        &forces,
        "way of the die: down to 1.4 mm, then along [mm]",
        "out/elastic_die_forces.png",
    )?;
    Ok(())
}

fn main() -> ExitCode {
    program(run)
}

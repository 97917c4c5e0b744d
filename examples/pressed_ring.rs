//! A ring of rubber pressed between two round rigid tools until its inner walls meet, and on: large strains, tools and self contact in
//! one form. By symmetry the right half is computed.
//!
//! ```text
//! ∫ P(u):∇v − ∫_Γtools T·v − ½ ∫_Γwalls T·(v(X) − v(Y)) dA = 0
//! ```
//!
//! Each step is refused unless both tools press alike, and halved if points may have passed through a tool or a wall. In the end the work
//! of the tools, by the trapezoidal rule, is what the rubber stores.
//!
//! Run it with `cargo run --release --bin pressed_ring -- [CELLS ALONG THE HALF RING] [STEPS]`. Frames for ParaView are in
//! `out/pressed_ring.pvd`.

use std::error::Error;
use std::f64::consts::PI;
use std::process::ExitCode;

use forms_fem::constraints::RigidMap;
use forms_fem::mesh::{RigidSurface, structured};
use forms_fem::output::picture::{Colour, Curve, FieldMap, LinePlot, Picture, Scale, Shown};
use forms_fem::output::{StandardOutput, VtuFile, VtuSeries, program};
use forms_fem::prelude::*;

/// λ and μ \[MPa\].
const LAMBDA: f64 = 3.0;
const MU: f64 = 1.0;
/// Radii of the ring and of the tools \[mm\].
const INSIDE: f64 = 0.8;
const OUTSIDE: f64 = 1.0;
const TOOL: f64 = 0.4;
/// The way of each tool \[mm\]; the walls meet after some 0.8.
const WAY: f64 = 0.88;
/// Largest distance of opposite points \[mm\].
const REACH: f64 = 0.2;
/// Degree of quadrature.
const DEGREE: usize = 4;

/// The form: `sliding_bodies` with tools whose whole integral is the ring's, and walls that share theirs.
#[forms]
mod ring {
    pub use forms_contact::laws::sliding_bodies::{Data, Omega, Touch, opposite_traction};
    use forms_contact::operators::neo_hookean::{energy_density, first_piola};

    /// The inner walls, which may touch each other.
    #[pairs]
    pub struct Walls;

    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(first_piola(u), grad(v)))
            - integral(Touch(u), dot(opposite_traction(u), jump(v)))
            - integral(Walls(u), dot(opposite_traction(u), jump(v)) / 2)
    }

    pub fn stored_energy(u: State<Vector>) -> Functional {
        integral(Omega, energy_density(u))
    }

    /// ∫ e·T over the walls; with e upward on the upper one and downward on the lower one twice the force between them.
    pub fn wall_force(u: State<Vector>) -> Functional {
        integral(Walls(u), dot(opposite_traction(u), this(force_direction)))
    }
}

/// The lower half of a circle that touches the ring's top, from left to right: its outward side is on the right of the way.
fn upper_tool() -> Vec<[f64; 2]> {
    let point = |k: i32| {
        let angle = PI * f64::from(k) / 120.0;
        [TOOL * angle.sin(), OUTSIDE + TOOL * (1.0 - angle.cos())]
    };
    (-60..=60).map(point).collect()
}

/// The upper tool turned by half a turn.
fn lower_tool() -> Vec<[f64; 2]> {
    upper_tool().iter().map(|[x, y]| [-x, -y]).collect()
}

/// The right half of the ring, from its top to its bottom, and both tools.
fn half_ring(along: usize) -> Result<Mesh<2>, Box<dyn Error>> {
    let across = along.div_ceil(16);
    let half = structured([along, across], CellShape::Quadrilateral, 2, |[s, t]| {
        let (angle, radius) = (PI * (0.5 - s), INSIDE + t * (OUTSIDE - INSIDE));
        [radius * angle.cos(), radius * angle.sin()]
    })?;
    let tools =
        [("above", RigidSurface::along(&upper_tool())?), ("below", RigidSurface::along(&lower_tool())?)];
    Ok(half.with_rigid_surfaces(&tools.each_ref().map(|(name, tool)| (*name, tool)))?)
}

/// Setting of a step.
struct Pressed {
    way: f64,
    /// Force of each tool on the whole ring, and of one wall on the other \[N/mm\].
    tool: f64,
    wall: f64,
    /// Energy of the whole ring per depth \[N\].
    energy: f64,
    /// The difference of the tools' forces relative to one of them.
    unbalanced: f64,
    iterations: usize,
}

/// The ring with its tools, and the pairs of their surfaces.
struct Setting {
    space: Arc<Space<2>>,
    assembler: Assembler<2>,
    tools: Pairing,
    walls: Pairing,
    /// A node on the line between the tools' ends, which symmetry holds.
    held: usize,
}

impl Setting {
    fn new(along: usize) -> Result<Setting, Box<dyn Error>> {
        let mesh = half_ring(along)?;
        let space = Space::vector(&mesh, 2)?;
        let from_middle = |x: &[f64; 2]| (x[0] - OUTSIDE).hypot(x[1]);
        let nodes = space.positions().iter().map(from_middle).enumerate();
        let (held, _) = nodes.min_by(|a, b| a.1.total_cmp(&b.1)).ok_or("a mesh without nodes")?;
        Ok(Setting {
            assembler: Assembler::new(&mesh).with_quadrature(Quadrature::Degree(DEGREE)),
            space,
            tools: Pairing::onto("top", "above").and(Pairing::onto("top", "below")).within_reach(REACH),
            walls: Pairing::within("bottom").within_reach(REACH),
            held,
        })
    }

    /// The ring with each tool moved by the step's factor.
    fn solve(&self, step: &Increment<'_, Field<2>>) -> Result<(Field<2>, Pressed), Box<dyn Error>> {
        let way = step.factor;
        let mut constraints = Constraints::new(&self.space);
        constraints.fix_component("left", 0, |_| 0.0)?;
        constraints.fix_component("right", 0, |_| 0.0)?;
        constraints.fix_node(self.held, 1, 0.0)?;
        constraints.move_rigidly("above", &RigidMap::translation([0.0, -way]))?;
        constraints.move_rigidly("below", &RigidMap::translation([0.0, way]))?;
        let data = ring::data()
            .lambda(LAMBDA)
            .mu(MU)
            .gamma0(40.0 * MU)
            .force_direction(|x: &[f64; 2]| [0.0, x[1].signum()]);
        let regions = ring::Regions::default().touch(self.tools.clone()).walls(self.walls.clone());
        let model = ring::Model { data, regions };
        let options = NewtonOptions { line_search: LineSearch::OnResidual, ..NewtonOptions::default() };
        let form = model.balance();
        let problem = Problem::new(&form, &self.space).assembler(&self.assembler).options(options);
        let problem = problem.constrained(&constraints).increment(step);
        let mut iterations = 0;
        let count = |newton: &NewtonStep| iterations += usize::from(newton.iteration > 0);
        let solved = problem.each_step(count).solve()?;

        let [above, below] = [solved.reaction("above")?, solved.reaction("below")?];
        // What the tools leave over is the reaction at the node that is held.
        let unbalanced = ((above[1] + below[1]) / above[1]).abs();
        let u = solved.field();
        let pressed = Pressed {
            way,
            tool: -2.0 * above[1],
            wall: solved.functional(&model.wall_force(u))?,
            energy: 2.0 * solved.functional(&model.stored_energy(u))?,
            unbalanced,
            iterations,
        };
        Ok((solved.into_field(), pressed))
    }

    /// The distance between the inner walls in the middle.
    fn opening(&self, u: &Field<2>) -> Result<f64, Box<dyn Error>> {
        let [above, below] = [u.evaluate(&[0.0, INSIDE])?, u.evaluate(&[0.0, -INSIDE])?];
        Ok(2.0 * INSIDE + above[1] - below[1])
    }

    fn draw(&self, u: &Field<2>, way: f64, path: &str) -> Result<(), Box<dyn Error>> {
        let [above, below] = [(upper_tool(), -way), (lower_tool(), way)]
            .map(|(tool, way)| tool.iter().map(|[x, y]| [*x, y + way]).collect::<Vec<_>>());
        FieldMap::of(u, Shown::Magnitude, "displacement [mm]")
            .length_unit("mm")
            .deformed(u, 1.0)
            .line(&above, "upper tool", Colour::BLACK)
            .line(&below, "lower tool", Colour::BLACK)
            .write_png(path)?;
        Ok(())
    }
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let counts: Vec<usize> = std::env::args().skip(1).map(|count| count.parse()).collect::<Result<_, _>>()?;
    let given = |place: usize, otherwise: usize| counts.get(place).copied().unwrap_or(otherwise).max(1);
    let [along, steps] = [given(0, 64), given(1, 44)];
    let setting = Setting::new(along)?;
    out.line(format!("{} unknowns", setting.space.unknowns()));
    out.line("| way [mm] | opening [mm] | tool [N/mm] | wall [N/mm] | work [N] | stored [N] | unbalanced | Newton steps |");
    out.line("| --: | --: | --: | --: | --: | --: | --: | --: |");

    let start = Field::zero(&setting.space);
    let mut frames = VtuSeries::new("out/pressed_ring.pvd")?;
    frames.write(0.0, &VtuFile::new(setting.space.mesh()).point_data("displacement", &start)?)?;
    let (mut way, mut work, mut stored) = (0.0, 0.0, 0.0);
    let (mut ways, mut tools, mut walls) = (vec![0.0], vec![0.0], vec![0.0]);
    let solve = |step: &Increment<'_, Field<2>>| -> Result<Field<2>, Box<dyn Error>> {
        let (u, pressed) = setting.solve(step)?;
        if pressed.unbalanced > 1e-10 {
            return Err(format!("the tools' forces differ by {:.1e} of them", pressed.unbalanced).into());
        }
        // Two tools, by the trapezoidal rule.
        work += (pressed.tool + tools.last().copied().unwrap_or(0.0)) * (pressed.way - way);
        (way, stored) = (pressed.way, pressed.energy);
        out.line(format!(
            "| {:.3} | {:.4} | {:.6} | {:.6} | {:.6} | {:.6} | {:.0e} | {} |",
            pressed.way,
            setting.opening(&u)?,
            pressed.tool,
            pressed.wall,
            work,
            pressed.energy,
            pressed.unbalanced,
            pressed.iterations
        ));
        frames.write(way, &VtuFile::new(setting.space.mesh()).point_data("displacement", &u)?)?;
        ways.push(way);
        tools.push(pressed.tool);
        walls.push(pressed.wall);
        Ok(u)
    };
    let path = LoadSteps::uniform(steps, WAY).advance(start, solve).map_err(|error| error.to_string())?;
    // The rule's error is largest where the walls meet.
    if (work / stored - 1.0).abs() > 40.0 / (steps * steps) as f64 + 1e-3 {
        return Err(format!("the tools do the work {work}, and the rubber stores {stored}").into());
    }
    setting.draw(&path.state, WAY, "out/pressed_ring.png")?;
    LinePlot::new()
        .x_axis("way of each tool [mm]", Scale::Linear)
        .y_axis("force [N/mm]", Scale::Linear)
        .curve(Curve::new("of a tool", &ways, &tools))
        .curve(Curve::new("of a wall on the other", &ways, &walls).dashed())
        .write_png("out/pressed_ring_forces.png")?;
    Ok(())
}

fn main() -> ExitCode {
    program(run)
}

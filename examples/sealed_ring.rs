//! A ring of rubber full of water between two round rigid tools, compared with the same ring open: the water keeps the area of the cavity.
//!
//! ```text
//! ∫ W(u,p) − c (V(u) − V₀) + ∫_Γtool ([P_n]₋² − σ_n²)/2γ  stationary in u, p and the pressure c of the water
//! ```
//!
//! c is one unknown of the whole body. By symmetry a quarter is computed. In the end the work of the tools, by the trapezoidal rule, is what the
//! rubber stores, for water takes none.
//!
//! Run it with `cargo run --release --bin sealed_ring -- [CELLS ALONG THE QUARTER] [STEPS]`.

use std::error::Error;
use std::f64::consts::PI;
use std::process::ExitCode;

use forms_contact::laws::mixed_nitsche::usual_gamma0;
use forms_contact::laws::sealed_cavity::sealed_cavity as law;
use forms_fem::mesh::structured;
use forms_fem::output::picture::{Colour, Curve, FieldMap, LinePlot, Picture, Scale};
use forms_fem::output::{StandardOutput, program};
use forms_fem::prelude::*;

/// Radii of the ring and of the tools \[mm\].
const INSIDE: f64 = 20.0;
const OUTSIDE: f64 = 25.0;
const TOOL: f64 = 15.0;
/// μ and K \[MPa\].
const MU: f64 = 0.5;
const BULK: f64 = 500.0;
/// The way of each tool \[mm\].
const WAY: f64 = 5.0;

/// The ring without water, with the same tool.
#[forms(dimension = 2)]
mod open {
    pub use forms_contact::laws::sealed_cavity::{Data, GammaC, Omega};
    use forms_contact::operators::rubber::{mixed_density, mixed_piola};
    use forms_contact::operators::signed_distance::{ball_distance, nitsche_energy};

    pub fn energy(u: Unknown<Vector>, p: Unknown<Scalar>) -> Energy {
        let y = x + u;
        integral(Omega, mixed_density(u, p))
            + integral(
                GammaC,
                nitsche_energy(
                    mixed_piola(u, p) * n,
                    ball_distance(y, centre, radius),
                    normalize(y - centre),
                    gamma0 / h,
                ),
            )
    }

    pub fn stored(u: State<Vector>, p: State<Scalar>) -> Functional {
        integral(Omega, mixed_density(u, p))
    }
}

/// One place of the tools.
#[derive(Clone, Copy)]
struct Pressed {
    way: f64,
    /// Of a tool on the whole ring \[N/mm\].
    force: f64,
    /// Of the water \[MPa\].
    water: f64,
    /// The cavity's area over that of the undeformed one.
    area: f64,
    /// The stored energy of the whole ring \[N\].
    stored: f64,
    iterations: usize,
}

/// The quarter of the ring between both axes.
struct Ring {
    mesh: Mesh<2>,
    spaces: [Arc<Space<2>>; 3],
}

impl Ring {
    fn new(along: usize) -> Result<Ring, Box<dyn Error>> {
        let across = (along / 8).max(2);
        let mesh = structured([along, across], CellShape::Quadrilateral, 2, |[s, t]| {
            let (angle, radius) = (PI / 2.0 * (1.0 - s), INSIDE + t * (OUTSIDE - INSIDE));
            [radius * angle.cos(), radius * angle.sin()]
        })?;
        let spaces = [
            Space::of(&mesh, Elements::Lagrange(2), Scope::Nodes, &[2])?,
            Space::of(&mesh, Elements::LinearInSpace, Scope::Cell, &[])?,
            Space::of(&mesh, Elements::Lagrange(0), Scope::Body, &[])?,
        ];
        Ok(Ring { mesh, spaces })
    }

    fn law(&self, way: f64) -> law::Model<2> {
        let data = law::data()
            .mu(MU)
            .bulk_modulus(BULK)
            .gamma0(usual_gamma0(MU))
            .volume_ratio(1.0)
            .centre([0.0, OUTSIDE + TOOL - way])
            .radius(TOOL)
            .direction([0.0, -1.0]);
        law::Model { data, regions: law::Regions::default().gamma_n("top").gamma_c("top").wall("bottom") }
    }

    /// All ways with water or without, and the last displacement with p.
    fn press(&self, full: bool, steps: usize) -> Result<(Vec<Pressed>, [Field<2>; 2]), Box<dyn Error>> {
        let [displacements, pressures, body] = self.spaces.each_ref();
        let mut held = Constraints::new(displacements);
        held.fix_component("left", 0, |_| 0.0)?;
        held.fix_component("right", 1, |_| 0.0)?;
        let assembler = Assembler::new(&self.mesh).with_quadrature(Quadrature::Degree(5));
        let (omega, surface) = (law::Omega::on("all"), law::GammaC::on("top"));
        let start = [displacements, pressures, body].map(Field::zero);
        let mut rows = vec![];
        let mut iterations = 0;
        let solve = |step: &Increment<'_, [Field<2>; 3]>| -> Result<[Field<2>; 3], Box<dyn Error>> {
            let model = self.law(step.factor);
            let count = |newton: &NewtonStep| iterations += usize::from(newton.iteration > 0);
            let fields = if full {
                let form = model.energy().into();
                let problem = Problem::new(&form, [displacements, pressures, body]);
                problem
                    .assembler(&assembler)
                    .constrained(&held)
                    .increment(step)
                    .each_step(count)
                    .solve()?
                    .fields
            } else {
                let form = open::energy(&model.data, &omega, &surface).into();
                let [u, p, _] = step.start();
                let problem = Problem::new(&form, [displacements, pressures]).start([u, p]);
                let [u, p] =
                    problem.assembler(&assembler).constrained(&held).each_step(count).solve()?.fields;
                [u, p, Field::zero(body)]
            };
            let [u, p, water] = &fields;
            let of = |functional: &Functional<2>| assembler.functional(functional);
            // Half of the tool presses the quarter.
            let force = 2.0 * of(&model.tool_force(u, p, water))?;
            let water = water.values()[0];
            rows.push(Pressed {
                way: step.factor,
                force,
                water,
                area: of(&model.volume(u))? / of(&model.volume_at_rest())?,
                stored: 4.0 * of(&open::stored(&model.data, &omega, u, p))?,
                iterations,
            });
            iterations = 0;
            Ok(fields)
        };
        let path = LoadSteps::uniform(steps, WAY).advance(start, solve).map_err(|error| error.to_string())?;
        let [u, p, _] = path.state;
        Ok((rows, [u, p]))
    }
}

/// The work of both tools by the trapezoidal rule \[N\].
fn work(rows: &[Pressed]) -> f64 {
    let mut before = (0.0, 0.0);
    let mut work = 0.0;
    for row in rows {
        work += (row.way - before.0) * (row.force + before.1);
        before = (row.way, row.force);
    }
    work
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let counts: Vec<usize> = std::env::args().skip(1).map(|count| count.parse()).collect::<Result<_, _>>()?;
    let given = |place: usize, otherwise: usize| counts.get(place).copied().unwrap_or(otherwise).max(1);
    let [along, steps] = [given(0, 32), given(1, 20)];
    let ring = Ring::new(along)?;
    out.line(
        "| ring | way of each tool mm | force N/mm | water MPa | area of the cavity − 1 | Newton steps |",
    );
    out.line("| --- | --: | --: | --: | --: | --: |");
    let mut plot = LinePlot::new()
        .x_axis("way of each tool [mm]", Scale::Linear)
        .y_axis("force of a tool [N/mm]", Scale::Linear);
    for (full, name) in [(true, "full of water"), (false, "open")] {
        let (rows, [u, p]) = ring.press(full, steps)?;
        for row in rows.iter().filter(|row| row.way.fract() == 0.0) {
            out.line(format!(
                "| {name} | {} | {:.6} | {:.6} | {:.1e} | {} |",
                row.way,
                row.force,
                row.water,
                row.area - 1.0,
                row.iterations
            ));
        }
        let last = rows.last().ok_or("no step")?;
        if full && (last.area - 1.0).abs() > 1e-12 {
            return Err(format!("the cavity's area changes by {:e}", last.area - 1.0).into());
        }
        let (work, stored) = (work(&rows), last.stored);
        out.line(format!("{name}: the tools' work {work:.5} N, stored {stored:.5} N"));
        if (work / stored - 1.0).abs() > 8.0 / (steps * steps) as f64 + 2e-3 {
            return Err(format!("the tools do the work {work}, and the rubber stores {stored}").into());
        }
        let [ways, forces]: [Vec<f64>; 2] = [|row: &Pressed| row.way, |row: &Pressed| row.force]
            .map(|value| rows.iter().map(value).collect());
        plot = plot.curve(Curve::new(name, &ways, &forces));
        if full {
            let tool: Vec<[f64; 2]> = (0..=60)
                .map(|k| PI / 2.0 * f64::from(k) / 60.0)
                .map(|angle| [TOOL * angle.sin(), OUTSIDE + TOOL * (1.0 - angle.cos()) - WAY])
                .collect();
            let mean = |cell: usize, point: &[f64; 2]| p.evaluate_in(cell, point)[0];
            FieldMap::cell_by_cell(&ring.mesh, mean, "mean stress p [MPa]")
                .length_unit("mm")
                .levels(20)
                .size(220.0, 220.0)
                .deformed(&u, 1.0)
                .undeformed_outline("undeformed")
                .line(&tool, "tool", Colour::BLACK)
                .write_png("out/sealed_ring.png")?;
        }
    }
    plot.write_png("out/sealed_ring_forces.png")?;
    Ok(())
}

fn main() -> ExitCode {
    program(run)
}

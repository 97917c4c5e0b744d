//! A shallow arch of rubber, clamped at both ends and pressed at its crown, that snaps through onto a flat floor.
//!
//! ```text
//! Π(u) = ∫ W(u) + ∫_bottom ([P]₋² − σ²) / 2γ − λ ∫_top q (−u_y),   P = σ + γ g
//! ```
//!
//! σ is the vertical traction of the lower side, g its distance from the floor. The branch of equilibria is followed by its arc length through
//! both limit points, with contact in between; a bifurcation on it leads to arches that lean to one side. At one load deflation finds
//! the other equilibria from a single guess. Work and energy are compared along the branch.
//!
//! Run it with `cargo run --release --bin arch -- [CELLS ALONG THE ARCH]`.

use std::error::Error;
use std::f64::consts::PI;
use std::process::ExitCode;

use forms_fem::mesh::structured;
use forms_fem::output::picture::{Colour, Curve, FieldMap, LinePlot, Marker, Picture, Scale, Shown};
use forms_fem::output::{StandardOutput, program};
use forms_fem::prelude::*;
use forms_fem::solve::{Branch, EventKind, Inertia};

/// Half the span, the rise of the middle line, the thickness \[mm\].
const HALF_SPAN: f64 = 1.0;
const RISE: f64 = 0.25;
const THICKNESS: f64 = 0.06;
/// λ and μ \[MPa\].
const LAMBDA: f64 = 3.0;
const MU: f64 = 1.0;
/// The floor is so far below the line between the supports \[mm\].
const FLOOR: f64 = 0.0;
/// Half the width of the floor \[mm\].
const FLAT: f64 = 0.5;
/// Half the width of the load at the crown \[mm\].
const WIDTH: f64 = 0.9;
/// The deflection up to which branches are followed \[mm\].
const DEFLECTION: f64 = 0.62;
/// Degree of quadrature.
const DEGREE: usize = 6;

#[forms(dimension = 2)]
mod arch {
    use forms_contact::operators::neo_hookean::{energy_density, first_piola};

    #[includes(forms_contact::operators::linear_elastic::Data)]
    pub struct Data {
        /// λ, the force per depth.
        pub load: Param,
        /// Its distribution along the top.
        pub distribution: Given<Scalar>,
        /// The height of the floor.
        pub floor: Given<Scalar>,
        /// γ₀ [stress].
        pub gamma0: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Top;
    #[facets]
    pub struct Bottom;

    /// σ, negative where the floor presses.
    fn normal_stress(u: Vector) -> Scalar {
        -(first_piola(u) * n)[1]
    }
    fn pressing(u: Vector) -> Scalar {
        neg_part(normal_stress(u) + gamma0 / h * (x[1] + u[1] - floor))
    }
    fn contact(u: Vector) -> Scalar {
        (sqr(pressing(u)) - sqr(normal_stress(u))) * h / (2 * gamma0)
    }
    pub fn potential(u: Unknown<Vector>) -> Energy {
        integral(Omega, energy_density(u)) + integral(Bottom, contact(u)) + integral(Top, load * distribution * u[1])
    }
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        derivative(potential(u), u, v)
    }
    pub fn by_load(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        derivative(balance(u, v), load, 1)
    }
    /// What the rubber stores, with the terms of contact, which vanish with the mesh size.
    pub fn stored(u: State<Vector>) -> Functional {
        integral(Omega, energy_density(u)) + integral(Bottom, contact(u))
    }
    pub fn floor_force(u: State<Vector>) -> Functional {
        integral(Bottom, pressing(u))
    }
    /// The mean deflection under the load.
    pub fn deflection(u: State<Vector>) -> Functional {
        integral(Top, -distribution * u[1])
    }
}

/// A point of a load–deflection curve.
#[derive(Clone, Debug)]
struct Measured {
    deflection: f64,
    floor: f64,
    stored: f64,
    sway: f64,
    u: Field<2>,
}

struct Setting {
    space: Arc<Space<2>>,
    clamps: Constraints<2>,
    assembler: Assembler<2>,
}

impl Setting {
    fn new(along: usize) -> Result<Setting, Box<dyn Error>> {
        let radius = (HALF_SPAN * HALF_SPAN + RISE * RISE) / (2.0 * RISE);
        let half_angle = (HALF_SPAN / radius).asin();
        let mesh = structured([along, along.div_ceil(24)], CellShape::Quadrilateral, 2, |[s, t]| {
            let (angle, r) = ((2.0 * s - 1.0) * half_angle, radius + (t - 0.5) * THICKNESS);
            [r * angle.sin(), r * angle.cos() - (radius - RISE)]
        })?;
        let space = Space::vector(&mesh, 2)?;
        let mut clamps = Constraints::new(&space);
        clamps.fix("left", |_| [0.0; 2])?;
        clamps.fix("right", |_| [0.0; 2])?;
        let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(DEGREE));
        Ok(Setting { space, clamps, assembler })
    }

    fn model(load: f64, floor: f64) -> arch::Model<2> {
        let distribution = |x: &[f64; 2]| match x[0].abs() < WIDTH {
            true => (1.0 + (PI * x[0] / WIDTH).cos()) / (2.0 * WIDTH),
            false => 0.0,
        };
        let data = arch::data().lambda(LAMBDA).mu(MU).load(load).distribution(distribution);
        let flat = move |x: &[f64; 2]| if x[0].abs() < FLAT { floor } else { -10.0 };
        arch::Model::new(data.floor(flat).gamma0(400.0 * MU))
    }

    fn continuation(&self, floor: f64) -> Continuation<'_, 2> {
        let forms = move |load: f64| {
            let model = Self::model(load, floor);
            [model.balance(), model.by_load()]
        };
        Continuation::new(&self.space, forms).constrained(&self.clamps).assembler(&self.assembler)
    }

    fn measure(floor: f64, solved: &Solved<2>) -> Result<Measured, Box<dyn Error + Send + Sync>> {
        let (model, u) = (Self::model(0.0, floor), solved.field());
        Ok(Measured {
            deflection: solved.functional(&model.deflection(u))?,
            floor: solved.functional(&model.floor_force(u))?,
            stored: solved.functional(&model.stored(u))?,
            sway: u.evaluate(&[0.0, RISE])?[0],
            u: u.clone(),
        })
    }

    /// The branch from the arch at rest.
    fn primary(&self, floor: f64) -> Result<Branch<Measured, 2>, Box<dyn Error>> {
        let found = self
            .continuation(floor)
            .step(2e-4)
            .between_steps(1.0 / 1024.0, 4.0)
            .points(250)
            .until(|load, solved| {
                let model = Self::model(load, floor);
                solved.functional(&model.deflection(solved.field())).is_ok_and(|w| w > DEFLECTION)
            })
            .run(|_, solved| Self::measure(floor, solved))?;
        Ok(found)
    }
}

/// The work of the load along a branch, by the trapezoidal rule, next to what the rubber stores at its end.
fn work(branch: &Branch<Measured, 2>) -> f64 {
    let pairs = branch.points.windows(2);
    pairs.map(|p| 0.5 * (p[0].parameter + p[1].parameter) * (p[1].measured.deflection - p[0].measured.deflection)).sum()
}

fn table(out: &mut StandardOutput, branch: &Branch<Measured, 2>) {
    out.line("| deflection [mm] | load [N/mm] | floor [N/mm] | sway [mm] | stored [N] | negative eigenvalues | Newton steps |");
    out.line("| --: | --: | --: | --: | --: | --: | --: |");
    for (number, point) in branch.points.iter().enumerate() {
        let negative = match point.inertia {
            Inertia::NegativeEigenvalues(count) => count.to_string(),
            other => format!("{other:?}"),
        };
        let Measured { deflection, floor, stored, sway, .. } = &point.measured;
        out.line(format!(
            "| {deflection:.4} | {:.6} | {floor:.6} | {sway:.4} | {stored:.7} | {negative} | {} |",
            point.parameter, point.iterations
        ));
        for event in branch.events.iter().filter(|event| event.after == number) {
            let kind = match event.kind {
                EventKind::LimitPoint => "limit point".to_owned(),
                EventKind::Bifurcation { eigenvalues } => format!("bifurcation ({eigenvalues})"),
            };
            out.line(format!("{kind} at the load {:.8}, uncertain by {:.0e}", event.parameter, event.uncertainty));
        }
    }
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let along: usize = std::env::args().nth(1).map_or(Ok(48), |count| count.parse())?;
    let setting = Setting::new(along.max(4))?;
    out.line(format!("{} unknowns", setting.space.unknowns()));

    let free = setting.primary(-10.0)?;
    out.line("without a floor:");
    table(out, &free);
    let held = setting.primary(-FLOOR)?;
    out.line("with a floor:");
    table(out, &held);
    Ok(())
}

fn main() -> ExitCode {
    program(run)
}

//! A shallow arch of rubber, clamped at both ends and pressed at its crown, that snaps through onto a flat floor.
//!
//! ```text
//! Π(u) = ∫ W(u) + ∫_bottom ([P]₋² − σ²) / 2γ + ∫_bottom k [g]₋² / 2 − λ ∫_top q (−u_y),   P = σ + γ g
//! ```
//!
//! σ is the vertical traction of the lower side, g its distance from a floor, which is rigid (γ) or soft (k). The branch of
//! equilibria is followed by its arc length through both limit points. Contact with the soft floor begins between them, and both are
//! smooth; contact with the rigid one turns the branch round. A bifurcation leads to arches that lean to one side. At one load
//! deflation finds the upright equilibria from two guesses. Work and energy are compared along the branches.
//!
//! Run it with `cargo run --release --bin arch -- [CELLS ALONG THE ARCH]`.

use std::error::Error;
use std::f64::consts::PI;
use std::process::ExitCode;

use forms_fem::mesh::structured;
use forms_fem::output::picture::{Colour, Curve, FieldMap, LinePlot, Marker, Picture, Scale, Shown};
use forms_fem::output::{StandardOutput, program};
use forms_fem::prelude::*;
use forms_fem::solve::{Branch, BranchEvent, EventKind, Inertia};

/// Half the span, the rise of the middle line, the thickness \[mm\].
const HALF_SPAN: f64 = 1.0;
const RISE: f64 = 0.25;
const THICKNESS: f64 = 0.06;
/// λ and μ \[MPa\].
const LAMBDA: f64 = 3.0;
const MU: f64 = 1.0;
/// The height of the floor above the line between the supports \[mm\], and half its width.
const FLOOR: f64 = 0.0;
const FLAT: f64 = 0.5;
/// The stiffness of the soft floor \[MPa/mm\].
const BED: f64 = 0.003;
/// Half the width of the load at the crown \[mm\].
const WIDTH: f64 = 0.6;
/// The deflection and the load up to which branches are followed \[mm, N/mm\].
const DEFLECTION: f64 = 0.4;
const LARGEST_LOAD: f64 = 8e-4;
/// The load at which deflation looks for all equilibria \[N/mm\].
const LOAD: f64 = 3e-4;
/// The largest displacement from a bifurcation to the first arch that leans \[mm\].
const LEAN: f64 = 0.01;
/// Most equilibria that deflation looks for from a guess.
const MOST: usize = 8;
/// A place below every floor.
const NOWHERE: f64 = -10.0;
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
        /// The height of the soft floor, and its stiffness.
        pub soft_floor: Given<Scalar>,
        pub bed: Param,
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
    fn sinking(u: Vector) -> Scalar {
        neg_part(x[1] + u[1] - soft_floor)
    }
    pub fn potential(u: Unknown<Vector>) -> Energy {
        integral(Omega, energy_density(u))
            + integral(Bottom, contact(u) + bed * sqr(sinking(u)) / 2)
            + integral(Top, load * distribution * u[1])
    }
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        derivative(potential(u), u, v)
    }
    pub fn by_load(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        derivative(balance(u, v), load, 1)
    }
    /// The stored energy of the rubber and the soft floor, with the terms of rigid contact, which vanish with the mesh size.
    pub fn stored(u: State<Vector>) -> Functional {
        integral(Omega, energy_density(u)) + integral(Bottom, contact(u) + bed * sqr(sinking(u)) / 2)
    }
    pub fn floor_force(u: State<Vector>) -> Functional {
        integral(Bottom, pressing(u) + bed * sinking(u))
    }
    /// The mean deflection under the load.
    pub fn deflection(u: State<Vector>) -> Functional {
        integral(Top, -distribution * u[1])
    }
}

/// The ground below the arch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ground {
    Nothing,
    Soft,
    Rigid,
}

/// An equilibrium, with the number of negative eigenvalues of its tangent where it is known.
type Equilibrium = (Measured, Option<usize>);

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

    fn model(load: f64, ground: Ground) -> arch::Model<2> {
        let distribution = |x: &[f64; 2]| match x[0].abs() < WIDTH {
            true => (1.0 + (PI * x[0] / WIDTH).cos()) / (2.0 * WIDTH),
            false => 0.0,
        };
        let data = arch::data().lambda(LAMBDA).mu(MU).load(load).distribution(distribution);
        let flat = move |kind: Ground| {
            move |x: &[f64; 2]| if ground == kind && x[0].abs() < FLAT { FLOOR } else { NOWHERE }
        };
        let data = data.floor(flat(Ground::Rigid)).gamma0(400.0 * MU);
        arch::Model::new(data.soft_floor(flat(Ground::Soft)).bed(BED))
    }

    fn continuation(&self, ground: Ground) -> Continuation<'_, 2> {
        let forms = move |load: f64| {
            let model = Self::model(load, ground);
            [model.balance(), model.by_load()]
        };
        Continuation::new(&self.space, forms).constrained(&self.clamps).assembler(&self.assembler)
    }

    fn measure(ground: Ground, solved: &Solved<2>) -> Result<Measured, Box<dyn Error + Send + Sync>> {
        let (model, u) = (Self::model(0.0, ground), solved.field());
        Ok(Measured {
            deflection: solved.functional(&model.deflection(u))?,
            floor: solved.functional(&model.floor_force(u))?,
            stored: solved.functional(&model.stored(u))?,
            sway: u.evaluate(&[0.0, RISE])?[0],
            u: u.clone(),
        })
    }

    /// The branch of arches that lean to one side, from a bifurcation until it comes back to the upright ones.
    fn leaning(&self, fork: &BranchEvent<2>) -> Result<Branch<Measured, 2>, Box<dyn Error>> {
        let mut leant = false;
        let found = self
            .continuation(Ground::Rigid)
            .switched(fork, 0, LEAN)
            .step(2e-5)
            .between_steps(1.0 / 1024.0, 1.0)
            .points(60)
            .until(|_, solved| {
                let lean = solved.field().evaluate(&[0.0, RISE]).map_or(0.0, |u| u[0].abs());
                leant |= lean > 4e-3;
                leant && lean < 1e-3
            })
            .run(|_, solved| Self::measure(Ground::Rigid, solved))?;
        Ok(found)
    }

    /// Further equilibria at one load from a guess, each with the number of negative eigenvalues of its tangent.
    fn deflated(
        &self,
        guess: &Field<2>,
        known: &mut Deflation<2>,
    ) -> Result<Vec<Equilibrium>, Box<dyn Error>> {
        let form = Self::model(LOAD, Ground::Rigid).balance();
        let mut found = vec![];
        while found.len() < MOST {
            let mut solver = TangentSolver::default();
            let options = NewtonOptions { max_iterations: 100, ..NewtonOptions::default() };
            let problem =
                Problem::new(&form, &self.space).constrained(&self.clamps).assembler(&self.assembler);
            let solved = problem.start(guess).deflated(known).solver(&mut solver).options(options).solve();
            let Ok(solved) = solved else { break };
            found.push((
                Self::measure(Ground::Rigid, &solved).map_err(|e| e.to_string())?,
                solver.negative_eigenvalues(),
            ));
            known.add(solved.field());
        }
        Ok(found)
    }

    /// The branch from the arch at rest.
    fn primary(&self, ground: Ground) -> Result<Branch<Measured, 2>, Box<dyn Error>> {
        let found = self
            .continuation(ground)
            .step(1e-4)
            .between_steps(1.0 / 1024.0, 2.0)
            .points(250)
            .within(0.0..=LARGEST_LOAD)
            .until(|load, solved| {
                let model = Self::model(load, ground);
                solved.functional(&model.deflection(solved.field())).is_ok_and(|w| w > DEFLECTION)
            })
            .run(|_, solved| Self::measure(ground, solved))?;
        Ok(found)
    }
}

/// The work of the load along a branch, by the trapezoidal rule, next to what the rubber stores at its end.
fn work(branch: &Branch<Measured, 2>) -> f64 {
    let pairs = branch.points.windows(2);
    pairs
        .map(|p| {
            0.5 * (p[0].parameter + p[1].parameter) * (p[1].measured.deflection - p[0].measured.deflection)
        })
        .sum()
}

/// Contact is to begin between two limit points, both of them smooth.
fn check_contact(branch: &Branch<Measured, 2>) -> Result<(), Box<dyn Error>> {
    let limits = branch.events.iter().filter(|event| matches!(event.kind, EventKind::LimitPoint));
    let places: Vec<usize> = limits.map(|event| event.after).collect();
    let touches = |point: usize| branch.points[point].measured.floor > 0.0;
    match places[..] {
        [first, second] if !touches(first + 1) && touches(second) => Ok(()),
        _ => Err(format!("contact does not begin between two limit points: {places:?}").into()),
    }
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
            out.line(format!(
                "{kind} at the load {:.8}, uncertain by {:.0e}",
                event.parameter, event.uncertainty
            ));
        }
    }
}

/// The curve of a branch.
fn curve(name: &str, branch: &Branch<Measured, 2>) -> Curve {
    let deflections: Vec<f64> = branch.points.iter().map(|point| point.measured.deflection).collect();
    let loads: Vec<f64> = branch.points.iter().map(|point| 1e3 * point.parameter).collect();
    Curve::new(name, &deflections, &loads).without_markers()
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let along: usize = std::env::args().nth(1).map_or(Ok(48), |count| count.parse())?;
    let setting = Setting::new(along.max(4))?;
    out.line(format!("{} unknowns", setting.space.unknowns()));

    out.line("without a floor:");
    let free = setting.primary(Ground::Nothing)?;
    table(out, &free);
    out.line("onto a soft floor:");
    let soft = setting.primary(Ground::Soft)?;
    table(out, &soft);
    check_contact(&soft)?;
    out.line("onto a rigid floor:");
    let held = setting.primary(Ground::Rigid)?;
    table(out, &held);
    for branch in [&free, &soft, &held] {
        let last = branch.points.last().ok_or("no point")?;
        let (done, stored) = (work(branch), last.measured.stored);
        out.line(format!("the load did the work {done:.6e}, the rubber stores {stored:.6e} N"));
        if (done / stored - 1.0).abs() > 0.01 {
            return Err("work and energy differ".into());
        }
    }

    out.line("arches that lean:");
    let fork = held.bifurcations().next().ok_or("no bifurcation")?;
    let leaning = setting.leaning(fork)?;
    table(out, &leaning);

    // Two guesses: the arch at rest, and pressed onto the floor.
    let (rest, pressed) = (Field::zero(&setting.space), &held.points.last().ok_or("no point")?.measured.u);
    let mut known = Deflation::new();
    let mut found = setting.deflated(&rest, &mut known)?;
    found.extend(setting.deflated(pressed, &mut known)?);
    out.line(format!("equilibria at the load {LOAD} N/mm, by deflation:"));
    out.line(
        "| deflection [mm] | floor [N/mm] | sway [mm] | stored [N] | potential [N] | negative eigenvalues |",
    );
    out.line("| --: | --: | --: | --: | --: | --: |");
    for (Measured { deflection, floor, stored, sway, .. }, negative) in &found {
        let negative = negative.map_or_else(|| "?".to_owned(), |count| count.to_string());
        let potential = stored - LOAD * deflection;
        out.line(format!(
            "| {deflection:.4} | {floor:.6} | {sway:.4} | {stored:.4e} | {potential:.4e} | {negative} |"
        ));
    }

    let deflections: Vec<f64> = found.iter().map(|(measured, _)| measured.deflection).collect();
    LinePlot::new()
        .x_axis("deflection [mm]", Scale::Linear)
        .y_axis("load [10⁻³ N/mm]", Scale::Linear)
        .curve(curve("onto a rigid floor", &held))
        .curve(curve("onto a soft floor", &soft))
        .curve(curve("without a floor", &free).dashed())
        .curve(curve("leaning", &leaning))
        .curve(
            Curve::new("by deflation", &deflections, &vec![1e3 * LOAD; found.len()])
                .without_line()
                .marker(Marker::Circle)
                .colour(Colour::BLACK),
        )
        .write_png("out/arch_curves.png")?;
    let snapped = held.points.last().ok_or("no point")?;
    FieldMap::of(&snapped.measured.u, Shown::Component(1), "upward [mm]")
        .length_unit("mm")
        .deformed(&snapped.measured.u, 1.0)
        .undeformed_outline("at rest")
        .line(&[[-FLAT, FLOOR], [FLAT, FLOOR]], "floor", Colour::BLACK)
        .write_png("out/arch.png")?;
    Ok(())
}

fn main() -> ExitCode {
    program(run)
}

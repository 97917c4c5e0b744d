//! Tutorial 12: two bodies, large sliding. Shallow ironing: a rounded block of stiff rubber is pressed into a soft foundation and
//! drawn along it with Coulomb friction, at finite strains, on meshes that do not match.
//!
//! ```text
//! ∫ P(u):∇v − Σ ½ ∫ T(u)·(v(X) − v(Y)) dA = 0
//! ```
//!
//! X is a point of one surface, Y the point of the other one that a ray along the deformed normal meets. Both move with u, which the
//! tangent includes. The law is `sliding_bodies` of `forms-contact`; a law of your own names `gap`, `toward`, `jump(u)` and
//! integrates over `Touch(u)` in the same way.
//!
//! Publications disagree on the forces of this benchmark by a quarter. Vertical and tangential forces in N/mm, at the end of
//! pressing and then half of the way along, are: Poulios and Renard 268, 55 and 337, 102; Yastrebov 290, 59 and 360, 171; Fischer and Wriggers 298,
//! 62 and 365, 189; Hartmann and others 320, 67 and 408, 160.
//!
//! Run it with `cargo run --release --bin 12_two_bodies -- [FINENESS] [STEPS OF PRESSING] [STEPS OF SLIDING]`. A step of sliding is a
//! fifth of a millimetre. The benchmark's fineness is 4, and half of its way along takes 25 steps.

use forms_contact::ContactProblem;
use forms_contact::laws::sliding_bodies as law;
use forms_fem::mesh::structured;
use forms_fem::output::picture::{Curve, FieldMap, LinePlot, Picture, Scale, Shown};
use forms_fem::prelude::*;
use forms_fem::solve::LoadSteps;

/// Young's modulus of the foundation \[MPa\]; the block is ten times as stiff.
const YOUNG: f64 = 689.6;
const POISSON: f64 = 0.32;
const FRICTION: f64 = 0.3;
/// The way down and the whole way along \[mm\].
const DOWN: f64 = 1.0;
const ALONG: f64 = 10.0;

/// A foundation of 12 × 4 mm, and a block with an arc for its lower side; the benchmark's mesh at a fineness of 4.
pub fn mesh(fineness: usize) -> Result<Mesh<2>, Failure> {
    let cells = [30 * fineness, 15 * fineness / 2];
    let foundation = rectangle([0.0; 2], [12.0, 4.0], cells, CellShape::Quadrilateral, 1)?;
    let block = structured([3 * fineness, 3 * fineness / 2], CellShape::Quadrilateral, 1, |[s, t]| {
        let x = 0.2 + 1.2 * s;
        // Through (0.2, 4.5), (0.8, 4.2) and (1.4, 4.5).
        let bottom = 4.95 - (0.75_f64.powi(2) - (x - 0.8).powi(2)).sqrt();
        [x, bottom + t * (5.4 - bottom)]
    })?;
    let mut mesh = Mesh::of_bodies(&[("foundation", &foundation), ("block", &block)])?;
    // The block sinks in deeper than its arc: its sides touch, too.
    mesh.name_facets("skin", "block boundary", |x| x[1] < 5.4 - 1e-9)?;
    Ok(mesh)
}

/// Young's modulus by the place: the bodies do not overlap.
fn modulus(x: &[f64; 2]) -> f64 {
    if x[1] > 4.0 + 1e-9 { 10.0 * YOUNG } else { YOUNG }
}

fn data(before: &Field<2>) -> law::Data<2> {
    law::data()
        .lambda(|x: &[f64; 2]| modulus(x) * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON)))
        .mu(|x: &[f64; 2]| modulus(x) / (2.0 * (1.0 + POISSON)))
        .gamma0(|x: &[f64; 2]| 10.0 * modulus(x))
        .friction(FRICTION)
        .displacement_before(before)
}

/// The problem with the block's top at a place on its way, the slip counted from the state before.
pub fn problem(
    space: &Arc<Space<2>>,
    before: &Field<2>,
    way: f64,
) -> Result<ContactProblem<2, law::Model<2>>, Failure> {
    let mut constraints = Constraints::new(space);
    constraints.fix("foundation bottom", |_| [0.0, 0.0])?;
    // Up to 1 it goes down, then along.
    let top = [ALONG * (way - 1.0).max(0.0), -DOWN * way.min(1.0)];
    constraints.fix("block top", |_| top)?;
    let touch = Pairing::between("foundation top", "skin").within_reach(0.4);
    let regions = law::Regions::default().touch(touch).gamma_n("block top");
    let law = law::Model { data: data(before), regions };
    Ok(ContactProblem::new(space, law, constraints))
}

fn main() -> Result<(), Failure> {
    let counts: Vec<usize> = std::env::args().skip(1).map(|count| count.parse()).collect::<Result<_, _>>()?;
    let given = |place: usize, otherwise: usize| counts.get(place).copied().unwrap_or(otherwise);
    let [fineness, pressing, sliding] = [given(0, 2), given(1, 8), given(2, 10)];
    let mesh = mesh(fineness.max(1))?;
    let space = Space::vector(&mesh, 1)?;
    println!("{} unknowns", space.unknowns());

    let (mut ways, mut upward, mut along) = (vec![], vec![], vec![]);
    let solve = |step: &Increment<'_, Field<2>>| -> Result<Field<2>, Failure> {
        let way = step.factor;
        let problem = problem(&space, step.before, way)?;
        let solved = problem.direct()?.increment(step).solve()?;
        let force = solved.reaction("foundation bottom")?;
        println!(
            "way {way:.3}: {:2} Newton steps, force {:8.3} down, {:8.3} along [N/mm]",
            solved.history.len() - 1,
            force[1],
            -force[0]
        );
        ways.push(way);
        upward.push(force[1]);
        along.push(-force[0]);
        Ok(solved.into_field())
    };
    let steps = (1..=pressing).map(|step| step as f64 / pressing as f64);
    let steps = steps.chain((1..=sliding).map(|step| 1.0 + 0.2 * step as f64 / ALONG));
    let path = LoadSteps::through(steps).advance(Field::zero(&space), solve)?;

    LinePlot::new()
        .x_axis("way of the block: down to 1, then along", Scale::Linear)
        .y_axis("force [N/mm]", Scale::Linear)
        .curve(Curve::new("downward", &ways, &upward))
        .curve(Curve::new("along", &ways, &along).dashed())
        .write_png("out/12_two_bodies_forces.png")?;
    FieldMap::of(&path.state, Shown::Component(0), "displacement along [mm]")
        .length_unit("mm")
        .deformed(&path.state, 1.0)
        .write_png("out/12_two_bodies.png")?;
    Ok(())
}

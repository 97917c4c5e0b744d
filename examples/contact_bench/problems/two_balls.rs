//! Two balls of stiffness 100 : 1 with axial symmetry in (r, z) (Kratos' test): Hertz, and both choices of the integrating side.

use std::f64::consts::PI;

use forms_fem::mesh::structured;
use forms_fem::output::Failure;
use forms_fem::prelude::*;

use super::grading::graded;
use crate::body;
use crate::case::{Case, Contact};
use crate::outcome::Outcome;
use crate::problem::{Problem, Quantity};

const POISSON: f64 = 0.29;
/// Of the upper and of the lower ball.
const YOUNG: [f64; 2] = [1e6, 1e8];
const RADIUS: f64 = 6.1237;
/// a for the force 117 808.787.
const REACH: f64 = 0.6302;
/// The angle up to which a ball is meshed.
const ANGLE: f64 = 1.0;
/// The way of the upper ball's flat side.
const WAY: f64 = 0.12;

/// The ball that is integrated over.
pub enum TwoBalls {
    /// The one with E = 10⁶.
    OverSoft,
    /// The one with E = 10⁸.
    OverHard,
}

/// 1/E* of both.
fn compliance() -> f64 {
    YOUNG.iter().map(|young| (1.0 - POISSON * POISSON) / young).sum()
}

/// p0 of a force: 3F/(2πa²) with a³ = 3FR/(4E*).
fn hertz(force: f64) -> [f64; 2] {
    let reach = (0.75 * force * 0.5 * RADIUS * compliance()).cbrt();
    [reach, 1.5 * force / (PI * reach * reach)]
}

/// The part of a ball above z = 0 below its centre, from the pole (0, 0) up to an angle; dense at the pole.
fn cap(part: f64, height: f64) -> [f64; 2] {
    let turn = graded(part, 1.3 * REACH / (RADIUS * ANGLE), 1.0);
    let up = graded(height, 1.3 * REACH / RADIUS, 1.0);
    let (sine, cosine) = (ANGLE * turn).sin_cos();
    let round = [RADIUS * sine, RADIUS * (1.0 - cosine)];
    let flat = [RADIUS * ANGLE.sin() * turn, RADIUS];
    [0, 1].map(|k| round[k] + up * (flat[k] - round[k]))
}

impl Problem for TwoBalls {
    fn name(&self) -> String {
        match self {
            TwoBalls::OverSoft => "two_balls",
            TwoBalls::OverHard => "two_balls_hard",
        }
        .to_owned()
    }

    fn statement(&self) -> &'static str {
        match self {
            TwoBalls::OverSoft => {
                "balls of radius 6.1237, E = 1e6 on E = 1e8, in (r, z), integrated over the soft one; p0 = 3F/(2πa²) (Hertz)"
            }
            TwoBalls::OverHard => "the same balls, integrated over the hard one",
        }
    }

    fn case(&self, level: usize, degree: usize) -> Result<Case, Failure> {
        // Meshes that do not match.
        let (above, below) = (12 << level, 10 << level);
        let upper = structured([above; 2], CellShape::Quadrilateral, 2, |[s, t]: [f64; 2]| cap(s, t))?;
        let lower = structured([below; 2], CellShape::Quadrilateral, 2, |[s, t]: [f64; 2]| {
            let [r, z] = cap(s, 1.0 - t);
            [r, -z]
        })?;
        let mut mesh = Mesh::of_bodies(&[("upper", &upper), ("lower", &lower)])?;
        mesh.name_facets("soft", "upper bottom", |x| x[0] < 1.4 * REACH)?;
        mesh.name_facets("hard", "lower top", |x| x[0] < 1.4 * REACH)?;
        let space = Space::vector(&mesh, degree)?;
        let mut constraints = Constraints::new(&space);
        constraints.fix("upper top", |_| [0.0, -WAY])?;
        constraints.fix("lower bottom", |_| [0.0; 2])?;
        for side in ["upper left", "lower left"] {
            constraints.fix_component(side, 0, |_| 0.0)?;
        }
        let materials = Space::of(&mesh, Elements::Lagrange(0), Scope::Cell, &[])?;
        let of_balls = |upper: f64, lower: f64| {
            Field::interpolate(&materials, move |x| if x[1] > 0.0 { upper } else { lower })
        };
        let [soft, hard] = YOUNG.map(|young| super::lame(young, POISSON));
        let data = body::data()
            .lambda(&of_balls(soft[0], hard[0])?)
            .mu(&of_balls(soft[1], hard[1])?)
            .young(&of_balls(YOUNG[0], YOUNG[1])?)
            .axial(1.0);
        let surfaces = match self {
            TwoBalls::OverSoft => ["soft", "lower top"],
            TwoBalls::OverHard => ["hard", "upper bottom"],
        };
        Ok(Case {
            space,
            constraints,
            data,
            // There is no load.
            loaded: "lower right".to_owned(),
            cut: None,
            contact: Contact::Bodies(surfaces.map(str::to_owned)),
            start: None,
            pressure: 1e5,
            approach: WAY,
        })
    }

    fn quantities(&self, case: &Case, found: &Outcome) -> Result<Vec<Quantity>, Failure> {
        // The force of contact on the own ball.
        let nodes = case.space.nodes_on(case.own())?;
        let force: f64 = nodes.iter().map(|node| found.forces[2 * *node as usize + 1]).sum();
        let [reach, most] = hertz(force.abs());
        // The pressure in the middle, by that within a half of the width.
        let inside = |x: [f64; 2]| x[0] < 0.5 * reach;
        let shape = |x: [f64; 2]| (1.0 - (x[0] / reach).powi(2)).max(0.0).sqrt();
        let pressed = found.pressures.integral(|x, pressure| if inside(x) { pressure } else { 0.0 });
        let shaped = found.pressures.integral(|x, _| if inside(x) { shape(x) } else { 0.0 });
        Ok(vec![
            Quantity { name: "force", value: force.abs(), exact: None },
            Quantity { name: "p0/p0 of the force (Hertz)", value: pressed / shaped / most, exact: Some(1.0) },
            Quantity { name: "a of the force (Hertz)", value: reach, exact: None },
        ])
    }
}

//! A rigid parabola on a half-plane (Hertz). The block has the displacement of the half-plane at its cut, so that its size hardly matters.

use std::f64::consts::{FRAC_PI_2, PI};

use forms_fem::mesh::structured;
use forms_fem::output::Failure;
use forms_fem::prelude::*;

use super::grading::graded;
use crate::body;
use crate::case::{Case, Contact};
use crate::cut_body::CutBody;
use crate::outcome::Outcome;
use crate::problem::{Problem, Quantity};

const POISSON: f64 = 0.3;
/// Half the width of contact for which the cut is made; the radius of the parabola is 1.
const REACH: f64 = 0.05;
/// Size of the block, in widths.
const SIZE: f64 = 20.0;
/// The first gap in the middle, which the block closes first.
const GAP: f64 = 1e-4;

/// E/(1 − ν²) with E = 1.
fn modulus() -> f64 {
    1.0 / (1.0 - POISSON * POISSON)
}

/// a of a force per length, R = 1.
fn reach(force: f64) -> f64 {
    2.0 * (force / (PI * modulus())).sqrt()
}

/// The force per length for which the cut is made.
fn nominal() -> f64 {
    PI * modulus() * REACH * REACH / 4.0
}

/// Displacement of the half-plane y < 0 under p0 √(1 − x²/a²), from afar, after Flamant, with the second moment of the pressure, relative to the surface in
/// the middle of the contact.
fn far(x: f64, y: f64) -> [f64; 2] {
    let (force, shear) = (nominal(), 0.5 / (1.0 + POISSON));
    let depth = -y;
    let (r, angle) = (x.hypot(depth), (depth + 0.0).atan2(x));
    let spread = REACH * REACH / (r * r);
    let scale = force / PI;
    // The complex potential of a pushed half-plane, and its slope.
    let potential = [
        scale * (angle - FRAC_PI_2 + spread * (2.0 * angle).sin() / 8.0),
        -scale * (r.ln() - spread * (2.0 * angle).cos() / 8.0),
    ];
    let slope = [
        -scale * (angle.sin() + spread * (3.0 * angle).sin() / 4.0) / r,
        -scale * (angle.cos() + spread * (3.0 * angle).cos() / 4.0) / r,
    ];
    let aside = ((1.0 - 2.0 * POISSON) * potential[0] - depth * slope[1]) / (2.0 * shear);
    let down = (2.0 * (1.0 - POISSON) * potential[1] - depth * slope[0]) / (2.0 * shear);
    let middle = (1.0 - POISSON) / shear * scale * ((2.0 / REACH).ln() + 0.5);
    [aside, middle - down]
}

/// Half of the block.
pub struct Line;

impl Line {
    /// The problem on a mesh, with the whole surface or a part of it.
    fn on(mesh: &Mesh<2>, degree: usize, contact: &str) -> Result<Case, Failure> {
        let space = Space::vector(mesh, degree)?;
        let mut constraints = Constraints::new(&space);
        constraints.fix_component("left", 0, |_| 0.0)?;
        for side in ["right", "bottom"] {
            constraints.fix(side, |x| {
                let [aside, up] = far(x[0], x[1]);
                [aside, up + GAP]
            })?;
        }
        let [lambda, mu] = super::lame(1.0, POISSON);
        let data = body::data().lambda(lambda).mu(mu).young(1.0).obstacle_normal([0.0, 1.0]);
        Ok(Case {
            space,
            constraints,
            data: data.obstacle_gap(|x: &[f64; 2]| GAP + 0.5 * x[0] * x[0]),
            // There is no load.
            loaded: "right".to_owned(),
            cut: None,
            contact: Contact::Obstacle(contact.to_owned()),
            start: None,
            pressure: 0.5 * modulus() * REACH,
            approach: 0.5 * REACH * REACH,
        })
    }
}

impl Problem for Line {
    fn name(&self) -> String {
        "hertz".to_owned()
    }

    fn statement(&self) -> &'static str {
        "a rigid parabola x²/2 on a half-plane, E = 1: p = p0 √(1 − x²/a²), p0 = 2F/πa (Hertz)"
    }

    fn case(&self, level: usize, degree: usize) -> Result<Case, Failure> {
        let size = SIZE * REACH;
        let cells = [12 << level; 2];
        let mut mesh = structured(cells, CellShape::Quadrilateral, 1, |[s, t]: [f64; 2]| {
            [graded(s, 2.0 * REACH, size), -graded(1.0 - t, 2.0 * REACH, size)]
        })?;
        mesh.name_facets("contact", "top", |x| x[0] < 2.0 * REACH)?;
        Self::on(&mesh, degree, "contact")
    }

    fn cut_case(&self, level: usize, degree: usize) -> Result<Option<Case>, Failure> {
        let (size, across, down) = (SIZE * REACH, 12 << level, (12 << level) + 1);
        let height = 2.0 * REACH / (6 << level) as f64;
        // Rows of nodes above and below the surface, which is at another height of each cell.
        let mesh = structured([across, down], CellShape::Triangle, 1, |[s, t]: [f64; 2]| {
            let depth = graded((1.0 - t) * down as f64 / across as f64, 2.0 * REACH, size);
            let near = (-depth / (4.0 * height)).exp();
            [graded(s, 2.0 * REACH, size), height * (0.5 + 0.4 * near * (29.0 * s).sin()) - depth]
        })?;
        let body = CutBody::of(&mesh, |x| x[1])?;
        let mut case = Self::on(&mesh, degree, "all")?;
        body.hold_outside(&mut case.constraints)?;
        Ok(Some(Case { cut: Some(body), ..case }))
    }

    fn exact_pressure(&self, place: [f64; 2], force: f64) -> Option<f64> {
        let reach = reach(2.0 * force);
        Some(4.0 * force / (PI * reach) * (1.0 - (place[0] / reach).powi(2)).max(0.0).sqrt())
    }

    fn quantities(&self, _case: &Case, found: &Outcome) -> Result<Vec<Quantity>, Failure> {
        let force = 2.0 * found.pressures.force();
        // The pressure in the middle, by that within a half of the width.
        let reach = reach(force);
        let inside = |x: [f64; 2]| x[0] < 0.5 * reach;
        let shape = |x: [f64; 2]| (1.0 - (x[0] / reach).powi(2)).max(0.0).sqrt();
        let pressed = found.pressures.integral(|x, pressure| if inside(x) { pressure } else { 0.0 });
        let shaped = found.pressures.integral(|x, _| if inside(x) { shape(x) } else { 0.0 });
        Ok(vec![
            Quantity { name: "force", value: force, exact: Some(nominal()) },
            Quantity { name: "p0", value: pressed / shaped, exact: Some(2.0 * force / (PI * reach)) },
        ])
    }
}

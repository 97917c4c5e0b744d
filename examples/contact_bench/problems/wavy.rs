//! A wavy surface on a rigid flat (Westergaard): contact widths and pressures by the mean pressure.

use std::f64::consts::PI;

use forms_fem::mesh::structured;
use forms_fem::output::Failure;
use forms_fem::prelude::*;

use crate::body;
use crate::case::{Case, Contact};
use crate::cut_body::CutBody;
use crate::outcome::Outcome;
use crate::problem::{Problem, Quantity};

const POISSON: f64 = 0.3;
/// Height of the wave, whose length is 1.
const WAVE: f64 = 1e-3;
const DEPTH: f64 = 2.0;
/// The first gap above the crest.
const GAP: f64 = 1e-4;

/// Mean pressures, in parts of that of full contact.
pub const PRESSURES: [f64; 5] = [0.05, 0.2, 0.5, 0.8, 1.2];

/// Half of a wave of a strip of depth 2, pressed to a mean pressure.
pub struct Wavy {
    /// p̄/p*, p* = π E* d.
    pub part: f64,
}

/// The depth of a part of the rows of cells.
fn depth(part: f64) -> f64 {
    DEPTH * (0.03 * part + 0.97 * part.powi(3))
}

/// p* with E = 1.
fn full() -> f64 {
    PI * WAVE / (1.0 - POISSON * POISSON)
}

impl Wavy {
    /// The way of the flat: that of the mean gap, d (1 − q + q ln q), and the strip's compression.
    fn way(&self) -> f64 {
        let q = self.part;
        let [lambda, mu] = super::lame(1.0, POISSON);
        let closed = if q < 1.0 { q - q * q.ln() } else { 1.0 };
        WAVE * closed + q * full() * DEPTH / (lambda + 2.0 * mu)
    }

    /// The place of a node: half of the cells are in contact, and all are small toward its known end, where the pressure begins as a square root.
    fn place(&self, part: f64) -> f64 {
        if self.part >= 1.0 {
            return 0.5 * part;
        }
        let end = self.part.sqrt().asin() / PI;
        match part <= 0.5 {
            true => end * (1.0 - (1.0 - 2.0 * part).powi(2)),
            false => end + (0.5 - end) * (2.0 * part - 1.0).powi(2),
        }
    }

    /// Westergaard's pressure at a distance from the crest.
    fn pressure(&self, x: f64) -> f64 {
        let (q, mean) = (self.part, self.part * full());
        if q >= 1.0 {
            return mean + full() * (2.0 * PI * x).cos();
        }
        let inside = q - (PI * x).sin().powi(2);
        if inside > 0.0 { 2.0 * mean * (PI * x).cos() * inside.sqrt() / q } else { 0.0 }
    }

    /// The problem on a mesh, with a name of its surface.
    fn on(&self, mesh: &Mesh<2>, degree: usize, contact: &str) -> Result<Case, Failure> {
        let space = Space::vector(mesh, degree)?;
        let mut constraints = Constraints::new(&space);
        let way = self.way() + GAP;
        constraints.fix("bottom", |_| [0.0, way])?;
        // Half of a wave, between planes of symmetry.
        constraints.fix_component("left", 0, |_| 0.0)?;
        constraints.fix_component("right", 0, |_| 0.0)?;
        let [lambda, mu] = super::lame(1.0, POISSON);
        let data = body::data().lambda(lambda).mu(mu).young(1.0).obstacle_normal([0.0, 1.0]);
        Ok(Case {
            space,
            constraints,
            data: data.obstacle_gap(|x: &[f64; 2]| GAP + WAVE * (1.0 - (2.0 * PI * x[0]).cos())),
            // There is no load.
            loaded: "left".to_owned(),
            cut: None,
            contact: Contact::Obstacle(contact.to_owned()),
            start: None,
            pressure: self.part * full(),
            approach: WAVE,
        })
    }
}

impl Problem for Wavy {
    fn name(&self) -> String {
        if self.part == 0.5 { "wavy".to_owned() } else { format!("wavy_{}", self.part) }
    }

    fn statement(&self) -> &'static str {
        "a flat on a strip with the surface d cos 2πx, E = 1, pressed to a part q of p* = πE*d (Westergaard)"
    }

    fn case(&self, level: usize, degree: usize) -> Result<Case, Failure> {
        let cells = [16 << level, 12 << level];
        let place = |[s, t]: [f64; 2]| [self.place(s), -depth(1.0 - t)];
        let mut mesh = structured(cells, CellShape::Quadrilateral, 1, place)?;
        mesh.name_facets("contact", "top", |_| true)?;
        self.on(&mesh, degree, "contact")
    }

    fn cut_case(&self, level: usize, degree: usize) -> Result<Option<Case>, Failure> {
        let (across, down) = (16 << level, (12 << level) + 1);
        let height = depth(1.0 / down as f64);
        // Rows of nodes above and below the surface, which is at another height of each cell.
        let mesh = structured([across, down], CellShape::Triangle, 1, |[s, t]: [f64; 2]| {
            let depth = depth(1.0 - t);
            let near = (-depth / (4.0 * height)).exp();
            [self.place(s), t * height * (0.5 + 0.4 * near * (29.0 * s).sin()) - depth]
        })?;
        let body = CutBody::of(&mesh, |x| x[1])?;
        let mut case = self.on(&mesh, degree, "all")?;
        body.hold_outside(&mut case.constraints)?;
        Ok(Some(Case { cut: Some(body), ..case }))
    }

    fn exact_pressure(&self, place: [f64; 2], _force: f64) -> Option<f64> {
        Some(self.pressure(place[0]))
    }

    fn quantities(&self, _case: &Case, found: &Outcome) -> Result<Vec<Quantity>, Failure> {
        let most = if self.part < 1.0 { 2.0 * self.part.sqrt() } else { self.part + 1.0 };
        // The largest pressure, by that over the middle eighth of the contact's width.
        let half = if self.part < 1.0 { self.part.sqrt().asin() / PI / 8.0 } else { 1.0 / 16.0 };
        let near = |x: [f64; 2]| x[0].abs() < half;
        let pressed = found.pressures.integral(|x, p| if near(x) { p } else { 0.0 });
        let known = found.pressures.integral(|x, _| if near(x) { self.pressure(x[0]) } else { 0.0 });
        Ok(vec![
            Quantity {
                name: "mean pressure/p*",
                value: 2.0 * found.pressures.force() / full(),
                exact: Some(self.part),
            },
            Quantity { name: "largest pressure/p*", value: most * pressed / known, exact: Some(most) },
        ])
    }
}

//! Quarters of rings, one in the other, on unlike meshes: the pressure between them by Lamé.

use std::f64::consts::FRAC_PI_2;

use forms_fem::mesh::structured;
use forms_fem::output::Failure;
use forms_fem::prelude::*;

use super::grading::crossed;
use crate::body;
use crate::case::{Case, Contact};
use crate::cut_body::CutBody;
use crate::outcome::Outcome;
use crate::problem::{Problem, Quantity};

const POISSON: f64 = 0.3;

/// Rings of radii 1 to 2 and 2 to 3.
pub enum Rings {
    /// The inner wall has the pressure 1.
    Loaded,
    /// The outer ring is smaller by 0.001, and shrunk onto the inner one.
    ShrinkFit,
    /// It is smaller by 0.002.
    TightFit,
}

impl Rings {
    fn pressure(&self) -> f64 {
        match self {
            Rings::Loaded => 0.15625,
            Rings::ShrinkFit | Rings::TightFit => 0.1171875 * self.interference() / (1.0 - POISSON * POISSON),
        }
    }

    /// The length by which the outer ring is too small.
    fn interference(&self) -> f64 {
        match self {
            Rings::Loaded => 0.0,
            Rings::ShrinkFit => 1e-3,
            Rings::TightFit => 2e-3,
        }
    }
}

impl Problem for Rings {
    fn name(&self) -> String {
        match self {
            Rings::Loaded => "lame",
            Rings::ShrinkFit => "shrink_fit",
            Rings::TightFit => "tight_fit",
        }
        .to_owned()
    }

    fn statement(&self) -> &'static str {
        match self {
            Rings::Loaded => {
                "quarter rings 1 to 2 and 2 to 3, 8 and 11 cells around, pressure 1 inside, E = 1; p = 0.15625 (Lamé)"
            }
            Rings::ShrinkFit => {
                "the same rings, the outer one too small by 0.001; p = 1.171875e-4 E/(1 − ν²)"
            }
            Rings::TightFit => "the same rings, the outer one too small by 0.002; p = 2.34375e-4 E/(1 − ν²)",
        }
    }

    fn case(&self, level: usize, degree: usize) -> Result<Case, Failure> {
        let less = self.interference();
        let ring = |from: f64, to: f64, around: usize| {
            let cells = [4 << level, around << level];
            structured(cells, CellShape::Quadrilateral, degree.min(2), |[across, turn]: [f64; 2]| {
                let (radius, angle) = (from + (to - from) * across, FRAC_PI_2 * turn);
                [radius * angle.cos(), radius * angle.sin()]
            })
        };
        let (inner, outer) = (ring(1.0, 2.0, 8)?, ring(2.0 - less, 3.0, 11)?);
        let mesh = Mesh::of_bodies(&[("inner", &inner), ("outer", &outer)])?;
        let space = Space::vector(&mesh, degree)?;
        let mut constraints = Constraints::new(&space);
        for body in ["inner", "outer"] {
            constraints.fix_component(&format!("{body} bottom"), 1, |_| 0.0)?;
            constraints.fix_component(&format!("{body} top"), 0, |_| 0.0)?;
        }
        let [lambda, mu] = super::lame(1.0, POISSON);
        let load = if matches!(self, Rings::Loaded) { 1.0 } else { 0.0 };
        Ok(Case {
            space,
            constraints,
            data: body::data().lambda(lambda).mu(mu).young(1.0).wall_pressure(load),
            loaded: "inner left".to_owned(),
            cut: None,
            contact: Contact::Bodies(["inner right", "outer left"].map(str::to_owned)),
            start: None,
            pressure: self.pressure(),
            approach: if matches!(self, Rings::Loaded) { 1.0 } else { self.interference() },
        })
    }

    /// The inner ring of the loaded ones only: contact pairs need facets. Around it is a rigid wall, as far out as the known solution moves the radius 2.
    /// A shrink fit of one body would be another problem.
    fn cut_case(&self, level: usize, degree: usize) -> Result<Option<Case>, Failure> {
        if !matches!(self, Rings::Loaded) {
            return Ok(None);
        }
        let (rows, around) = ((4 << level) + 1, 8 << level);
        let mesh =
            structured([rows, around], CellShape::Quadrilateral, degree.min(2), |[t, turn]: [f64; 2]| {
                let (radius, angle) = (2.0 + crossed(turn, t, rows), FRAC_PI_2 * turn);
                [radius * angle.cos(), radius * angle.sin()]
            })?;
        let body = CutBody::of(&mesh, |x| x[0].hypot(x[1]) - 2.0)?;
        let space = Space::vector(&mesh, degree)?;
        let mut constraints = Constraints::new(&space);
        constraints.fix_component("bottom", 1, |_| 0.0)?;
        constraints.fix_component("top", 0, |_| 0.0)?;
        body.hold_outside(&mut constraints)?;
        let [lambda, mu] = super::lame(1.0, POISSON);
        let data = body::data().lambda(lambda).mu(mu).young(1.0).wall_pressure(1.0);
        // u_r of the radius 2 between the pressures 1 and p.
        let p = self.pressure();
        let moved = (1.0 + POISSON) / 3.0 * ((1.0 - 2.0 * POISSON) * (1.0 - 4.0 * p) * 2.0 + (1.0 - p) * 2.0);
        let outward = |x: &[f64; 2]| x.map(|coordinate| coordinate / x[0].hypot(x[1]));
        Ok(Some(Case {
            space,
            constraints,
            data: data
                .obstacle_normal(outward)
                .obstacle_gap(move |x: &[f64; 2]| 2.0 + moved - x[0].hypot(x[1])),
            loaded: "left".to_owned(),
            cut: Some(body),
            contact: Contact::Obstacle("all".to_owned()),
            start: None,
            pressure: p,
            approach: 1.0,
        }))
    }

    fn exact_pressure(&self, _place: [f64; 2], _force: f64) -> Option<f64> {
        Some(self.pressure())
    }

    fn along(&self, [x, y]: [f64; 2]) -> f64 {
        y.atan2(x).to_degrees()
    }

    fn quantities(&self, _case: &Case, found: &Outcome) -> Result<Vec<Quantity>, Failure> {
        let value = found.pressures.force() / found.pressures.integral(|_, _| 1.0);
        Ok(vec![Quantity { name: "mean pressure", value, exact: Some(self.pressure()) }])
    }
}

//! A flat rigid punch on a block: the pressure is infinite at its corners.

use std::f64::consts::PI;

use forms_fem::mesh::structured;
use forms_fem::output::Failure;
use forms_fem::prelude::*;

use crate::body;
use crate::case::{Case, Contact};
use crate::outcome::Outcome;
use crate::problem::{Problem, Quantity};

const YOUNG: f64 = 2e5;
const POISSON: f64 = 0.3;
/// Half the width of the punch.
const HALF: f64 = 10.0;
/// Width of half of the block, and its height.
const SIZE: f64 = 200.0;
/// The way of the base toward the punch, after the first gap.
const WAY: f64 = 0.01;
const GAP: f64 = 1e-3;

/// Half of a block of 400 × 200, mm and MPa.
pub enum Punch {
    /// Free out of the plane.
    PlaneStress,
    /// Held out of the plane.
    PlaneStrain,
}

/// Parts of the punch whose forces are asked for.
const PARTS: [f64; 2] = [0.5, 0.8];

/// The distance from the axis at a number of cells of the coarsest mesh, which need not be whole. Parts of the force end at nodes: an integral over points of a facet that a
/// limit cuts is off by the force between two points. Cells are small toward the corner on both of its sides.
fn place(cells: f64) -> f64 {
    let [inner, outer] = PARTS.map(|part| part * HALF);
    match cells {
        ..3.0 => inner * cells / 3.0,
        ..5.0 => inner + (outer - inner) * (cells - 3.0) / 2.0,
        ..8.0 => outer + (HALF - outer) * (1.0 - ((8.0 - cells) / 3.0).powi(3)),
        _ => HALF + (SIZE - HALF) * ((cells - 8.0) / 8.0).powi(4),
    }
}

impl Problem for Punch {
    fn name(&self) -> String {
        match self {
            Punch::PlaneStress => "punch",
            Punch::PlaneStrain => "punch_strain",
        }
        .to_owned()
    }

    fn statement(&self) -> &'static str {
        match self {
            Punch::PlaneStress => {
                "a flat punch, half-width 10, on a block of 400 × 200, plane stress; parts of the force by NGSolve, degree 10"
            }
            Punch::PlaneStrain => "the same punch in plane strain",
        }
    }

    fn case(&self, level: usize, degree: usize) -> Result<Case, Failure> {
        let cells = [16 << level, 10 << level];
        let mut mesh = structured(cells, CellShape::Quadrilateral, 1, |[s, t]: [f64; 2]| {
            [place(16.0 * s), -SIZE * (1.0 - t).powi(4)]
        })?;
        mesh.name_facets("contact", "top", |x| x[0] < HALF)?;
        let space = Space::vector(&mesh, degree)?;
        let mut constraints = Constraints::new(&space);
        constraints.fix_component("left", 0, |_| 0.0)?;
        constraints.fix("bottom", |_| [0.0, WAY + GAP])?;
        let [lambda, mu] = super::lame(YOUNG, POISSON);
        let lambda = match self {
            Punch::PlaneStress => 2.0 * lambda * mu / (lambda + 2.0 * mu),
            Punch::PlaneStrain => lambda,
        };
        let data = body::data().lambda(lambda).mu(mu).young(YOUNG);
        Ok(Case {
            space,
            constraints,
            data: data.obstacle_normal([0.0, 1.0]).obstacle_gap(GAP),
            // There is no load.
            loaded: "right".to_owned(),
            cut: None,
            contact: Contact::Obstacle("contact".to_owned()),
            start: None,
            pressure: 0.3 * YOUNG * WAY / HALF,
            approach: WAY,
        })
    }

    fn exact_pressure(&self, place: [f64; 2], force: f64) -> Option<f64> {
        // Of a half-plane.
        Some(2.0 * force / (PI * (HALF * HALF - place[0] * place[0]).sqrt()))
    }

    fn quantities(&self, _case: &Case, found: &Outcome) -> Result<Vec<Quantity>, Failure> {
        let force = found.pressures.force();
        // By NGSolve, degree 10.
        let known = match self {
            Punch::PlaneStress => [0.33381, 0.59087, 0.48256],
            Punch::PlaneStrain => [0.33386, 0.59092, 0.53858],
        };
        let within = |part: f64| {
            let inside = found.pressures.integral(|x, p| if x[0] < part * HALF { p } else { 0.0 });
            inside / force
        };
        Ok(vec![
            Quantity { name: "part of F within a/2", value: within(PARTS[0]), exact: Some(known[0]) },
            Quantity { name: "part of F within 0.8 a", value: within(PARTS[1]), exact: Some(known[1]) },
            Quantity { name: "F/(E way)", value: 2.0 * force / (YOUNG * WAY), exact: Some(known[2]) },
        ])
    }
}

//! A rigid parabola that is put down at places one after the other over a cell of a layer: its force should not depend on the place.

use forms_fem::output::Failure;
use forms_fem::prelude::*;

use crate::body;
use crate::case::{Case, Contact};
use crate::outcome::Outcome;
use crate::problem::{Problem, Quantity};

const POISSON: f64 = 0.3;
/// The way of the base toward the parabola, after the first gap.
const WAY: f64 = 0.02;
const GAP: f64 = 1e-4;
/// Places over one cell.
const PLACES: usize = 10;

/// A layer of thickness 1 and length 8.
pub struct SlidingParabola;

fn case_at(place: usize, level: usize, degree: usize) -> Result<Case, Failure> {
    let per_unit = 4 << level;
    let s = place as f64 / (PLACES * per_unit) as f64;
    let mut mesh = rectangle([-4.0, 0.0], [4.0, 1.0], [8 * per_unit, per_unit], CellShape::Quadrilateral, 1)?;
    mesh.name_facets("contact", "top", |x| x[0].abs() < 1.0)?;
    let space = Space::vector(&mesh, degree)?;
    let mut constraints = Constraints::new(&space);
    constraints.fix("bottom", |_| [0.0, WAY + GAP])?;
    let [lambda, mu] = super::lame(1.0, POISSON);
    let data = body::data().lambda(lambda).mu(mu).young(1.0).obstacle_normal([0.0, 1.0]);
    Ok(Case {
        space,
        constraints,
        data: data.obstacle_gap(move |x: &[f64; 2]| GAP + 0.5 * (x[0] - s).powi(2)),
        // There is no load.
        loaded: "left".to_owned(),
        cut: None,
        contact: Contact::Obstacle("contact".to_owned()),
        start: None,
        pressure: 0.1,
        approach: WAY,
    })
}

impl Problem for SlidingParabola {
    fn name(&self) -> String {
        "sliding_parabola".to_owned()
    }

    fn statement(&self) -> &'static str {
        "a rigid parabola x²/2 pressed 0.02 into a layer of 8 × 1 at 11 places over one cell, E = 1; the force 0.01234 at all places"
    }

    fn case(&self, level: usize, degree: usize) -> Result<Case, Failure> {
        case_at(0, level, degree)
    }

    fn further_cases(&self, level: usize, degree: usize) -> Result<Vec<Case>, Failure> {
        (1..=PLACES).map(|place| case_at(place, level, degree)).collect()
    }

    fn quantities_of_all(&self, found: &[Outcome]) -> Result<Vec<Quantity>, Failure> {
        let forces = found.iter().map(|found| found.forces.iter().skip(1).step_by(2).sum::<f64>().abs());
        let forces: Vec<f64> = forces.collect();
        let mean = forces.iter().sum::<f64>() / forces.len() as f64;
        let most = forces.iter().copied().fold(0.0, f64::max);
        let least = forces.iter().copied().fold(f64::INFINITY, f64::min);
        Ok(vec![
            Quantity { name: "mean force", value: mean, exact: Some(0.01234) },
            Quantity { name: "(max − min)/mean", value: (most - least) / mean, exact: Some(0.0) },
        ])
    }
}

//! Two unlike meshes of one square on another: a uniform pressure. The bodies are apart by a small gap at first.

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
/// The gap that the upper body falls.
const GAP: f64 = 1e-3;

/// −u_y of the place between the squares, (1 − ν²)/E.
fn sunk() -> f64 {
    1.0 - POISSON * POISSON
}

/// Lower \[0,1\]², upper above it, pressed by 1.
pub struct Patch;

impl Problem for Patch {
    fn name(&self) -> String {
        "patch".to_owned()
    }

    fn statement(&self) -> &'static str {
        "one square pressed on another, E = 1, meshes 5 : 7; the pressure is 1 everywhere"
    }

    fn case(&self, level: usize, degree: usize) -> Result<Case, Failure> {
        let squares = |low: f64, cells: usize| {
            let cells = cells << level;
            rectangle([0.0, low], [1.0, low + 1.0], [cells; 2], CellShape::Quadrilateral, 1)
        };
        let (lower, upper) = (squares(0.0, 7)?, squares(1.0 + GAP, 5)?);
        let mesh = Mesh::of_bodies(&[("lower", &lower), ("upper", &upper)])?;
        let space = Space::vector(&mesh, degree)?;
        let mut constraints = Constraints::new(&space);
        constraints.fix_component("lower bottom", 1, |_| 0.0)?;
        constraints.fix_component("lower left", 0, |_| 0.0)?;
        constraints.fix_component("upper left", 0, |_| 0.0)?;
        let [lambda, mu] = super::lame(1.0, POISSON);
        // Nothing but contact holds the upper body, so that it begins in contact.
        let fallen = |x: &[f64; 2]| [0.0, if x[1] > 1.0 + 0.5 * GAP { -1.5 * GAP } else { 0.0 }];
        Ok(Case {
            start: Some(Field::interpolate(&space, fallen)?),
            space,
            constraints,
            data: body::data().lambda(lambda).mu(mu).young(1.0).traction([0.0, -1.0]),
            loaded: "upper top".to_owned(),
            cut: None,
            contact: Contact::Bodies(["lower top", "upper bottom"].map(str::to_owned)),
            pressure: 1.0,
            approach: 1.0,
        })
    }

    /// The lower square only: contact pairs need facets. It is pressed by a flat that moves as the known solution between the squares does.
    fn cut_case(&self, level: usize, degree: usize) -> Result<Option<Case>, Failure> {
        let (across, rows) = (7 << level, (7 << level) + 1);
        let place = |[s, t]: [f64; 2]| [s, 1.0 + crossed(s, t, rows)];
        let mesh = structured([across, rows], CellShape::Triangle, 1, place)?;
        let body = CutBody::of(&mesh, |x| x[1] - 1.0)?;
        let space = Space::vector(&mesh, degree)?;
        let mut constraints = Constraints::new(&space);
        constraints.fix_component("bottom", 1, |_| sunk() + GAP)?;
        constraints.fix_component("left", 0, |_| 0.0)?;
        body.hold_outside(&mut constraints)?;
        let [lambda, mu] = super::lame(1.0, POISSON);
        let data = body::data().lambda(lambda).mu(mu).young(1.0);
        Ok(Some(Case {
            space,
            constraints,
            data: data.obstacle_normal([0.0, 1.0]).obstacle_gap(GAP),
            // There is no load.
            loaded: "bottom".to_owned(),
            cut: Some(body),
            contact: Contact::Obstacle("all".to_owned()),
            start: None,
            pressure: 1.0,
            approach: 1.0,
        }))
    }

    fn exact_pressure(&self, _place: [f64; 2], _force: f64) -> Option<f64> {
        Some(1.0)
    }

    fn quantities(&self, case: &Case, found: &Outcome) -> Result<Vec<Quantity>, Failure> {
        let name = "u_y of the top";
        if case.cut.is_some() {
            return Ok(vec![Quantity { name, value: f64::NAN, exact: None }]);
        }
        // u_y = −(1 − ν²) y/E, and the fall.
        let value = found.u.evaluate(&[0.5, 2.0 + GAP])?[1];
        Ok(vec![Quantity { name, value, exact: Some(-2.0 * sunk() - GAP) }])
    }
}

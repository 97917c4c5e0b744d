//! Two unlike meshes of one square on another: a uniform pressure. The bodies are apart by a small gap at first.

use forms_fem::output::Failure;
use forms_fem::prelude::*;

use crate::body;
use crate::case::{Case, Contact};
use crate::outcome::Outcome;
use crate::problem::{Problem, Quantity};

const POISSON: f64 = 0.3;
/// The gap that the upper body falls.
const GAP: f64 = 1e-3;

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

    fn exact_pressure(&self, _place: [f64; 2], _force: f64) -> Option<f64> {
        Some(1.0)
    }

    fn quantities(&self, _case: &Case, found: &Outcome) -> Result<Vec<Quantity>, Failure> {
        // u_y = −(1 − ν²) y/E, and the fall.
        let exact = -2.0 * (1.0 - POISSON * POISSON) - GAP;
        let value = found.u.evaluate(&[0.5, 2.0 + GAP])?[1];
        Ok(vec![Quantity { name: "u_y of the top", value, exact: Some(exact) }])
    }
}

//! A half ball on a plane, its flat side pushed down: Signorini's problem with axial symmetry in (r, z).

use forms_fem::mesh::disc;
use forms_fem::output::Failure;
use forms_fem::prelude::*;

use crate::body;
use crate::case::{Case, Contact};
use crate::cut_body::CutBody;
use crate::outcome::Outcome;
use crate::problem::{Problem, Quantity};

const YOUNG: f64 = 2e4;
const RADIUS: f64 = 0.4;
/// Height of the centre above the plane.
const CENTRE: f64 = 0.5;
const WAY: f64 = 0.15;

/// Half of a ball of radius 0.4 about z = 0.5, round side down.
pub struct HalfBall;

impl HalfBall {
    /// The problem on a mesh, with the names of the flat side, the axis and the surface.
    fn on(mesh: &Mesh<2>, degree: usize, [flat, axis]: [&str; 2], contact: &str) -> Result<Case, Failure> {
        let space = Space::vector(mesh, degree)?;
        let mut constraints = Constraints::new(&space);
        constraints.fix(flat, |_| [0.0, -WAY])?;
        constraints.fix_component(axis, 0, |_| 0.0)?;
        let [lambda, mu] = super::lame(YOUNG, 0.3);
        let data = body::data().lambda(lambda).mu(mu).young(YOUNG).axial(1.0);
        Ok(Case {
            space,
            constraints,
            data: data.obstacle_normal([0.0, -1.0]).obstacle_gap(|x: &[f64; 2]| x[1]),
            // There is no load.
            loaded: flat.to_owned(),
            cut: None,
            contact: Contact::Obstacle(contact.to_owned()),
            start: None,
            pressure: 4000.0,
            approach: 0.05,
        })
    }
}

impl Problem for HalfBall {
    fn name(&self) -> String {
        "half_ball".to_owned()
    }

    fn statement(&self) -> &'static str {
        "a half ball of radius 0.4, E = 2e4, pushed 0.15 onto a plane 0.1 below it; NGSolve in (r, z), degree 4"
    }

    fn case(&self, level: usize, degree: usize) -> Result<Case, Failure> {
        let core = 4 << level;
        // A quarter disc with x, y ≥ 0, turned by a right angle.
        let quarter = disc(RADIUS, [true; 2], core, core, CellShape::Quadrilateral, 2)?;
        let turned = quarter.nodes().iter().map(|[x, y]| [*y, CENTRE - x]).collect();
        let mut mesh = quarter.with_nodes(turned)?;
        mesh.name_facets("contact", "circle", |x| x[0] < 0.75 * RADIUS)?;
        Self::on(&mesh, degree, ["left", "bottom"], "contact")
    }

    fn cut_case(&self, level: usize, degree: usize) -> Result<Option<Case>, Failure> {
        let (cells, size) = (9 << level, 1.1 * RADIUS);
        let mesh = rectangle([0.0, CENTRE - size], [size, CENTRE], [cells; 2], CellShape::Quadrilateral, 1)?;
        let body = CutBody::of(&mesh, |x| x[0].hypot(x[1] - CENTRE) - RADIUS)?;
        let mut case = Self::on(&mesh, degree, ["top", "left"], "all")?;
        body.hold_outside(&mut case.constraints)?;
        Ok(Some(Case { cut: Some(body), ..case }))
    }

    fn quantities(&self, case: &Case, found: &Outcome) -> Result<Vec<Quantity>, Failure> {
        let nodes = found.forces.iter().skip(1).step_by(2);
        let energy = case.energy(&found.u)?;
        // The outermost point that presses.
        let pressed = found.pressures.positions.iter().zip(&found.pressures.values);
        let threshold = 1e-3 * found.pressures.peak();
        let radius = pressed.filter(|(_, p)| **p > threshold).fold(0.0, |most: f64, (x, _)| most.max(x[0]));
        Ok(vec![
            Quantity { name: "reaction", value: nodes.sum(), exact: Some(277.4) },
            Quantity { name: "energy", value: energy, exact: Some(5.274) },
            Quantity { name: "contact radius", value: radius, exact: Some(0.150) },
        ])
    }
}

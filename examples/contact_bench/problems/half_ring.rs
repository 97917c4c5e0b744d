//! Half a ring of rubber, ν = 0.4995, on a rigid flat that comes from below.

use std::f64::consts::PI;

use forms_fem::mesh::structured;
use forms_fem::output::Failure;
use forms_fem::prelude::*;

use crate::formulation::Formulation;
use crate::outcome::Refusal;
use crate::posed::Posed;
use crate::problem::Quantity;
use crate::rows::{Answer, Measured};
use crate::rubber::{self, Pressed, Rubber};

/// Radii \[mm\].
const INSIDE: f64 = 20.0;
const OUTSIDE: f64 = 40.0;
/// E \[MPa\] and ν.
const YOUNG: f64 = 1.4;
const POISSON: f64 = 0.4995;
/// The last way of the flat \[mm\], and the force for which its way is looked for \[N/mm\].
const END: usize = 10;
const FORCE: f64 = 5.0;

/// Elements of degree 1 and 2 that are stable.
pub enum HalfRing {
    /// The mean dilatation Q1/P0, and Q2/P₋₁.
    Quadrilaterals,
    /// MINI, and P2/P1.
    Triangles,
}

impl HalfRing {
    fn rubber(&self, level: usize, degree: usize) -> Result<Rubber, Failure> {
        let shape = match self {
            HalfRing::Quadrilaterals => CellShape::Quadrilateral,
            HalfRing::Triangles => CellShape::Triangle,
        };
        // The right half, whose mirror is at x = 0: "bottom" is the outer arc, "top" the inner one. As many nodes for both degrees.
        let along = (if degree == 1 { 16 } else { 8 }) << level;
        let mesh = structured([along, along / 4], shape, 2, |[s, t]: [f64; 2]| {
            let (angle, radius) = (PI / 2.0 * (s - 1.0), OUTSIDE - t * (OUTSIDE - INSIDE));
            [radius * angle.cos(), radius * angle.sin()]
        })?;
        let (displacements, pressures) = match (self, degree) {
            (HalfRing::Quadrilaterals, 1) => (Elements::Lagrange(1), (Elements::Lagrange(0), Scope::Cell)),
            (HalfRing::Quadrilaterals, _) => (Elements::Lagrange(2), (Elements::LinearInSpace, Scope::Cell)),
            (HalfRing::Triangles, 1) => (Elements::Mini(1), (Elements::Lagrange(1), Scope::Nodes)),
            (HalfRing::Triangles, _) => (Elements::Lagrange(2), (Elements::Lagrange(1), Scope::Nodes)),
        };
        let displacements = Space::of(&mesh, displacements, Scope::Nodes, &[2])?;
        let pressures = Space::of(&mesh, pressures.0, pressures.1, &[])?;
        let (mu, bulk) = (YOUNG / (2.0 * (1.0 + POISSON)), YOUNG / (3.0 * (1.0 - 2.0 * POISSON)));
        let distance = |x: &[f64; 2]| x[1] + OUTSIDE;
        Ok(Rubber {
            spaces: [displacements, pressures],
            held: "top",
            mirror: "left",
            touching: "bottom",
            data: rubber::data().mu(mu).bulk_modulus(bulk).obstacle_normal([0.0, -1.0]).flat(distance),
            distance,
            end: END,
            force: FORCE,
            pressure: 0.5,
            copies: 2.0,
        })
    }
}

fn quantities(pressed: &Pressed) -> Vec<Quantity> {
    let force = |way: usize| pressed.forces.get(way - 1).copied().unwrap_or(f64::NAN);
    let [way, growth] = pressed.at_force.unwrap_or([f64::NAN; 2]);
    vec![
        Quantity { name: "F(2)", value: force(2), exact: Some(4.589) },
        Quantity { name: "F(5)", value: force(5), exact: Some(19.28) },
        Quantity { name: "F(10)", value: force(10), exact: Some(65.7) },
        Quantity { name: "δ at F = 5", value: way, exact: Some(2.1183) },
        Quantity { name: "∫(J − 1) there", value: growth, exact: Some(-0.1342) },
    ]
}

impl Posed for HalfRing {
    fn name(&self) -> String {
        match self {
            HalfRing::Quadrilaterals => "half_ring",
            HalfRing::Triangles => "half_ring_triangles",
        }
        .to_owned()
    }

    fn statement(&self) -> &'static str {
        match self {
            HalfRing::Quadrilaterals => {
                "half a ring of rubber, ν = 0.4995, on a flat that moves by 10 mm: mean dilatation Q1, Q2/P₋₁; F(2) = 4.589 ± 0.001 (felupe, NGSolve)"
            }
            HalfRing::Triangles => "the same half ring by MINI and P2/P1",
        }
    }

    fn answer(
        &self,
        formulation: &dyn Formulation,
        level: usize,
        degree: usize,
    ) -> Result<(usize, Answer), Failure> {
        let rubber = self.rubber(level, degree)?;
        let solve = || {
            let pressed = formulation.press(&rubber)?;
            match &pressed.failure {
                Some(why) => Err(Refusal::Failed(why.clone())),
                None => Ok(pressed),
            }
        };
        let measure = |pressed: Pressed, seconds| {
            Ok(Measured {
                seconds,
                no_gradient: Some("the flat has no unknowns".to_owned()),
                penetration: pressed.penetration / END as f64,
                quantities: quantities(&pressed),
                ..Measured::of_newton(pressed.newton.iter().copied())
            })
        };
        let answer = Answer::timed(solve, measure)?;
        Ok((rubber.spaces[0].unknowns(), answer))
    }
}

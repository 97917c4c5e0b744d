//! A membrane on the unit disc over a round obstacle: contact in the volume, in closed form.

use std::f64::consts::PI;

use forms_fem::mesh::disc;
use forms_fem::output::Failure;
use forms_fem::prelude::*;

use crate::cut_body::CutBody;
use crate::formulation::{Formulation, Meshing};
use crate::membrane::{Membrane, volume};
use crate::outcome::Outcome;
use crate::posed::Posed;
use crate::problem::Quantity;
use crate::rows::{Answer, Measured};

/// The contact radius, and the slope A of u = A ln r outside of it.
const REACH: f64 = 0.348_982_574_111_686;
const SLOPE: f64 = -0.340_129_705_945_858;
const ENERGY: f64 = 0.453_542_954_841;
/// Half of the force per area in the middle, which is the least one where the membrane touches.
const TOUCHING: f64 = 2.0;
/// The obstacle is a half circle up to this radius, and its tangent cone beyond.
const KINK: f64 = 0.45;

/// φ.
fn below(r: f64) -> f64 {
    let top = |r: f64| (0.25 - r * r).sqrt();
    if r <= KINK { top(r) } else { top(KINK) - KINK / top(KINK) * (r - KINK) }
}

fn exact(r: f64) -> f64 {
    if r <= REACH { below(r) } else { SLOPE * r.ln() }
}

fn exact_slope(x: &[f64; 2]) -> [f64; 2] {
    let r = x[0].hypot(x[1]);
    let part = if r <= REACH { -1.0 / (0.25 - r * r).sqrt() } else { SLOPE / (r * r) };
    [part * x[0], part * x[1]]
}

/// −Δφ where the membrane touches.
fn force(r: f64) -> f64 {
    let top = 0.25 - r * r;
    if r <= REACH { (0.5 - r * r) / top.powf(1.5) } else { 0.0 }
}

/// The whole disc: 80 cells on the first mesh, as in MFEM's example 36 after two refinements.
pub struct Obstacle;

impl Obstacle {
    fn membrane(level: usize, degree: usize) -> Result<Membrane, Failure> {
        let mesh = disc(1.0, [false; 2], 2 << level, 4 << level, CellShape::Quadrilateral, degree.min(2))?;
        let space = Space::scalar(&mesh, degree)?;
        let mut constraints = Constraints::new(&space);
        constraints.fix("circle", |_| 0.0)?;
        Self::on(space, constraints, None)
    }

    /// The disc as a cut body of a square.
    fn cut_membrane(level: usize, degree: usize) -> Result<Membrane, Failure> {
        let mesh = rectangle([-1.1; 2], [1.1; 2], [9 << level; 2], CellShape::Quadrilateral, 1)?;
        let space = Space::scalar(&mesh, degree)?;
        let mut constraints = Constraints::new(&space);
        let cut = CutBody::of(&mesh, |x| x[0].hypot(x[1]) - 1.0)?;
        cut.hold_outside(&mut constraints)?;
        Self::on(space, constraints, Some(cut))
    }

    fn on(
        space: Arc<Space<2>>,
        constraints: Constraints<2>,
        cut: Option<CutBody>,
    ) -> Result<Membrane, Failure> {
        Ok(Membrane {
            below: Field::interpolate(&space, |x| below(x[0].hypot(x[1])))?,
            above: Field::interpolate(&space, |x| 1.0 - x[0] * x[0] - x[1] * x[1])?,
            constraints,
            cut,
            data: volume::data().obstacle(|x: &[f64; 2]| below(x[0].hypot(x[1]))),
            space,
            pressure: 4.0,
            approach: 0.1,
        })
    }

    fn least_height(membrane: &Membrane, found: &Outcome) -> Result<f64, Failure> {
        membrane.least_height(&found.u).map_err(|why| Failure::from(why.to_string()))
    }

    fn quantities(membrane: &Membrane, found: &Outcome) -> Result<Vec<Quantity>, Failure> {
        let assembler = membrane.assembler().with_quadrature(Quadrature::Degree(10));
        let off = norms::errors(
            &assembler,
            &found.u,
            |x, value| value[0] = exact(x[0].hypot(x[1])),
            |x, slope| slope.copy_from_slice(&exact_slope(x)),
        )?;
        let energy = assembler.functional(&volume::energy(&membrane.data, &membrane.omega(), &found.u))?;
        let force = found.pressures.force();
        let touching = found.pressures.integral(|_, pressure| f64::from(pressure > TOUCHING));
        let radius = (touching / PI).sqrt();
        let known = |name, value, exact| Quantity { name, value, exact: Some(exact) };
        Ok(vec![
            Quantity { name: "H1 error", value: off.h1, exact: None },
            Quantity { name: "L2 error", value: off.l2, exact: None },
            known("energy", energy, ENERGY),
            known("force", force, -2.0 * PI * SLOPE),
            known("contact radius", radius, REACH),
            Quantity { name: "min(u − φ)", value: Self::least_height(membrane, found)?, exact: None },
        ])
    }
}

impl Posed for Obstacle {
    fn name(&self) -> String {
        "obstacle".to_owned()
    }

    fn statement(&self) -> &'static str {
        "a membrane on the unit disc over φ = √(¼ − r²), beyond r = 0.45 its tangent cone; u = A ln r outside of r = 0.349"
    }

    fn answer(
        &self,
        formulation: &dyn Formulation,
        level: usize,
        degree: usize,
    ) -> Result<(usize, Answer), Failure> {
        let membrane = match formulation.meshing() {
            Meshing::Fitted => Self::membrane(level, degree)?,
            Meshing::Cut => Self::cut_membrane(level, degree)?,
        };
        let measure = |found: Outcome, seconds| {
            let measured = Measured {
                seconds,
                no_gradient: Some("no way".to_owned()),
                penetration: (-Self::least_height(&membrane, &found)?).max(0.0) / membrane.approach,
                quantities: Self::quantities(&membrane, &found)?,
                ..Measured::of(&found)
            };
            let radius = |x: [f64; 2]| x[0].hypot(x[1]);
            Ok(measured.compared(&found.pressures, radius, |x| Some(force(radius(x)))))
        };
        let answer = Answer::timed(|| formulation.cover(&membrane), measure)?;
        Ok((membrane.space.unknowns(), answer))
    }
}

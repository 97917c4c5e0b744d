//! A bar that falls onto a rigid stop, by implicit schemes whose steps are problems of contact (Doyen, Ern and Piperno 2011).
//!
//! Each scheme here balances forces at one displacement w of the step, c ρ (w − w₀) + A w = f with known c and w₀, so that each formulation of static
//! contact solves it.

use forms_fem::output::Failure;
use forms_fem::prelude::*;
use forms_fem::time::redistributed_mass;

use crate::body;
use crate::case::{Case, Contact};
use crate::formulation::Formulation;
use crate::outcome::{Pressures, Refusal};
use crate::posed::Posed;
use crate::problem::Quantity;
use crate::rows::{Answer, Measured};

const LENGTH: f64 = 10.0;
const YOUNG: f64 = 900.0;
const DENSITY: f64 = 1.0;
const GRAVITY: f64 = 10.0;
/// The height from which it falls.
const HEIGHT: f64 = 5.0;
const WAVE_SPEED: f64 = 30.0;
/// m g times the height, per width.
const ENERGY: f64 = 500.0;
/// Touch, release and the end.
const TIMES: [f64; 3] = [1.0, 5.0 / 3.0, 3.0];

/// A scheme whose steps are problems of contact.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Scheme {
    /// The trapezoidal rule, Newmark's with β = ¼ and γ = ½.
    Trapezoidal,
    /// The same with no mass at the end that hits.
    Massless,
    /// The mid-point rule: contact is in the middle of the step.
    MidPoint,
    /// Backward differences of order 2.
    Backward,
}

/// All schemes.
pub const SCHEMES: [Scheme; 4] = [Scheme::Trapezoidal, Scheme::Massless, Scheme::MidPoint, Scheme::Backward];

/// A bar by a scheme.
pub struct Bar {
    /// The scheme.
    pub scheme: Scheme,
    /// Cells that a wave passes in a step.
    pub courant: f64,
}

/// Displacement, velocity and acceleration of all unknowns, and the first two of the step before.
struct Motion {
    u: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    before: [Vec<f64>; 2],
}

impl Scheme {
    /// c of a step.
    fn factor(self, step: f64) -> f64 {
        let of = if self == Scheme::Backward { 2.25 } else { 4.0 };
        of / (step * step)
    }

    /// w₀ of an unknown.
    fn coasted(self, motion: &Motion, k: usize, step: f64) -> f64 {
        let (u, v, a) = (motion.u[k], motion.v[k], motion.a[k]);
        let [u_before, v_before] = [motion.before[0][k], motion.before[1][k]];
        match self {
            Scheme::Trapezoidal | Scheme::Massless => u + step * v + 0.25 * step * step * a,
            Scheme::MidPoint => u + 0.5 * step * v,
            Scheme::Backward => (4.0 * u - u_before) / 3.0 + step * 2.0 / 9.0 * (4.0 * v - v_before),
        }
    }

    /// The end of a step with this w, and c (w − w₀), the acceleration there.
    fn end(self, motion: Motion, w: &[f64], a: Vec<f64>, step: f64) -> Motion {
        let all = 0..w.len();
        let v = match self {
            Scheme::Trapezoidal | Scheme::Massless => {
                all.map(|k| motion.v[k] + 0.5 * step * (motion.a[k] + a[k])).collect()
            }
            Scheme::MidPoint => all.map(|k| 4.0 * (w[k] - motion.u[k]) / step - motion.v[k]).collect(),
            Scheme::Backward => {
                all.map(|k| (3.0 * w[k] - 4.0 * motion.u[k] + motion.before[0][k]) / (2.0 * step)).collect()
            }
        };
        let u = match self {
            Scheme::MidPoint => w.iter().zip(&motion.u).map(|(w, u)| 2.0 * w - u).collect(),
            _ => w.to_vec(),
        };
        Motion { u, v, a, before: [motion.u, motion.v] }
    }

    /// The part of the step at whose end forces are balanced.
    fn place(self) -> f64 {
        if self == Scheme::MidPoint { 0.5 } else { 1.0 }
    }
}

/// What was seen on the way.
#[derive(Default)]
struct Course {
    newton: Vec<usize>,
    outer: Option<usize>,
    /// Forces over time, per width.
    forces: Pressures,
    /// The place of the end that hits, after each step.
    places: Vec<[f64; 2]>,
    energy_change: f64,
    penetration: f64,
}

impl Bar {
    fn cells(level: usize) -> usize {
        20 << level
    }

    fn case(&self, level: usize, degree: usize) -> Result<Case, Failure> {
        let cells = Self::cells(level);
        let width = LENGTH / cells as f64;
        let mesh = rectangle([0.0; 2], [width, LENGTH], [1, cells], CellShape::Quadrilateral, 1)?;
        let space = Space::vector(&mesh, degree)?;
        let mut constraints = Constraints::new(&space);
        for side in ["left", "right"] {
            constraints.fix_component(side, 0, |_| 0.0)?;
        }
        let data = body::data().lambda(0.0).mu(0.5 * YOUNG).young(YOUNG).obstacle_normal([0.0, -1.0]);
        let data = data.body_force([0.0, -DENSITY * GRAVITY]);
        Ok(Case {
            space,
            constraints,
            data: data.obstacle_gap(|x: &[f64; 2]| HEIGHT + x[1]),
            loaded: "left".to_owned(),
            cut: None,
            contact: Contact::Obstacle("bottom".to_owned()),
            start: None,
            pressure: 300.0,
            // The change of length under the first pressure.
            approach: LENGTH / 3.0,
        })
    }

    fn density(&self, case: &Case) -> Result<Field<2>, Refusal> {
        let cells = Space::discontinuous_scalar(case.mesh(), 0)?;
        let even = Field::interpolate(&cells, |_| DENSITY)?;
        match self.scheme {
            Scheme::Massless => Ok(redistributed_mass(&even, case.own(), &case.assembler())?),
            _ => Ok(even),
        }
    }

    fn follow(&self, formulation: &dyn Formulation, case: &Case) -> Result<Course, Refusal> {
        let (scheme, count) = (self.scheme, case.space.unknowns());
        let width = LENGTH / (case.mesh().cell_count() as f64);
        let step = self.courant * width / WAVE_SPEED;
        let density = self.density(case)?;
        let factor = scheme.factor(step);
        let scaled = density.values().iter().map(|rho| factor * rho).collect();
        let inertia = Field::from_values(density.space(), scaled)?;
        let along = |of: f64| (0..count).map(|k| if k % 2 == 1 { of } else { 0.0 }).collect::<Vec<f64>>();
        let before = [along(-0.5 * GRAVITY * step * step), along(GRAVITY * step)];
        let mut motion = Motion { u: along(0.0), v: along(0.0), a: along(-GRAVITY), before };
        let mut course = Course::default();
        for index in 0..(TIMES[2] / step).round() as usize {
            let time = (index as f64 + scheme.place()) * step;
            let coasted: Vec<f64> = (0..count).map(|k| scheme.coasted(&motion, k, step)).collect();
            let data = case.data.clone().inertia(&inertia);
            let data = data.coasted(&Field::from_values(&case.space, coasted.clone())?);
            let start = Some(Field::from_values(&case.space, motion.u.clone())?);
            let taken = Case { data, start, ..case.clone() };
            let failed = |why| match why {
                Refusal::Failed(why) => Refusal::Failed(format!("at t = {time:.3}: {why}")),
                other => other,
            };
            let found = formulation.solve(&taken).map_err(failed)?;
            let w = found.u.values();
            let a = w.iter().zip(&coasted).map(|(w, coasted)| factor * (w - coasted)).collect();
            motion = scheme.end(motion, w, a, step);
            course.newton.push(found.newton.iter().sum());
            course.outer = found.outer.map(|outer| outer + course.outer.unwrap_or(0)).or(course.outer);
            course.forces.positions.push([time, 0.0]);
            course.forces.weights.push(step);
            course.forces.values.push(found.forces.iter().skip(1).step_by(2).sum::<f64>() / width);
            let [u, v] = [&motion.u, &motion.v].map(|all| Field::from_values(&case.space, all.clone()));
            let (u, v) = (u?, v?);
            course.places.push([(index as f64 + 1.0) * step, HEIGHT + u.evaluate(&[0.5 * width, 0.0])?[1]]);
            course.penetration = course.penetration.max(case.penetration(&found.u)?);
            let at_rest = case.data.clone().inertia(&density);
            let of_motion = case.assembler().functional(&body::kinetic(&at_rest, &case.bodies(), &v))?;
            let work =
                case.assembler().functional(&body::work_of_body_force(&case.data, &case.bodies(), &u))?;
            let change = (of_motion + case.energy(&u)? - work) / (width * ENERGY);
            course.energy_change =
                if change.abs() > course.energy_change.abs() { change } else { course.energy_change };
        }
        Ok(course)
    }
}

/// The exact pressure over time.
fn pressure(time: f64) -> f64 {
    if time > TIMES[0] && time < TIMES[1] { 30.0 * (10.0 + 10.0 * (time - 1.0)) } else { 0.0 }
}

fn quantities(course: &Course) -> Vec<Quantity> {
    let place = |time: f64| {
        let nearest = course.places.iter().min_by(|a, b| (a[0] - time).abs().total_cmp(&(b[0] - time).abs()));
        nearest.map_or(f64::NAN, |place| place[1])
    };
    let settled = |x: [f64; 2], p: f64| if (1.1..1.6).contains(&x[0]) { p - pressure(x[0]) } else { 0.0 };
    let worst = course.forces.positions.iter().zip(&course.forces.values);
    let worst = worst.fold(0.0, |most: f64, (x, p)| most.max(settled(*x, *p).abs()));
    vec![
        Quantity { name: "impulse", value: course.forces.force(), exact: Some(800.0 / 3.0) },
        Quantity { name: "end at t = 2", value: place(2.0), exact: Some(5.0 / 3.0) },
        Quantity { name: "end at t = 7/3", value: place(7.0 / 3.0), exact: Some(40.0 / 9.0) },
        Quantity { name: "end at t = 3", value: place(3.0), exact: Some(40.0 / 9.0) },
        Quantity { name: "change of the energy/500", value: course.energy_change, exact: Some(0.0) },
        Quantity { name: "worst error of p for 1.1 < t < 1.6", value: worst, exact: Some(0.0) },
    ]
}

impl Posed for Bar {
    fn name(&self) -> String {
        let scheme = match self.scheme {
            Scheme::Trapezoidal => "trapezoidal",
            Scheme::Massless => "massless",
            Scheme::MidPoint => "mid_point",
            Scheme::Backward => "backward",
        };
        let of = if self.courant == 1.0 { String::new() } else { format!("_{}", self.courant) };
        format!("bar_{scheme}{of}")
    }

    fn statement(&self) -> &'static str {
        match self.scheme {
            Scheme::Trapezoidal => {
                "a bar that falls 5 onto a stop, 20 cells on the coarsest mesh, trapezoidal rule; p = 300 t for 1 < t < 5/3; errors of p are over time"
            }
            Scheme::Massless => "the same bar with no mass at the end that hits",
            Scheme::MidPoint => "the same bar by the mid-point rule, with contact in the middle of a step",
            Scheme::Backward => "the same bar by backward differences of order 2",
        }
    }

    fn answer(
        &self,
        formulation: &dyn Formulation,
        level: usize,
        degree: usize,
    ) -> Result<(usize, Answer), Failure> {
        let case = self.case(level, degree)?;
        let measure = |course: Course, seconds| {
            let measured = Measured {
                seconds,
                outer: course.outer,
                no_gradient: Some("no way".to_owned()),
                penetration: course.penetration / case.approach,
                quantities: quantities(&course),
                ..Measured::of_newton(course.newton.iter().copied())
            };
            Ok(measured.compared(&course.forces, |x| x[0], |x| Some(pressure(x[0]))))
        };
        let answer = Answer::timed(|| self.follow(formulation, &case), measure)?;
        Ok((case.space.unknowns(), answer))
    }
}

//! Two elastic bodies of one material that touch near the origin as half-spaces do: cylinders and balls that are pressed (Hertz
//! 1882) and then drawn along with friction (Cattaneo 1938, Mindlin 1949).
//!
//! E = 200 MPa, ν = 0.3. The bodies are cut out of half-spaces, y < 0 and y > 0: the cut has the displacement of a
//! half-space under the force of contact, so that blocks a few times as wide as the contact have the answer of bodies without an
//! end. Their surfaces are paraboloids, exactly, where they may touch; further out they return to the plane, so that little of the half-spaces is
//! missing. The force that comes out is compared with the one that the cut was made for.

pub mod far_field;
mod grading;
mod tractions;

use std::cmp::Ordering;
use std::f64::consts::PI;

use forms_fem::mesh::structured;
use forms_fem::prelude::*;

use self::far_field::{Strip, in_the_middle};
use self::grading::Grading;
pub use self::tractions::{Traction, Tractions};
use crate::contact_problem::ContactProblem;
use crate::hertz::{Hertz, HertzError, POISSON, YOUNG, modulus};
use crate::laws::two_bodies as law;

/// Names of the surfaces that may touch.
pub const SURFACES: [&str; 2] = ["lower contact", "upper contact"];

/// Surfaces may touch, are paraboloids and have cells of equal size up to this many a.
const NEAR: f64 = 1.25;
/// Cells are of equal size down to this many a.
const DEEP: f64 = 0.5;
/// γ₀/E.
const GAMMA0: f64 = 5.0;
/// Degree of quadrature in the plane, and in space.
const DEGREES: [usize; 2] = [6, 4];

/// A contact that was pressed and is then sheared, of cylinders after Cattaneo, of balls after Mindlin: in the middle, up to c, it
/// sticks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StickSlip {
    /// The contact as it was pressed.
    pub hertz: Hertz,
    /// P, the force that presses \[N, in the plane N/mm\].
    pub force: f64,
    /// κ, the coefficient of friction.
    pub friction: f64,
    /// Q, the force that shears, below κP \[N, in the plane N/mm\].
    pub shear: f64,
    /// c, half the width or the radius of what sticks \[mm\].
    pub stick: f64,
}

impl StickSlip {
    /// The contact of P, κ and Q: c = a √(1 − Q/κP).
    pub fn of_line(hertz: Hertz, force: f64, friction: f64, shear: f64) -> StickSlip {
        let stick = hertz.reach * (1.0 - shear / (friction * force)).sqrt();
        StickSlip { hertz, force, friction, shear, stick }
    }

    /// The contact of P, κ and Q between balls: c = a ∛(1 − Q/κP).
    pub fn of_point(hertz: Hertz, force: f64, friction: f64, shear: f64) -> StickSlip {
        let stick = hertz.reach * (1.0 - shear / (friction * force)).cbrt();
        StickSlip { hertz, force, friction, shear, stick }
    }

    /// δ_x = 3κP/16a (1 − (1 − Q/κP)^⅔) 2(2−ν)/G, the way by which distant points of two balls of the
    /// bodies' material slide past each other \[mm\] (Johnson 1985, equation 7.42).
    pub fn way_of_balls(&self) -> f64 {
        let limit = self.friction * self.force;
        let held = 1.0 - (1.0 - self.shear / limit).powf(2.0 / 3.0);
        let compliance = 2.0 * (2.0 - POISSON) / far_field::SHEAR_MODULUS;
        3.0 * limit / (16.0 * self.hertz.reach) * held * compliance
    }

    /// q = κ p0 (√(1 − r²/a²) − (c/a) √(1 − r²/c²)) \[MPa\] at a distance from the middle \[mm\].
    pub fn traction(&self, distance: f64) -> f64 {
        let peak = self.hertz.peak * self.stick / self.hertz.reach;
        let less = Hertz { reach: self.stick, peak };
        self.friction * (self.hertz.pressure(distance) - less.pressure(distance))
    }
}

/// Two bodies near their contact.
#[derive(Clone, Debug)]
pub struct HalfSpaces<const D: usize> {
    /// Both bodies, with displacements of degree 2.
    pub space: Arc<Space<D>>,
    /// The contact under the force that the bodies are cut out for.
    pub hertz: Hertz,
    /// The force P \[N, in the plane N/mm\].
    pub force: f64,
    /// Surfaces that are integrated over, and those opposite to them.
    pairing: Pairing,
    /// Sides at which both bodies are cut out, besides the lowest and the highest one.
    cut: &'static [&'static str],
    /// Planes of symmetry, each with the component that vanishes there.
    symmetric: &'static [(&'static str, usize)],
}

/// Cylinders of these radii, the lower one first, under the force P per length; a radius may be infinite. `cells` is the number
/// of cells over half the width of contact.
///
/// # Errors
/// No cells, or more than can be numbered.
pub fn cylinders(radii: [f64; 2], force: f64, cells: usize) -> Result<HalfSpaces<2>, HertzError> {
    let hertz = Hertz::of_line_between(force, common(radii), 0.5 * modulus());
    let (along, down) = gradings(&hertz, cells);
    let divisions = [2 * along.cells(), down.cells()];
    let body = |side: Side| {
        let outline = Outline { side, radius: radii[side as usize], reach: hertz.reach, down: &down };
        structured(divisions, CellShape::Quadrilateral, 2, |[s, t]| {
            let x = along.on_both_sides(s);
            [x, outline.height(x.abs(), t)]
        })
    };
    let bodies = [body(Side::Lower)?, body(Side::Upper)?];
    HalfSpaces::of(&bodies, (hertz, force), pairing(radii), &["left", "right"], &[])
}

/// A quarter of balls of these radii, the lower one first, under the force P; a radius may be infinite. `cells` is the number of
/// cells over the radius of contact.
///
/// # Errors
/// As [`cylinders`].
pub fn balls(radii: [f64; 2], force: f64, cells: usize) -> Result<HalfSpaces<3>, HertzError> {
    let planes = &[("left", 0), ("front", 1)];
    part_of_balls(radii, force, cells, (Grading::cells, Grading::place), &["right", "back"], planes)
}

/// Half of the same balls, y > 0, which may be drawn along x.
///
/// # Errors
/// As [`cylinders`].
pub fn halved_balls(radii: [f64; 2], force: f64, cells: usize) -> Result<HalfSpaces<3>, HertzError> {
    let both = |along: &Grading| 2 * along.cells();
    let cut = &["left", "right", "back"];
    part_of_balls(radii, force, cells, (both, Grading::on_both_sides), cut, &[("front", 1)])
}

/// Number of cells along x of a grading, and the place at a part of their row.
type Row = (fn(&Grading) -> usize, fn(&Grading, f64) -> f64);

fn part_of_balls(
    radii: [f64; 2],
    force: f64,
    cells: usize,
    (cells_along_x, place_along_x): Row,
    cut: &'static [&'static str],
    symmetric: &'static [(&'static str, usize)],
) -> Result<HalfSpaces<3>, HertzError> {
    let hertz = Hertz::of_point_between(force, common(radii), 0.5 * modulus());
    let (along, down) = gradings(&hertz, cells);
    let divisions = [cells_along_x(&along), along.cells(), down.cells()];
    let body = |side: Side| {
        let outline = Outline { side, radius: radii[side as usize], reach: hertz.reach, down: &down };
        structured(divisions, CellShape::Hexahedron, 2, |[s, t, w]| {
            let (x, y) = (place_along_x(&along, s), along.place(t));
            [x, y, outline.height(x.hypot(y), w)]
        })
    };
    let bodies = [body(Side::Lower)?, body(Side::Upper)?];
    HalfSpaces::of(&bodies, (hertz, force), pairing(radii), cut, symmetric)
}

/// Cells along the surface and into the depth.
fn gradings(hertz: &Hertz, cells: usize) -> (Grading, Grading) {
    (Grading::new(hertz.reach, NEAR, cells), Grading::new(hertz.reach, DEEP, cells))
}

/// Both surfaces where they are alike, else the flatter one alone: along normals that differ the two would measure gaps that
/// differ, too, by a part (a/R)² of them, and their pressures by γ times as much.
fn pairing(radii: [f64; 2]) -> Pairing {
    let [lower, upper] = SURFACES;
    match radii[0].total_cmp(&radii[1]) {
        Ordering::Equal => Pairing::between(lower, upper),
        Ordering::Greater => Pairing::onto(lower, upper),
        Ordering::Less => Pairing::onto(upper, lower),
    }
}

/// R with 1/R = 1/R₁ + 1/R₂.
fn common(radii: [f64; 2]) -> f64 {
    1.0 / radii.iter().map(|radius| 1.0 / radius).sum::<f64>()
}

/// Distance of a point from the axis of the contact.
fn distance_from_axis<const D: usize>(x: &[f64; D]) -> f64 {
    x[..D - 1].iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// The body below or above the surface of contact.
#[derive(Clone, Copy, Debug)]
enum Side {
    Lower,
    Upper,
}

/// The shape of a body.
struct Outline<'a> {
    side: Side,
    radius: f64,
    reach: f64,
    down: &'a Grading,
}

impl Outline<'_> {
    /// The coordinate along the axis at a distance from it, and at a part of the way up.
    fn height(&self, r: f64, way: f64) -> f64 {
        let near = NEAR * self.reach;
        let rise = match r < near {
            true => r * r / 2.0,
            // The cubic with the parabola's end and slope that is level at 0 twice as far out.
            false => {
                let left = (2.0 - r / near).max(0.0);
                near * near * (2.5 - 2.0 * left) * left * left
            }
        };
        let surface = rise / self.radius;
        let below = |way: f64| surface + self.down.place(way) * (1.0 - surface / self.down.length());
        match self.side {
            Side::Lower => -below(1.0 - way),
            Side::Upper => below(way),
        }
    }
}

impl<const D: usize> HalfSpaces<D>
where
    Dim: Dimension<D>,
{
    fn of(
        [lower, upper]: &[Mesh<D>; 2],
        (hertz, force): (Hertz, f64),
        pairing: Pairing,
        cut: &'static [&'static str],
        symmetric: &'static [(&'static str, usize)],
    ) -> Result<Self, HertzError> {
        let mut mesh = Mesh::of_bodies(&[("lower", lower), ("upper", upper)])?;
        for (name, side) in SURFACES.into_iter().zip(["lower top", "upper bottom"]) {
            mesh.name_facets(name, side, |x| distance_from_axis(x) < NEAR * hertz.reach)?;
        }
        let space = Space::vector(&mesh, 2)?;
        Ok(HalfSpaces { space, hertz, force, pairing, cut, symmetric })
    }

    /// The part of the bodies that is computed: a quarter in space, all in the plane.
    pub fn part(&self) -> f64 {
        0.5_f64.powi(self.symmetric.len() as i32)
    }

    /// The problem with a displacement of the upper cut; that of the lower one is the same turned around the origin.
    fn problem(
        &self,
        upper: impl Fn([f64; D]) -> [f64; D],
    ) -> Result<ContactProblem<D, law::Model<D>>, HertzError> {
        let mut constraints = Constraints::new(&self.space);
        for (side, component) in self.symmetric {
            for body in ["lower", "upper"] {
                constraints.fix_component(&format!("{body} {side}"), *component, |_| 0.0)?;
            }
        }
        for side in self.cut.iter().chain(&["bottom"]) {
            let turned = |x: &[f64; D]| upper(x.map(|x| -x)).map(|u| -u);
            constraints.fix(&format!("lower {side}"), turned)?;
        }
        for side in self.cut.iter().chain(&["top"]) {
            constraints.fix(&format!("upper {side}"), |x| upper(*x))?;
        }
        let share = 1.0 / self.pairing.surfaces.len() as f64;
        let required = law::data()
            .lambda(YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON)))
            .mu(YOUNG / (2.0 * (1.0 + POISSON)))
            .gamma0(GAMMA0 * YOUNG);
        let data = required.share(share);
        // There is no load.
        let regions = law::Regions::default().touch(self.pairing.clone()).gamma_n(SURFACES[0]);
        Ok(ContactProblem::new(&self.space, law::Model { data, regions }, constraints)
            .quadrature(Quadrature::Degree(DEGREES[D - 2])))
    }
}

impl HalfSpaces<2> {
    /// The bodies under P.
    ///
    /// # Errors
    /// Data that do not fit.
    pub fn pressed(&self) -> Result<ContactProblem<2, law::Model<2>>, HertzError> {
        self.problem(|x| self.pressing(x))
    }

    /// The bodies under P and Q, the upper one drawn along x, from the displacement under only P.
    ///
    /// # Errors
    /// Data that do not fit.
    pub fn sheared(
        &self,
        law: &StickSlip,
        before: &Field<2>,
    ) -> Result<ContactProblem<2, law::Model<2>>, HertzError> {
        let limit = law.friction * self.force;
        let less = limit - law.shear;
        let spread = (limit * self.hertz.reach.powi(2) - less * law.stick.powi(2)) / law.shear;
        let drag = Strip { force: -law.shear, spread };
        let way = in_the_middle(limit, self.hertz.reach) - in_the_middle(less, law.stick);
        let mut problem = self.problem(|x| {
            let ([u, v], [aside, along]) = (self.pressing(x), drag.dragged(x));
            [u + aside + way, v + along]
        })?;
        problem.law.data.friction = law.friction;
        problem.law.data.displacement_before = Given::field(before);
        Ok(problem)
    }

    fn pressing(&self, x: [f64; 2]) -> [f64; 2] {
        let strip = Strip { force: self.force, spread: self.hertz.reach.powi(2) };
        let [u, v] = strip.pushed(x);
        [u, v - in_the_middle(self.force, self.hertz.reach)]
    }
}

impl HalfSpaces<3> {
    /// a²/R = π a p0/2E*, the way by which distant points of the bodies approach each other \[mm\].
    pub fn approach(&self) -> f64 {
        PI * self.hertz.reach * self.hertz.peak / modulus()
    }

    /// The bodies under P.
    ///
    /// # Errors
    /// Data that do not fit.
    pub fn pressed(&self) -> Result<ContactProblem<3, law::Model<3>>, HertzError> {
        self.problem(|x| self.pressing(x))
    }

    /// The bodies under P and Q, the upper one drawn along x, from the displacement under only P: for [`halved_balls`].
    ///
    /// # Errors
    /// Data that do not fit.
    pub fn sheared(
        &self,
        law: &StickSlip,
        before: &Field<3>,
    ) -> Result<ContactProblem<3, law::Model<3>>, HertzError> {
        let half_way = 0.5 * law.way_of_balls();
        let mut problem = self.problem(|x| {
            let (pressed, dragged) = (self.pressing(x), far_field::dragged(-law.shear, x));
            let [u, v, w] = std::array::from_fn(|k| pressed[k] + dragged[k]);
            [u + half_way, v, w]
        })?;
        problem.law.data.friction = law.friction;
        problem.law.data.displacement_before = Given::field(before);
        Ok(problem)
    }

    fn pressing(&self, x: [f64; 3]) -> [f64; 3] {
        let [u, v, w] = far_field::pushed(self.force, x);
        [u, v, w - 0.5 * self.approach()]
    }
}

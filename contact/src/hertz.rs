//! Hertz's contacts (1882): an elastic cylinder or ball on a rigid flat, an elastic block on a rigid ball.
//!
//! R = 8 mm, E = 200 MPa, ν = 0.3. By symmetry half of the cylinder's section and a quarter of the ball and the block
//! are computed, cylinder and ball up to the height of their centre; tops are pressed down. Cells are graded towards
//! the contact. The block's obstacle is its signed distance: the gap g and the direction n_y into it follow x.
//!
//! Hertz's answer is that of a half-space with a paraboloid's boundary: bodies nine (cylinder) and six times as wide as
//! their contact leave differences of percents.

mod cut;
mod simplices;

use std::f64::consts::PI;

use forms_fem::constraints::ConstraintsError;
use forms_fem::cut::CutError;
use forms_fem::field::FieldError;
use forms_fem::mesh::{MeshError, structured};
use forms_fem::prelude::*;
use forms_fem::space::SpaceError;
use thiserror::Error;

use crate::contact_problem::ContactProblem;
use crate::forms;
pub use cut::{
    CutCylinder, CutMeasured, background, cylinder_cut_from, cylinder_distance, estimate as estimate_on_cut,
};
pub use simplices::{FREE, Measured, cylinder_mesh, estimate, onto_body, quarter_mesh};

/// R, radius of cylinder and ball \[mm\].
pub const RADIUS: f64 = 8.0;
/// Half the cylinder's width \[mm\].
const CYLINDER_WIDTH: f64 = 6.0;
/// Width of a quarter of ball and block \[mm\]; the block is as high.
pub const QUARTER_WIDTH: f64 = 4.0;
/// E \[MPa\].
pub const YOUNG: f64 = 200.0;
/// ν.
pub const POISSON: f64 = 0.3;
/// Displacement of the cylinder's top \[mm\], which gives about P = 10 N/mm.
pub const CYLINDER_PRESSED: f64 = 0.0975;
/// Displacement of the top of ball and block \[mm\].
pub const QUARTER_PRESSED: f64 = 0.05;
/// Mesh region of Γ_C.
pub const CONTACT: &str = "contact";
/// Mesh region of the cells that own facets of Γ_C.
pub const CONTACT_CELLS: &str = "contact cells";

/// Γ_C is the lower boundary where coordinates are below this \[mm\].
const CYLINDER_REACH: f64 = 1.2;
const QUARTER_REACH: f64 = 0.75;

/// Errors of a contact's set-up.
#[derive(Debug, Error)]
pub enum HertzError {
    /// The mesh could not be made.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The space could not be made.
    #[error(transparent)]
    Space(#[from] SpaceError),
    /// A condition does not fit.
    #[error(transparent)]
    Constraints(#[from] ConstraintsError),
    /// Form and data do not fit.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// The level set function could not be made.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// The body could not be cut.
    #[error(transparent)]
    Cut(#[from] CutError),
}

/// Spacing of cells along 0..1: a part of them is of equal size, where the contact is; the others grow.
#[derive(Clone, Copy, Debug)]
struct Grading {
    /// The part of equal size.
    near: f64,
    /// Its cells' size, in units of even spacing.
    size: f64,
    /// The power by which the others grow.
    power: i32,
}

/// Three fifths of the cells within 0.15 of the way.
const OF_CYLINDER: Grading = Grading { near: 0.6, size: 0.25, power: 3 };
/// Three quarters of the cells within 0.18 of the length. Positions grow by squares, because the middle node of a quadratic cell must stay near the
/// cell's middle.
const OF_QUARTER: Grading = Grading { near: 0.75, size: 0.24, power: 2 };

impl Grading {
    fn place(self, t: f64) -> f64 {
        let rest = (1.0 - self.size) / (1.0 - self.near).powi(self.power);
        self.size * t + rest * (t - self.near).max(0.0).powi(self.power)
    }
}

/// x \[mm\] of ball and block at a part of their row of cells.
pub fn quarter_place(t: f64) -> f64 {
    QUARTER_WIDTH * OF_QUARTER.place(t)
}

/// The pairs of bodies in space.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Body {
    /// A ball with its centre at the origin, on the plane z = −R.
    Ball,
    /// A block, z > 0, on a rigid ball around (0, 0, −R).
    Block,
}

impl Body {
    /// z \[mm\] of the lower boundary.
    pub fn surface(self, x: f64, y: f64) -> f64 {
        match self {
            Body::Ball => -(RADIUS * RADIUS - x * x - y * y).sqrt(),
            Body::Block => 0.0,
        }
    }

    /// The body \[mm\] as the unit cube's image.
    pub fn place(self, [s, t, w]: [f64; 3]) -> [f64; 3] {
        let [x, y] = [s, t].map(quarter_place);
        match self {
            Body::Ball => [x, y, self.surface(x, y) * (1.0 - OF_QUARTER.place(w))],
            Body::Block => [x, y, quarter_place(w)],
        }
    }

    /// n_y, the direction into the obstacle, and g, the distance to it \[mm\].
    fn obstacle(self) -> (Given<[f64; 3], 3>, Given<f64, 3>) {
        match self {
            Body::Ball => (Given::constant([0.0, 0.0, -1.0]), Given::function(|x: &[f64; 3]| x[2] + RADIUS)),
            Body::Block => (
                Given::function(|x: &[f64; 3]| from_centre(x).1.map(|v| -v)),
                Given::function(|x: &[f64; 3]| from_centre(x).0 - RADIUS),
            ),
        }
    }
}

/// The distance to the point (0, 0, −R), and the unit vector away from it.
fn from_centre(x: &[f64; 3]) -> (f64, [f64; 3]) {
    let away = [x[0], x[1], x[2] + RADIUS];
    let length = away.iter().map(|v| v * v).sum::<f64>().sqrt();
    (length, away.map(|v| v / length))
}

/// Half a cylinder's section on a flat, with `divisions` cells each way; θ = −1, γ₀ = 10 E.
///
/// # Errors
/// No cells, or more than can be numbered.
pub fn cylinder_on_flat(divisions: usize) -> Result<ContactProblem<2>, HertzError> {
    let place = |[s, t]: [f64; 2]| {
        let x = CYLINDER_WIDTH * OF_CYLINDER.place(s);
        [x, -(RADIUS * RADIUS - x * x).sqrt() * (1.0 - OF_CYLINDER.place(t))]
    };
    let mut mesh = structured([divisions; 2], CellShape::Quadrilateral, 2, place)?;
    mesh.name_facets(CONTACT, "bottom", |centre| centre[0] < CYLINDER_REACH)?;
    mesh.name_cells_of_facets(CONTACT_CELLS, CONTACT)?;
    cylinder_on(&mesh, "right", CYLINDER_PRESSED)
}

/// Half a cylinder's section on a flat, on a given mesh of it, as [`cylinder_mesh`] or its refinements; `free` is the region
/// of its boundary that is neither held nor able to touch, and `way` \[mm\] that of its top, [`CYLINDER_PRESSED`] or less: then the
/// body is larger relative to its contact.
///
/// # Errors
/// A region that the mesh lacks.
pub fn cylinder_on(mesh: &Mesh<2>, free: &str, way: f64) -> Result<ContactProblem<2>, HertzError> {
    let flat = (Given::constant([0.0, -1.0]), Given::function(|x: &[f64; 2]| x[1] + RADIUS));
    pressed(mesh, free, &["left"], way, flat, 8)
}

/// A quarter of ball or block on its obstacle, with `divisions` cells each way; θ = −1, γ₀ = 10 E.
///
/// # Errors
/// As [`cylinder_on_flat`].
pub fn in_space(body: Body, divisions: usize) -> Result<ContactProblem<3>, HertzError> {
    let mut mesh = structured([divisions; 3], CellShape::Hexahedron, 2, |t| body.place(t))?;
    mesh.name_facets(CONTACT, "bottom", |centre| centre[0].max(centre[1]) < QUARTER_REACH)?;
    mesh.name_cells_of_facets(CONTACT_CELLS, CONTACT)?;
    body_on(body, &mesh, "right", QUARTER_PRESSED)
}

/// A quarter of ball or block on its obstacle, on a given mesh of it, as [`quarter_mesh`] or its refinements.
///
/// # Errors
/// As [`cylinder_on`].
pub fn body_on(body: Body, mesh: &Mesh<3>, free: &str, way: f64) -> Result<ContactProblem<3>, HertzError> {
    pressed(mesh, free, &["left", "front"], way, body.obstacle(), 6)
}

/// The body on its obstacle: plane `i` of `symmetric` holds component i, the top moves down.
fn pressed<const D: usize>(
    mesh: &Mesh<D>,
    free: &str,
    symmetric: &[&str],
    way: f64,
    (obstacle_normal, gap): (Given<[f64; D], D>, Given<f64, D>),
    degree: usize,
) -> Result<ContactProblem<D>, HertzError>
where
    Dim: Dimension<D>,
{
    let space = Space::vector(mesh, 2)?;
    let mut constraints = Constraints::new(&space);
    for (component, plane) in symmetric.iter().enumerate() {
        constraints.fix_component(plane, component, |_| 0.0)?;
    }
    constraints.fix_component("top", D - 1, |_| -way)?;
    let data = forms::data()
        .lambda(YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON)))
        .mu(YOUNG / (2.0 * (1.0 + POISSON)))
        .gamma0(10.0 * YOUNG)
        .obstacle_normal(obstacle_normal)
        .gap(gap)
        .theta(-1.0);
    let regions = forms::Regions::default().gamma_n(free).gamma_c(CONTACT);
    Ok(ContactProblem::new(&space, forms::Model { data, regions }, constraints)
        .quadrature(Quadrature::Degree(degree)))
}

/// Hertz's answer: the pressure p0 √(1 − r²/a²).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hertz {
    /// a \[mm\]: half the width of contact of a cylinder, else the radius of contact.
    pub reach: f64,
    /// p0 \[MPa\].
    pub peak: f64,
}

impl Hertz {
    /// A cylinder on a rigid flat under the force P per length \[N/mm\]: a = 2√(RP/πE′), p0 = 2P/(πa), E′ = E/(1−ν²).
    pub fn of_line(force: f64) -> Hertz {
        Hertz::of_line_between(force, RADIUS, modulus())
    }

    /// Ball and block under the force P \[N\]: a³ = 3PR/4E′, p0 = 3P/(2πa²), E′ = E/(1−ν²).
    pub fn of_point(force: f64) -> Hertz {
        Hertz::of_point_between(force, RADIUS, modulus())
    }

    /// Two cylinders under the force P per length \[N/mm\]: a = 2√(RP/πE*), 1/R = 1/R₁ + 1/R₂ and 1/E* = 1/E′₁ + 1/E′₂.
    pub fn of_line_between(force: f64, radius: f64, modulus: f64) -> Hertz {
        let reach = 2.0 * (radius * force / (PI * modulus)).sqrt();
        Hertz { reach, peak: 2.0 * force / (PI * reach) }
    }

    /// Two balls under the force P \[N\]: a³ = 3PR/4E*, with R and E* as for two cylinders.
    pub fn of_point_between(force: f64, radius: f64, modulus: f64) -> Hertz {
        let reach = (3.0 * force * radius / (4.0 * modulus)).cbrt();
        Hertz { reach, peak: 3.0 * force / (2.0 * PI * reach * reach) }
    }

    /// The pressure \[MPa\] at a distance from the axis \[mm\].
    pub fn pressure(&self, distance: f64) -> f64 {
        self.peak * (1.0 - (distance / self.reach).powi(2)).max(0.0).sqrt()
    }

    /// ‖p_h − p‖/‖p‖ in L²(Γ_C) of the contact pressure p_h of a displacement.
    ///
    /// # Errors
    /// A displacement of another mesh.
    pub fn profile_error<const D: usize>(
        &self,
        problem: &ContactProblem<D>,
        u: &Field<D>,
    ) -> Result<f64, AssemblyError>
    where
        Dim: Dimension<D>,
    {
        let pressure = problem.law.contact_pressure(u);
        let points = problem.assembler.at_quadrature_points(&pressure, Entity::Facets, CONTACT, 8)?;
        let (mut difference, mut whole) = (0.0, 0.0);
        for ((x, weight), value) in points.positions.iter().zip(&points.weights).zip(&points.values) {
            let exact = self.pressure(x[..D - 1].iter().map(|x| x * x).sum::<f64>().sqrt());
            difference += weight * (value[0] - exact).powi(2);
            whole += weight * exact * exact;
        }
        Ok((difference / whole).sqrt())
    }
}

/// E′ = E/(1−ν²) \[MPa\].
pub(crate) fn modulus() -> f64 {
    YOUNG / (1.0 - POISSON * POISSON)
}

//! Small distorted bodies with an oblique, curved obstacle below: every term of the contact forms is at work,
//! and some quadrature points are in contact, others not.

use forms_contact::forms;
use forms_fem::mesh::structured;
use forms_fem::prelude::*;

/// λ of every body.
pub const LAMBDA: f64 = 3.0;
/// μ of every body.
pub const MU: f64 = 2.0;
/// γ₀ of every body.
pub const GAMMA0: f64 = 40.0;
/// C in ξ = C √h_T of every body.
pub const EXTENSION: f64 = 0.2;
/// Degree of the quadrature of every body.
pub const DEGREE: usize = 6;
/// Γ_C.
pub const CONTACT: &str = "bottom";
/// Γ_N.
pub const LOADED: &str = "top";

/// A body at some displacement, not a solution.
pub struct Body<const D: usize> {
    /// For messages.
    pub name: &'static str,
    /// Assembler with a rule of degree [`DEGREE`].
    pub assembler: Assembler<D>,
    /// Displacements of degree 2.
    pub space: Arc<Space<D>>,
    /// The state.
    pub u: Field<D>,
}

/// Triangles and quadrilaterals, with straight and with curved sides.
pub fn plane_bodies() -> Vec<Body<2>> {
    vec![
        body("triangles", CellShape::Triangle, 1, [3, 2]),
        body("curved triangles", CellShape::Triangle, 2, [2, 1]),
        body("quadrilaterals", CellShape::Quadrilateral, 1, [3, 2]),
        body("curved quadrilaterals", CellShape::Quadrilateral, 2, [3, 1]),
    ]
}

/// Tetrahedra and hexahedra, these with faces that are not plane.
pub fn solid_bodies() -> Vec<Body<3>> {
    vec![
        body("tetrahedra", CellShape::Tetrahedron, 1, [2, 1, 1]),
        body("hexahedra", CellShape::Hexahedron, 1, [2, 1, 1]),
    ]
}

fn body<const D: usize>(
    name: &'static str,
    shape: CellShape,
    degree: usize,
    divisions: [usize; D],
) -> Body<D> {
    // Every coordinate bends with the next one.
    let bend = |t: [f64; D]| {
        std::array::from_fn(|k| {
            let next = t[(k + 1) % D];
            1.3 * t[k] + 0.12 * (2.0 * next + 0.5 * k as f64).sin() + 0.05 * t[k] * next
        })
    };
    let mesh = structured(divisions, shape, degree, bend).unwrap_or_else(|error| panic!("{name}: {error}"));
    let space = Space::vector(&mesh, 2).unwrap_or_else(|error| panic!("{name}: {error}"));
    let u = wave(&space, 0.01, 0.0);
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(DEGREE));
    Body { name, assembler, space, u }
}

/// A smooth field without symmetry, of about this size.
pub fn wave<const D: usize>(space: &Arc<Space<D>>, size: f64, phase: f64) -> Field<D> {
    let value = |x: &[f64; D]| -> [f64; D] {
        std::array::from_fn(|k| {
            let angle: f64 = x.iter().enumerate().map(|(axis, x)| (2.0 + 0.7 * axis as f64) * x).sum();
            size * (angle + phase + 1.9 * k as f64).sin()
        })
    };
    Field::interpolate(space, value).unwrap_or_else(|error| panic!("{error}"))
}

/// n_y, which turns from point to point.
pub fn obstacle_normal<const D: usize>(x: &[f64; D]) -> [f64; D] {
    let angle = 0.2 + 0.1 * x[0];
    let mut normal = [0.0; D];
    normal[0] = angle.sin();
    normal[D - 1] = -angle.cos();
    normal
}

/// g.
pub fn gap<const D: usize>(x: &[f64; D]) -> f64 {
    0.05 * (x[0] - 0.6)
}

/// f.
pub fn body_force<const D: usize>(x: &[f64; D]) -> [f64; D] {
    std::array::from_fn(|k| 0.3 * x[0] - 0.2 * k as f64)
}

/// g_N.
pub fn traction<const D: usize>(x: &[f64; D]) -> [f64; D] {
    std::array::from_fn(|k| 0.1 + 0.4 * x[k])
}

/// F.
pub fn criterion_force<const D: usize>(x: &[f64; D]) -> [f64; D] {
    std::array::from_fn(|k| 0.5 * x[D - 1] - 0.3 * k as f64)
}

/// c.
pub fn criterion_weight<const D: usize>(x: &[f64; D]) -> f64 {
    2.0 + x[0]
}

/// The data of every body.
pub fn data<const D: usize>(theta: f64) -> forms::Data<D> {
    forms::data()
        .lambda(LAMBDA)
        .mu(MU)
        .gamma0(GAMMA0)
        .obstacle_normal(obstacle_normal::<D>)
        .gap(gap::<D>)
        .theta(theta)
        .extension(EXTENSION)
        .body_force(body_force::<D>)
        .traction(traction::<D>)
        .criterion_force(criterion_force::<D>)
        .criterion_weight(criterion_weight::<D>)
}

/// The forms of a body, with its regions bound.
impl<const D: usize> Body<D>
where
    Dim: Dimension<D>,
{
    /// (14).
    pub fn direct(&self, theta: f64) -> Form<D> {
        let (omega, gamma_c) = (forms::Omega::on("all"), forms::GammaC::on(CONTACT));
        forms::direct(&data(theta), &omega, &forms::GammaN::on(LOADED), &gamma_c)
    }

    /// (21) at the body's state.
    pub fn discrete_adjoint(&self, data: &forms::Data<D>) -> Form<D> {
        let (omega, gamma_c) = (forms::Omega::on("all"), forms::GammaC::on(CONTACT));
        forms::discrete_adjoint(
            data,
            &omega,
            &forms::GammaN::on(LOADED),
            &gamma_c,
            &forms::Boundary::on("boundary"),
            &self.u,
        )
    }

    /// (22) at the body's state.
    pub fn consistent_adjoint(&self, data: &forms::Data<D>) -> Form<D> {
        let (omega, gamma_c) = (forms::Omega::on("all"), forms::GammaC::on(CONTACT));
        forms::consistent_adjoint(data, &omega, &gamma_c, &forms::Boundary::on("boundary"), &self.u)
    }

    /// (41) at the body's state.
    pub fn extended_adjoint(&self, data: &forms::Data<D>) -> Form<D> {
        let (omega, gamma_c) = (forms::Omega::on("all"), forms::GammaC::on(CONTACT));
        forms::extended_adjoint(data, &omega, &gamma_c, &forms::Boundary::on("boundary"), &self.u)
    }

    /// J.
    pub fn criterion(&self, data: &forms::Data<D>, u: &Field<D>) -> Functional<D> {
        forms::criterion(data, &forms::Omega::on("all"), &forms::Boundary::on("boundary"), u)
    }

    /// A step along a direction on which no quadrature point changes its state: β_h is affine in u, so that
    /// it is enough to look at the end.
    pub fn step_without_switch(&self, theta: f64, direction: &Field<D>) -> f64
    where
        Dim: Dimension<D>,
    {
        let form = self.direct(theta);
        let set = |u: &Field<D>| {
            self.assembler.active_set(&form, &[u]).unwrap_or_else(|error| panic!("{}: {error}", self.name))
        };
        let start = set(&self.u);
        let mut step = 0.5;
        while set(&self.moved(step, direction)) != start {
            step *= 0.5;
            assert!(step > 1e-9, "{}: a point lies on the switch", self.name);
        }
        step
    }

    /// u + step · direction.
    pub fn moved(&self, step: f64, direction: &Field<D>) -> Field<D> {
        let values = self.u.values().iter().zip(direction.values()).map(|(u, d)| u + step * d).collect();
        Field::from_values(&self.space, values).unwrap_or_else(|error| panic!("{}: {error}", self.name))
    }
}

//! Hertz's contacts on simplices of equal size, to be refined where the error is, and what is measured there.

use std::f64::consts::PI;

use forms_fem::adaptivity::{ErrorEstimate, EstimateError};
use forms_fem::mesh::{Facet, onto_sphere, structured};
use forms_fem::prelude::*;

use super::{
    Body, CONTACT, CYLINDER_REACH, CYLINDER_WIDTH, Hertz, HertzError, QUARTER_REACH, QUARTER_WIDTH, RADIUS,
};
use crate::contact_problem::{ContactProblem, RESOLUTION};
use crate::residual_estimator::frictionless;

/// Mesh region of what is neither held nor able to touch.
pub const FREE: &str = "free";

/// Half of the cylinder's section in pairs of triangles, `divisions` each way, with [`FREE`].
///
/// # Errors
/// No cells, or more than can be numbered.
pub fn cylinder_mesh(divisions: usize) -> Result<Mesh<2>, HertzError> {
    let place = |[s, t]: [f64; 2]| {
        let x = CYLINDER_WIDTH * s;
        [x, -(RADIUS * RADIUS - x * x).sqrt() * (1.0 - t)]
    };
    let mesh = structured([divisions; 2], CellShape::Triangle, 2, place)?;
    named(mesh, |centre| centre[0] < CYLINDER_REACH, &["right"])
}

/// A quarter of ball or block in sixes of tetrahedra, `divisions` each way, with [`FREE`].
///
/// # Errors
/// As [`cylinder_mesh`].
pub fn quarter_mesh(body: Body, divisions: usize) -> Result<Mesh<3>, HertzError> {
    let place = |[s, t, w]: [f64; 3]| {
        let [x, y] = [s, t].map(|s| QUARTER_WIDTH * s);
        match body {
            Body::Ball => [x, y, body.surface(x, y) * (1.0 - w)],
            Body::Block => [x, y, QUARTER_WIDTH * w],
        }
    };
    let mesh = structured([divisions; 3], CellShape::Tetrahedron, 2, place)?;
    named(mesh, |centre| centre[0].max(centre[1]) < QUARTER_REACH, &["right", "back"])
}

/// Names the regions Γ_C and [`FREE`]. The latter has some of the sides, and the bottom outside of Γ_C.
fn named<const D: usize>(
    mut mesh: Mesh<D>,
    touches: impl Fn(&[f64; D]) -> bool,
    sides: &[&str],
) -> Result<Mesh<D>, HertzError> {
    mesh.name_facets(CONTACT, "bottom", |centre| touches(centre))?;
    mesh.name_facets("beside", "bottom", |centre| !touches(centre))?;
    let mut free: Vec<Facet> = mesh.facet_region("beside")?.to_vec();
    for side in sides {
        free.extend_from_slice(mesh.facet_region(side)?);
    }
    mesh.name_listed_facets(FREE, &free)?;
    Ok(mesh)
}

/// The circle or sphere of cylinder and ball, for new nodes on "bottom".
pub fn onto_body<const D: usize>() -> impl Fn(&[f64; D]) -> [f64; D] {
    onto_sphere([0.0; D], RADIUS)
}

/// The error of a displacement by the residual estimator of contact, on a mesh with [`FREE`].
///
/// # Errors
/// Data that do not fit.
pub fn estimate<const D: usize>(
    problem: &ContactProblem<D>,
    u: &Field<D>,
) -> Result<ErrorEstimate, EstimateError>
where
    Dim: Dimension<D>,
{
    let regions = frictionless::Regions::default().gamma_n(FREE).gamma_c(CONTACT);
    let model = frictionless::Model { data: problem.law.data.clone(), regions };
    ErrorEstimate::residual(&problem.assembler, &model.squared(u))
}

/// Measurements of a contact: force, width or radius of contact, and the pressure in its middle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// P \[N\], of the cylinder per length \[N/mm\], of the whole body.
    pub force: f64,
    /// Half the width of contact, or the radius of a disc of the area of contact \[mm\]; facets are split where contact ends.
    pub reach: f64,
    /// The contact pressure on the axis \[MPa\].
    pub peak: f64,
    /// p0 \[MPa\] by the pressure within half of the reach: its integral over that of √(1 − r²/a²), a the reach.
    pub middle: f64,
}

impl Measured {
    /// Measurements of a displacement of half the cylinder, or of a quarter of ball or block.
    ///
    /// # Errors
    /// A displacement of another mesh.
    pub fn of<const D: usize>(problem: &ContactProblem<D>, u: &Field<D>) -> Result<Measured, AssemblyError>
    where
        Dim: Dimension<D>,
    {
        let (law, assembler) = (&problem.law, &problem.assembler);
        let parts = if D == 2 { 2.0 } else { 4.0 };
        let split = assembler.split_at_zeros(&law.contact_indicator(u), CONTACT, RESOLUTION)?;
        let size = parts * split.functional(&law.contact_length(u))?;
        let corners = &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]][..D];
        let samples = assembler.along_facets(&law.contact_pressure(u), CONTACT, corners)?;
        let from_axis = |x: &[f64; D]| x[..D - 1].iter().map(|x| x * x).sum::<f64>().sqrt();
        let on_axis = samples.iter().filter(|sample| from_axis(&sample.position) < 1e-9 * RADIUS);
        let (sum, count) =
            on_axis.fold((0.0, 0.0), |(sum, count), sample| (sum + sample.value[0], count + 1.0));
        let reach = if D == 2 { size / 2.0 } else { (size / PI).sqrt() };
        let points = assembler.at_quadrature_points(&law.contact_pressure(u), Entity::Facets, CONTACT, 8)?;
        let shape = Hertz { reach, peak: 1.0 };
        let (mut pressed, mut shaped) = (0.0, 0.0);
        for ((x, weight), value) in points.positions.iter().zip(&points.weights).zip(&points.values) {
            let distance = from_axis(x);
            if distance < 0.5 * reach {
                pressed += weight * value[0];
                shaped += weight * shape.pressure(distance);
            }
        }
        Ok(Measured {
            force: parts * split.functional(&law.contact_force(u))?,
            reach,
            peak: sum / count,
            middle: pressed / shaped,
        })
    }

    /// The relative errors of reach, peak and middle relative to Hertz's answer for this force.
    pub fn errors(&self, hertz: &Hertz) -> [f64; 3] {
        [self.reach / hertz.reach, self.peak / hertz.peak, self.middle / hertz.peak].map(|ratio| ratio - 1.0)
    }
}

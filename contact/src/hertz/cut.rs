//! Hertz's cylinder as a body that is cut from a rectangle of triangles.

use forms_fem::adaptivity::{ErrorEstimate, EstimateError};
use forms_fem::prelude::*;

use super::{CYLINDER_WIDTH, Hertz, HertzError, POISSON, RADIUS, YOUNG};
use crate::contact_problem::ContactProblem;
use crate::laws::cut_nitsche;
use crate::residual_estimator::cut_frictionless;

/// Depth of the rectangle \[mm\]: a little more than the radius.
const DEPTH: f64 = 8.2;
/// Degree of the rule for integrands that jump inside pieces.
const FINE: usize = 20;

/// A cylinder that is cut from a mesh, on a flat.
pub type CutCylinder = ContactProblem<2, cut_nitsche::Model<2>>;

#[forms(dimension = 2)]
mod measures {
    pub use crate::laws::cut_nitsche::GammaC;
    use crate::laws::cut_nitsche::contact_pressure;

    #[includes(crate::laws::cut_nitsche::Data)]
    pub struct Data {
        /// a.
        pub reach: Param,
        /// p0.
        pub peak: Param,
    }

    /// The force within a/2, with the weight 1 − 4r²/a².
    pub fn in_the_middle(u: State<Vector>) -> Functional {
        integral(GammaC, pos_part(1 - 4 * sqr(x[0] / reach)) * contact_pressure(u))
    }
    /// ‖p_h − p‖², p = p0 √(1 − r²/a²).
    pub fn missed(u: State<Vector>) -> Functional {
        integral(GammaC, sqr(contact_pressure(u) - peak * sqrt(pos_part(1 - sqr(x[0] / reach)))))
    }
}

/// The rectangle around half of the cylinder's section up to the height of its centre, in pairs of triangles, `divisions` each way.
///
/// # Errors
/// No cells, or more than can be numbered.
pub fn background(divisions: usize) -> Result<Mesh<2>, HertzError> {
    let corners = ([0.0, -DEPTH], [CYLINDER_WIDTH, 0.0]);
    Ok(rectangle(corners.0, corners.1, [divisions; 2], CellShape::Triangle, 1)?)
}

/// The distance to the cylinder's surface \[mm\], negative inside.
pub fn cylinder_distance(x: &[f64; 2]) -> f64 {
    x[0].hypot(x[1]) - RADIUS
}

/// Half of the cylinder's section on a flat, cut from a rectangle or its refinements, with elements of degree 2; θ = −1, γ₀ = 10 E. `way` \[mm\] is that
/// of its top.
///
/// # Errors
/// A mesh of something else.
pub fn cylinder_cut_from(mesh: &Mesh<2>, way: f64) -> Result<CutCylinder, HertzError> {
    let phi = Field::interpolate(&Space::scalar(mesh, 1)?, cylinder_distance)?;
    let body = Assembler::new(mesh).cut_by(&phi)?;
    let space = Space::vector(mesh, 2)?;
    let mut constraints = Constraints::new(&space);
    constraints.fix_component("left", 0, |_| 0.0)?;
    constraints.fix_component("top", 1, |_| -way)?;
    body.cut().map_or(Ok(()), |cut| cut.hold_outside(&mut constraints))?;
    let data = cut_nitsche::data()
        .lambda(YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON)))
        .mu(YOUNG / (2.0 * (1.0 + POISSON)))
        .gamma0(10.0 * YOUNG)
        .obstacle_normal([0.0, -1.0])
        .gap(|x: &[f64; 2]| x[1] + RADIUS)
        .theta(-1.0);
    let law = cut_nitsche::Model { data, regions: cut_nitsche::regions().gamma_c("all").gamma_n("right") };
    Ok(ContactProblem::new(&space, law, constraints).assembler(body.with_quadrature(Quadrature::Degree(8))))
}

/// The error of a displacement by the residual estimator of contact.
///
/// # Errors
/// Data that do not fit.
pub fn estimate(problem: &CutCylinder, u: &Field<2>) -> Result<ErrorEstimate, EstimateError> {
    let regions = cut_frictionless::Regions::default().gamma_n("right").gamma_c("all");
    let model = cut_frictionless::Model { data: problem.law.data.clone(), regions };
    ErrorEstimate::residual(&problem.assembler, &model.squared(u))
}

/// Measurements of a cylinder that is cut from a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutMeasured {
    /// P \[N/mm\] of the whole body.
    pub force: f64,
    /// Half the width of contact \[mm\].
    pub reach: f64,
    /// p0 \[MPa\] by the pressure within half of the reach a, with the weight 1 − 4r²/a².
    pub middle: f64,
    /// ‖p_h − p‖/‖p‖ in L²(Γ_C), with p Hertz's pressure for this force.
    pub profile: f64,
}

impl CutMeasured {
    /// Measurements of a displacement; integrands that jump inside pieces have a rule of degree 20.
    ///
    /// # Errors
    /// A displacement of another mesh.
    pub fn of(problem: &CutCylinder, u: &Field<2>) -> Result<CutMeasured, AssemblyError> {
        let law = &problem.law;
        let fine = problem.assembler.clone().with_quadrature(Quadrature::Degree(FINE));
        let [force, reach] = [law.contact_force(u), law.contact_length(u)].map(|one| fine.functional(&one));
        let (force, reach) = (2.0 * force?, reach?);
        let hertz = Hertz::of_line(force);
        let measures = |reach: f64| {
            let cut_nitsche::Data { lambda, mu, gamma0, theta, obstacle_normal, gap, .. } = law.data.clone();
            let data = measures::data().lambda(lambda).mu(mu).gamma0(gamma0);
            let data =
                data.obstacle_normal(obstacle_normal).gap(gap).theta(theta).reach(reach).peak(hertz.peak);
            measures::Model { data, regions: measures::Regions::default().gamma_c("all") }
        };
        // ∫ (1 − 4s²) √(1 − s²) over 0 < s < ½.
        let (angle, root) = (std::f64::consts::PI / 6.0, 0.75_f64.sqrt());
        let shape = 0.5 * (0.5 * root + angle) - 0.5 * (angle - 0.25 * root);
        let pressed = fine.functional(&measures(reach).in_the_middle(u))?;
        let missed = fine.functional(&measures(hertz.reach).missed(u))?;
        // ∫ p² over the whole zone is 4/3 p0² a; one half of it is computed.
        let whole = 2.0 / 3.0 * hertz.peak.powi(2) * hertz.reach;
        Ok(CutMeasured { force, reach, middle: pressed / (reach * shape), profile: (missed / whole).sqrt() })
    }
}

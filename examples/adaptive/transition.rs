//! Scalar Signorini on (−1, 1) × (0, 1) with the transition at a node: u = r^{3/2} cos(3φ/2) lies on the obstacle for x < 0, and
//! p = r^{1/2} cos(φ/2) solves the adjoint problem (22). All data are fluxes, so that no prescribed value is interpolated.

use forms_fem::adaptivity::{AdaptiveSolution, ErrorEstimate};
use forms_fem::norms::errors;
use forms_fem::prelude::*;

use crate::Outcome;
use crate::membrane::signorini;
use crate::study::{Study, WithError};

/// The degree of the rules, for kinks and for data that are no polynomials.
const DEGREE: usize = 8;
/// γ₀ = 10 k² with k the highest degree.
const GAMMA0: f64 = 40.0;

/// Re z^s with z = x + iy above the axis.
fn real_power(x: &[f64; 2], s: f64) -> f64 {
    let angle = x[1].max(0.0).atan2(x[0]);
    x[0].hypot(x[1]).powf(s) * (s * angle).cos()
}

/// ∇ Re z^s = s (Re z^{s−1}, −Im z^{s−1}).
fn gradient(x: &[f64; 2], s: f64) -> [f64; 2] {
    let angle = (s - 1.0) * x[1].max(0.0).atan2(x[0]);
    let length = s * x[0].hypot(x[1]).powf(s - 1.0);
    [length * angle.cos(), -length * angle.sin()]
}

/// ∫u = (2/7) ∮ u x·n, by Euler's theorem for u homogeneous of degree 3/2, with ∫z^{3/2} in closed form along the three sides
/// on which x·n = 1.
fn exact_goal() -> f64 {
    // (2/5) z^{5/2} at a point: real and imaginary part.
    let primitive = |x: f64, y: f64| {
        let (length, angle) = (0.4 * x.hypot(y).powf(2.5), 2.5 * y.atan2(x));
        [length * angle.cos(), length * angle.sin()]
    };
    let top = primitive(1.0, 1.0)[0] - primitive(-1.0, 1.0)[0];
    let right = primitive(1.0, 1.0)[1] - primitive(1.0, 0.0)[1];
    let left = primitive(-1.0, 1.0)[1] - primitive(-1.0, 0.0)[1];
    2.0 / 7.0 * (top + right + left)
}

fn mesh() -> Outcome<Mesh<2>> {
    let mut mesh = rectangle([-1.0, 0.0], [1.0, 1.0], [4, 2], CellShape::Triangle, 1)?;
    mesh.name_facets("loaded", "boundary", |x| x[1] > 0.0)?;
    Ok(mesh)
}

/// The forms with the flux of Re z^s.
fn model(theta: f64, s: f64) -> signorini::Model<2> {
    let data = signorini::data()
        .theta(theta)
        .gamma0(GAMMA0)
        .flux(move |x: &[f64; 2]| gradient(x, s))
        .contact(|x: &[f64; 2]| if x[0] < 0.0 { 1.0 } else { 0.0 });
    signorini::Model { data, regions: signorini::Regions::default().obstacle("bottom") }
}

fn assembler(mesh: &Mesh<2>) -> Assembler<2> {
    Assembler::new(mesh).with_quadrature(Quadrature::Degree(DEGREE))
}

/// Newton's method begins in full contact, or where the mesh before has ended.
fn direct(
    model: &signorini::Model<2>,
    space: &Arc<Space<2>>,
    before: Option<&Field<2>>,
) -> Outcome<Solved<2, 1>> {
    let start = match before {
        Some(before) => before.onto(space).interpolated()?,
        None => Field::interpolate(space, |_| -1.0)?,
    };
    let form = model.direct();
    let assembler = assembler(space.mesh());
    Ok(Problem::new(&form, space).assembler(&assembler).start(&start).solve()?)
}

/// The solution with its estimate, and its error in H¹.
fn with_error(field: Field<2>, estimate: ErrorEstimate, s: f64) -> Outcome<WithError> {
    let value = move |x: &[f64; 2], out: &mut [f64]| out[0] = real_power(x, s);
    let slope = move |x: &[f64; 2], out: &mut [f64]| out.copy_from_slice(&gradient(x, s));
    let error = errors(&assembler(field.space().mesh()), &field, value, slope)?.h1;
    Ok((AdaptiveSolution::new(field, estimate), error))
}

/// u of degree 2 in H¹, θ = −1.
pub fn displacement(unknowns: usize) -> Outcome<Study> {
    let model = model(-1.0, 1.5);
    Study::new("u in H1", &mesh()?, unknowns, |mesh, before| {
        let u = direct(&model, &Space::scalar(mesh, 2)?, before)?.into_field();
        let estimate = ErrorEstimate::residual(&assembler(mesh), &model.residual(&u))?;
        with_error(u, estimate, 1.5)
    })
}

/// p of (22) of degree 2 in H¹, θ = −1.
pub fn adjoint(unknowns: usize) -> Outcome<Study> {
    let model = model(-1.0, 0.5);
    Study::new("p by (22) in H1", &mesh()?, unknowns, |mesh, _| {
        let (space, assembler) = (Space::scalar(mesh, 2)?, assembler(mesh));
        let form = model.consistent_adjoint();
        let p = Problem::new(&form, &space).assembler(&assembler).solve()?.into_field();
        let estimate = ErrorEstimate::residual(&assembler, &model.adjoint_residual(&p))?;
        with_error(p, estimate, 0.5)
    })
}

/// p̃ of (21) of degree 2 in H¹, θ = −1, marked by its true error.
pub fn discrete_adjoint(unknowns: usize) -> Outcome<Study> {
    let model = model(-1.0, 0.5);
    Study::new("p by (21) in H1", &mesh()?, unknowns, |mesh, _| {
        let (space, assembler) = (Space::scalar(mesh, 2)?, assembler(mesh));
        let form = model.discrete_adjoint();
        let p = Problem::new(&form, &space).assembler(&assembler).solve()?.into_field();
        let error = ErrorEstimate::residual(&assembler, &model.true_error(&p))?;
        with_error(p, error, 0.5)
    })
}

/// J = ∫u by degree 1, its error by the adjoint state (21) of degree 2.
pub fn goal(unknowns: usize, theta: f64) -> Outcome<Study> {
    let model = model(theta, 1.5);
    let exact = exact_goal();
    Study::new(&format!("contact, goal, theta = {theta}"), &mesh()?, unknowns, |mesh, before| {
        let (space, higher) = (Space::scalar(mesh, 1)?, Space::scalar(mesh, 2)?);
        let solved = direct(&model, &space, before)?;
        let u = solved.field();
        let (form, assembler) = (model.adjoint(u), assembler(mesh));
        let p = Problem::new(&form, &higher).assembler(&assembler).solve()?.into_field();
        let localised = |z: &Field<2>| model.localised(u, z);
        let estimate = ErrorEstimate::dual_weighted(&assembler, &p, &space, localised)?;
        let goal = solved.functional(&model.goal(u))?;
        Ok((AdaptiveSolution::new(u.clone(), estimate).with_goal(goal), exact - goal))
    })
}

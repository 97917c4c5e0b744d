//! Adaptive backgrounds: Hertz's cylinder, and problems A, B and C on the half-plane, each cut anew from every mesh.

use forms_contact::hertz::{
    CYLINDER_PRESSED, CutMeasured, Hertz, background, cylinder_cut_from, cylinder_distance, estimate_on_cut,
};
use forms_contact::residual_estimator::cut_frictionless;
use forms_fem::adaptivity::{Adaptation, AdaptiveSolution, ErrorEstimate, InterfaceBand};
use forms_fem::mesh::AdaptiveMesh;
use forms_fem::prelude::*;

use crate::half_plane::{
    HalfPlane, Potential, SIGNORINI, SMOOTH, TRANSITION, background as around_half_plane,
};

type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

#[forms]
mod adjoint_error {
    use forms_contact::laws::cut_nitsche::penetration;
    pub use forms_contact::laws::cut_nitsche::{Data, GammaC, Omega};
    use forms_contact::laws::cut_nitsche::{normal_displacement, normal_stress, stress};
    use forms_contact::operators::obstacle::gamma;
    #[interior_facets]
    pub struct Interior;

    /// h²‖div σ(p)‖² + h‖½⟦σ(p)n⟧‖² + h‖σ(p)n − T‖², T = (σ_n(p) − γ p_n) n_y where u touches.
    pub fn squared(u: State<Vector>, p: State<Vector>, q: Test<Scalar>) -> Form {
        let rest = div(stress(p));
        let jumped = jump(stress(p)) * n;
        let pressed = heaviside(gamma() * penetration(u) - normal_stress(u));
        let miss =
            stress(p) * n - pressed * (normal_stress(p) - gamma() * normal_displacement(p)) * obstacle_normal;
        integral(Omega, sqr(h) * dot(rest, rest) * q)
            + integral(Interior, avg(h) * dot(jumped, jumped) / 2 * avg(q))
            + integral(GammaC, h * dot(miss, miss) * q)
    }
}

/// The exponent of N in errors, by the first and the last of some rows (N, error).
fn exponent(rows: &[[f64; 2]]) -> f64 {
    let [first, last] = [rows[0], rows[rows.len() - 1]];
    (last[1] / first[1]).ln() / (last[0] / first[0]).ln()
}

/// Errors over unknowns of active cells, from 500 of them on, on adaptive meshes.
fn errors(unknowns: usize, solve: impl Fn(&HalfPlane) -> (Field<2>, f64, ErrorEstimate)) -> Vec<[f64; 2]> {
    let mut mesh = around_half_plane(6);
    // What the estimator takes for free lies outside.
    mesh.name_facets("outside", "boundary", |x| x[1] < -0.4).unwrap();
    let mut rows = vec![];
    let on_mesh = |mesh: &Mesh<2>, _: Option<&Field<2>>| -> Outcome<_> {
        let problem = HalfPlane::on(mesh, 2, -1.0);
        let (field, error, estimate) = solve(&problem);
        let mut held = Constraints::new(&problem.space);
        problem.body.cut().ok_or("no cut")?.hold_outside(&mut held)?;
        rows.push([held.free().len() as f64, error]);
        Ok(AdaptiveSolution::new(field, estimate))
    };
    Adaptation::to_unknowns(unknowns).run(mesh, on_mesh, |_| ()).unwrap();
    rows.retain(|row| row[0] > 500.0);
    rows
}

fn sweeps<T>(long: T, short: T) -> T {
    if std::env::var_os("FORMS_SWEEPS").is_some() { long } else { short }
}

#[test]
fn transition_of_contact_has_order_1_in_the_unknowns() {
    let rows = errors(sweeps(20_000, 5000), |problem| {
        let u = problem.solve(&problem.model.direct(), SIGNORINI);
        let regions = cut_frictionless::Regions::default().gamma_n("outside").gamma_c("all");
        let model = cut_frictionless::Model { data: problem.model.data.clone(), regions };
        let estimate = ErrorEstimate::residual(&problem.body, &model.squared(&u)).unwrap();
        let error = problem.error(&u, SIGNORINI);
        println!("A: {} unknowns, η/error {:.2}", problem.space.unknowns(), estimate.value() / error);
        (u, error, estimate)
    });
    println!("A: {rows:?} N^{:.3}", exponent(&rows));
    assert!((exponent(&rows) + 1.0).abs() < 0.1, "N^{} of {rows:?}", exponent(&rows));
}

/// (22) with the contact zone of u, its error and its estimate.
fn adjoint(problem: &HalfPlane, u: &Field<2>, exact: Potential) -> (Field<2>, f64, ErrorEstimate) {
    let p = problem.solve(&problem.model.consistent_adjoint(u), exact);
    let regions = adjoint_error::Regions::default().gamma_c("all");
    let model = adjoint_error::Model { data: problem.model.data.clone(), regions };
    let estimate = ErrorEstimate::residual(&problem.body, &model.squared(u, &p)).unwrap();
    let error = problem.error(&p, exact);
    (p, error, estimate)
}

#[test]
fn transition_of_the_adjoint_has_order_1_in_the_unknowns() {
    let rows = errors(sweeps(20_000, 5000), |problem| {
        adjoint(problem, &problem.solve(&problem.model.direct(), SIGNORINI), TRANSITION)
    });
    println!("B: {rows:?} N^{:.3}", exponent(&rows));
    // At least order 1: at first the error of u, which says where (22) has contact, falls faster.
    assert!(exponent(&rows) < -0.9, "N^{} of {rows:?}", exponent(&rows));
    // With the exact contact zone.
    let rows = errors(sweeps(20_000, 5000), |problem| {
        let u = Field::interpolate(&problem.space, |x| SIGNORINI.displacement(x)).unwrap();
        adjoint(problem, &u, TRANSITION)
    });
    println!("B, exact zone: {rows:?} N^{:.3}", exponent(&rows));
    assert!((exponent(&rows) + 1.0).abs() < 0.1, "N^{} of {rows:?}", exponent(&rows));
}

#[test]
fn smooth_adjoint_has_order_1_in_the_unknowns() {
    let rows = errors(sweeps(20_000, 5000), |problem| {
        let pressed = Field::interpolate(&problem.space, |_| [0.0, -1.0]).unwrap();
        adjoint(problem, &pressed, SMOOTH)
    });
    println!("C: {rows:?} N^{:.3}", exponent(&rows));
    assert!((exponent(&rows) + 1.0).abs() < 0.1, "N^{} of {rows:?}", exponent(&rows));
}

/// Unknowns, errors of a and p0, and the least cell.
fn hertz(problem: &forms_contact::hertz::CutCylinder, u: &Field<2>) -> [f64; 4] {
    let measured = CutMeasured::of(problem, u).unwrap();
    let hertz = Hertz::of_line(measured.force);
    let mesh = problem.space.mesh();
    let least = (0..mesh.cell_count()).map(|cell| mesh.diameter(cell)).fold(f64::INFINITY, f64::min);
    let [reach, middle] = [measured.reach / hertz.reach - 1.0, measured.middle / hertz.peak - 1.0];
    println!(
        "{} unknowns, P {:.4}, a {:+.3} %, p0 {:+.3} %, profile {:.3} %, least {least:.4}",
        problem.space.unknowns(),
        measured.force,
        100.0 * reach,
        100.0 * middle,
        100.0 * measured.profile
    );
    [problem.space.unknowns() as f64, reach, middle, least]
}

#[test]
fn hertz_with_a_tenth_of_the_unknowns() -> Outcome<()> {
    let mut rows = vec![];
    let on_mesh = |mesh: &Mesh<2>, before: Option<&Field<2>>| -> Outcome<_> {
        let problem = cylinder_cut_from(mesh, CYLINDER_PRESSED)?;
        let start =
            before.map_or(Ok(Field::zero(&problem.space)), |u| u.onto(&problem.space).interpolated())?;
        let u = problem.direct()?.start(&start).solve()?.into_field();
        rows.push(hertz(&problem, &u));
        let estimate = estimate_on_cut(&problem, &u)?;
        Ok(AdaptiveSolution::new(u, estimate))
    };
    Adaptation::to_unknowns(3300).run(background(4)?, on_mesh, |_| ())?;
    let [unknowns, reach, middle, least] = rows[rows.len() - 1];
    assert!(reach.abs() < 0.005 && middle.abs() < 0.005, "{rows:?}");
    // A uniform mesh with such cells.
    let evenly = 2.0 * (2.0 * 4.0 * rows[0][3] / least + 1.0).powi(2);
    assert!(10.0 * unknowns < evenly, "{unknowns} {evenly}");
    Ok(())
}

#[test]
fn band_around_the_surface_is_enough() -> Outcome<()> {
    let touches = |x: &[f64; 2]| x[0] < 1.2;
    let band = InterfaceBand::new(0.0, 0.03)?.only_in(&touches);
    let (mesh, _) = band.fitted(&AdaptiveMesh::new(background(8)?)?, |space| -> Outcome<_> {
        Ok(Field::interpolate(space, cylinder_distance)?)
    })?;
    let problem = cylinder_cut_from(mesh.mesh(), CYLINDER_PRESSED)?;
    let u = problem.direct()?.solve()?.into_field();
    let [_, reach, middle, _] = hertz(&problem, &u);
    assert!(reach.abs() < 0.005 && middle.abs() < 0.005, "{reach} {middle}");
    Ok(())
}

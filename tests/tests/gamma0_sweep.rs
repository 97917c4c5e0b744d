//! γ₀ from 0.01 E to 10⁵ E, θ = −1, 0, 1, on straight and curved cells: a wrong answer comes with a warning.
//! FORMS_SWEEPS=1: fifteen γ₀ on all cells; else four, except for curved quadrilaterals.

use forms_contact::ContactProblem;
use forms_contact::forms;
use forms_contact::hollow_cylinder::{
    CONTACT, CONTACT_CELLS, IMPOSED_DISPLACEMENT, INNER_RADIUS, OBSTACLE_DEPTH, OUTER_RADIUS, Settings,
};
use forms_contact::threshold::threshold;
use forms_fem::norms::norms;
use forms_fem::prelude::*;

/// γ₀/E.
const GAMMA0: [f64; 15] = [0.01, 0.03, 0.1, 0.3, 1.0, 2.0, 3.0, 5.0, 8.0, 10.0, 20.0, 100.0, 1e3, 1e4, 1e5];

/// Some of them: far below a threshold, about it, and far above.
const FEWER: [f64; 4] = [0.1, 1.0, 10.0, 1e4];

/// Largest difference from the trusted answer, in the H¹ norm and in the contact force, relative.
const OFF: f64 = 0.05;

/// The paper's cylinder on four cells across, of a shape and a degree.
fn problem(shape: CellShape, degree: usize) -> ContactProblem<2> {
    let settings = Settings::default();
    let mut mesh = annulus(INNER_RADIUS, OUTER_RADIUS, 4, 64, shape, degree).unwrap();
    mesh.name_facets(CONTACT, "outer", |centre| centre[1] < 0.0).unwrap();
    mesh.name_cells_of_facets(CONTACT_CELLS, CONTACT).unwrap();
    let space = Space::vector(&mesh, degree).unwrap();
    let mut constraints = Constraints::new(&space);
    constraints.fix("inner", |_| IMPOSED_DISPLACEMENT).unwrap();
    let (lambda, mu) = settings.lame();
    let data = forms::data()
        .lambda(lambda)
        .mu(mu)
        .gamma0(0.0)
        .obstacle_normal([0.0, -1.0])
        .gap(|x: &[f64; 2]| x[1] + OBSTACLE_DEPTH)
        .theta(-1.0);
    let regions = forms::Regions::default().gamma_n("outer").gamma_c(CONTACT);
    ContactProblem::new(&space, forms::Model { data, regions }, constraints).quadrature(Quadrature::Degree(8))
}

/// u and the contact force.
fn solve(problem: &ContactProblem<2>) -> Option<(Field<2>, f64)> {
    let mut solver = CondensedSolver::default();
    let u = problem.direct().unwrap().solver(&mut solver).solve().ok()?.into_field();
    let force = forms::contact_force(&problem.law.data, &problem.law.regions.gamma_c, &u);
    let force = problem.assembler.functional(&force).unwrap();
    Some((u, force))
}

fn sweep(shape: CellShape, degree: usize, factors: &[f64]) {
    let young = Settings::default().young;
    let mut problem = problem(shape, degree);
    problem.law.data.gamma0 = 10.0 * young;
    // θ = −1 has no threshold.
    let (trusted, trusted_force) = solve(&problem).unwrap();
    let scale = norms(&problem.assembler, &trusted).unwrap().h1;
    println!("\n{shape:?}, degree {degree}, contact force {trusted_force:.6}");
    println!("| γ₀/E | θ | required/E | H¹ difference | force difference | warning |");
    println!("| --: | --: | --: | --: | --: | --- |");
    let (mut warned, mut off) = (0, 0);
    for theta in [-1.0, 0.0, 1.0] {
        for &factor in factors {
            problem.law.data.theta = theta;
            problem.law.data.gamma0 = factor * young;
            let threshold = threshold(&problem, CONTACT_CELLS).unwrap();
            let warning = threshold.warning();
            let differences = solve(&problem).map(|(u, force)| {
                let values = u.values().iter().zip(trusted.values()).map(|(u, trusted)| u - trusted);
                let difference = Field::from_values(&problem.space, values.collect()).unwrap();
                let h1 = norms(&problem.assembler, &difference).unwrap().h1 / scale;
                (h1, (force - trusted_force).abs() / trusted_force)
            });
            let (h1, force) = differences.unwrap_or((f64::NAN, f64::NAN));
            println!(
                "| {factor} | {theta} | {:.3} | {h1:.1e} | {force:.1e} | {} |",
                threshold.required / young,
                if warning.is_some() { "yes" } else { "" }
            );
            let is_off = differences.is_some_and(|(h1, force)| h1.max(force) > OFF);
            assert!(
                !is_off || warning.is_some(),
                "{shape:?}, degree {degree}, θ = {theta}, γ₀ = {factor} E: off by {h1:.1e} and {force:.1e} without a warning"
            );
            if let Some(warning) = warning {
                assert!(theta > -1.0 && warning.contains("threshold"), "{warning}");
                warned += 1;
            }
            off += usize::from(is_off);
        }
    }
    // The warning is worth something: it is neither always there, nor for nothing.
    assert!(off > 0 && warned < 2 * factors.len(), "{off} off, {warned} warnings");
}

fn factors() -> &'static [f64] {
    if std::env::var_os("FORMS_SWEEPS").is_some() { &GAMMA0 } else { &FEWER }
}

#[test]
fn no_wrong_answer_on_straight_triangles() {
    sweep(CellShape::Triangle, 1, factors());
}

#[test]
fn no_wrong_answer_on_curved_triangles() {
    sweep(CellShape::Triangle, 2, factors());
}

#[test]
fn no_wrong_answer_on_straight_quadrilaterals() {
    sweep(CellShape::Quadrilateral, 1, factors());
}

#[test]
fn no_wrong_answer_on_curved_quadrilaterals() {
    sweep(CellShape::Quadrilateral, 2, &GAMMA0);
}

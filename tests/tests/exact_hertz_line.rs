//! Hertz's line contact: an elastic cylinder, R = 8, on a rigid flat. Half a = 2√(RP/πE′), p0 = 2P/(πa) and the
//! pressure p0 √(1 − x²/a²), with E′ = E/(1−ν²), are those of a half-plane with a parabolic boundary: the body is
//! nine times as wide as the contact, which leaves a difference below (a/W)², one percent. a and p0 are taken at the
//! computed force P.

use forms_contact::forms;
use forms_contact::states::{ContactProblem, Regions};
use forms_contact::threshold::required_gamma0;
use forms_fem::prelude::*;

const RADIUS: f64 = 8.0;
const YOUNG: f64 = 200.0;
const POISSON: f64 = 0.3;
/// Half the body's width; its top is at the height of the cylinder's axis.
const WIDTH: f64 = 6.0;
/// Γ_C is the cylinder's boundary up to this x.
const CONTACT_REACH: f64 = 1.2;
/// Displacement of the top, which gives about P = 10 per length.
const PRESSED: f64 = 0.0975;

/// Contact of one half of the body (symmetric in x).
struct Contact {
    force: f64,
    /// (a_h − a)/a.
    half_width_error: f64,
    /// (p_h(0) − p0)/p0.
    peak_error: f64,
    /// ‖p_h − p‖/‖p‖ in L²(Γ_C).
    profile_error: f64,
}

/// Three fifths of the cells lie within 0.15 of the way, of equal size; the others grow.
fn graded(t: f64) -> f64 {
    let (near, slope) = (0.6, 0.25);
    let rest = (1.0 - slope) / (1.0_f64 - near).powi(3);
    slope * t + rest * (t - near).max(0.0).powi(3)
}

fn solve(divisions: usize, theta: f64) -> Contact {
    let map = |[s, t]: [f64; 2]| {
        let x = WIDTH * graded(s);
        [x, -(RADIUS * RADIUS - x * x).sqrt() * (1.0 - graded(t))]
    };
    let shape = CellShape::Quadrilateral;
    let mut mesh = forms_fem::mesh::structured([divisions; 2], shape, 2, map).unwrap();
    mesh.name_facets("contact", "bottom", |centre| centre[0] < CONTACT_REACH).unwrap();
    mesh.name_cells_of_facets("contact cells", "contact").unwrap();
    let mesh = Arc::new(mesh);
    let space = Space::vector(&mesh, 2).unwrap();
    let mut constraints = Constraints::new(&space);
    constraints.fix_component("left", 0, |_| 0.0).unwrap();
    constraints.fix_component("top", 1, |_| -PRESSED).unwrap();
    let data = forms::Data {
        lambda: YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON)),
        mu: YOUNG / (2.0 * (1.0 + POISSON)),
        theta: 1.0,
        gamma0: YOUNG,
        extension: 0.0,
        obstacle_normal: Given::constant([0.0, -1.0]),
        gap: Given::function(|x: &[f64; 2]| x[1] + RADIUS),
        body_force: Given::constant([0.0; 2]),
        traction: Given::constant([0.0; 2]),
        criterion_force: Given::constant([0.0; 2]),
        criterion_weight: Given::constant(0.0),
    };
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(8));
    let regions = Regions::new("right", "contact");
    let mut problem = ContactProblem::new(assembler, &space, data, regions, constraints).unwrap();
    // 1.5 times what θ = 1 asks for.
    problem.data.gamma0 = 1.5 * required_gamma0(&problem, "contact cells").unwrap();
    problem.data.theta = theta;
    let solved = problem.solve_direct(&mut TangentSolver::default(), &NewtonOptions::default(), &mut |_| ());
    let u = solved.unwrap().result.field;
    let (data, gamma_c, assembler) = (&problem.data, &problem.regions.gamma_c, &problem.assembler);
    let force = 2.0 * assembler.functional(&forms::contact_force(data, gamma_c, &u), &[]).unwrap();
    let modulus = YOUNG / (1.0 - POISSON * POISSON);
    let a = 2.0 * (RADIUS * force / (std::f64::consts::PI * modulus)).sqrt();
    let p0 = 2.0 * force / (std::f64::consts::PI * a);
    let length = assembler.functional(&forms::contact_length(data, gamma_c, &u), &[]).unwrap();
    let pressure = forms::contact_pressure(data, &u);
    let points = assembler.at_quadrature_points(&pressure, Entity::Facets, "contact", 8).unwrap();
    let (mut difference, mut whole) = (0.0, 0.0);
    for ((x, weight), value) in points.positions.iter().zip(&points.weights).zip(&points.values) {
        let exact = p0 * (1.0 - (x[0] / a).powi(2)).max(0.0).sqrt();
        difference += weight * (value[0] - exact).powi(2);
        whole += weight * exact * exact;
    }
    let samples = assembler.along_facets_uniformly(&pressure, "contact", 2).unwrap();
    let first = samples.iter().min_by(|a, b| a.position[0].total_cmp(&b.position[0])).unwrap();
    let contact = Contact {
        force,
        half_width_error: (length - a) / a,
        peak_error: (first.value[0] - p0) / p0,
        profile_error: (difference / whole).sqrt(),
    };
    println!(
        "n={divisions} γ₀={} E θ={theta}: P {force:.4} a {a:.5} {length:.5} ({:+.2e}) p0 {p0:.4} ({:+.2e}) profile {:.2e}",
        problem.data.gamma0 / YOUNG,
        contact.half_width_error,
        contact.peak_error,
        contact.profile_error
    );
    contact
}

#[test]
fn a_cylinder_on_a_rigid_flat() {
    for theta in [-1.0, 0.0, 1.0] {
        let meshes = [10, 20, 40].map(|divisions| solve(divisions, theta));
        for pair in meshes.windows(2) {
            assert!(pair[1].half_width_error.abs() < pair[0].half_width_error.abs());
            assert!(pair[1].profile_error < pair[0].profile_error);
        }
        let finest = &meshes[2];
        // p0's error is that of the finite body, not the mesh's.
        assert!((finest.force - 10.0).abs() < 0.05, "P = {}", finest.force);
        assert!(finest.half_width_error.abs() < 0.005, "a: {}", finest.half_width_error);
        assert!(finest.peak_error.abs() < 0.003, "p0: {}", finest.peak_error);
        assert!(finest.profile_error < 0.01, "pressure: {}", finest.profile_error);
    }
}

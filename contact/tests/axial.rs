//! Bodies of revolution in the (r, z) plane: a thick tube and a half ball on a plane.

use forms_contact::ContactProblem;
use forms_contact::laws::axial_nitsche as law;
use forms_fem::mesh::disc;
use forms_fem::prelude::*;
use forms_fem::verification;

fn lame(young: f64, poisson: f64) -> [f64; 2] {
    [young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)), young / (2.0 * (1.0 + poisson))]
}

/// A tube of radii 1 and 2 between fixed planes, with the pressure 1 inside (Lamé): u_r = A r + B/r.
#[test]
fn a_tube_has_the_displacement_of_lame() {
    let [lambda, mu] = lame(10.0, 0.3);
    let a = 1.0 / 3.0 / (2.0 * (lambda + mu));
    let b = 4.0 / 3.0 / (2.0 * mu);
    let mut errors = vec![];
    for cells in [2, 4, 8] {
        let mesh = rectangle([1.0, 0.0], [2.0, 0.5], [cells, 1], CellShape::Quadrilateral, 1).unwrap();
        let space = Space::vector(&mesh, 2).unwrap();
        let mut held = Constraints::new(&space);
        held.fix_component("bottom", 1, |_| 0.0).unwrap();
        held.fix_component("top", 1, |_| 0.0).unwrap();
        let data =
            law::data().lambda(lambda).mu(mu).gamma0(100.0).obstacle_normal([0.0, -1.0]).gap(1.0).theta(0.0);
        let regions = law::Regions::default().gamma_n("left").gamma_c("bottom");
        let model = law::Model { data: data.traction([1.0, 0.0]), regions };
        let problem = ContactProblem::new(&space, model, held).quadrature(Quadrature::Degree(6));
        let solved = problem.direct().unwrap().solve().unwrap();
        let exact = |r: f64| a * r + b / r;
        let worst =
            [1.0, 1.3, 1.7, 2.0].map(|r| (solved.field().evaluate(&[r, 0.2]).unwrap()[0] - exact(r)).abs());
        errors.push(worst.into_iter().fold(0.0, f64::max));
        // ½ a(u,u) is half of the work of the pressure, 2π · 0.5 · u(1) / 2.
        let energy = solved.functional(&problem.law.elastic_energy(solved.field())).unwrap();
        let work = 0.5 * std::f64::consts::TAU * 0.5 * solved.field().evaluate(&[1.0, 0.2]).unwrap()[0];
        assert!((energy / work - 1.0).abs() < 1e-10, "{energy} {work}");
    }
    println!("{errors:?}");
    assert!(errors[2] < 1e-4 * exact_scale(a, b));
    assert!(errors.windows(2).all(|pair| (pair[0] / pair[1]).log2() > 2.8), "{errors:?}");
}

fn exact_scale(a: f64, b: f64) -> f64 {
    a + b
}

/// A half ball of radius 0.4 about z = 0.5 whose flat side is pushed down by a way.
fn half_ball(core: usize, degree: usize, theta: f64, way: f64) -> ContactProblem<2, law::Model<2>> {
    let quarter = disc(0.4, [true; 2], core, core, CellShape::Quadrilateral, 2).unwrap();
    let turned = quarter.nodes().iter().map(|[x, y]| [*y, 0.5 - x]).collect();
    let mut mesh = quarter.with_nodes(turned).unwrap();
    mesh.name_facets("contact", "circle", |x| x[0] < 0.3).unwrap();
    let space = Space::vector(&mesh, degree).unwrap();
    let mut held = Constraints::new(&space);
    held.fix("left", |_| [0.0, -way]).unwrap();
    held.fix_component("bottom", 0, |_| 0.0).unwrap();
    let [lambda, mu] = lame(2e4, 0.3);
    let data = law::data().lambda(lambda).mu(mu).gamma0(80.0 * 2e4).obstacle_normal([0.0, -1.0]);
    let data = data.gap(|x: &[f64; 2]| x[1]).theta(theta).criterion_force(|x: &[f64; 2]| [x[0], 1.0 + x[1]]);
    let regions = law::Regions::default().gamma_n("circle").gamma_c("contact");
    ContactProblem::new(&space, law::Model { data, regions }, held)
        .quadrature(Quadrature::Degree(2 * degree + 2))
}

/// NGSolve, (r, z), degree 4: 277.4 ± 0.1, and the energy 5.274.
#[test]
fn a_half_ball_has_the_reaction_and_the_energy_of_ngsolve() {
    for theta in [-1.0, 0.0, 1.0] {
        let problem = half_ball(16, 3, theta, 0.15);
        let solved = problem.direct().unwrap().solve().unwrap();
        let u = solved.field();
        let force = solved.functional(&problem.law.contact_force(u)).unwrap();
        let energy = solved.functional(&problem.law.elastic_energy(u)).unwrap();
        let reaction = -solved.reaction("left").unwrap()[1];
        println!(
            "θ = {theta}: {} steps, force {force:.4}, reaction {reaction:.4}, energy {energy:.5}",
            solved.iterations()
        );
        assert!((reaction - 277.4).abs() < 0.1 && (energy - 5.274).abs() < 1e-3, "{reaction} {energy}");
    }
}

#[test]
fn the_tangent_and_a_gradient_are_right() {
    let problem = half_ball(4, 2, 1.0, 0.15);
    let solved = problem.direct().unwrap().solve().unwrap();
    let u = solved.field().clone();
    let direction =
        Field::interpolate(u.space(), |x| [0.3 * x[0] * (3.0 * x[1]).cos(), (2.0 * x[0] + x[1]).sin()])
            .unwrap();
    let report =
        verification::tangent(&problem.assembler, &problem.law.direct(), &[&u], &[&direction], 1e-3).unwrap();
    println!("{report}");
    assert!(report.is_affine() || report.second_order().unwrap() > 1.9, "{report}");
    let p = problem.adjoint(&u).unwrap().solve().unwrap().into_field();
    let found = problem.assembler.functional(&problem.law.by_mu(&u, &p)).unwrap();
    let value = |mu: f64| {
        let mut problem = half_ball(4, 2, 1.0, 0.15);
        problem.law.data.mu = mu;
        let u = problem.direct().unwrap().solve().unwrap().into_field();
        problem.assembler.functional(&problem.law.criterion(&u)).unwrap()
    };
    let mu = problem.law.data.mu;
    let step = 1e-4 * mu;
    let difference = (value(mu + step) - value(mu - step)) / (2.0 * step);
    assert!((found - difference).abs() < 1e-6 * difference.abs(), "{found} {difference}");
}

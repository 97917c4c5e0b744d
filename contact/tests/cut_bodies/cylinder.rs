//! The paper's hollow cylinder, cut from a square of triangles: the inner circle is held by Nitsche's method and the outer one touches, both
//! inside cells. The criterion, the contact force and the contact length come to those of fitted meshes with order 2, the length by the pressure's moments.

use forms_contact::hollow_cylinder::{CONTACT, Settings, hollow_cylinder};
use forms_contact::laws::cut_nitsche;
use forms_fem::prelude::*;

use crate::order;

const YOUNG: f64 = 100.0;
const POISSON: f64 = 0.3;
/// R_i and R_e \[cm\].
const RADII: [f64; 2] = [20.0, 30.0];

#[forms(dimension = 2)]
mod moments {
    pub use forms_contact::laws::cut_nitsche::GammaC;
    use forms_contact::laws::cut_nitsche::contact_pressure;

    #[includes(forms_contact::laws::cut_nitsche::Data)]
    pub struct Data {
        pub weight: Given<Scalar>,
    }
    pub fn of_pressure(u: State<Vector>) -> Functional {
        integral(GammaC, weight * contact_pressure(u))
    }
}

/// The length 2a of a contact zone from the moments ∫ sᵏ p, k = 0 … 4, along the arc: those of a pressure √(1 − t²) (c₀ + c₁ t²), t = s/a about its
/// middle. With μ₂ and μ₄, divided by ∫ p, a² = 6μ₂ − √(36μ₂² − 16μ₄); Hertz's pressure has c₁ = 0.
pub fn length_of_moments(moments: [f64; 5]) -> f64 {
    let [_, m1, m2, m3, m4] = moments.map(|moment| moment / moments[0]);
    let second = m2 - m1 * m1;
    let fourth = m4 - 4.0 * m1 * m3 + 6.0 * m1 * m1 * m2 - 3.0 * m1.powi(4);
    2.0 * (6.0 * second - (36.0 * second * second - 16.0 * fourth).sqrt()).sqrt()
}

/// sᵏ, s the way along the outer circle from its lowest point.
fn power_of_arc(k: i32) -> Given<f64, 2> {
    Given::function(move |x: &[f64; 2]| (RADII[1] * x[0].atan2(-x[1])).powi(k))
}

/// J, contact force and contact length, by the discrete zone and by moments, on a square of n × n pairs of triangles, or for degree 2 on quadrilaterals with φ of this degree.
pub fn solve(cells: usize, theta: f64, degree: usize) -> [f64; 4] {
    // No node is on a circle, and the centre of the body is not a node.
    let corner = [-31.013, -31.027];
    let shape = if degree == 2 { CellShape::Quadrilateral } else { CellShape::Triangle };
    let mut mesh = rectangle(corner, [62.0 + corner[0], 62.0 + corner[1]], [cells; 2], shape, 1).unwrap();
    let middle = 0.5 * (RADII[0] + RADII[1]);
    mesh.name_cells("inner", |x| x[0].hypot(x[1]) < middle).unwrap();
    mesh.name_cells("lower", |x| x[0].hypot(x[1]) > middle && x[1] < 0.0).unwrap();
    let phi = Field::interpolate(&Space::scalar(&mesh, degree).unwrap(), |x| {
        let radius = x[0].hypot(x[1]);
        (RADII[0] - radius).max(radius - RADII[1])
    });
    let body = Assembler::new(&mesh).cut_by(&phi.unwrap()).unwrap();
    let space = Space::vector(&mesh, degree).unwrap();
    let mut held = Constraints::new(&space);
    body.cut().unwrap().hold_outside(&mut held).unwrap();
    let (lambda, mu) =
        (YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON)), YOUNG / (2.0 * (1.0 + POISSON)));
    let data = cut_nitsche::data()
        .lambda(lambda)
        .mu(mu)
        .gamma0(10.0 * (degree * degree) as f64 * (2.0 * mu + lambda))
        .obstacle_normal([0.0, -1.0])
        .gap(|x: &[f64; 2]| x[1] + RADII[1])
        .theta(theta)
        .prescribed([0.0, -1.0])
        .criterion_force([0.0, -1.0]);
    let regions = cut_nitsche::regions().gamma_c("lower").gamma_d("inner").gamma_n("boundary");
    let law = cut_nitsche::Model { data, regions };
    let form = law.direct() + law.dirichlet();
    let u = Problem::new(&form, &space).assembler(&body).constrained(&held).solve().unwrap().into_field();
    let of = |functional: &Functional<2>| body.functional(functional).unwrap();
    // With many points, as the integrand jumps.
    let fine = body.clone().with_quadrature(Quadrature::Degree(20));
    let length = fine.functional(&law.contact_length(&u)).unwrap();
    let moments = [0, 1, 2, 3, 4].map(|k| {
        let data = moments::data_from(law.data.clone()).weight(power_of_arc(k));
        let regions = moments::Regions::default().gamma_c("lower");
        fine.functional(&moments::Model { data, regions }.of_pressure(&u)).unwrap()
    });
    [of(&law.criterion(&u)), of(&law.contact_force(&u)), length, length_of_moments(moments)]
}

#[forms(dimension = 2)]
mod fitted_moments {
    pub use forms_contact::nitsche::GammaC;
    use forms_contact::nitsche::contact_pressure;

    #[includes(forms_contact::nitsche::Data)]
    pub struct Data {
        pub weight: Given<Scalar>,
    }
    pub fn of_pressure(u: State<Vector>) -> Functional {
        integral(GammaC, weight * contact_pressure(u))
    }
}

/// The contact length by moments on a fitted mesh of biquadratic cells.
fn fitted_length(radial: usize) -> f64 {
    let problem = hollow_cylinder(&Settings { radial, ..Settings::default() }).unwrap();
    let u = problem.direct().unwrap().solve().unwrap().into_field();
    length_of_moments([0, 1, 2, 3, 4].map(|k| {
        let data = fitted_moments::data_from(problem.law.data.clone()).weight(power_of_arc(k));
        let regions = fitted_moments::Regions::default().gamma_c(CONTACT);
        problem.assembler.functional(&fitted_moments::Model { data, regions }.of_pressure(&u)).unwrap()
    }))
}

/// J of adaptive meshes, the contact force of the main job on 32 × 512 biquadratic cells, the contact length on 128 × 2048.
pub const FITTED: [f64; 3] = [1494.2486, 133.721, 12.302];

fn thetas() -> &'static [f64] {
    match std::env::var_os("FORMS_SWEEPS") {
        Some(_) => &[-1.0, 0.0, 1.0],
        None => &[0.0],
    }
}

#[test]
fn cylinder_comes_to_that_of_fitted_meshes() {
    let meshes = [31, 62, 124];
    for theta in thetas() {
        let found = meshes.map(|cells| solve(cells, *theta, 1));
        for (cells, values) in meshes.iter().zip(&found) {
            let off = [0, 1, 2].map(|k| values[k] / FITTED[k] - 1.0);
            println!("θ = {theta} {cells} × {cells}: {values:?}, off by {off:?}");
        }
        for k in [0, 1] {
            let errors: Vec<f64> = found.iter().map(|values| (values[k] - FITTED[k]).abs()).collect();
            let order = order(&errors);
            println!("θ = {theta}: order {order:.2} of {}", ["J", "the contact force"][k]);
            assert!((order - 2.0).abs() < 0.35, "θ = {theta}: order {order} of {errors:?}");
        }
        // The discrete zone ends somewhere in a cell: order 1, less than a cell at each end.
        let lengths: Vec<f64> = found.iter().map(|values| (values[2] - FITTED[2]).abs()).collect();
        assert!(lengths.windows(2).all(|pair| pair[1] < pair[0]), "{lengths:?}");
        let cell = 62.0 / meshes[meshes.len() - 1] as f64;
        assert!(lengths[lengths.len() - 1] < 2.0 * cell, "{lengths:?}");
    }
}

/// Moments of the pressure are as exact as J, and so is the length that they give.
#[test]
fn contact_length_by_moments_has_order_2() {
    let fitted = fitted_length(32);
    println!("fitted: {fitted}");
    // That of the fitted zone.
    assert!((fitted / FITTED[2] - 1.0).abs() < 1e-3, "{fitted}");
    for theta in thetas() {
        let errors = [62, 124, 248].map(|cells| (solve(cells, *theta, 1)[3] - fitted).abs());
        println!("θ = {theta}: contact length off by {errors:?}, order {:.2}", order(&errors));
        assert!((order(&errors) - 2.0).abs() < 0.35, "θ = {theta}: order {} of {errors:?}", order(&errors));
    }
}

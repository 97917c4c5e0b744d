//! The scalar Signorini problem on a half-plane that is cut at an angle: u = r^{3/2} cos(3ϑ/2), contact for x < 0.

use forms_fem::prelude::*;

use crate::{cut, order, turned};

#[forms]
mod membrane {
    use forms_contact::operators::ghost_penalty::scalar_ghost;

    #[includes(forms_contact::operators::ghost_penalty::Data)]
    pub struct Data {
        pub theta: Param,
        pub gamma0: Param,
        pub slope_of_solution: Given<Vector>,
    }
    #[cells]
    pub struct Omega;
    #[interface]
    pub struct Obstacle;
    #[interior_facets]
    pub struct Ghost;

    fn gamma() -> Scalar {
        gamma0 / h
    }
    fn slope(w: Scalar) -> Scalar {
        dot(grad(w), n)
    }
    fn reaction(w: Scalar) -> Scalar {
        pos_part(slope(w) - gamma() * w)
    }
    pub fn signorini(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v))) + integral(Ghost, scalar_ghost(u, v))
            - integral(Obstacle, theta / gamma() * slope(u) * slope(v))
            + integral(Obstacle, reaction(u) / gamma() * (theta * slope(v) - gamma() * v))
    }
    pub fn error(u: State<Scalar>) -> Functional {
        integral(Omega, dot(grad(u) - slope_of_solution, grad(u) - slope_of_solution))
    }
}

/// Angles from −π/2 to 3π/2, so that the solution continues below the half-plane.
fn angle(x: &[f64; 2]) -> f64 {
    let angle = x[1].atan2(x[0]);
    if angle < -0.5 * std::f64::consts::PI { angle + 2.0 * std::f64::consts::PI } else { angle }
}

fn exact(x: &[f64; 2]) -> f64 {
    x[0].hypot(x[1]).powf(1.5) * (1.5 * angle(x)).cos()
}

fn gradient(x: &[f64; 2]) -> [f64; 2] {
    let root = 1.5 * x[0].hypot(x[1]).sqrt();
    [root * (0.5 * angle(x)).cos(), -root * (0.5 * angle(x)).sin()]
}

fn error(cells: usize, degree: usize, theta: f64) -> f64 {
    let mesh = rectangle([-1.0, -1.0], [1.0, 1.0], [cells; 2], CellShape::Triangle, 1).unwrap();
    let mesh = turned(&mesh, 0.3);
    let body = cut(&mesh, |x| -x[1]).with_quadrature(Quadrature::Degree(8));
    let space = Space::scalar(&mesh, degree).unwrap();
    let mut held = Constraints::new(&space);
    held.fix("boundary", exact).unwrap();
    body.cut().unwrap().hold_outside(&mut held).unwrap();
    let data = membrane::data()
        .theta(theta)
        .gamma0(20.0 * degree as f64)
        .slope_of_solution(Given::function(gradient));
    let regions = membrane::Regions::default().ghost("ghost");
    let model = membrane::Model { data, regions };
    let start = Field::zero(&space);
    let mut solved =
        Problem::new(&model.signorini(), &space).assembler(&body).constrained(&held).start(&start);
    let u = solved.solve().unwrap().into_field();
    body.functional(&model.error(&u)).unwrap().sqrt()
}

#[test]
fn orders_are_those_of_fitted_meshes() {
    for (degree, band) in [(1, 0.94..1.06), (2, 1.35..1.6)] {
        for theta in [-1.0, 0.0, 1.0] {
            let errors = [8, 16, 32].map(|cells| error(cells, degree, theta));
            let found = order(&errors);
            println!("P{degree} θ = {theta}: {errors:?} order {found:.3}");
            assert!(band.contains(&found), "P{degree} θ = {theta}: order {found} of {errors:?}");
        }
    }
}

//! Problems A, B and C: contact on the axis of a half-plane that is cut from a turned mesh. Z is holomorphic, Z̃ its primitive;
//! 2μ u_x = (κ−1)/2 Re Z̃ − y Im Z, 2μ u_y = (κ+1)/2 Im Z̃ − y Re Z.

use forms_contact::laws::cut_nitsche;
use forms_fem::prelude::*;

use crate::{cut, order, turned};

const LAMBDA: f64 = 0.3 / (1.3 * 0.4);
const MU: f64 = 1.0 / 2.6;
const THETAS: [f64; 3] = [-1.0, 0.0, 1.0];

#[forms]
mod errors {
    use forms_contact::operators::linear_elastic::stress;
    #[includes(forms_contact::operators::linear_elastic::Data)]
    pub struct Data {
        pub solution: Given<Tensor>,
    }
    #[cells]
    pub struct Omega;
    pub fn of_stress(u: State<Vector>) -> Functional {
        let miss = stress(u) - solution;
        integral(Omega, inner(miss, miss))
    }
}

/// A complex number.
#[derive(Clone, Copy)]
struct Complex(f64, f64);

impl Complex {
    /// c zᵖ, with angles from −π/2 to 3π/2, so that the solution continues below the axis.
    fn power(x: &[f64; 2], p: f64, factor: Complex) -> Complex {
        let angle = x[1].atan2(x[0]);
        let angle =
            if angle < -0.5 * std::f64::consts::PI { angle + 2.0 * std::f64::consts::PI } else { angle };
        let (size, turn) = (x[0].hypot(x[1]).powf(p), p * angle);
        let (re, im) = (size * turn.cos(), size * turn.sin());
        Complex(factor.0 * re - factor.1 * im, factor.0 * im + factor.1 * re)
    }
    fn plus(self, other: Complex) -> Complex {
        Complex(self.0 + other.0, self.1 + other.1)
    }
}

/// Z, its primitive and its derivative as sums of c zᵖ.
#[derive(Clone, Copy)]
pub struct Potential(&'static [(f64, f64, f64)]);

impl Potential {
    fn at(self, x: &[f64; 2], order: i32) -> Complex {
        self.0.iter().fold(Complex(0.0, 0.0), |sum, &(p, re, im)| {
            let (p, factor) = match order {
                -1 => (p + 1.0, 1.0 / (p + 1.0)),
                0 => (p, 1.0),
                _ => (p - 1.0, p),
            };
            sum.plus(Complex::power(x, p, Complex(re * factor, im * factor)))
        })
    }
    pub fn displacement(self, x: &[f64; 2]) -> [f64; 2] {
        let kappa = (LAMBDA + 3.0 * MU) / (LAMBDA + MU);
        let (z, primitive) = (self.at(x, 0), self.at(x, -1));
        [
            ((kappa - 1.0) / 2.0 * primitive.0 - x[1] * z.1) / (2.0 * MU),
            ((kappa + 1.0) / 2.0 * primitive.1 - x[1] * z.0) / (2.0 * MU),
        ]
    }
    fn stress(self, x: &[f64; 2]) -> [[f64; 2]; 2] {
        let (z, slope) = (self.at(x, 0), self.at(x, 1));
        [[z.0 - x[1] * slope.1, -x[1] * slope.0], [-x[1] * slope.0, z.0 + x[1] * slope.1]]
    }
}

/// i √z, i/√z and 4z³ + 3z².
pub const SIGNORINI: Potential = Potential(&[(0.5, 0.0, 1.0)]);
pub const TRANSITION: Potential = Potential(&[(-0.5, 0.0, 1.0)]);
pub const SMOOTH: Potential = Potential(&[(3.0, 4.0, 0.0), (2.0, 3.0, 0.0)]);

/// The rectangle from which it is cut.
pub fn background(cells: usize) -> Mesh<2> {
    turned(&rectangle([-1.0, -0.9], [1.0, 1.1], [cells; 2], CellShape::Triangle, 1).unwrap(), 0.3)
}

pub struct HalfPlane {
    pub body: Assembler<2>,
    pub space: Arc<Space<2>>,
    pub model: cut_nitsche::Model<2>,
}

impl HalfPlane {
    /// With the transition inside a cell.
    fn new(cells: usize, degree: usize, theta: f64) -> Self {
        Self::on(&background(cells), degree, theta)
    }

    pub fn on(mesh: &Mesh<2>, degree: usize, theta: f64) -> Self {
        let body = cut(mesh, |x| -x[1]).with_quadrature(Quadrature::Degree(8));
        let space = Space::vector(mesh, degree).unwrap();
        let data = cut_nitsche::data()
            .lambda(LAMBDA)
            .mu(MU)
            .gamma0(10.0 * (degree * degree) as f64 * (2.0 * MU + LAMBDA))
            .obstacle_normal([0.0, -1.0])
            .gap(0.0)
            .theta(theta);
        let regions = cut_nitsche::regions().gamma_c("all").gamma_d("all").gamma_n("boundary");
        HalfPlane { body, space, model: cut_nitsche::Model { data, regions } }
    }

    pub fn solve(&self, form: &Form<2>, exact: Potential) -> Field<2> {
        let mut held = Constraints::new(&self.space);
        held.fix("boundary", |x| exact.displacement(x)).unwrap();
        self.body.cut().unwrap().hold_outside(&mut held).unwrap();
        let start = Field::zero(&self.space);
        let mut problem =
            Problem::new(form, &self.space).assembler(&self.body).constrained(&held).start(&start);
        problem.solve().unwrap().into_field()
    }

    pub fn error(&self, field: &Field<2>, exact: Potential) -> f64 {
        let data = errors::data()
            .lambda(LAMBDA)
            .mu(MU)
            .solution(Given::function(move |x: &[f64; 2]| exact.stress(x)));
        self.body.functional(&errors::of_stress(&data, &errors::Omega::on("all"), field)).unwrap().sqrt()
    }
}

fn check(name: &str, degree: usize, band: std::ops::Range<f64>, error: impl Fn(&HalfPlane) -> f64) {
    for theta in THETAS {
        let errors = [8, 16, 32].map(|cells| error(&HalfPlane::new(cells, degree, theta)));
        let found = order(&errors);
        println!("{name} P{degree} θ = {theta}: {errors:?} order {found:.3}");
        assert!(band.contains(&found), "{name} P{degree} θ = {theta}: order {found} of {errors:?}");
    }
}

#[test]
fn transition_of_contact() {
    for (degree, band) in [(1, 0.9..1.1), (2, 1.35..1.65)] {
        check("A", degree, band, |problem| {
            let u = problem.solve(&problem.model.direct(), SIGNORINI);
            problem.error(&u, SIGNORINI)
        });
    }
}

#[test]
fn transition_of_the_adjoint() {
    check("B", 2, 0.4..0.6, |problem| {
        let u = problem.solve(&problem.model.direct(), SIGNORINI);
        let p = problem.solve(&problem.model.consistent_adjoint(&u), TRANSITION);
        problem.error(&p, TRANSITION)
    });
}

#[test]
fn smooth_adjoint() {
    for (degree, band) in [(1, 0.9..1.1), (2, 1.9..2.1)] {
        check("C", degree, band, |problem| {
            let pressed = Field::interpolate(&problem.space, |_| [0.0, -1.0]).unwrap();
            let p = problem.solve(&problem.model.consistent_adjoint(&pressed), SMOOTH);
            problem.error(&p, SMOOTH)
        });
    }
}

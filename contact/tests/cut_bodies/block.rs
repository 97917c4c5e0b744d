//! The contact patch test on cut blocks: the bottom, which touches the obstacle, or a side is inside cells. The solution is linear, and
//! J = ½ a(u, u) = ½ E′δ²w/H has the derivatives −J/H and J/w.

use forms_contact::ContactProblem;
use forms_contact::forms;
use forms_contact::laws::cut_nitsche;
use forms_fem::prelude::*;

use crate::cut;

const YOUNG: f64 = 70.0;
const POISSON: f64 = 0.3;
const PRESSED: f64 = 0.02;
/// E′.
const PLANE_MODULUS: f64 = YOUNG / (1.0 - POISSON * POISSON);
const THETAS: [f64; 3] = [-1.0, 0.0, 1.0];

/// J and its adjoint state, with contact on the interface or on facets.
#[forms(level_set_derivatives)]
mod energy {
    pub use forms_contact::laws::cut_nitsche::{GammaC, Ghost, Omega};
    use forms_contact::laws::cut_nitsche::{elasticity, normal_stress, stabilisation, stress};
    use forms_contact::operators::obstacle::nitsche_density;

    #[includes(forms_contact::laws::cut_nitsche::Data)]
    pub struct Data {
        /// −σ_yy.
        pub pressure: Param,
    }
    #[facets]
    pub struct Bottom;

    fn contact(u: Vector, v: Vector) -> Scalar {
        nitsche_density(normal_stress(u), u, normal_stress(v), v)
    }
    fn density(u: Vector) -> Scalar {
        inner(stress(u), eps(u)) / 2
    }
    fn stored(u: State<Vector>) -> Functional {
        integral(Omega, density(u))
    }
    pub fn weighted(u: State<Vector>, t: Test<Scalar>) -> Form {
        integral(Omega, density(u) * t)
    }
    pub fn missed(u: State<Vector>) -> Functional {
        integral(Omega, sqr(dot(stress(u) * obstacle_normal, obstacle_normal) + pressure))
    }
    pub fn on_interface(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        elasticity(u, v) + stabilisation(u, v) + integral(GammaC, contact(u, v))
    }
    pub fn on_facets(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        elasticity(u, v) + stabilisation(u, v) + integral(Bottom, contact(u, v))
    }
    pub fn adjoint_on_interface(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        derivative(on_interface(u, p), u, q) + derivative(stored(u), u, q)
    }
    pub fn adjoint_on_facets(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        derivative(on_facets(u, p), u, q) + derivative(stored(u), u, q)
    }
}

fn data(theta: f64, degree: usize) -> cut_nitsche::Data<2> {
    let (lambda, mu) =
        (YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON)), YOUNG / (2.0 * (1.0 + POISSON)));
    cut_nitsche::data()
        .lambda(lambda)
        .mu(mu)
        .gamma0(10.0 * (degree * degree) as f64 * (2.0 * mu + lambda))
        .obstacle_normal([0.0, -1.0])
        .gap(|x: &[f64; 2]| x[1])
        .theta(theta)
}

/// A block from y = 0 to `height`, of width `width` from x = 0 on, cut from a larger rectangle whose top and left side are its own.
fn check(phi: impl Fn(&[f64; 2]) -> f64, [width, height]: [f64; 2], theta: f64, degree: usize) {
    let mesh = rectangle([0.0, -0.31], [1.7, height], [7, 5], CellShape::Triangle, 1).unwrap();
    let space = Space::vector(&mesh, degree).unwrap();
    let body = cut(&mesh, phi);
    let mut held = Constraints::new(&space);
    held.fix_component("top", 1, |_| -PRESSED).unwrap();
    held.fix_component("left", 0, |_| 0.0).unwrap();
    body.cut().unwrap().hold_outside(&mut held).unwrap();
    let regions = cut_nitsche::regions().gamma_c("all").gamma_d("all").gamma_n("right");
    let law = cut_nitsche::Model { data: data(theta, degree), regions };
    let problem = ContactProblem::new(&space, law.clone(), held.clone()).assembler(body.clone());
    let u = problem.direct().unwrap().solve().unwrap().into_field();
    let strain = PRESSED / height;
    let expected = |x: &[f64; 2]| [POISSON / (1.0 - POISSON) * strain * x[0], -strain * x[1]];
    let nodes = space.positions().iter().enumerate();
    for (node, x) in nodes.filter(|(node, _)| !held.is_prescribed(2 * node + 1)) {
        for (found, expected) in u.at_node(node).iter().zip(expected(x)) {
            assert!((found - expected).abs() < 1e-10 * PRESSED, "u at {x:?}: {found} is not {expected}");
        }
    }
    let force = body.functional(&law.contact_force(&u)).unwrap();
    let exact = PLANE_MODULUS * strain * width;
    assert!((force / exact - 1.0).abs() < 1e-10, "force {force} is not {exact}");
    let length = body.functional(&law.contact_length(&u)).unwrap();
    assert!((length / width - 1.0).abs() < 1e-10, "length {length} is not {width}");
}

#[test]
fn bottom_is_cut() {
    for theta in THETAS {
        for degree in [1, 2] {
            check(|x| -x[1], [1.7, 0.8], theta, degree);
        }
    }
}

/// The bottom is fitted and its facets are clipped by the side, which is cut and free of load.
#[test]
fn side_is_cut() {
    let (width, height) = (1.3, 0.8);
    for theta in THETAS {
        for degree in [1, 2] {
            let mesh = rectangle([0.0, 0.0], [1.7, height], [7, 4], CellShape::Triangle, 1).unwrap();
            let space = Space::vector(&mesh, degree).unwrap();
            let body = cut(&mesh, |x| x[0] - width);
            let mut held = Constraints::new(&space);
            held.fix_component("top", 1, |_| -PRESSED).unwrap();
            held.fix_component("left", 0, |_| 0.0).unwrap();
            body.cut().unwrap().hold_outside(&mut held).unwrap();
            let cut = cut_nitsche::Model { data: data(theta, degree), regions: cut_nitsche::regions() };
            let fitted = forms::data()
                .lambda(cut.data.lambda)
                .mu(cut.data.mu)
                .gamma0(cut.data.gamma0)
                .obstacle_normal([0.0, -1.0])
                .gap(0.0)
                .theta(theta);
            let regions = forms::Regions::default().gamma_n("right").gamma_c("bottom");
            let fitted = forms::Model { data: fitted, regions };
            let form = fitted.direct() + cut.stabilisation();
            let solved = Problem::new(&form, &space).assembler(&body).constrained(&held).solve().unwrap();
            let (u, strain) = (solved.field(), PRESSED / height);
            let nodes = space.positions().iter().enumerate();
            for (node, x) in nodes.filter(|(node, _)| !held.is_prescribed(2 * node)) {
                let expected = [POISSON / (1.0 - POISSON) * strain * x[0], -strain * x[1]];
                for (found, expected) in u.at_node(node).iter().zip(expected) {
                    assert!(
                        (found - expected).abs() < 1e-10 * PRESSED,
                        "u at {x:?}: {found} is not {expected}"
                    );
                }
            }
            let force = body.functional(&fitted.contact_force(u)).unwrap();
            let exact = PLANE_MODULUS * strain * width;
            assert!((force / exact - 1.0).abs() < 1e-10, "force {force} is not {exact}");
        }
    }
}

/// The boundary that is inside cells.
#[derive(Clone, Copy, Debug, PartialEq)]
enum CutPart {
    Bottom,
    Side,
}

/// ∂J/∂H = −J/H where the bottom moves and takes the obstacle along, ∂J/∂w = J/w where the side does.
fn check_derivative(part: CutPart, theta: f64, degree: usize) {
    let (width, height) = (if part == CutPart::Side { 1.3 } else { 1.7 }, 0.8);
    let lower = if part == CutPart::Bottom { -0.31 } else { 0.0 };
    let mesh = rectangle([0.0, lower], [1.7, height], [7, 5], CellShape::Triangle, 1).unwrap();
    let space = Space::vector(&mesh, degree).unwrap();
    let body = cut(&mesh, |x| if part == CutPart::Bottom { -x[1] } else { x[0] - width });
    let mut held = Constraints::new(&space);
    held.fix_component("top", 1, |_| -PRESSED).unwrap();
    held.fix_component("left", 0, |_| 0.0).unwrap();
    body.cut().unwrap().hold_outside(&mut held).unwrap();
    let regions = energy::Regions::default().gamma_c("all").ghost("ghost").bottom("bottom");
    let pressure = PLANE_MODULUS * PRESSED / height;
    let data = energy::data_from(data(theta, degree).gap(0.0)).pressure(pressure);
    let model = energy::Model { data, regions };
    let direct = if part == CutPart::Bottom { model.on_interface() } else { model.on_facets() };
    let u = Problem::new(&direct, &space).assembler(&body).constrained(&held).solve().unwrap().into_field();
    let adjoint =
        if part == CutPart::Bottom { model.adjoint_on_interface(&u) } else { model.adjoint_on_facets(&u) };
    let p = Problem::new(&adjoint, &space).assembler(&body).homogeneous(&held).solve().unwrap().into_field();

    let missed = (body.functional(&model.missed(&u)).unwrap() / (width * height)).sqrt() / pressure;
    assert!(missed < 1e-10, "σ_yy is off by {missed}");
    let one = Field::interpolate(&Space::discontinuous_scalar(&mesh, 0).unwrap(), |_| 1.0).unwrap();
    let weighted = model.weighted(&u);
    let found: f64 = body.linear_form(&weighted, one.space()).unwrap().iter().sum();
    let criterion = 0.5 * pressure * PRESSED * width;
    assert!((found / criterion - 1.0).abs() < 1e-10, "J = {found} is not {criterion}");
    let own = body.derivative_by_level_set(&weighted, &[], &[&one]).unwrap();
    let by_state = body.derivative_by_level_set(&direct, &[&u], &[&p]).unwrap();
    // φ + t is the block that is shorter or narrower by t.
    let slope = -own.iter().chain(&by_state).sum::<f64>();
    let expected = if part == CutPart::Bottom { -criterion / height } else { criterion / width };
    let apart = (slope / expected - 1.0).abs();
    println!("{part:?} θ = {theta} P{degree}: {slope} is {expected}, apart {apart:.1e}");
    assert!(apart < 1e-10, "{part:?} θ = {theta} P{degree}: {slope} is not {expected}");
}

#[test]
fn derivatives_by_height_and_width_are_exact() {
    for part in [CutPart::Bottom, CutPart::Side] {
        for theta in THETAS {
            check_derivative(part, theta, 1);
            check_derivative(part, theta, 2);
        }
    }
}

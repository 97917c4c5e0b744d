//! Branches that are not taken, of laws that read stresses and precede other factors: a plan of the tangent takes such
//! factors apart, and what is no number in a branch must stay inside of it. On contact pairs, facets and cells.

use forms_core::forms;
use forms_core::real::Real;
use toy_backend::contract::{Dim, Dimension, Entity, Form, Pairing};
use toy_backend::lanes::Four;
use toy_backend::mesh::Mesh;
use toy_backend::random::Random;
use toy_backend::{Nodal, residual, tangent};

/// Not a number below zero, and neither are its derivatives.
pub fn root<R: Real>(p: R) -> R {
    p.powf(R::from(0.3))
}

#[forms(crate = toy_backend)]
pub mod laws {
    extern "Rust" {
        fn root(p: Scalar) -> Scalar;
    }
    pub struct Data {
        lambda: Param,
        mu: Param,
        gamma0: Param,
        m: Param,
        zero: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Wall;
    #[pairs]
    pub struct Touch;

    fn stress(w: Vector) -> Tensor {
        2 * mu * eps(w) + lambda * tr(eps(w)) * I
    }
    fn pressure(u: Vector) -> Scalar {
        gamma0 / this(h) * (dot(jump(u), toward) - gap) - dot(this(stress(u) * n), toward)
    }
    /// Each has no value, or an infinite one, where p is negative, or where the parameter `zero` is zero.
    fn power(p: Scalar) -> Scalar {
        if p > 0 { pow(p, m) } else { 0 }
    }
    fn power_of_two(p: Scalar, q: Scalar) -> Scalar {
        if p > 0 { pow(p, q) } else { 0 }
    }
    fn square_root(p: Scalar) -> Scalar {
        if p > 0 { sqrt(p) } else { 0 }
    }
    fn logarithm(p: Scalar) -> Scalar {
        if p > 0 { ln(p) + log10(p) } else { 0 }
    }
    fn quotient(p: Scalar) -> Scalar {
        if p > 0 { m / (abs(p) + p) } else { 0 }
    }
    fn overflow(p: Scalar) -> Scalar {
        if p > 0 { m * exp(-10000 * p) + sinh(10000 * p) } else { 0 }
    }
    fn large_power(p: Scalar) -> Scalar {
        if p > 0 {
            m * pow(10000000000 * p, 80) + pow(100000000000000000000000000000000000000000000000000 * p, 15)
        } else {
            0
        }
    }
    fn by_parameter(p: Scalar) -> Scalar {
        if zero > 0 { m * p / zero } else { 0 }
    }
    fn in_rust(p: Scalar) -> Scalar {
        if p > 0 { m * root(p) } else { 0 }
    }
    fn arcs(p: Scalar) -> Scalar {
        if p > 0 { acosh(1 + p) + atanh(p / (1 + p)) + m * asin(1 - 1000 * p) } else { 0 }
    }
    fn tensors(A: Tensor) -> Scalar {
        if tr(A) > 0 { m * tr(tensor_sqrt(A)) + tr(inv(A)) + norm(tensor_ln(A)) } else { 0 }
    }
    fn nested(p: Scalar) -> Scalar {
        if p > 0 {
            if sqrt(p) > 1 { pow(p, m) } else { m * sqrt(p) }
        } else if p > -1000 {
            0
        } else {
            m * ln(-p)
        }
    }
    fn all(p: Scalar) -> Vector<10> {
        [
            power(p),
            square_root(p),
            logarithm(p),
            quotient(p),
            overflow(p),
            large_power(p),
            by_parameter(p),
            in_rust(p),
            arcs(p),
            nested(p),
        ]
    }

    pub fn on_pairs(u: Unknown<Vector>, t: Unknown<Scalar>, s: Test<Scalar>) -> Form {
        let f = all(pressure(u));
        integral(Touch, (f[0] + f[1]) * jump(t) * jump(s))
            + integral(Touch, f[2] * jump(t) * jump(s))
            + integral(Touch, f[3] * jump(t) * jump(s))
            + integral(Touch, f[4] * jump(t) * jump(s))
            + integral(Touch, f[5] * jump(t) * jump(s))
            + integral(Touch, f[6] * jump(t) * jump(s))
            + integral(Touch, f[7] * jump(t) * jump(s))
            + integral(Touch, f[8] * jump(t) * jump(s))
            + integral(Touch, f[9] * jump(t) * jump(s))
    }
    /// One law each: a plan is made for the sum of a region.
    pub fn pow_on_pairs(u: Unknown<Vector>, t: Unknown<Scalar>, s: Test<Scalar>) -> Form {
        integral(Touch, power(pressure(u)) * jump(t) * jump(s))
    }
    pub fn ln_on_pairs(u: Unknown<Vector>, t: Unknown<Scalar>, s: Test<Scalar>) -> Form {
        integral(Touch, m * logarithm(pressure(u)) * jump(t) * jump(s))
    }
    pub fn quotient_on_pairs(u: Unknown<Vector>, t: Unknown<Scalar>, s: Test<Scalar>) -> Form {
        integral(Touch, quotient(pressure(u)) * jump(t) * jump(s))
    }
    pub fn overflow_on_pairs(u: Unknown<Vector>, t: Unknown<Scalar>, s: Test<Scalar>) -> Form {
        integral(Touch, overflow(pressure(u)) * jump(t) * jump(s))
    }
    pub fn large_power_on_pairs(u: Unknown<Vector>, t: Unknown<Scalar>, s: Test<Scalar>) -> Form {
        integral(Touch, large_power(pressure(u)) * jump(t) * jump(s))
    }
    pub fn parameter_on_pairs(u: Unknown<Vector>, t: Unknown<Scalar>, s: Test<Scalar>) -> Form {
        integral(Touch, by_parameter(pressure(u)) * jump(t) * jump(s))
    }
    pub fn rust_on_pairs(u: Unknown<Vector>, t: Unknown<Scalar>, s: Test<Scalar>) -> Form {
        integral(Touch, in_rust(pressure(u)) * jump(t) * jump(s))
    }
    pub fn arcs_on_pairs(u: Unknown<Vector>, t: Unknown<Scalar>, s: Test<Scalar>) -> Form {
        integral(Touch, arcs(pressure(u)) * jump(t) * jump(s))
    }
    pub fn nested_on_pairs(u: Unknown<Vector>, t: Unknown<Scalar>, s: Test<Scalar>) -> Form {
        integral(Touch, nested(pressure(u)) * jump(t) * jump(s))
    }
    /// The exponent is an unknown, too.
    pub fn exponent_on_pairs(u: Unknown<Vector>, t: Unknown<Scalar>, s: Test<Scalar>) -> Form {
        integral(Touch, power_of_two(pressure(u), this(t)) * jump(t) * jump(s))
    }
    pub fn by_exponent(u: Unknown<Vector>, t: Unknown<Scalar>, s: Test<Scalar>) -> Form {
        derivative(pow_on_pairs(u, t, s), m, 1)
    }
    pub fn twice(u: Unknown<Vector>, t: Unknown<Scalar>, s: Test<Scalar>) -> Form {
        derivative(derivative(pow_on_pairs(u, t, s), m, 1), m, 1)
            + derivative(pow_on_pairs(u, t, s), gamma0, 1)
    }
    pub fn tensors_on_pairs(u: Unknown<Vector>, t: Unknown<Scalar>, s: Test<Scalar>) -> Form {
        integral(Touch, tensors(this(stress(u)) - I) * jump(t) * jump(s))
    }
    pub fn on_facets(u: Unknown<Vector>, t: Unknown<Scalar>, s: Test<Scalar>) -> Form {
        let p = dot(stress(u) * n, n) - 1;
        let f = all(p);
        integral(Wall, (f[0] + f[1] + f[2] + f[3] + f[4] + f[5] + f[6] + f[7] + f[8] + f[9]) * t * s)
            + integral(Wall, m * power(p) * t * s)
    }
    pub fn in_cells(u: Unknown<Vector>, t: Unknown<Scalar>, s: Test<Scalar>) -> Form {
        let p = inner(stress(u), stress(u)) - 1;
        integral(Omega, (power(p) + logarithm(p) + quotient(p)) * dot(grad(t), grad(s)))
    }
    /// The second derivative of an energy.
    pub fn energy(u: Unknown<Vector>, t: Unknown<Scalar>) -> Energy {
        integral(Touch, (power(pressure(u)) + nested(pressure(u))) * sqr(jump(t)))
    }
}

/// A law whose tangent is compared with its products with vectors, too.
#[forms(crate = toy_backend, matrix_free, dimension = 2)]
pub mod products {
    pub use super::laws::{Data, Touch, pow_on_pairs};
}

/// At u = 0 all points are open (p < 0): residual and tangent are zero, in one lane and in four.
fn is_nothing<const D: usize>(name: &str, mesh: &Mesh<D>, form: &Form<D>)
where
    Dim: Dimension<D>,
{
    let mut random = Random(4);
    let nodes = mesh.nodes.len();
    let unknowns = [Nodal { components: D, values: vec![0.0; D * nodes] }, random.field(nodes, 1, 1.0, 0.5)];
    for vector in [residual::<f64, D>(mesh, form, &unknowns), residual::<Four, D>(mesh, form, &unknowns)] {
        let wrong = vector.iter().filter(|entry| **entry != 0.0).count();
        assert_eq!(wrong, 0, "{name} in {D}D: {wrong} of {} entries of the residual", vector.len());
    }
    for matrix in [tangent::<f64, D>(mesh, form, &unknowns), tangent::<Four, D>(mesh, form, &unknowns)] {
        let wrong = matrix.iter().filter(|row| row.iter().any(|entry| *entry != 0.0)).count();
        assert_eq!(wrong, 0, "{name} in {D}D: {wrong} of {} rows of the tangent", matrix.len());
    }
}

fn nothing_poisons<const D: usize>()
where
    Dim: Dimension<D>,
{
    let mesh = Mesh::<D>::cube(&mut Random(62)).broken();
    let touch = || laws::Touch::on(Pairing::within("boundary"));
    let (omega, wall) = (laws::Omega::on("all"), laws::Wall::on("boundary"));
    // Bodies overlap in this mesh: with a negative γ₀ they are apart.
    let data = laws::data::<D>().lambda(1.3).mu(0.7).gamma0(-5.0).m(0.95).zero(0.0);
    macro_rules! check {
        ($($name:ident)*) => { $( is_nothing(stringify!($name), &mesh, &laws::$name(&data, &touch())); )* };
    }
    check! {
        on_pairs pow_on_pairs ln_on_pairs quotient_on_pairs overflow_on_pairs large_power_on_pairs parameter_on_pairs
        rust_on_pairs arcs_on_pairs nested_on_pairs exponent_on_pairs by_exponent twice tensors_on_pairs energy
    }
    is_nothing("on_facets", &mesh, &laws::on_facets(&data, &wall));
    is_nothing("in_cells", &mesh, &laws::in_cells(&data, &omega));
    assert!(mesh.elements(Entity::Pairs, "").iter().any(|pair| !pair.points.is_empty()));
}

#[test]
fn a_branch_that_is_not_taken_poisons_no_factor() {
    nothing_poisons::<2>();
    nothing_poisons::<3>();
}

/// So that the test above shows something: where the branch is taken, the laws are there, and their tangents are right.
#[test]
fn the_branch_that_is_taken_counts() {
    let mut random = Random(62);
    let mesh = Mesh::<2>::cube(&mut random).broken();
    let nodes = mesh.nodes.len();
    let data = laws::data::<2>().lambda(1.3).mu(0.7).gamma0(5.0).m(0.95).zero(0.0);
    let form = products::pow_on_pairs(&data, &laws::Touch::on(Pairing::within("boundary")));
    let unknowns = [random.field(nodes, 2, 0.0, 0.1), random.field(nodes, 1, 1.0, 0.5)];
    let matrix = tangent::<f64, 2>(&mesh, &form, &unknowns);
    assert!(matrix.iter().flatten().any(|entry| *entry != 0.0));
    toy_backend::differences::check_tangent(&mesh, &form, &unknowns, &mut random);
}

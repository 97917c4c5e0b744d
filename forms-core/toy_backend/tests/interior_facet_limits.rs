//! Limits, jumps and averages on interior facets, in 2D and 3D: values against plain floating-point code,
//! tangents against differences.

use forms_core::forms;
use toy_backend::contract::*;
use toy_backend::interpolate::{gradient, slope, value};
use toy_backend::mesh::Mesh;
use toy_backend::operator_module;
use toy_backend::plain::{Components, Matrix, assert_values, dot, matrix, vector};
use toy_backend::random::Random;
use toy_backend::{Nodal, differences, expression};

/// The state in one of the two cells.
struct Limit {
    u: Vec<f64>,
    grad_u: Matrix,
    s: f64,
    grad_s: Vec<f64>,
    h: f64,
    volume: f64,
}

/// The state at a point of a facet.
struct At {
    d: usize,
    this: Limit,
    other: Limit,
    n: Vec<f64>,
    x: Vec<f64>,
    area: f64,
}

const A: f64 = 0.8;

/// A mesh whose functions may jump, and a random state (u, s) on it.
struct State<const D: usize> {
    mesh: Mesh<D>,
    unknowns: [Nodal; 2],
    random: Random,
}

impl<const D: usize> State<D> {
    fn new(seed: u64) -> Self {
        let mut random = Random(seed);
        let mesh = Mesh::<D>::cube(&mut random).broken();
        let nodes = mesh.nodes.len();
        let unknowns = [random.field(nodes, D, 0.1, 0.25), random.field(nodes, 1, 0.15, 0.4)];
        State { mesh, unknowns, random }
    }

    fn points(&self) -> Vec<At> {
        let mut all = Vec::new();
        for facet in self.mesh.elements(Entity::InteriorFacets, "skeleton") {
            for (index, point) in facet.points.iter().enumerate() {
                let [u, s] = &self.unknowns;
                let limit = |side: Side| {
                    let place = facet.on(side);
                    let distance: f64 = (0..D)
                        .map(|k| {
                            (place.points[index].geometry.position[k] - point.geometry.position[k]).abs()
                        })
                        .sum();
                    assert!(distance < 1e-14, "the two cells see one point");
                    Limit {
                        u: vector(D, |i| value(place, index, u, i)),
                        grad_u: matrix(D, |i, j| slope(place, index, u, i, j)),
                        s: value(place, index, s, 0),
                        grad_s: gradient(place, index, s),
                        h: place.cell.diameter,
                        volume: place.cell.cell_volume,
                    }
                };
                all.push(At {
                    d: D,
                    this: limit(Side::This),
                    other: limit(Side::Other),
                    n: point.geometry.normal.to_vec(),
                    x: point.geometry.position.to_vec(),
                    area: facet.cell.facet_area,
                });
            }
        }
        all
    }

    fn check_value<R: Components>(&self, value: &Expression<D>, expected: impl Fn(&At) -> R) {
        let found = expression(&self.mesh, value, (Entity::InteriorFacets, "skeleton"));
        assert_values(&found, self.points().iter().map(expected));
    }
}

/// One operator: a module with its value and a form that holds it, and the test of both.
macro_rules! operator {
    ($name:ident: Scalar { $($body:tt)* } $expected:expr) => {
        operator! { @ $name Scalar Scalar { $($body)* } { value(u, s) * jump(v) } $expected }
    };
    ($name:ident: Vector { $($body:tt)* } $expected:expr) => {
        operator! { @ $name Vector Vector { $($body)* } { dot(value(u, s), avg(v)) } $expected }
    };
    ($name:ident: Tensor { $($body:tt)* } $expected:expr) => {
        operator! { @ $name Tensor Vector { $($body)* } { inner(value(u, s), other(grad(v))) } $expected }
    };
    (@ $name:ident $rank:ident $test:ident { $($body:tt)* } { $($density:tt)* } $expected:expr) => {
        operator_module! {
            $name: $rank tested by $test, on #[interior_facets] Skeleton "skeleton", seeds 41 42,
            data { a: Param } = { a: A },
            value { $($body)* } density { $($density)* } expected $expected
        }
    };
}

operator! { jump_and_average: Scalar { jump(s) * avg(s) }
|p: &At| (p.this.s - p.other.s) * 0.5 * (p.this.s + p.other.s) }
operator! { jump_of_vector: Vector { jump(u) } |p: &At| vector(p.d, |i| p.this.u[i] - p.other.u[i]) }
operator! { jump_of_scalar_along_normal: Vector { jump(s, n) }
|p: &At| vector(p.d, |i| (p.this.s - p.other.s) * p.n[i]) }
operator! { jump_of_vector_along_normal: Scalar { jump(u, n) }
|p: &At| dot(&p.this.u, &p.n) - dot(&p.other.u, &p.n) }
operator! { jump_of_tensor_along_normal: Vector { jump(grad(u), n) }
|p: &At| vector(p.d, |i| dot(&p.this.grad_u[i], &p.n) - dot(&p.other.grad_u[i], &p.n)) }
// The outward normal turns with the side.
operator! { jump_of_flux: Scalar { jump(dot(grad(s), n)) }
|p: &At| dot(&p.this.grad_s, &p.n) + dot(&p.other.grad_s, &p.n) }
operator! { average_of_gradient: Tensor { avg(grad(u)) }
|p: &At| matrix(p.d, |i, j| 0.5 * (p.this.grad_u[i][j] + p.other.grad_u[i][j])) }
operator! { limits: Scalar { this(s * s) * other(exp(s)) } |p: &At| p.this.s * p.this.s * p.other.s.exp() }
operator! { limits_of_geometry: Scalar {
    (this(h) / other(h) + avg(cell_volume) * facet_area + 3 * dot(other(n), n) + avg(curvature)) * avg(s)
} |p: &At| {
    let volume = 0.5 * (p.this.volume + p.other.volume);
    (p.this.h / p.other.h + volume * p.area - 3.0) * 0.5 * (p.this.s + p.other.s)
} }
operator! { what_needs_no_side: Scalar { x[0] * avg(s * s) + a * dot(avg(u), n) + jump(a) + jump(x[1]) } |p: &At| {
    let mean = vector(p.d, |i| 0.5 * (p.this.u[i] + p.other.u[i]));
    p.x[0] * 0.5 * (p.this.s * p.this.s + p.other.s * p.other.s) + A * dot(&mean, &p.n)
} }
operator! { average_of_flux: Scalar { let flux = (1 + s * s) * grad(s); dot(avg(flux), n) } |p: &At| {
    let flux = |limit: &Limit| (1.0 + limit.s * limit.s) * dot(&limit.grad_s, &p.n);
    0.5 * (flux(&p.this) + flux(&p.other))
} }
operator! { gradient_of_limits: Vector { grad(this(s) * other(s)) }
|p: &At| vector(p.d, |k| p.this.grad_s[k] * p.other.s + p.this.s * p.other.grad_s[k]) }
operator! { diff_by_one_side: Scalar { let w = this(s); diff(w * w * other(s), w) }
|p: &At| 2.0 * p.this.s * p.other.s }
operator! { diff_by_a_field_moves_both_sides: Scalar { diff(this(s) * other(s), s) } |p: &At| p.this.s + p.other.s }
operator! { derivative_takes_the_sides_of_the_field: Scalar { derivative(jump(s) * jump(s), s, u[0]) }
|p: &At| 2.0 * (p.this.s - p.other.s) * (p.this.u[0] - p.other.u[0]) }
operator! { limit_of_derivative: Scalar { this(derivative(s * s, s, u[0])) } |p: &At| 2.0 * p.this.s * p.this.u[0] }
operator! { limit_of_diff: Scalar { let w = s; other(diff(w * w, w)) } |p: &At| 2.0 * p.other.s }
operator! { largest_of_both: Scalar { max(abs(this(s)), abs(other(s))) * jump(s) }
|p: &At| p.this.s.abs().max(p.other.s.abs()) * (p.this.s - p.other.s) }
operator! { upwind: Scalar { if dot(avg(u), n) > 0 { this(s) } else { other(s) } } |p: &At| {
    let flow = dot(&p.this.u, &p.n) + dot(&p.other.u, &p.n);
    if flow > 0.0 { p.this.s } else { p.other.s }
} }
operator! { part_of_jump: Scalar { neg_part(jump(s)) } |p: &At| (p.other.s - p.this.s).max(0.0) }

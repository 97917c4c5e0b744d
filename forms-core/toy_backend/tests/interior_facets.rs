//! Forms on interior facets, in 2D and 3D: interior penalties, fluxes with kinks, energies of jumps, against
//! loops written out; what is proved of each pair of sides.

use forms_core::described::Described;
use forms_core::forms;
use toy_backend::contract::*;
use toy_backend::interpolate::{gradient, value};
use toy_backend::lanes::Four;
use toy_backend::mesh::Mesh;
use toy_backend::random::Random;
use toy_backend::{Nodal, differences, functional, residual, switches, tangent};

type Matrix = Vec<Vec<f64>>;

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[forms(crate = toy_backend, matrix_free)]
pub mod discontinuous {
    pub struct Data {
        gamma: Param,
        k: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Gamma;
    #[interior_facets]
    pub struct Skeleton;

    /// Poisson by the symmetric interior penalty method, without boundary conditions.
    pub fn interior_penalty(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)))
            - integral(Skeleton, dot(avg(grad(u)), n) * jump(v) + jump(u) * dot(avg(grad(v)), n))
            + integral(Skeleton, gamma / avg(h) * jump(u) * jump(v))
            - integral(Gamma, dot(grad(u), n) * v)
    }
    /// The same by UFL's jump along the normal.
    pub fn interior_penalty_along_normal(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)))
            - integral(Skeleton, dot(avg(grad(u)), jump(v, n)) + dot(jump(u, n), avg(grad(v))))
            + integral(Skeleton, gamma / avg(h) * dot(jump(u, n), jump(v, n)))
            - integral(Gamma, dot(grad(u), n) * v)
    }
    /// One term less: not symmetric.
    pub fn incomplete(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Skeleton, gamma * jump(u) * jump(v) - dot(avg(grad(u)), n) * jump(v))
    }
    /// Burgers' equation along the first axis with the local Lax–Friedrichs flux.
    pub fn burgers(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        let speed = max(abs(this(u)), abs(other(u)));
        integral(Skeleton, (avg(u * u / 2) * n[0] + speed / 2 * jump(u)) * jump(v))
    }
    /// A kink that both cells see.
    pub fn outflow(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Skeleton, avg(pos_part(u)) * jump(v))
    }
    /// The transposed derivative of `burgers`.
    pub fn adjoint_of_burgers(u: State<Scalar>, p: Unknown<Scalar>, q: Test<Scalar>) -> Form {
        derivative(burgers(u, p), u, q)
    }
    /// A cohesive zone between cells that resists opening, and the bulk.
    pub fn cohesive(u: Unknown<Vector>) -> Energy {
        let opening = jump(u);
        let normal_opening = dot(opening, n);
        integral(Omega, inner(grad(u), grad(u)) / 2)
            + integral(
                Skeleton,
                gamma / avg(h) * pow(pos_part(normal_opening), 2) * (1 + dot(avg(u), avg(u)))
                    + pow(dot(opening, opening), 2),
            )
    }
    pub fn jumps(u: State<Scalar>) -> Functional {
        integral(Skeleton, avg(k) * pow(jump(u), 2) / facet_area)
    }
    pub fn slope_of_jumps(u: State<Scalar>, v: Test<Scalar>) -> Form {
        derivative(jumps(u), u, v)
    }
    pub fn jump_of_data(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Skeleton, (this(k) + 2 * other(k)) * avg(u) * avg(v))
    }
    /// The biharmonic equation with continuous functions: the C⁰ interior penalty method.
    pub fn continuous_penalty(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        let bending = avg(dot(hess(u) * n, n));
        integral(Skeleton, gamma / avg(h) * jump(grad(u), n) * jump(grad(v), n) - bending * jump(grad(v), n))
    }
}

fn data<const D: usize>() -> discontinuous::Data<D> {
    discontinuous::data().gamma(3.0).k(1.0)
}

fn regions() -> (discontinuous::Omega, discontinuous::Gamma, discontinuous::Skeleton) {
    use discontinuous::*;
    (Omega::on("all"), Gamma::on("boundary"), Skeleton::on("skeleton"))
}

fn assert_matrix(found: &Matrix, expected: &Matrix) {
    assert_eq!(found.len(), expected.len());
    let scale = expected.iter().flatten().fold(1.0_f64, |largest, entry| largest.max(entry.abs()));
    for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
        assert!((found - expected).abs() <= 1e-12 * scale, "{found} is not {expected}");
    }
}

fn transpose(a: &Matrix) -> Matrix {
    (0..a[0].len()).map(|j| a.iter().map(|row| row[j]).collect()).collect()
}

/// a(u, v) of the interior penalty method, point by point.
fn interior_penalty_by_hand<const D: usize>(mesh: &Mesh<D>, gamma: f64, u: &Nodal, v: &Nodal) -> f64 {
    let mut sum = 0.0;
    for cell in mesh.elements(Entity::Cells, "all") {
        for (index, point) in cell.points.iter().enumerate() {
            sum += point.geometry.weight * dot(&gradient(cell, index, u), &gradient(cell, index, v));
        }
    }
    for facet in mesh.elements(Entity::InteriorFacets, "skeleton") {
        let other = facet.on(Side::Other);
        for (index, point) in facet.points.iter().enumerate() {
            let jump = |w: &Nodal| value(facet, index, w, 0) - value(other, index, w, 0);
            let flux = |w: &Nodal| {
                let sum =
                    [facet, other].map(|element| dot(&gradient(element, index, w), &point.geometry.normal));
                0.5 * (sum[0] + sum[1])
            };
            let h = 0.5 * (facet.cell.diameter + other.cell.diameter);
            let penalty = gamma / h * jump(u) * jump(v);
            sum += point.geometry.weight * (penalty - flux(u) * jump(v) - jump(u) * flux(v));
        }
    }
    for facet in mesh.elements(Entity::Facets, "boundary") {
        for (index, point) in facet.points.iter().enumerate() {
            let flux = dot(&gradient(facet, index, u), &point.geometry.normal);
            sum -= point.geometry.weight * flux * value(facet, index, v, 0);
        }
    }
    sum
}

fn interior_penalty_in<const D: usize>()
where
    Dim: Dimension<D>,
{
    let mut random = Random(43);
    let mesh = Mesh::<D>::cube(&mut random).broken();
    let nodes = mesh.nodes.len();
    let (omega, gamma, skeleton) = regions();
    let form = discontinuous::interior_penalty(&data(), &omega, &gamma, &skeleton);
    let (u, v) = (random.field(nodes, 1, 0.0, 1.0), random.field(nodes, 1, 0.0, 1.0));
    let matrix = tangent::<f64, D>(&mesh, &form, std::slice::from_ref(&u));
    let found: f64 = matrix.iter().zip(&v.values).map(|(row, v)| v * dot(row, &u.values)).sum();
    let expected = interior_penalty_by_hand(&mesh, 3.0, &u, &v);
    assert!((found - expected).abs() <= 1e-12 * expected.abs().max(1.0), "{found} is not {expected}");
    assert_matrix(&tangent::<Four, D>(&mesh, &form, std::slice::from_ref(&u)), &matrix);
    let along_normal = discontinuous::interior_penalty_along_normal(&data(), &omega, &gamma, &skeleton);
    assert_matrix(&tangent::<f64, D>(&mesh, &along_normal, std::slice::from_ref(&u)), &matrix);
    let product = matrix.iter().map(|row| dot(row, &u.values)).collect();
    assert_matrix(&vec![residual::<f64, D>(&mesh, &form, std::slice::from_ref(&u))], &vec![product]);

    // Consistency: a linear function is harmonic and does not jump, so all terms together vanish.
    let linear = |x: &[f64; D]| 0.7 - dot(x, &[1.3, -0.4, 0.9][..D]);
    let u = Nodal { components: 1, values: mesh.nodes.iter().map(linear).collect() };
    for entry in residual::<f64, D>(&mesh, &form, &[u]) {
        assert!(entry.abs() < 1e-13, "{entry} is not zero");
    }
}

#[test]
fn interior_penalty_equals_loops_and_is_consistent() {
    interior_penalty_in::<2>();
    interior_penalty_in::<3>();
}

/// The description of the integrals on one region.
#[derive(Default)]
struct Told {
    region: usize,
    sides: Vec<(Side, Side)>,
    symmetric: Vec<bool>,
    dependence: Vec<Dependence>,
    opposite_diameter: Vec<bool>,
    slots: Vec<Vec<(usize, Order, Side)>>,
}

impl Told {
    fn tell(&mut self, integral: &Integral, requirements: &Requirements) {
        if integral.region == self.region {
            self.sides.push((integral.test_side, integral.trial_side));
            self.symmetric.push(integral.symmetric);
            self.dependence.push(integral.dependence);
            self.opposite_diameter.push(requirements.opposite_diameter);
            let slots = requirements.fields.iter();
            self.slots.push(slots.map(|slot| (slot.field, slot.order, slot.side)).collect());
        }
    }

    fn of_residual<I: Integrals<D>, const D: usize>(form: &Form<D>, region: usize) -> Told {
        assert!(form.has_integrals::<I>());
        let mut told = Told { region, ..Told::default() };
        for Term { integral, kernel } in I::residual::<Described>(form.inputs().constants()) {
            told.tell(integral, kernel.requirements);
        }
        told
    }

    fn of_tangent<I: Integrals<D>, const D: usize>(form: &Form<D>, region: usize) -> Told {
        assert!(form.has_integrals::<I>());
        let mut told = Told { region, ..Told::default() };
        for Term { integral, kernel } in I::tangent::<Described>(form.inputs().constants()) {
            assert_eq!(integral.symmetric, kernel.symmetric);
            told.tell(integral, kernel.requirements);
        }
        told
    }
}

#[test]
fn each_pair_of_sides_is_an_integral_and_equal_sides_may_be_symmetric() {
    use Side::{Other, This};
    let (omega, gamma, skeleton) = regions();
    let form = discontinuous::interior_penalty::<2>(&data(), &omega, &gamma, &skeleton);
    assert_eq!(form.inputs().regions[2].entity, Entity::InteriorFacets);
    let told = Told::of_residual::<discontinuous::interior_penalty::Kernels, 2>(&form, 2);
    assert_eq!(told.sides.iter().map(|sides| sides.0).collect::<Vec<_>>(), [This, Other]);
    assert_eq!(told.dependence, [Dependence::Linear; 2]);
    assert_eq!(told.opposite_diameter, [true; 2]);
    let read = [
        (0, Order::Value, This),
        (0, Order::Gradient, This),
        (0, Order::Value, Other),
        (0, Order::Gradient, Other),
    ];
    assert_eq!(told.slots, [read; 2]);

    let pairs = [(This, This), (This, Other), (Other, This), (Other, Other)];
    let told = Told::of_tangent::<discontinuous::interior_penalty::Kernels, 2>(&form, 2);
    assert_eq!(told.sides, pairs);
    assert_eq!(told.symmetric, [true, false, false, true]);
    let form = discontinuous::incomplete(&data(), &skeleton);
    let told = Told::of_tangent::<discontinuous::incomplete::Kernels, 3>(&form, 0);
    assert_eq!(told.sides, pairs);
    assert_eq!(told.symmetric, [false; 4]);
    let form = discontinuous::burgers(&data(), &skeleton);
    let told = Told::of_tangent::<discontinuous::burgers::Kernels, 2>(&form, 0);
    assert_eq!(told.sides, pairs);
    // f′(u) u v on one side is symmetric for every f. The blocks between the sides need not be.
    assert_eq!(told.symmetric, [true, false, false, true]);
    assert_eq!(told.dependence, [Dependence::Nonlinear; 4]);
    let form = discontinuous::cohesive(&data(), &omega, &skeleton);
    let told = Told::of_tangent::<discontinuous::cohesive::Kernels, 2>(&form, 1);
    assert_eq!(told.symmetric, [true, false, false, true]);
}

#[test]
fn nonlinear_fluxes_and_their_adjoint() {
    let mut random = Random(44);
    let mesh = Mesh::<3>::cube(&mut random).broken();
    let u = [random.field(mesh.nodes.len(), 1, 0.2, 1.0)];
    let skeleton = regions().2;
    let form = discontinuous::burgers(&data(), &skeleton);
    differences::check_tangent(&mesh, &form, &u, &mut random);
    let matrix = tangent::<f64, 3>(&mesh, &form, &u);
    let adjoint = discontinuous::adjoint_of_burgers(&data(), &skeleton, u[0].source());
    let p = [random.field(mesh.nodes.len(), 1, 0.0, 1.0)];
    assert_matrix(&tangent::<f64, 3>(&mesh, &adjoint, &p), &transpose(&matrix));
}

#[test]
fn switches_see_both_sides() {
    let mut random = Random(45);
    let mesh = Mesh::<2>::cube(&mut random).broken();
    let u = [random.field(mesh.nodes.len(), 1, 0.0, 1.0)];
    let found = switches(&mesh, &discontinuous::burgers(&data(), &regions().2), &u);
    let limits = switches(&mesh, &discontinuous::outflow(&data(), &regions().2), &u);
    let facets = mesh.elements(Entity::InteriorFacets, "skeleton");
    let mut points = Vec::new();
    for facet in facets {
        for index in 0..facet.points.len() {
            points.push([Side::This, Side::Other].map(|side| value(facet.on(side), index, &u[0], 0)));
        }
    }
    assert_eq!((found.len(), limits.len()), (points.len(), points.len()));
    for ((mut found, limits), [this, other]) in found.into_iter().zip(limits).zip(points) {
        assert_matrix(&vec![limits], &vec![vec![this, other]]);
        let mut expected = [this, other, this.abs() - other.abs()];
        found.sort_by(f64::total_cmp);
        expected.sort_by(f64::total_cmp);
        assert_matrix(&vec![found], &vec![expected.to_vec()]);
    }
}

#[test]
fn energies_of_jumps() {
    let mut random = Random(46);
    let mesh = Mesh::<2>::cube(&mut random).broken();
    let u = [random.field(mesh.nodes.len(), 2, 0.0, 0.3)];
    let (omega, _, skeleton) = regions();
    let energy = discontinuous::cohesive(&data(), &omega, &skeleton);
    differences::check_variation(&mesh, &energy, &u);
    differences::check_tangent(&mesh, &energy, &u, &mut random);
    let matrix = tangent::<f64, 2>(&mesh, &energy, &u);
    assert_matrix(&matrix, &transpose(&matrix));
}

#[test]
fn functionals_of_known_fields_and_their_slope() {
    let mut random = Random(47);
    let mesh = Mesh::<3>::cube(&mut random).broken();
    let u = random.field(mesh.nodes.len(), 1, 0.0, 1.0);
    let k = random.field(mesh.nodes.len(), 1, 1.0, 0.5);
    let mut data = data::<3>();
    data.k = Given::field(std::sync::Arc::new(k.clone()) as FieldHandle);
    let skeleton = regions().2;
    let mut expected = 0.0;
    let mut slope = vec![0.0; mesh.nodes.len()];
    for facet in mesh.elements(Entity::InteriorFacets, "skeleton") {
        let sides = [(facet, 1.0), (facet.on(Side::Other), -1.0)];
        for (index, point) in facet.points.iter().enumerate() {
            let mean: f64 = sides.iter().map(|(element, _)| 0.5 * value(element, index, &k, 0)).sum();
            let jump: f64 = sides.iter().map(|(element, sign)| sign * value(element, index, &u, 0)).sum();
            let factor = point.geometry.weight * mean / facet.cell.facet_area;
            expected += factor * jump * jump;
            for (element, sign) in sides {
                for (node, basis) in element.nodes.iter().zip(&element.points[index].basis) {
                    slope[*node] += factor * 2.0 * jump * sign * basis.value;
                }
            }
        }
    }
    let found = functional(&mesh, &discontinuous::jumps(&data, &skeleton, u.source()));
    assert!((found - expected).abs() <= 1e-13 * expected, "{found} is not {expected}");
    let form = discontinuous::slope_of_jumps(&data, &skeleton, u.source());
    assert_matrix(&vec![residual::<f64, 3>(&mesh, &form, &[])], &vec![slope]);
}

#[test]
fn data_from_functions_are_the_same_on_both_sides() {
    let mut random = Random(48);
    let mesh = Mesh::<2>::cube(&mut random).broken();
    let u = [random.field(mesh.nodes.len(), 1, 0.0, 1.0)];
    let matrix = |k: Given<f64, 2>| {
        let data = discontinuous::data().gamma(1.0).k(k);
        tangent::<f64, 2>(&mesh, &discontinuous::jump_of_data(&data, &regions().2), &u)
    };
    let linear = |x: &[f64; 2]| 1.0 + x[0] - 0.3 * x[1];
    let values = mesh.nodes.iter().map(linear).collect();
    let field = std::sync::Arc::new(Nodal { components: 1, values }) as FieldHandle;
    assert_matrix(&matrix(Given::function(linear)), &matrix(Given::field(field)));
}

#[test]
fn second_derivatives_on_both_sides() {
    let mut random = Random(49);
    let mesh = Mesh::<2>::quadratic_cube(&mut random);
    let nodes = mesh.nodes.len();
    let (u, v) = (random.field(nodes, 1, 0.0, 1.0), random.field(nodes, 1, 0.0, 1.0));
    let form = discontinuous::continuous_penalty(&data::<2>(), &regions().2);
    let matrix = tangent::<f64, 2>(&mesh, &form, std::slice::from_ref(&u));
    let found: f64 = matrix.iter().zip(&v.values).map(|(row, v)| v * dot(row, &u.values)).sum();
    let mut expected = 0.0;
    for facet in mesh.elements(Entity::InteriorFacets, "skeleton") {
        let sides = [facet, facet.on(Side::Other)];
        let h = 0.5 * (sides[0].cell.diameter + sides[1].cell.diameter);
        for (index, point) in facet.points.iter().enumerate() {
            let n = point.geometry.normal;
            let jump = |w: &Nodal| {
                let [this, other] = sides.map(|element| dot(&gradient(element, index, w), &n));
                this - other
            };
            let bending = sides.map(|element| {
                let nodes = element.nodes.iter().zip(&element.points[index].hessians);
                nodes
                    .map(|(node, hessian)| {
                        let along = [0, 1].map(|i| dot(&hessian[i], &n));
                        u.values[*node] * dot(&along, &n)
                    })
                    .sum::<f64>()
            });
            let mean = 0.5 * (bending[0] + bending[1]);
            expected += point.geometry.weight * (3.0 / h * jump(&u) - mean) * jump(&v);
        }
    }
    assert!((found - expected).abs() <= 1e-12 * expected.abs().max(1.0), "{found} is not {expected}");
}

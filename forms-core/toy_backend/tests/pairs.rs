//! Forms on contact pairs, in 2D and 3D: what is read at the opposite point, Nitsche's method with friction between two
//! bodies against loops written out and differences, energies of the gap.

use forms_core::described::Described;
use forms_core::forms;
use toy_backend::contract::*;
use toy_backend::interpolate::value;
use toy_backend::lanes::Four;
use toy_backend::mesh::{Element, Mesh};
use toy_backend::random::Random;
use toy_backend::{Nodal, differences, functional, residual, tangent};

#[forms(crate = toy_backend, matrix_free)]
pub mod blocks {
    pub struct Data {
        lambda: Param,
        mu: Param,
        gamma0: Param,
        theta: Param,
        kappa: Param,
        old: Given<Vector>,
    }
    #[cells]
    pub struct Omega;
    #[pairs]
    pub struct Touch;

    fn stress(w: Vector) -> Tensor {
        2 * mu * eps(w) + lambda * tr(eps(w)) * I
    }
    fn traction(w: Vector) -> Vector {
        this(stress(w) * n)
    }
    fn gamma() -> Scalar {
        gamma0 / this(h)
    }
    fn ball(q: Vector, s: Scalar) -> Vector {
        if s <= 0 {
            0 * q
        } else if dot(q, q) <= s * s {
            q
        } else {
            s / norm(q) * q
        }
    }
    fn contact(u: Vector) -> Vector {
        let pressure = neg_part(dot(traction(u), toward) - gamma() * (dot(jump(u), toward) - gap));
        let q = traction(u) - gamma() * jump(u - old);
        ball(q - dot(q, toward) * toward, kappa * pressure) - pressure * toward
    }
    /// Unbiased Nitsche's method with Coulomb friction between two bodies.
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let T = contact(u);
        integral(Omega, inner(stress(u), eps(v)))
            + integral(Touch, (theta / gamma() * dot(T - traction(u), traction(v)) - dot(T, jump(v))) / 2)
    }
    pub fn adjoint(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        derivative(balance(u, p), u, q)
    }
    /// The penalty method without friction.
    pub fn penalty(u: Unknown<Vector>) -> Energy {
        integral(Touch, gamma() / 2 * pow(neg_part(gap - dot(jump(u), toward)), 2))
    }
    pub fn distance() -> Functional {
        integral(Touch, dot(other(x) - this(x), toward) - gap)
    }
    pub fn places() -> Functional {
        integral(
            Touch,
            dot(other(n), x) + 2 * dot(n, other(x)) + other(h) * other(cell_volume) + dot(jump(x), n),
        )
    }
    pub fn opening(u: State<Vector>) -> Scalar {
        gap - dot(jump(u), toward)
    }
}

fn data<const D: usize>(old: Nodal) -> blocks::Data<D> {
    let old = Given::field(std::sync::Arc::new(old) as FieldHandle);
    blocks::data().lambda(1.3).mu(0.7).gamma0(5.0).theta(-1.0).kappa(0.4).old(old)
}

fn touch() -> blocks::Touch {
    blocks::Touch::on(Pairing::within("boundary"))
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The sum over all points of all pairs.
fn sum<const D: usize>(mesh: &Mesh<D>, of: impl Fn(&Element<D>, usize) -> f64) -> f64 {
    let pairs = mesh.elements(Entity::Pairs, "");
    let at = |pair: &&Element<D>| -> f64 {
        (0..pair.points.len()).map(|point| pair.points[point].geometry.weight * of(pair, point)).sum()
    };
    pairs.iter().map(at).sum()
}

fn places_in<const D: usize>()
where
    Dim: Dimension<D>,
{
    let mesh = Mesh::<D>::cube(&mut Random(61));
    let data = data(Random(60).field(mesh.nodes.len(), D, 0.0, 0.1));
    let found = functional(&mesh, &blocks::places(&data, &touch()));
    let expected = sum(&mesh, |pair, point| {
        let PointGeometry { position: x, normal: n, opposite, .. } = pair.points[point].geometry;
        let CellGeometry { opposite_diameter, opposite_volume, .. } = pair.cell;
        let apart: Vec<f64> = (0..D).map(|k| x[k] - opposite.position[k]).collect();
        dot(&opposite.normal, &x)
            + 2.0 * dot(&n, &opposite.position)
            + opposite_diameter * opposite_volume
            + dot(&apart, &n)
    });
    assert!((found - expected).abs() <= 1e-13 * expected.abs().max(1.0), "{found} is not {expected}");
    let distance = functional(&mesh, &blocks::distance(&data, &touch()));
    assert!(distance.abs() <= 1e-13, "{distance} is not zero");
}

#[test]
fn the_opposite_point_has_a_place_and_a_normal_of_its_own() {
    places_in::<2>();
    places_in::<3>();
}

/// The tangent against differences, by two lane types; the adjoint's matrix is its transpose.
fn friction_in<const D: usize>()
where
    Dim: Dimension<D>,
{
    let mut random = Random(62);
    let mesh = Mesh::<D>::cube(&mut random).broken();
    let nodes = mesh.nodes.len();
    let (u, old) = (random.field(nodes, D, 0.0, 0.8), random.field(nodes, D, 0.0, 0.1));
    let (data, omega) = (data(old), blocks::Omega::on("all"));
    let form = blocks::balance(&data, &omega, &touch());
    let unknowns = [u];
    differences::check_tangent(&mesh, &form, &unknowns, &mut random);
    let matrix = tangent::<f64, D>(&mesh, &form, &unknowns);
    let lanes = tangent::<Four, D>(&mesh, &form, &unknowns);
    let adjoint = blocks::adjoint(&data, &omega, &touch(), unknowns[0].source());
    let transposed = tangent::<f64, D>(&mesh, &adjoint, &unknowns);
    let scale = matrix.iter().flatten().fold(1.0_f64, |largest, entry| largest.max(entry.abs()));
    for (row, entries) in matrix.iter().enumerate() {
        for (column, entry) in entries.iter().enumerate() {
            assert!((lanes[row][column] - entry).abs() <= 1e-12 * scale);
            assert!((transposed[column][row] - entry).abs() <= 1e-12 * scale);
        }
    }
}

#[test]
fn friction_between_two_bodies() {
    friction_in::<2>();
    friction_in::<3>();
}

/// θ = 0 and without friction only the pressure is left, which both bodies feel with opposite signs.
fn pressure_in<const D: usize>()
where
    Dim: Dimension<D>,
{
    let mut random = Random(63);
    let mesh = Mesh::<D>::cube(&mut random).broken();
    let nodes = mesh.nodes.len();
    let u = random.field(nodes, D, 0.0, 0.8);
    let mut data = data(random.field(nodes, D, 0.0, 0.1));
    (data.lambda, data.mu, data.theta, data.kappa) = (0.0, 0.0, 0.0, 0.0);
    let form = blocks::balance(&data, &blocks::Omega::on("all"), &touch());
    let vector = residual::<f64, D>(&mesh, &form, std::slice::from_ref(&u));
    let v = random.field(nodes, D, 0.0, 1.0);
    let jump = |pair: &Element<D>, point: usize, w: &Nodal| -> f64 {
        let PointGeometry { opposite, .. } = pair.points[point].geometry;
        let other = pair.on(Side::Other);
        let apart = |k: usize| value(pair, point, w, k) - value(other, point, w, k);
        (0..D).map(|k| apart(k) * opposite.toward[k]).sum()
    };
    let expected = sum(&mesh, |pair, point| {
        let opening = pair.points[point].geometry.opposite.gap - jump(pair, point, &u);
        5.0 / pair.cell.diameter * (-opening).max(0.0) * jump(pair, point, &v) / 2.0
    });
    let found = dot(&vector, &v.values);
    assert!((found - expected).abs() <= 1e-12 * expected.abs().max(1.0), "{found} is not {expected}");
    // Forces balance: a translation of everything does no work.
    for axis in 0..D {
        let force: f64 = vector.iter().skip(axis).step_by(D).sum();
        assert!(force.abs() <= 1e-13 * expected.abs().max(1.0), "{force} along axis {axis}");
    }

    let energy = blocks::penalty(&data, &touch());
    differences::check_variation(&mesh, &energy, std::slice::from_ref(&u));
    differences::check_tangent(&mesh, &energy, std::slice::from_ref(&u), &mut random);
    let matrix = tangent::<f64, D>(&mesh, &energy, std::slice::from_ref(&u));
    for (row, entries) in matrix.iter().enumerate() {
        for (column, entry) in entries.iter().enumerate() {
            assert!((entry - matrix[column][row]).abs() <= 1e-12);
        }
    }
}

#[test]
fn pressures_balance_and_a_penalty_has_an_energy() {
    pressure_in::<2>();
    pressure_in::<3>();
}

#[test]
fn a_region_of_pairs_knows_its_surfaces() {
    let energy = blocks::penalty::<2>(&data(Random(1).field(4, 2, 0.0, 1.0)), &touch());
    let region = &energy.inputs().regions[0];
    assert_eq!((region.entity, &region.name[..]), (Entity::Pairs, "boundary onto boundary"));
    assert_eq!(region.pairing, Some(Pairing::within("boundary")));
    let both = Pairing::between("upper", "lower");
    assert_eq!(both, Pairing::onto("upper", "lower").and(Pairing::onto("lower", "upper")));
    assert_eq!(both.to_string(), "upper onto lower, lower onto upper");
    let regions = blocks::Regions::default().touch(both.clone());
    assert_eq!(regions.touch.0.pairing, Some(both));
    assert_eq!(blocks::Regions::default().touch.0.pairing, Some("touch".into()));

    let data = data::<3>(Random(1).field(4, 3, 0.0, 1.0));
    let opening = blocks::opening(&data, Source::Constant(vec![0.0; 3]));
    let terms =
        <blocks::opening::Kernels as Integrals<3>>::density::<Described>(opening.inputs().constants());
    let asked: Vec<&Requirements> = terms.iter().map(|term| term.kernel.requirements).collect();
    let [Requirements { gap: true, toward: true, opposite_normal: false, opposite_position: false, .. }] =
        asked[..]
    else {
        panic!("{asked:?}")
    };
}

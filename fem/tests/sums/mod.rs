//! Sums and multiples of forms, energies and functionals: compared with what is assembled from their parts, and with the same
//! integrals in one module.

mod assembly;
mod mismatches;
mod problems;

use forms_fem::prelude::*;

#[forms(dimension = 2, matrix_free)]
mod body {
    pub struct Data {
        lambda: Param,
        mu: Param,
        /// Weight of an area.
        weight: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;

    fn stress(w: Vector) -> Tensor {
        lambda * div(w) * I + 2 * mu * eps(w)
    }
    pub fn elasticity(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v)))
    }
    pub fn stored(u: Unknown<Vector>) -> Energy {
        let F = I + grad(u);
        let J = det(F);
        integral(Omega, mu / 2 * (inner(F, F) - D - 2 * ln(J)) + lambda / 2 * sqr(ln(J)))
    }
    pub fn weighed(u: State<Vector>) -> Functional {
        integral(Omega, weight * u[0])
    }
}

/// Nitsche's method on a flat obstacle, with another order of its fields and a region that several parts bind to other places.
#[forms(dimension = 2)]
mod touching {
    pub struct Data {
        gap: Given<Scalar>,
        lambda: Param,
        mu: Param,
        theta: Param,
        gamma0: Param,
        stiffness: Param,
    }
    #[facets]
    pub struct Contact;

    fn stress(w: Vector) -> Tensor {
        lambda * div(w) * I + 2 * mu * eps(w)
    }
    fn pressed(w: Vector) -> Scalar {
        dot(stress(w) * n, n)
    }
    pub fn nitsche(v: Test<Vector>, u: Unknown<Vector>) -> Form {
        let gamma = gamma0 / h;
        let P = neg_part(pressed(u) - gamma * (dot(u, n) - gap));
        integral(
            Contact,
            -theta / gamma * pressed(u) * pressed(v) - P / gamma * (theta * pressed(v) - gamma * dot(v, n)),
        )
    }
    pub fn springs(u: Unknown<Vector>) -> Energy {
        integral(Contact, stiffness / 2 * dot(u, u) + stiffness * pow(dot(u, u), 2))
    }
    pub fn worn(u: State<Vector>) -> Functional {
        integral(Contact, gap * u[1])
    }
}

/// The same integrals in one module.
#[forms(dimension = 2)]
mod whole {
    pub struct Data {
        lambda: Param,
        mu: Param,
        theta: Param,
        gamma0: Param,
        gap: Given<Scalar>,
        pull: Given<Vector>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Contact;
    #[facets]
    pub struct Loaded;

    fn stress(w: Vector) -> Tensor {
        lambda * div(w) * I + 2 * mu * eps(w)
    }
    fn pressed(w: Vector) -> Scalar {
        dot(stress(w) * n, n)
    }
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let gamma = gamma0 / h;
        let P = neg_part(pressed(u) - gamma * (dot(u, n) - gap));
        integral(Omega, inner(stress(u), eps(v)))
            + integral(
                Contact,
                -theta / gamma * pressed(u) * pressed(v)
                    - P / gamma * (theta * pressed(v) - gamma * dot(v, n)),
            )
            - integral(Loaded, dot(pull, v))
    }
}

type Outcome = Result<(), Box<dyn std::error::Error>>;

const LAMBDA: f64 = 1.2;
const MU: f64 = 0.8;
const GAMMA0: f64 = 200.0;

#[forms]
mod viscous {
    pub struct Data {
        viscosity: Param,
    }
    #[cells]
    pub struct Omega;

    pub fn flow(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        integral(Omega, 2 * viscosity * inner(eps(u), eps(v)) - p * div(v) - q * div(u))
    }
}

fn solid() -> body::Model<2> {
    body::Model::new(body::data().lambda(LAMBDA).mu(MU).weight(|x: &[f64; 2]| 1.0 + x[0]))
}

/// Contact on a side of the body, at a distance that varies.
fn touch(side: &str, gap: f64) -> Form<2> {
    touching::nitsche(&at(gap), &touching::Contact::on(side))
}

fn at(gap: f64) -> touching::Data<2> {
    let gap = move |x: &[f64; 2]| gap * (1.0 + x[0]);
    touching::data().gap(gap).lambda(LAMBDA).mu(MU).theta(1.0).gamma0(GAMMA0).stiffness(0.6)
}

/// A load on a side, without an unknown.
fn load(side: Side, size: f64) -> Form<2> {
    match side {
        Side::Right => form!(
            |v: Test<Vector>| -> Form { -integral(facets("right"), dot(pull, v)) },
            pull: Given<Vector> = move |x: &[f64; 2]| [size * x[1], -size],
        ),
        Side::Top => form!(
            |v: Test<Vector>| -> Form { -integral(facets("top"), dot(pull, v)) },
            pull: Given<Vector> = move |x: &[f64; 2]| [size * x[1], -size],
        ),
    }
}

#[derive(Clone, Copy)]
enum Side {
    Right,
    Top,
}

fn setting() -> Result<(Assembler<2>, Arc<Space<2>>), Box<dyn std::error::Error>> {
    let mesh = rectangle([0.0; 2], [2.0, 1.0], [6, 4], CellShape::Triangle, 1)?;
    Ok((Assembler::new(&mesh), Space::vector(&mesh, 2)?))
}

/// Values that are no polynomial's.
fn wave<const D: usize>(space: &Arc<Space<D>>, frequency: f64, size: f64) -> Field<D> {
    let values = (0..space.unknowns()).map(|k| size * (frequency * k as f64).sin()).collect();
    Field::from_values(space, values).unwrap()
}

/// Σ factor × vector, and the size of what was summed.
fn combined(parts: &[(f64, Vec<f64>)]) -> (Vec<f64>, f64) {
    let mut sum = vec![0.0; parts[0].1.len()];
    let mut size = 0.0_f64;
    for (factor, part) in parts {
        for (sum, value) in sum.iter_mut().zip(part) {
            *sum += factor * value;
            size = size.max((factor * value).abs());
        }
    }
    (sum, size)
}

#[track_caller]
fn assert_near(found: &[f64], (expected, size): (Vec<f64>, f64)) {
    assert_eq!(found.len(), expected.len());
    assert!(size > 1e-3, "the test says nothing: {size}");
    for (row, (found, expected)) in found.iter().zip(&expected).enumerate() {
        assert!((found - expected).abs() <= 4e-15 * size, "row {row}: {found} for {expected}, of {size}");
    }
}

#[track_caller]
fn assert_same(found: &[f64], expected: impl IntoIterator<Item = f64>) {
    let expected: Vec<f64> = expected.into_iter().collect();
    assert!(found == expected, "not the same bits");
}

//! Matrix-free products against the matrix: linear, nonlinear, mixed forms, on cells, facets and interior facets.

use forms_fem::prelude::*;

#[forms(dimension = 2, matrix_free)]
mod forms_of_all_kinds {
    pub struct Data {
        mu: Param,
        lambda: Param,
        gamma: Param,
        load: Given<Vector>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Gamma;
    #[interior_facets]
    pub struct Skeleton;

    fn stress(w: Vector) -> Tensor {
        2 * mu * eps(w) + lambda * div(w) * I
    }
    pub fn elasticity(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v)) - dot(load, v))
    }
    pub fn rubber(u: Unknown<Vector>) -> Energy {
        let F = I + grad(u);
        let J = det(F);
        integral(Omega, mu / 2 * (inner(F, F) - D - 2 * ln(J)) + lambda / 2 * pow(ln(J), 2) - dot(load, u))
    }
    pub fn navier(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        integral(Omega, 2 * mu * inner(eps(u), eps(v)) + dot(grad(u) * u, v) - p * div(v) - q * div(u))
    }
    pub fn contact(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let pressure = dot(n, stress(u) * n) - gamma * dot(u, n);
        elasticity(u, v) + integral(Gamma, neg_part(pressure) * (dot(n, stress(v) * n) - dot(v, n)))
    }
    pub fn jumps(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)))
            + integral(Skeleton, gamma / avg(h) * jump(u) * jump(v) - avg(u) * dot(avg(grad(u)), n) * jump(v))
    }
}
use forms_of_all_kinds::*;

fn data() -> Data<2> {
    forms_of_all_kinds::data().mu(0.8).lambda(1.2).gamma(5.0).load([0.3, -0.2])
}

fn meshes() -> Vec<Mesh<2>> {
    [(CellShape::Triangle, 1), (CellShape::Quadrilateral, 2)]
        .map(|(shape, degree)| {
            let flat = rectangle([0.0, 0.0], [1.0, 1.2], [4, 3], shape, degree).unwrap();
            let nodes = flat.nodes().iter();
            let nodes = nodes.map(|x| [x[0] + 0.05 * x[1] * x[1], x[1] + 0.04 * x[0] * x[1]]).collect();
            let cells = flat.cells().to_vec();
            Mesh::from_parts(shape, degree, nodes, cells).unwrap()
        })
        .into()
}

/// Values that are no polynomial's, small enough for an admissible deformation.
fn wave(space: &Arc<Space<2>>, frequency: f64, size: f64) -> Field<2> {
    let values = (0..space.unknowns()).map(|k| size * (frequency * k as f64).sin()).collect();
    Field::from_values(space, values).unwrap()
}

/// The action against the matrix times the vector, all integrals and some; and the same as an operator.
fn check(form: &Form<2>, mesh: &Mesh<2>, spaces: &[&Arc<Space<2>>]) {
    let assembler = Assembler::new(mesh);
    let unknowns: Vec<Field<2>> = spaces.iter().map(|space| wave(space, 0.37, 0.02)).collect();
    let directions: Vec<Field<2>> = spaces.iter().map(|space| wave(space, 0.91, 1.0)).collect();
    let (unknowns, directions): (Vec<_>, Vec<_>) = (unknowns.iter().collect(), directions.iter().collect());
    let vector: Vec<f64> = directions.iter().flat_map(|field| field.values()).copied().collect();
    let matrix = assembler.tangent(form, &unknowns, spaces).unwrap();
    let expected = matrix.multiply(&vector).unwrap();
    let scale = expected.iter().fold(0.0_f64, |largest, entry| largest.max(entry.abs()));
    assert!(scale > 0.1, "the test says nothing: {scale}");
    let near = |found: &[f64]| {
        for (row, (found, expected)) in found.iter().zip(&expected).enumerate() {
            let (name, bound) = (form.name(), 1e-13 * scale);
            assert!((found - expected).abs() <= bound, "{name}, row {row}: {found} for {expected}");
        }
    };
    near(&assembler.action(form, &unknowns, &directions, spaces).unwrap());
    let parts = [Parts::LINEAR_AND_CONSTANT, Parts::NONLINEAR]
        .map(|parts| assembler.action_parts(form, &unknowns, &directions, spaces, parts).unwrap());
    let sum: Vec<f64> = parts[0].iter().zip(&parts[1]).map(|(a, b)| a + b).collect();
    near(&sum);
    let mut product = vec![f64::NAN; vector.len()];
    TangentAction::new(&assembler, form, &unknowns).apply(&vector, &mut product).unwrap();
    near(&product);
}

#[test]
fn the_action_is_the_matrix_times_the_vector() {
    let data = data();
    let (omega, gamma, skeleton) = (Omega::on("all"), Gamma::on("boundary"), Skeleton::on("interior"));
    for mesh in meshes() {
        let (vectors, scalars) = (Space::vector(&mesh, 2).unwrap(), Space::scalar(&mesh, 1).unwrap());
        let broken = Space::discontinuous_scalar(&mesh, 2).unwrap();
        check(&elasticity(&data, &omega), &mesh, &[&vectors]);
        check(&rubber(&data, &omega), &mesh, &[&vectors]);
        check(&navier(&data, &omega), &mesh, &[&vectors, &scalars]);
        check(&contact(&data, &omega, &gamma), &mesh, &[&vectors]);
        check(&jumps(&data, &omega, &skeleton), &mesh, &[&broken]);
    }
}

#[test]
fn constraints_make_rows_and_columns_of_the_identity() {
    let mesh = &meshes()[0];
    let space = Space::vector(mesh, 2).unwrap();
    let mut constraints = Constraints::new(&space);
    constraints.fix("boundary", |_: &[f64; 2]| [0.1, 0.0]).unwrap();
    let assembler = Assembler::new(mesh);
    let (form, u) = (rubber(&data(), &Omega::on("all")), wave(&space, 0.37, 0.02));
    let free = TangentAction::new(&assembler, &form, &[&u]);
    let constrained = free.clone().with_constraints(&[&constraints]);
    let vector = wave(&space, 0.91, 1.0).values().to_vec();
    let mut inside = vector.clone();
    constraints.homogeneous().apply(&mut inside);
    let (mut found, mut expected) = (vec![0.0; free.size()], vec![0.0; free.size()]);
    constrained.apply(&vector, &mut found).unwrap();
    free.apply(&inside, &mut expected).unwrap();
    for (row, (found, expected)) in found.iter().zip(&expected).enumerate() {
        let expected = if constraints.is_prescribed(row) { vector[row] } else { *expected };
        assert_eq!(*found, expected, "row {row}");
    }
}

#[test]
fn what_does_not_fit_is_named() {
    let mesh = &meshes()[0];
    let (space, other) = (Space::vector(mesh, 2).unwrap(), Space::scalar(mesh, 2).unwrap());
    let assembler = Assembler::new(mesh);
    let form = elasticity(&data(), &Omega::on("all"));
    let (u, w) = (Field::zero(&space), Field::zero(&other));
    let error = assembler.action(&form, &[&u], &[], &[&space]).unwrap_err().to_string();
    assert_eq!(error, "form `elasticity` has 1 directions, 0 were given");
    let error = assembler.action(&form, &[&u], &[&w], &[&space]).unwrap_err().to_string();
    assert!(error.contains("`elasticity`") && error.contains("`du`"), "{error}");
    let error =
        TangentAction::new(&assembler, &form, &[&u]).apply(&[0.0; 3], &mut [0.0; 3]).unwrap_err().to_string();
    assert!(error.contains("entries of a vector"), "{error}");
}

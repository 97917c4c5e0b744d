//! Means over cells, `mean(e)`: the same numbers in cells, on facets and on contact pairs; exact derivatives everywhere.

use forms_fem::assemble::AssemblyError;
use forms_fem::contract::{Entity, Projection};
use forms_fem::prelude::*;
use forms_fem::verification::{self, Sample};

use crate::interior_facets::broken;
use crate::pairs::{cubes, squares};
use crate::sliding_pairs::boxes;

#[forms]
mod numbers {
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Wall;
    #[interior_facets]
    pub struct Skeleton;
    #[pairs]
    pub struct Touch;

    pub fn slope(u: Scalar) -> Vector {
        grad(u)
    }
    /// The squared distance of both means from numbers of degree 0.
    fn off(u: Scalar, q: Scalar, g: Vector) -> Scalar {
        let d = mean(grad(u)) - g;
        pow(mean(u) - q, 2) + dot(d, d)
    }
    pub fn in_cells(u: State<Scalar>, q: State<Scalar>, g: State<Vector>) -> Functional {
        integral(Omega, off(u, q, g))
    }
    pub fn on_walls(u: State<Scalar>, q: State<Scalar>, g: State<Vector>) -> Functional {
        integral(Wall, off(u, q, g))
    }
    pub fn between(u: State<Scalar>, q: State<Scalar>, g: State<Vector>) -> Functional {
        integral(Skeleton, this(off(u, q, g)) + other(off(u, q, g)) + pow(mean(other(u)) - other(q), 2))
    }
    pub fn on_pairs(u: State<Scalar>, q: State<Scalar>, g: State<Vector>) -> Functional {
        integral(Touch, this(off(u, q, g)) + other(off(u, q, g)) + pow(mean(other(u)) - other(q), 2))
    }
    pub fn gradient_vanishes(u: State<Scalar>) -> Functional {
        integral(Omega, dot(grad(mean(u)), grad(mean(u))) + pow(div(mean(grad(u))), 2))
    }
}

#[forms]
mod of_data {
    use super::numbers::{Omega, Wall};

    pub struct Data {
        k: Param,
        seen: Given<Scalar>,
    }

    /// Constants on a cell, which are their own means.
    pub fn with_coefficients(u: State<Scalar>) -> Functional {
        let whole = mean((k * u + [h, k][1]) * h + mean(u) * u / cell_volume + k * I[0][0]);
        integral(Omega, pow(whole - (k * h * mean(u) + k * h + pow(mean(u), 2) / cell_volume + k), 2))
    }
    pub fn read() -> Functional {
        integral(Omega, mean(seen) + dot(mean(grad(seen)), mean(grad(seen))))
    }
    pub fn tested(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Wall, (u - mean(seen)) * mean(v))
    }
}

/// The mean of a field over each cell, and of its gradient, from values at points of a rule of high degree.
fn by_points<const D: usize>(u: &Field<D>) -> (Field<D>, Field<D>)
where
    Dim: Dimension<D>,
{
    let mesh = u.space().mesh();
    let assembler = Assembler::new(mesh);
    #[forms]
    mod values {
        pub fn value(u: Scalar) -> Scalar {
            u
        }
    }
    let at = |expression| assembler.at_quadrature_points(expression, Entity::Cells, "all", 14).unwrap();
    let (values, slopes) = (at(&values::value(u)), at(&numbers::slope(u)));
    let spaces =
        [Space::discontinuous_scalar(mesh, 0).unwrap(), Space::discontinuous_vector(mesh, 0).unwrap()];
    let (mut means, mut gradients) = (vec![0.0; mesh.cell_count()], vec![0.0; D * mesh.cell_count()]);
    let mut volumes = vec![0.0; mesh.cell_count()];
    let locator = forms_fem::locate::Locator::new(mesh);
    for (point, weight) in values.weights.iter().enumerate() {
        let (cell, _) = locator.find(&values.positions[point]).unwrap();
        volumes[cell] += weight;
        means[cell] += weight * values.values[point][0];
        (0..D).for_each(|k| gradients[D * cell + k] += weight * slopes.values[point][k]);
    }
    let node = |space: &Space<D>, cell: usize| space.cell_nodes(cell)[0] as usize;
    let mut fields = spaces.iter().map(|space| vec![0.0; space.unknowns()]).collect::<Vec<_>>();
    for cell in 0..mesh.cell_count() {
        fields[0][node(&spaces[0], cell)] = means[cell] / volumes[cell];
        for k in 0..D {
            fields[1][D * node(&spaces[1], cell) + k] = gradients[D * cell + k] / volumes[cell];
        }
    }
    let gradient = Field::from_values(&spaces[1], fields.pop().unwrap()).unwrap();
    (Field::from_values(&spaces[0], fields.pop().unwrap()).unwrap(), gradient)
}

/// Bent cells that face each other without matching.
fn meshes() -> Vec<Mesh<2>> {
    let below = |[x, y]: [f64; 2]| [x + 0.1 * y * (1.0 - y), y + 0.07 * (1.0 - y) * (3.0 * x).sin()];
    let above = |[x, y]: [f64; 2]| [x + 0.05 + 0.1 * (y - 1.0), y + 0.03 + 0.06 * (y - 1.0) * x * y];
    let pairs = [[CellShape::Quadrilateral; 2], [CellShape::Triangle, CellShape::Quadrilateral]];
    pairs
        .into_iter()
        .flat_map(|shapes| [1, 2].map(|degree| squares(shapes, degree, [&below, &above])))
        .collect()
}

fn numbers_agree<const D: usize>(mesh: &Mesh<D>, degrees: &[usize])
where
    Dim: Dimension<D>,
{
    let pairing = Pairing::between("below", "above").by(Projection::Ray);
    for &degree in degrees {
        let u = broken(&Space::discontinuous_scalar(mesh, degree).unwrap());
        let (q, g) = by_points(&u);
        let (omega, touch) = (numbers::Omega::on("all"), numbers::Touch::on(pairing.clone()));
        // Means do not depend on the rule of the integral.
        for rule in [1, 5] {
            let assembler = Assembler::new(mesh).with_quadrature(Quadrature::Degree(rule));
            let found = [
                assembler.functional(&numbers::in_cells(&omega, &u, &q, &g)),
                assembler.functional(&numbers::on_walls(&numbers::Wall::on("boundary"), &u, &q, &g)),
                assembler.functional(&numbers::between(&numbers::Skeleton::on("interior"), &u, &q, &g)),
                assembler.functional(&numbers::on_pairs(&touch, &u, &q, &g)),
            ];
            for (place, found) in found.into_iter().enumerate() {
                let found = found.unwrap();
                assert!(found < 1e-22, "degree {degree}, rule {rule}, place {place}: {found:e}");
            }
        }
        let data = of_data::data().k(0.7).seen(&u);
        let assembler = Assembler::new(mesh);
        assert!(assembler.functional(&of_data::with_coefficients(&data, &omega, &u)).unwrap() < 1e-24);
        assert_eq!(assembler.functional(&numbers::gradient_vanishes(&omega, &u)).unwrap(), 0.0);
    }
}

#[test]
fn the_same_number_in_cells_on_facets_and_on_pairs() {
    for mesh in meshes() {
        numbers_agree(&mesh, &[0, 1, 2, 3]);
    }
    let (below, above) = (
        |[x, y, z]: [f64; 3]| [x + 0.1 * y * z * (1.0 - z), y, z + 0.05 * (1.0 - z) * x * y],
        |[x, y, z]: [f64; 3]| [x + 0.04, y + 0.02 * (z - 1.0) * x, z + 0.03],
    );
    for shape in [CellShape::Tetrahedron, CellShape::Hexahedron] {
        numbers_agree(&cubes(shape, 2, [&below, &above]), &[1, 2]);
    }
}

#[test]
fn data_without_a_mean_are_errors() {
    let mesh = rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Quadrilateral, 1).unwrap();
    let (omega, assembler) = (numbers::Omega::on("all"), Assembler::new(&mesh));
    let of = |seen: Given<f64, 2>| {
        assembler.functional(&of_data::read(&of_data::data().k(1.0).seen(seen), &omega))
    };
    assert!((of(Given::constant(3.0)).unwrap() - 3.0).abs() < 1e-15);
    assert!(matches!(
        of(Given::function(|x| x[0])),
        Err(AssemblyError::MeanOfFunction { form: "read", field: "seen" })
    ));
    let on_wall = Space::on_facets(&mesh, "boundary", 1).unwrap();
    let failed = of(Given::field(Field::zero(&on_wall)));
    assert!(matches!(failed, Err(AssemblyError::MeanOnFacets { field: "seen", .. })), "{failed:?}");
    let data = of_data::data().k(1.0).seen(0.0);
    let form = of_data::tested(&data, &numbers::Wall::on("boundary"));
    let u = Field::zero(&on_wall);
    let failed = assembler.residual(&form, &[&u], &[&on_wall]);
    assert!(matches!(failed, Err(AssemblyError::MeanOnFacets { field: "v", .. })), "{failed:?}");
}

#[forms(matrix_free)]
mod nonlinear {
    pub struct Data {
        k: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Wall;
    #[interior_facets]
    pub struct Skeleton;
    #[pairs]
    pub struct Touch;

    pub fn f_bar(u: Vector) -> Tensor {
        let F = I + grad(u);
        pow(det(mean(F)) / det(F), 1 / D) * F
    }
    fn density(F: Tensor) -> Scalar {
        0.35 * (inner(F, F) - D - 2 * ln(det(F))) + 0.65 * pow(ln(det(F)), 2)
    }
    fn piola(u: Vector) -> Tensor {
        let F = f_bar(u);
        diff(density(F), F)
    }
    pub fn stored(u: Unknown<Vector>) -> Energy {
        integral(Omega, density(f_bar(u)) + k * dot(mean(u), mean(u)) * dot(u, u))
            + integral(Wall, pow(dot(mean(u), n), 4) + k * tr(mean(grad(u))) * dot(u, u))
            + integral(Skeleton, dot(jump(mean(u)), jump(mean(u))) * avg(dot(u, mean(u))))
    }
    /// Every way of reading means: of the unknown, of the test function, of both.
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(piola(u), grad(v)) + sin(tr(mean(grad(u)))) * dot(mean(u), v))
            + integral(Omega, inner(det(mean(k * I + grad(u))) * grad(u), mean(grad(v))) + dot(u, mean(v)))
            + integral(Wall, dot(piola(u) * n, v) + dot(mean(grad(v)) * n, mean(u)) * dot(u, n))
            + integral(
                Skeleton,
                dot(jump(mean(grad(u))) * this(n), avg(mean(v))) * dot(this(u), other(mean(u))),
            )
    }
    pub fn on_pairs(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let t = this(piola(u) * n) + other(mean(grad(u))) * toward;
        integral(Touch, dot(t, jump(v)) + gap * dot(other(mean(v)), this(u)) + dot(jump(u), this(mean(v))))
    }
    pub fn sliding(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let t = this(piola(u) * n) + other(mean(grad(u))) * toward;
        integral(Touch(u), dot(t, jump(v)) + gap * dot(other(mean(v)), this(u)))
    }
    pub fn adjoint(u: State<Vector>, z: Unknown<Vector>, v: Test<Vector>) -> Form {
        derivative(balance(u, z), u, v)
    }
    /// A direction that is an expression.
    pub fn along(u: State<Vector>, w: State<Vector>, v: Test<Vector>) -> Form {
        derivative(balance(u, v), u, k * w - 2 * h * w)
    }
    /// Contribution of the parameter inside a mean.
    pub fn by_parameter(u: State<Vector>, v: Test<Vector>) -> Form {
        derivative(balance(u, v), k, 1)
    }
}

fn small<const D: usize>(space: &Arc<Space<D>>, size: f64) -> Field<D> {
    Field::from_values(space, broken(space).values().iter().map(|value| size * value).collect()).unwrap()
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    let largest = |list: &mut dyn Iterator<Item = f64>| list.fold(0.0, |m: f64, x| m.max(x.abs()));
    largest(&mut a.iter().zip(b).map(|(a, b)| a - b)) / largest(&mut b.iter().copied())
}

macro_rules! derivatives_fit {
    ($mesh:expr, $degree:expr) => {
        let mesh = $mesh;
        let space = Space::vector(&mesh, $degree).unwrap();
        let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(4));
        let data = nonlinear::data().k(0.8);
        let regions = (
            nonlinear::Omega::on("all"),
            nonlinear::Wall::on("boundary"),
            nonlinear::Skeleton::on("interior"),
        );
        let (omega, wall, skeleton) = (&regions.0, &regions.1, &regions.2);
        let (u, w) = (small(&space, 0.05), broken(&space));
        let touch = nonlinear::Touch::on(Pairing::between("below", "above").by(Projection::Ray));
        let balance = nonlinear::balance(&data, omega, wall, skeleton);
        for form in [&balance, &nonlinear::on_pairs(&data, &touch)] {
            let report = verification::tangent(&assembler, form, &[&u], &[&w], 0.02).unwrap();
            let order = report.second_order().unwrap();
            assert!(order > 1.9, "{order}: {report:?}");
            let matrix = assembler.tangent(form, &[&u], &[&space]).unwrap();
            let action = assembler.action(form, &[&u], &[&w], &[&space]).unwrap();
            let product = matrix.multiply(w.values()).unwrap();
            assert!(distance(&action, &product) < 1e-12, "{}", distance(&action, &product));
        }
        // The adjoint's matrix is the transposed one.
        let tangent = assembler.tangent(&balance, &[&u], &[&space]).unwrap();
        let adjoint = nonlinear::adjoint(&data, omega, wall, skeleton, &u);
        let adjoint = assembler.tangent(&adjoint, &[&w], &[&space]).unwrap();
        let z = small(&space, 1.3);
        let [a, b] = [(&tangent, &w, &z), (&adjoint, &z, &w)].map(|(matrix, right, left)| -> f64 {
            let product = matrix.multiply(right.values()).unwrap();
            product.iter().zip(left.values()).map(|(a, b)| a * b).sum()
        });
        assert!((a - b).abs() < 1e-11 * a.abs().max(1.0), "{a} {b}");
        // A direction that is an expression.
        let along = nonlinear::along(&data, omega, wall, skeleton, &u, &w);
        let found = assembler.residual(&along, &[], &[&space]).unwrap();
        assert!(found.iter().all(|value| value.is_finite()) && found.iter().any(|value| *value != 0.0));
        let by_parameter = nonlinear::by_parameter(&data, omega, wall, skeleton, &u);
        let slope = assembler.residual(&by_parameter, &[], &[&space]).unwrap();
        let report = verification::taylor::<AssemblyError>(0.1, &slope, |step| {
            let form = nonlinear::balance(&nonlinear::data().k(0.8 + step), omega, wall, skeleton);
            Ok(Sample { value: assembler.residual(&form, &[&u], &[&space])?, active_set: None })
        })
        .unwrap();
        assert!(report.is_affine() || report.second_order().unwrap() > 1.9, "{report:?}");
        // An energy: its residual is its derivative, its tangent is symmetric.
        let stored = nonlinear::stored(&data, omega, wall, skeleton);
        let slope = assembler.residual(&stored, &[&u], &[&space]).unwrap();
        let slope: f64 = slope.iter().zip(w.values()).map(|(a, b)| a * b).sum();
        let report = verification::taylor::<AssemblyError>(0.02, &[slope], |step| {
            let moved = Field::combination(&[(1.0, &u), (step, &w)]).unwrap();
            Ok(Sample { value: vec![assembler.energy(&stored, &[&moved])?], active_set: None })
        })
        .unwrap();
        assert!(report.second_order().unwrap() > 1.9, "{report:?}");
        let report = verification::tangent(&assembler, &stored, &[&u], &[&w], 0.02).unwrap();
        assert!(report.second_order().unwrap() > 1.9, "{report:?}");
        let tangent = assembler.tangent(&stored, &[&u], &[&space]).unwrap();
        assert!(tangent.is_symmetric(1e-13).unwrap());
    };
}

#[test]
fn derivatives_are_exact_in_cells_on_facets_and_on_pairs() {
    for mesh in meshes() {
        derivatives_fit!(mesh, 1);
    }
    derivatives_fit!(meshes().swap_remove(2), 2);
    let still = |x: [f64; 3]| x;
    let above = |[x, y, z]: [f64; 3]| [x + 0.04, y + 0.02 * (z - 1.0) * x, z + 0.03];
    derivatives_fit!(cubes(CellShape::Hexahedron, 1, [&still, &above]), 1);
}

#[test]
fn derivatives_are_exact_where_points_slide() {
    let mesh = boxes([3, 4], [0.03, 0.02]);
    let space = Space::vector(&mesh, 1).unwrap();
    let smooth = |size: f64, phase: f64| {
        Field::interpolate(&space, move |x: &[f64; 2]| {
            [size * (2.0 * x[1] + phase).cos(), size * (3.0 * x[0] + x[1] - phase).sin()]
        })
        .unwrap()
    };
    let form = nonlinear::sliding(
        &nonlinear::data().k(0.8),
        &nonlinear::Touch::on(Pairing::between("below", "above")),
    );
    let report = verification::tangent(
        &Assembler::new(&mesh),
        &form,
        &[&smooth(0.02, 0.0)],
        &[&smooth(1.0, 0.7)],
        1e-3,
    )
    .unwrap();
    assert!(report.second_order().unwrap() > 1.9, "{report:?}");
}

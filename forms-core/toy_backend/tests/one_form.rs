//! `form!`: one expression, compiled like a module, against the module that says the same.

use forms_core::{form, forms};
use toy_backend::contract::*;
use toy_backend::mesh::Mesh;
use toy_backend::random::Random;
use toy_backend::{action, expression, functional, residual, tangent};

#[forms(crate = toy_backend)]
pub mod module {
    pub struct Data {
        k: Param,
        f: Given<Scalar>,
        b: Param<Vector>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Wall;

    pub fn flux(u: Scalar) -> Vector {
        k * (1 + u * u) * grad(u)
    }
    pub fn balance(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(flux(u), grad(v)) - f * v) + integral(Wall, 2 * u * v * dot(b, n))
    }
    pub fn energy(u: Unknown<Scalar>) -> Energy {
        integral(Omega, k / 2 * dot(grad(u), grad(u)))
    }
    pub fn total(u: State<Scalar>) -> Functional {
        integral(Omega, f * u)
    }
}

fn data() -> module::Data<2> {
    module::data().k(2.0).f(|x: &[f64; 2]| x[0] - x[1]).b([1.0, -2.0])
}

fn regions() -> (module::Omega, module::Wall) {
    (module::Omega::on("all"), module::Wall::on("boundary"))
}

fn close(mine: &[f64], theirs: &[f64]) {
    assert_eq!(mine.len(), theirs.len());
    let size = theirs.iter().fold(0.0, |size: f64, entry| size.max(entry.abs()));
    assert!(size > 0.0);
    for (mine, theirs) in mine.iter().zip(theirs) {
        assert!((mine - theirs).abs() <= 1e-14 * size, "{mine} and {theirs}");
    }
}

#[test]
fn a_form_with_data_regions_and_an_import_is_the_modules() {
    let mut random = Random(5);
    let mesh = Mesh::<2>::cube(&mut random);
    let u = [random.field(mesh.nodes.len(), 1, 0.2, 0.5)];
    let (omega, wall) = regions();
    let theirs = module::balance(&data(), &omega, &wall);
    let (k, wall) = (2.0, String::from("boundary"));
    let one = form!(
        use module::flux;
        |u: Unknown<Scalar>, v: Test<Scalar>| {
            let load = f * v;
            integral(cells("all"), dot(flux(u), grad(v)) - load) + integral(Wall, 2 * u * v * dot(b, n))
        },
        k: Param,
        b: Param<Vector> = [1, -2],
        f: Given<Scalar> = |x| x[0] - x[1],
        Wall: Facets = wall,
        crate = toy_backend, matrix_free,
    );
    close(&residual::<f64, 2>(&mesh, &one, &u), &residual::<f64, 2>(&mesh, &theirs, &u));
    close(&tangent::<f64, 2>(&mesh, &one, &u).concat(), &tangent::<f64, 2>(&mesh, &theirs, &u).concat());
    assert_eq!(one.inputs().regions.len(), 2);
    // By an option, as of a module, products of the tangent and a vector need no matrix.
    let product: Vec<f64> = tangent::<f64, 2>(&mesh, &one, &u)
        .iter()
        .map(|row| row.iter().zip(&u[0].values).map(|(k, u)| k * u).sum())
        .collect();
    close(&action::<f64, 2>(&mesh, &one, &u, &u), &product);
    assert!(theirs.action().is_empty());
}

#[test]
fn energies_functionals_and_values() {
    let mut random = Random(6);
    let mesh = Mesh::<2>::cube(&mut random);
    let u = random.field(mesh.nodes.len(), 1, 0.2, 0.5);
    let (omega, _) = regions();
    let energy = form!(
        |u: Unknown<Scalar>| -> Energy { integral(cells("all"), k / 2 * dot(grad(u), grad(u))) },
        k: Param = 2,
        crate = toy_backend,
        dimension = 2,
    );
    let unknowns = [u.clone()];
    close(
        &tangent::<f64, 2>(&mesh, &energy, &unknowns).concat(),
        &tangent::<f64, 2>(&mesh, &module::energy(&data(), &omega), &unknowns).concat(),
    );
    let mean = form!(
        |u: State<Scalar>| -> Functional { integral(cells("all"), f * u) },
        f: Given<Scalar> = Given::function(|x: &[f64; 2]| x[0] - x[1]),
        crate = toy_backend,
    );
    let theirs = functional(&mesh, &module::total(&data(), &omega, u.source()));
    assert!((functional(&mesh, &mean(u.source())) - theirs).abs() < 1e-14);
    // A closure may be called again, with another field.
    let twice: Vec<f64> = u.values.iter().map(|value| 2.0 * value).collect();
    let twice = toy_backend::Nodal { components: 1, values: twice };
    assert!((functional(&mesh, &mean(twice.source())) - 2.0 * theirs).abs() < 1e-13);
    let square =
        form!(|s: Scalar| -> Scalar { s * s - offset }, offset: Given<Scalar> = -1, crate = toy_backend);
    let square = square(Source::<2>::Constant(vec![3.0]));
    assert_eq!(expression(&mesh, &square, (Entity::Cells, "all"))[0], [10.0]);
}

#[test]
fn the_same_region_twice_is_one_and_different_ones_are_two() {
    let name = "all";
    let other = "all";
    let one = form!(
        |u: Unknown<Scalar>, v: Test<Scalar>| integral(cells(name), u * v)
            + integral(cells(name), dot(grad(u), grad(v)))
            - integral(cells(other), v)
            - integral(facets("boundary"), v),
        crate = toy_backend,
        dimension = 2,
    );
    let regions: Vec<&str> = one.inputs().regions.iter().map(|region| region.symbol).collect();
    assert_eq!(regions, ["CellsName", "CellsOther", "FacetsBoundary"]);
}

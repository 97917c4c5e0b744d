//! Compiled functions are values: forms of different functions are kept in one list, cloned, sent to other threads, and an
//! energy is used where a form is asked for.

use forms_core::forms;
use toy_backend::contract::*;
use toy_backend::mesh::Mesh;
use toy_backend::random::Random;
use toy_backend::{Nodal, action, differences, energy, expression, functional, residual, tangent};

#[forms(crate = toy_backend)]
pub mod membrane {
    pub struct Data {
        k: Param,
        load: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Wall;

    pub fn stored(u: Unknown<Scalar>) -> Energy {
        integral(Omega, k / 2 * dot(grad(u), grad(u)) + pow(u, 4))
    }
    pub fn loaded(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        -integral(Omega, load * v)
    }
    pub fn held(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Wall, u * v)
    }
    /// The sum of the three.
    pub fn balance(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        derivative(stored(u), u, v) + loaded(u, v) + held(u, v)
    }
    pub fn work(u: State<Scalar>) -> Functional {
        integral(Omega, load * u)
    }
    pub fn flux(u: Scalar) -> Vector {
        -k * grad(u)
    }
}

/// The same energy with products of its tangent and vectors.
#[forms(crate = toy_backend, matrix_free)]
pub mod without_matrix {
    pub use super::membrane::{Data, Omega, stored};
}

struct State {
    mesh: Mesh<2>,
    u: [Nodal; 1],
    random: Random,
}

fn state() -> State {
    let mut random = Random(81);
    let mesh = Mesh::<2>::cube(&mut random);
    let u = [random.field(mesh.nodes.len(), 1, 0.2, 0.5)];
    State { mesh, u, random }
}

fn data() -> membrane::Data<2> {
    membrane::data().k(1.7).load(|x: &[f64; 2]| 1.0 + x[0])
}

fn omega() -> membrane::Omega {
    membrane::Omega::on("all")
}

fn wall() -> membrane::Wall {
    membrane::Wall::on("boundary")
}

/// An energy, a load without a tangent, and a term on facets: no two have the same kernels or regions.
fn parts() -> Vec<Form<2>> {
    vec![
        membrane::stored(&data(), &omega()).into(),
        membrane::loaded(&data(), &omega()),
        membrane::held(&data(), &wall()),
    ]
}

fn sum(vectors: impl Iterator<Item = Vec<f64>>) -> Vec<f64> {
    let add = |sum: Vec<f64>, next: Vec<f64>| sum.iter().zip(next).map(|(sum, next)| sum + next).collect();
    vectors.reduce(add).expect("a vector")
}

fn close(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    assert!(expected.iter().any(|entry| entry.abs() > 1e-3));
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() <= 1e-13, "{found} is not {expected}");
    }
}

#[test]
fn forms_of_different_functions_are_in_one_list() {
    let State { mesh, u, .. } = state();
    let parts = parts();
    let names: Vec<&str> = parts.iter().map(|form| form.name()).collect();
    assert_eq!(names, ["stored", "loaded", "held"]);
    assert_eq!(parts.iter().map(|form| form.tangent().len()).collect::<Vec<_>>(), [1, 0, 1]);
    let whole = membrane::balance(&data(), &omega(), &wall());
    let found = sum(parts.iter().map(|form| residual::<f64, 2>(&mesh, form, &u)));
    close(&found, &residual::<f64, 2>(&mesh, &whole, &u));
    let found = sum(parts.iter().map(|form| tangent::<f64, 2>(&mesh, form, &u).concat()));
    close(&found, &tangent::<f64, 2>(&mesh, &whole, &u).concat());
}

/// A clone has its original's data and kernels, also after the original and the data struct are gone.
#[test]
fn clones_outlive_their_originals() {
    let State { mesh, u, .. } = state();
    let parts = parts();
    let expected: Vec<_> = parts.iter().map(|form| residual::<f64, 2>(&mesh, form, &u)).collect();
    let clones = parts.clone();
    drop(parts);
    for (form, expected) in clones.iter().zip(&expected) {
        assert_eq!(&residual::<f64, 2>(&mesh, form, &u), expected);
        assert_eq!(form.inputs().parameters, [1.7]);
    }
    let found = std::thread::scope(|scope| {
        let work = |form: Form<2>| residual::<f64, 2>(&state().mesh, &form, &state().u);
        let threads: Vec<_> = clones.into_iter().map(|form| scope.spawn(move || work(form))).collect();
        threads.into_iter().map(|thread| thread.join().expect("no panic")).collect::<Vec<_>>()
    });
    assert_eq!(found, expected);
}

#[test]
fn an_energy_is_a_form_and_a_number() {
    let State { mesh, u, mut random } = state();
    let stored = without_matrix::stored(&data(), &omega());
    // Where a form is asked for.
    differences::check_tangent(&mesh, &stored, &u, &mut random);
    differences::check_variation(&mesh, &stored, &u);
    let (by_reference, by_value) = (Form::from(&stored), Form::from(stored.clone()));
    for form in [&by_reference, &by_value] {
        assert!(form.has_integrals::<without_matrix::stored::Kernels>());
        assert_eq!(residual::<f64, 2>(&mesh, form, &u), residual::<f64, 2>(&mesh, &stored, &u));
    }
    // ∫ u⁴ of a constant, which has no gradient.
    let constant = [Nodal { components: 1, values: vec![0.5; mesh.nodes.len()] }];
    let area: f64 = mesh.elements(Entity::Cells, "all").iter().map(|cell| cell.cell.cell_volume).sum();
    assert!((energy(&mesh, &stored, &constant) - area / 16.0).abs() < 1e-13);
}

/// Functionals and expressions are values, too.
#[test]
fn functionals_and_expressions_are_in_lists() {
    let State { mesh, u, .. } = state();
    let twice = Nodal { values: u[0].values.iter().map(|value| 2.0 * value).collect(), components: 1 };
    let works: Vec<Functional<2>> =
        [&u[0], &twice].map(|field| membrane::work(&data(), &omega(), field.source())).to_vec();
    let [one, two] = [&works[0], &works[1].clone()].map(|work| functional(&mesh, work));
    assert!(one.abs() > 1e-3 && (two - 2.0 * one).abs() < 1e-13, "{one} and {two}");
    let fluxes: Vec<Expression<2>> =
        [&u[0], &twice].map(|field| membrane::flux(&data(), field.source())).to_vec();
    let cells = (Entity::Cells, "all");
    let [one, two] = [&fluxes[0], &fluxes[1].clone()].map(|flux| expression(&mesh, flux, cells).concat());
    close(&two, &one.iter().map(|entry| 2.0 * entry).collect::<Vec<_>>());
}

/// Products of a tangent and a vector are compiled where a module asks for them.
#[test]
fn kernels_of_products_are_an_option() {
    let State { mesh, u, .. } = state();
    let (without, with) = (membrane::stored(&data(), &omega()), without_matrix::stored(&data(), &omega()));
    assert!(without.action().is_empty());
    assert!(!without.has_integrals::<without_matrix::stored::Kernels>());
    let product = tangent::<f64, 2>(&mesh, &without, &u)
        .iter()
        .map(|row| row.iter().zip(&u[0].values).map(|(k, u)| k * u).sum())
        .collect::<Vec<f64>>();
    close(&action::<f64, 2>(&mesh, &with, &u, &u), &product);
}

//! Energies: residual and tangent by the compiler against closed forms and against nested derivatives.

use forms_core::forms;
use toy_backend::contract::*;
use toy_backend::mesh::{Mesh, determinant, inverse};
use toy_backend::random::Random;
use toy_backend::{Nodal, expression, residual, tangent};

#[forms(crate = toy_backend)]
pub mod hyperelastic {
    pub struct Data {
        lambda: Param,
        mu: Param,
    }
    #[cells]
    pub struct Omega;

    fn psi(F: Tensor) -> Scalar {
        let J = det(F);
        mu / 2 * (inner(F, F) - D) - mu * ln(J) + lambda / 2 * pow(ln(J), 2)
    }
    pub fn energy(u: Unknown<Vector>) -> Energy {
        integral(Omega, psi(I + grad(u)))
    }
    /// The first Piola stress.
    pub fn piola(u: Vector) -> Tensor {
        let F = I + grad(u);
        diff(psi(F), F)
    }
    /// The same by an argument instead of a `let` name.
    fn stress_of(F: Tensor) -> Tensor {
        diff(psi(F), F)
    }
    pub fn piola_by_argument(u: Vector) -> Tensor {
        stress_of(I + grad(u))
    }
    /// At F = I the stress vanishes: an argument may be a constant.
    pub fn reference_stress() -> Tensor {
        stress_of(I)
    }
    pub fn weak_form(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress_of(I + grad(u)), grad(v)))
    }
    /// Linear in w: its tangent is the energy's second derivative at u.
    pub fn hessian(u: State<Vector>, w: Unknown<Vector>, v: Test<Vector>) -> Form {
        derivative(derivative(energy(u), u, v), u, w)
    }
    /// Two fields, one energy: a spring to a field of its own.
    pub fn coupled(u: Unknown<Vector>, s: Unknown<Scalar>) -> Energy {
        integral(Omega, s * s * dot(u, u) + exp(s) * div(u) + dot(grad(s), grad(s)) / 2)
    }
}

const LAMBDA: f64 = 1.7;
const MU: f64 = 0.6;

fn data<const D: usize>() -> hyperelastic::Data<D> {
    hyperelastic::data().lambda(LAMBDA).mu(MU)
}

fn omega() -> hyperelastic::Omega {
    hyperelastic::Omega::on("all")
}

fn state<const D: usize>() -> (Mesh<D>, Nodal) {
    let mut random = Random(21);
    let mesh = Mesh::<D>::cube(&mut random);
    let u = random.field(mesh.nodes.len(), D, 0.0, 0.15);
    (mesh, u)
}

fn assert_near(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    let scale = expected.iter().fold(1.0_f64, |largest, entry| largest.max(entry.abs()));
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() <= 1e-12 * scale, "{found} is not {expected}");
    }
}

/// P = μ (F − F⁻ᵀ) + λ ln J F⁻ᵀ in each cell (P1: F is constant there).
fn piola_in_closed_form<const D: usize>(mesh: &Mesh<D>, u: &Nodal) -> Vec<Vec<Vec<f64>>> {
    let stress = |cell: &&toy_backend::mesh::Element<D>| {
        let mut f: Vec<Vec<f64>> = (0..D).map(|i| (0..D).map(|j| f64::from(i == j)).collect()).collect();
        for (node, basis) in cell.nodes.iter().zip(&cell.points[0].basis) {
            for (i, row) in f.iter_mut().enumerate() {
                for (entry, slope) in row.iter_mut().zip(&basis.gradient) {
                    *entry += u.values[node * D + i] * slope;
                }
            }
        }
        let (k, logarithm) = (inverse(&f), determinant(&f).ln());
        let entry = |i: usize, j: usize| MU * (f[i][j] - k[j][i]) + LAMBDA * logarithm * k[j][i];
        (0..D).map(|i| (0..D).map(|j| entry(i, j)).collect()).collect()
    };
    mesh.elements(Entity::Cells, "all").iter().map(stress).collect()
}

fn stresses<const D: usize>()
where
    Dim: Dimension<D>,
{
    let (mesh, u) = state::<D>();
    let stress = piola_in_closed_form(&mesh, &u);
    let by_name = expression(&mesh, &hyperelastic::piola(&data(), u.source()), (Entity::Cells, "all"));
    let by_argument =
        expression(&mesh, &hyperelastic::piola_by_argument(&data(), u.source()), (Entity::Cells, "all"));
    let points = mesh.elements(Entity::Cells, "all")[0].points.len();
    for (index, expected) in stress.iter().enumerate() {
        assert_near(&by_name[index * points], &expected.concat());
        assert_near(&by_argument[index * points], &expected.concat());
    }
    let reference = expression(&mesh, &hyperelastic::reference_stress(&data()), (Entity::Cells, "all"));
    assert!(reference.iter().flatten().all(|entry| *entry == 0.0), "{reference:?}");
    // ∫ P : ∇v = Σ |T| P ∇φ.
    let mut expected = vec![0.0; u.values.len()];
    for (cell, stress) in mesh.elements(Entity::Cells, "all").iter().zip(&stress) {
        for (node, basis) in cell.nodes.iter().zip(&cell.points[0].basis) {
            for i in 0..D {
                let force: f64 = (0..D).map(|j| stress[i][j] * basis.gradient[j]).sum();
                expected[node * D + i] += cell.cell.cell_volume * force;
            }
        }
    }
    let unknowns = [u];
    let energy = hyperelastic::energy(&data(), &omega());
    let weak = hyperelastic::weak_form(&data(), &omega());
    assert_near(&residual::<f64, D>(&mesh, &energy, &unknowns), &expected);
    assert_near(&residual::<f64, D>(&mesh, &weak, &unknowns), &expected);
    let tangents = [tangent::<f64, D>(&mesh, &energy, &unknowns), tangent::<f64, D>(&mesh, &weak, &unknowns)];
    assert_near(&tangents[0].concat(), &tangents[1].concat());
}

#[test]
fn stresses_equal_their_closed_form() {
    stresses::<2>();
    stresses::<3>();
}

fn second_derivatives<const D: usize>()
where
    Dim: Dimension<D>,
{
    let (mesh, u) = state::<D>();
    let energy = hyperelastic::energy(&data(), &omega());
    let matrix = tangent::<f64, D>(&mesh, &energy, std::slice::from_ref(&u));
    let hessian = hyperelastic::hessian(&data(), &omega(), u.source());
    // What w is does not matter to the tangent of a linear form; to the residual it does.
    let w = Random(22).field(mesh.nodes.len(), D, 0.0, 1.0);
    let unknowns = [w];
    assert_near(&tangent::<f64, D>(&mesh, &hessian, &unknowns).concat(), &matrix.concat());
    let product: Vec<f64> =
        matrix.iter().map(|row| row.iter().zip(&unknowns[0].values).map(|(k, w)| k * w).sum()).collect();
    assert_near(&residual::<f64, D>(&mesh, &hessian, &unknowns), &product);
    // The residual is the energy's slope: central differences, error h² E‴ / 6.
    let at = |step: f64| {
        let values = u.values.iter().zip(&unknowns[0].values).map(|(u, w)| u + step * w).collect();
        toy_backend::energy(&mesh, &energy, &[Nodal { components: D, values }])
    };
    let slope: f64 = residual::<f64, D>(&mesh, &energy, std::slice::from_ref(&u))
        .iter()
        .zip(&unknowns[0].values)
        .map(|(r, w)| r * w)
        .sum();
    let difference = (at(1e-5) - at(-1e-5)) / 2e-5;
    assert!((slope - difference).abs() <= 1e-8 * slope.abs().max(1.0), "{slope} is not {difference}");
}

#[test]
fn a_nested_derivative_is_the_tangent_of_an_energy() {
    second_derivatives::<2>();
    second_derivatives::<3>();
}

#[test]
fn an_energy_of_two_fields_has_a_symmetric_tangent() {
    let mut random = Random(23);
    let mesh = Mesh::<3>::cube(&mut random);
    let unknowns = [random.field(8, 3, 0.0, 0.5), random.field(8, 1, 0.0, 0.5)];
    let form = hyperelastic::coupled(&data(), &omega());
    let matrix = tangent::<f64, 3>(&mesh, &form, &unknowns);
    for (i, row) in matrix.iter().enumerate() {
        for (j, entry) in row.iter().enumerate() {
            assert!((entry - matrix[j][i]).abs() <= 1e-14);
        }
    }
    // Residual against the energy, entry by entry; the remainder is h² E‴ / 6.
    let found = residual::<f64, 3>(&mesh, &form, &unknowns);
    for (index, found) in found.iter().enumerate() {
        let at = |step: f64| {
            let mut moved = unknowns.clone();
            if let Some(value) = moved.iter_mut().flat_map(|field| &mut field.values).nth(index) {
                *value += step;
            }
            toy_backend::energy(&mesh, &form, &moved)
        };
        let difference = (at(1e-5) - at(-1e-5)) / 2e-5;
        assert!((found - difference).abs() <= 1e-9, "{found} is not {difference}");
    }
}

//! When is γ₀ large enough? For θ > −1 Nitsche's method is monotone only if, on every contact cell,
//! γ ≥ s (1+θ)²/4 λ_T with s > 1, where λ_T is the largest eigenvalue of ∫_F σ_n(v)² = λ ∫_T σ(v):ε(v)
//! modulo rigid motions (F runs over the contact facets of T).

use std::collections::BTreeMap;

use forms_fem::prelude::*;
use nalgebra::{DMatrix, SymmetricEigen};

use crate::forms;
use crate::states::ContactProblem;

/// Eigenvalues of ∫_T σ:ε below this part of the largest belong to rigid motions.
const RIGID: f64 = 1e-10;

/// The γ₀ \[stress\] at which s = 1 on the worst contact cell; zero for θ = −1, which has no threshold.
/// `contact_cells` names the cells that own the facets of Γ_C.
///
/// # Errors
/// Data that do not fit.
pub fn required_gamma0<const D: usize>(
    problem: &ContactProblem<D>,
    contact_cells: &str,
) -> Result<f64, AssemblyError>
where
    forms::normal_stress_product::Form<D>: Form<D>,
    forms::elasticity::Form<D>: Form<D>,
{
    let factor = (1.0 + problem.data.theta).powi(2) / 4.0;
    if factor == 0.0 {
        return Ok(0.0);
    }
    let zero = Field::zero(&problem.space);
    let (unknowns, tests) = ([&zero], [&problem.space]);
    let product = forms::normal_stress_product(&problem.data, &problem.regions.gamma_c);
    let energy = forms::elasticity(&problem.data, &forms::Omega::on(contact_cells));
    let energies: BTreeMap<u32, DMatrix<f64>> = problem
        .assembler
        .element_matrices(&energy, &unknowns, &tests)?
        .into_iter()
        .map(|element| {
            (element.cell, DMatrix::from_row_slice(element.rows, element.columns, &element.values))
        })
        .collect();
    let mut stresses: BTreeMap<u32, DMatrix<f64>> = BTreeMap::new();
    for element in problem.assembler.element_matrices(&product, &unknowns, &tests)? {
        let matrix = DMatrix::from_row_slice(element.rows, element.columns, &element.values);
        match stresses.get_mut(&element.cell) {
            Some(sum) => *sum += matrix,
            None => {
                stresses.insert(element.cell, matrix);
            }
        }
    }
    let mut largest = 0.0_f64;
    for (cell, stress) in stresses {
        if let Some(energy) = energies.get(&cell) {
            let eigenvalue = largest_eigenvalue(stress, energy.clone());
            largest = largest.max(factor * eigenvalue * problem.space.mesh().diameter(cell as usize));
        }
    }
    Ok(largest)
}

/// The largest λ of S v = λ A v over the complement of A's kernel.
fn largest_eigenvalue(s: DMatrix<f64>, a: DMatrix<f64>) -> f64 {
    let decomposition = SymmetricEigen::new(a);
    let top = decomposition.eigenvalues.max();
    let kept: Vec<usize> = (0..decomposition.eigenvalues.len())
        .filter(|k| decomposition.eigenvalues[*k] > RIGID * top)
        .collect();
    let mut basis = DMatrix::zeros(s.nrows(), kept.len());
    for (column, k) in kept.into_iter().enumerate() {
        let scale = 1.0 / decomposition.eigenvalues[k].sqrt();
        basis.set_column(column, &(decomposition.eigenvectors.column(k) * scale));
    }
    SymmetricEigen::new(basis.transpose() * s * basis).eigenvalues.max()
}

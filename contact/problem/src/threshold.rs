//! The threshold of γ₀. For θ > −1 Nitsche's method is monotone only if, on every contact cell,
//! γ ≥ s (1+θ)²/4 λ_T with s > 1, where λ_T is the largest eigenvalue of ∫_F σ_n(v)² = λ ∫_T σ(v):ε(v)
//! modulo rigid motions (F runs over the contact facets of T). With friction the whole traction counts: ∫_F |σ(v)n|².

use std::collections::BTreeMap;

use forms_fem::assemble::ElementMatrix;
use forms_fem::linear_algebra::SymmetricEigen;
use forms_fem::prelude::*;

use crate::contact_problem::ContactProblem;
use crate::law::WithThreshold;

/// Eigenvalues of ∫_T σ:ε below this part of the largest belong to rigid motions.
const RIGID: f64 = 1e-10;

/// The threshold of γ₀ for Nitsche's method on a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Threshold {
    /// The γ₀ \[stress\] at which s = 1 on the worst contact cell; zero for θ = −1, which has no threshold.
    pub required: f64,
    /// The problem's γ₀.
    pub gamma0: f64,
    /// The problem's θ.
    pub theta: f64,
    /// The mean of the worst cell's vertices; none for θ = −1.
    pub worst: Option<Vec<f64>>,
}

impl Threshold {
    /// A warning that names both values and the worst cell, where γ₀ is not above the threshold.
    pub fn warning(&self) -> Option<String> {
        let Threshold { required, gamma0, theta, worst } = self;
        (gamma0 <= required).then(|| {
            format!(
                "gamma0 = {gamma0} is below the threshold of Nitsche's method: at theta = {theta} the contact cell at \
                 {:?} asks for more than {required:.6}; the results cannot be relied on",
                worst.as_deref().unwrap_or_default()
            )
        })
    }
}

/// The γ₀ \[stress\] of [`threshold`] at which s = 1 on the worst contact cell.
///
/// # Errors
/// Data that do not fit.
pub fn required_gamma0<L: WithThreshold<D>, const D: usize>(
    problem: &ContactProblem<D, L>,
    contact_cells: &str,
) -> Result<f64, AssemblyError>
where
    Dim: Dimension<D>,
{
    Ok(threshold(problem, contact_cells)?.required)
}

/// The threshold of γ₀. `contact_cells` names the cells that own the facets of Γ_C; the products ∫_F σ_n σ_n of a
/// cell's facets add up, since all of them have its γ.
///
/// # Errors
/// Data that do not fit; a cell with a facet of Γ_C that is not among `contact_cells`.
pub fn threshold<L: WithThreshold<D>, const D: usize>(
    problem: &ContactProblem<D, L>,
    contact_cells: &str,
) -> Result<Threshold, AssemblyError>
where
    Dim: Dimension<D>,
{
    let (gamma0, theta) = (problem.law.gamma0(), problem.law.theta());
    let factor = (1.0 + theta).powi(2) / 4.0;
    if factor == 0.0 {
        return Ok(Threshold { required: 0.0, gamma0, theta, worst: None });
    }
    let zero = Field::zero(&problem.space);
    let (unknowns, tests) = ([&zero], [&problem.space]);
    let product = problem.law.stress_product();
    let energy = problem.law.energy_on(contact_cells);
    let energies = problem.assembler.element_matrices(&energy, &unknowns, &tests)?;
    let products = problem.assembler.element_matrices(&product, &unknowns, &tests)?;
    let mesh = problem.space.mesh();
    let (mut required, mut worst) = (0.0, None);
    for (cell, largest) in largest_eigenvalues(energies, products) {
        let centre = mesh.cell_centre(cell as usize).to_vec();
        let Some(largest) = largest else {
            return Err(AssemblyError::CellOfFacet {
                form: product.name(),
                cells: contact_cells.to_owned(),
                facets: problem.law.contact_region().to_owned(),
                position: centre,
            });
        };
        let of_cell = factor * largest * mesh.diameter(cell as usize);
        if of_cell > required {
            (required, worst) = (of_cell, Some(centre));
        }
    }
    Ok(Threshold { required, gamma0, theta, worst })
}

/// The largest eigenvalue of each cell that has products of stresses on its facets; none where its energy is missing.
fn largest_eigenvalues(
    energies: Vec<ElementMatrix>,
    products: Vec<ElementMatrix>,
) -> Vec<(u32, Option<f64>)> {
    let energies: BTreeMap<u32, ElementMatrix> =
        energies.into_iter().map(|element| (element.cell, element)).collect();
    let mut stresses: BTreeMap<u32, Vec<f64>> = BTreeMap::new();
    for element in products {
        let sum = stresses.entry(element.cell).or_insert_with(|| vec![0.0; element.values.len()]);
        sum.iter_mut().zip(&element.values).for_each(|(sum, value)| *sum += value);
    }
    let largest =
        |cell: &u32, stress: &[f64]| energies.get(cell).map(|energy| largest_eigenvalue(stress, energy));
    stresses.iter().map(|(cell, stress)| (*cell, largest(cell, stress))).collect()
}

/// The largest λ of S v = λ A v over the complement of A's kernel; infinite where it cannot be determined.
fn largest_eigenvalue(s: &[f64], a: &ElementMatrix) -> f64 {
    let size = a.rows;
    let Some(energy) = SymmetricEigen::of(size, &a.values) else { return f64::INFINITY };
    let top = largest(&energy.values);
    // Where A is the identity: its eigenvectors, scaled, without those of the kernel.
    let basis: Vec<Vec<f64>> = energy
        .values
        .iter()
        .zip(&energy.vectors)
        .filter(|(value, _)| **value > RIGID * top)
        .map(|(value, vector)| vector.iter().map(|entry| entry / value.sqrt()).collect())
        .collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let image = |vector: &Vec<f64>| s.chunks(size).map(|row| dot(row, vector)).collect();
    let images: Vec<Vec<f64>> = basis.iter().map(image).collect();
    let products: Vec<f64> = basis.iter().flat_map(|v| images.iter().map(|image| dot(v, image))).collect();
    SymmetricEigen::of(basis.len(), &products).map_or(f64::INFINITY, |found| largest(&found.values))
}

fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

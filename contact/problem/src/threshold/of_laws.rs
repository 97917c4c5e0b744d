//! The threshold of a law's γ₀ from the eigenvalues of its contact cells.

use std::collections::BTreeMap;

use forms_fem::assemble::ElementMatrix;
use forms_fem::mesh::EVERYWHERE;
use forms_fem::prelude::*;

use super::Threshold;
use super::eigenvalue::largest_eigenvalue;
use crate::contact_problem::ContactProblem;
use crate::law::{ContactLaw, WithThreshold};

/// Matrices whose entries differ by less than this part of the largest one are the same.
const SAME_MATRIX: f64 = 1e-12;

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
    on_cells(&problem.law, &problem.assembler, &problem.space, contact_cells)
}

/// The threshold of a law on the cells that own the facets of its Γ_C.
///
/// # Errors
/// Data that do not fit.
pub fn of_law<L: WithThreshold<D>, const D: usize>(
    law: &L,
    assembler: &Assembler<D>,
    space: &Arc<Space<D>>,
) -> Result<Threshold, AssemblyError>
where
    Dim: Dimension<D>,
{
    // Nothing is assembled for the variant without a threshold.
    if law.theta() == -1.0 {
        return on_cells(law, assembler, space, EVERYWHERE);
    }
    let owned = on_cells_of_facets(assembler, space, law.stress_product().name(), &[law.contact_region()])?;
    on_cells(law, &owned, space, EVERYWHERE)
}

/// The assembler of the cells that own some facets.
///
/// # Errors
/// If a region is unknown.
#[doc(hidden)]
pub fn on_cells_of_facets<const D: usize>(
    assembler: &Assembler<D>,
    space: &Arc<Space<D>>,
    form: &'static str,
    regions: &[&str],
) -> Result<Assembler<D>, AssemblyError> {
    let refused = |source| AssemblyError::Region { form, symbol: "of contact", source };
    let mut cells = vec![];
    for region in regions {
        cells.extend(space.mesh().facet_region(region).map_err(refused)?.iter().map(|facet| facet.cell));
    }
    cells.sort_unstable();
    cells.dedup();
    assembler.clone().on_owned_cells(&cells).map_err(refused)
}

fn on_cells<L: WithThreshold<D>, const D: usize>(
    law: &L,
    assembler: &Assembler<D>,
    space: &Arc<Space<D>>,
    contact_cells: &str,
) -> Result<Threshold, AssemblyError>
where
    Dim: Dimension<D>,
{
    let (gamma0, theta) = (law.gamma0(), law.theta());
    let factor = (1.0 + theta).powi(2) / 4.0;
    if factor == 0.0 {
        return Ok(Threshold { required: 0.0, gamma0, theta, worst: None });
    }
    let zero = Field::zero(space);
    let (unknowns, tests) = ([&zero], [space]);
    let product = law.stress_product();
    let energies = assembler.element_matrices(&law.energy_on(contact_cells), &unknowns, &tests)?;
    let products = assembler.element_matrices(&product, &unknowns, &tests)?;
    let mesh = space.mesh();
    let (mut required, mut worst) = (0.0, None);
    for (cell, largest) in largest_eigenvalues(energies, products, assembler.threads()) {
        let centre = mesh.cell_centre(cell as usize).to_vec();
        let Some(largest) = largest else {
            return Err(AssemblyError::CellOfFacet {
                form: product.name(),
                cells: contact_cells.to_owned(),
                facets: law.contact_region().to_owned(),
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

impl<const D: usize, L: ContactLaw<D>> ContactProblem<D, L> {
    /// The threshold of the law's γ₀ on this mesh, with the undeformed body's stiffness; `None` for a law without a threshold.
    ///
    /// # Errors
    /// Data that do not fit.
    pub fn threshold(&self) -> Result<Option<Threshold>, AssemblyError> {
        self.law.threshold(&self.assembler, &self.space)
    }
}

/// The largest eigenvalue of each cell that has products of stresses on its facets; none where its energy is missing.
#[doc(hidden)]
pub fn largest_eigenvalues(
    energies: Vec<ElementMatrix>,
    products: Vec<ElementMatrix>,
    threads: Threads,
) -> Vec<(u32, Option<f64>)> {
    let energies: BTreeMap<u32, ElementMatrix> =
        energies.into_iter().map(|element| (element.cell, element)).collect();
    let mut stresses: BTreeMap<u32, Vec<f64>> = BTreeMap::new();
    for element in products {
        let sum = stresses.entry(element.cell).or_insert_with(|| vec![0.0; element.values.len()]);
        sum.iter_mut().zip(&element.values).for_each(|(sum, value)| *sum += value);
    }
    let cells: Vec<CellMatrices<'_>> = stresses
        .iter()
        .map(|(cell, stress)| CellMatrices { cell: *cell, stress, energy: energies.get(cell) })
        .collect();
    // Cells of one shape follow each other on many meshes: one of them is enough. Which ones are compared does not depend on threads.
    let firsts: Vec<usize> =
        (0..cells.len()).filter(|k| *k == 0 || !cells[*k].is_as(&cells[*k - 1])).collect();
    let count = threads.count().clamp(1, firsts.len().max(1));
    let parts = (0..count).map(|k| &firsts[k * firsts.len() / count..(k + 1) * firsts.len() / count]);
    let largest =
        |part: &[usize]| part.iter().map(|first| cells[*first].largest_eigenvalue()).collect::<Vec<_>>();
    let found: Vec<Option<f64>> = threads.run(parts.collect(), largest).into_iter().flatten().collect();
    let of_first = |k: usize| found[firsts.partition_point(|first| *first <= k) - 1];
    cells.iter().enumerate().map(|(k, one)| (one.cell, of_first(k))).collect()
}

/// The matrices of a cell that has products of stresses on its facets.
struct CellMatrices<'a> {
    cell: u32,
    stress: &'a [f64],
    energy: Option<&'a ElementMatrix>,
}

impl CellMatrices<'_> {
    fn largest_eigenvalue(&self) -> Option<f64> {
        self.energy.map(|energy| largest_eigenvalue(energy.rows, self.stress, &energy.values))
    }

    /// Whether another cell has the same matrices up to rounding.
    fn is_as(&self, other: &Self) -> bool {
        let same = |a: &[f64], b: &[f64]| {
            let most = a.iter().fold(0.0_f64, |most, entry| most.max(entry.abs()));
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= SAME_MATRIX * most)
        };
        match (self.energy, other.energy) {
            (Some(a), Some(b)) => same(self.stress, other.stress) && same(&a.values, &b.values),
            _ => false,
        }
    }
}

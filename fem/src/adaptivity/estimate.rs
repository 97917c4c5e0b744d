//! Estimates of an error, with the share of each cell.

use std::sync::Arc;

use crate::contract::Form;
use thiserror::Error;

use crate::assemble::{Assembler, AssemblyError};
use crate::constraints::{Constraints, ConstraintsError};
use crate::field::{Field, TransferError};
use crate::instantiate::instantiate;
use crate::mesh::Mesh;
use crate::space::{Space, SpaceError};

/// An estimated error and the indicators of the cells: which of them it comes from.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorEstimate {
    value: f64,
    indicators: Vec<f64>,
    /// R(u; I p) of a goal; zero of a norm.
    defect: f64,
}

/// Errors of estimates.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs)]
pub enum EstimateError {
    /// A square of an indicator that is negative or not finite.
    #[error("the square of the indicator of cell {cell} is {value}")]
    Square { cell: usize, value: f64 },
    /// An adjoint state whose space is not richer than that of the solution has no weight: the residual vanishes on it.
    #[error("the adjoint state has degree {adjoint}, which must be higher than the solution's, {primal}")]
    Degree {
        /// Degree of the adjoint state.
        adjoint: usize,
        /// Degree of the solution.
        primal: usize,
    },
    /// Estimates on different meshes have no indicators in common.
    #[error("an estimate on {cells} cells and one on {others} have no mesh in common")]
    Cells {
        /// Cells of the estimate.
        cells: usize,
        /// Cells of the other one.
        others: usize,
    },
    /// The spaces do not belong together.
    #[error(transparent)]
    Space(#[from] SpaceError),
    /// The adjoint state cannot be interpolated.
    #[error(transparent)]
    Transfer(#[from] TransferError),
    /// Continuity at hanging nodes cannot be stated.
    #[error(transparent)]
    Hanging(#[from] ConstraintsError),
    /// The form does not fit.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
}

impl ErrorEstimate {
    /// η = √Σ η_T² of a residual estimator: a linear form with a scalar test function, whose value at the function that is 1 on a
    /// cell and 0 elsewhere is η_T².
    ///
    /// # Errors
    /// [`EstimateError::Square`]: a square that is negative or not finite, by its cell; a form that does not fit.
    pub fn residual<const D: usize>(
        assembler: &Assembler<D>,
        squared: &Form<D>,
    ) -> Result<Self, EstimateError> {
        let constants = Space::discontinuous_scalar(assembler.mesh(), 0)?;
        let squares = assembler.linear_form(squared, &constants)?;
        // Nodes are numbered along a curve through the cells.
        let cells = 0..assembler.mesh().cell_count();
        let of_cell = |cell| constants.cell_nodes(cell).iter().map(|&node| squares[node as usize]).sum();
        ErrorEstimate::of_squares(&cells.map(of_cell).collect::<Vec<f64>>())
    }

    /// η = √Σ η_T² from the squares η_T², one number for each cell.
    ///
    /// # Errors
    /// [`EstimateError::Square`]: a number that is negative or not finite, by its cell.
    pub fn of_squares(squares: &[f64]) -> Result<Self, EstimateError> {
        let wrong = |value: &f64| !(value.is_finite() && *value >= 0.0);
        if let Some(cell) = squares.iter().position(wrong) {
            return Err(EstimateError::Square { cell, value: squares[cell] });
        }
        let value = squares.iter().sum::<f64>().sqrt();
        Ok(ErrorEstimate { value, indicators: squares.to_vec(), defect: 0.0 })
    }

    /// η = R(u; p − I p), which estimates J(u) − J(u_h) with its sign: p is the adjoint state, R'(u)(q, p) + J'(u)(q) = 0 for
    /// all q, in a space of higher degree on the same mesh, and I the interpolation in `space`, that of u_h. `localised` makes
    /// the linear form q ↦ R(u; q z) of the weight z = p − I p; its values at the hat functions q, whose sum is 1, are the shares
    /// of the vertices (Richter and Wick 2015), and each vertex hands its share to its cells in equal parts.
    ///
    /// On meshes with hanging nodes ([`OctreeMesh`](crate::mesh::OctreeMesh)) I p and the hat functions are continuous, as u_h is.
    ///
    /// Exact for a linear problem and a linear J, up to the error of p. Prescribed values that `space` cannot represent
    /// are not seen, nor is a boundary that moves as it is refined.
    ///
    /// **One rule for all.** η leaves R(u; I p) out, which is zero where u was solved for with the integrals that `assembler` takes. On curved
    /// cells the rules that forms choose for themselves differ from one form to another, and that part of the error is of the order of
    /// J(u) − J(u_h): give one [`Assembler::with_quadrature`] to u, p, J and the estimate, of degree 8 for u of degree 2 on geometry of degree 2.
    /// [`ErrorEstimate::defect`] is that part, and [`ErrorEstimate::note`] says where it is too large. With contact split the facets, too
    /// (`ContactProblem::with_split_facets`).
    ///
    /// # Errors
    /// [`EstimateError`]: spaces on different meshes, an adjoint state that is not of higher degree, a form that does not fit.
    pub fn dual_weighted<const D: usize>(
        assembler: &Assembler<D>,
        p: &Field<D>,
        space: &Arc<Space<D>>,
        localised: impl Fn(&Field<D>) -> Form<D>,
    ) -> Result<Self, EstimateError> {
        let [interpolated, weight] = interpolated_and_weight(p, space)?;
        let hats = Space::scalar(space.mesh(), 1)?;
        let mut shares = assembler.linear_form(&localised(&weight), &hats)?;
        let defect = assembler.linear_form(&localised(&interpolated), &hats)?.iter().sum();
        hand_over_hanging_shares(&hats, &mut shares)?;
        let indicators = handed_to_cells(&hats, &shares);
        Ok(ErrorEstimate { value: shares.iter().sum(), indicators, defect })
    }

    /// R(u; I p) of a goal \[J\], which η leaves out: zero but for rounding where u solves the equations that the estimate's assembler takes, and
    /// the part of the error that comes from another quadrature, where that is the difference. Loads that are in no form
    /// ([`RigidLoads`](crate::solve::RigidLoads)) are in it, too. Zero of an estimate in a norm.
    pub fn defect(&self) -> f64 {
        self.defect
    }

    /// A remark, where the part of the error that η leaves out is more than a twentieth of η: the quadrature of u and that of the
    /// estimate differ too much.
    pub fn note(&self) -> Option<String> {
        let ErrorEstimate { value, defect, .. } = self;
        (defect.abs() > DEFECT * value.abs()).then(|| {
            format!(
                "the estimated error {value:e} leaves out {defect:e}, the residual at the interpolated adjoint state, which is zero where one \
                 quadrature is taken for all: give one `Assembler::with_quadrature` to the solution, the goal and the estimate"
            )
        })
    }

    /// This estimated error with the indicators of two estimates on one mesh, each over its sum: cells are marked for both. A goal's η is
    /// as good as its adjoint state, so that a mesh for a goal is marked for the error of that state, too, where η is to be relied on.
    ///
    /// # Errors
    /// [`EstimateError::Cells`]: estimates with different numbers of cells.
    pub fn marking_also_by(mut self, other: &ErrorEstimate) -> Result<Self, EstimateError> {
        let (cells, others) = (self.indicators.len(), other.indicators.len());
        if cells != others {
            return Err(EstimateError::Cells { cells, others });
        }
        let relative = |indicators: &[f64]| -> Vec<f64> {
            let sum: f64 = indicators.iter().sum();
            indicators.iter().map(|one| if sum > 0.0 { one / sum } else { 0.0 }).collect()
        };
        let both = relative(&self.indicators).into_iter().zip(relative(&other.indicators));
        self.indicators = both.map(|(one, other)| one + other).collect();
        Ok(self)
    }

    /// The estimated error: η ≥ 0 of a norm, or J(u) − J(u_h) with its sign.
    pub fn value(&self) -> f64 {
        self.value
    }

    /// The share of each cell, by which to mark cells: numbers ≥ 0 that add up, to η² of a norm; of a goal to a bound of |η|, as
    /// nothing cancels in them.
    pub fn indicators(&self) -> &[f64] {
        &self.indicators
    }
}

/// The part that η leaves out is reported above this part of it.
const DEFECT: f64 = 0.05;

/// I p and p − I p, in the space of p.
#[inline(never)]
fn interpolated_and_weight<const D: usize>(
    p: &Field<D>,
    space: &Arc<Space<D>>,
) -> Result<[Field<D>; 2], EstimateError> {
    let higher = p.space();
    if !higher.mesh().is_same(space.mesh()) {
        return Err(SpaceError::OtherMesh.into());
    }
    if higher.degree() <= space.degree() {
        return Err(EstimateError::Degree { adjoint: higher.degree(), primal: space.degree() });
    }
    let mut interpolated = p.onto(space).interpolated()?;
    if let Some(joined) = Constraints::joining(space)? {
        let mut values = interpolated.values().to_vec();
        joined.apply(&mut values);
        interpolated = Field::of_known(space, values);
    }
    let interpolated = interpolated.onto(higher).interpolated()?;
    let difference = p.values().iter().zip(interpolated.values()).map(|(p, i)| p - i).collect();
    let weight = Field::of_known(higher, difference);
    Ok([interpolated, weight])
}

/// Gives the shares of hanging nodes to the nodes that they hang on: the hat functions of these are continuous then.
#[inline(never)]
fn hand_over_hanging_shares<const D: usize>(
    hats: &Arc<Space<D>>,
    shares: &mut [f64],
) -> Result<(), EstimateError> {
    if let Some(joined) = Constraints::joining(hats)? {
        for (&hanging, relation) in joined.relations() {
            let share = std::mem::take(&mut shares[hanging]);
            relation.terms.iter().for_each(|(free, a)| shares[*free] += a * share);
        }
    }
    Ok(())
}

/// Sums over the cells of what their vertices have for each of their cells, in absolute value.
#[inline(never)]
fn handed_to_cells<const D: usize>(hats: &Arc<Space<D>>, shares: &[f64]) -> Vec<f64> {
    let mesh: &Mesh<D> = hats.mesh();
    let cells = 0..mesh.cell_count();
    let mut counts = vec![0.0_f64; hats.node_count()];
    for &node in cells.clone().flat_map(|cell| hats.cell_nodes(cell)) {
        counts[node as usize] += 1.0;
    }
    let part = |&node: &u32| shares[node as usize].abs() / counts[node as usize];
    cells.map(|cell| hats.cell_nodes(cell).iter().map(part).sum()).collect()
}

instantiate!(estimate: hand_over_hanging_shares::<D>, interpolated_and_weight::<D>, handed_to_cells::<D>);

//! Condensed system: K x + N(x) = b on only the condensed unknowns c, for Newton's method. With y = D⁻¹ L⁻¹ b,
//!
//!   R_c(x) = S x_c + N_c(x) − L_c D_c y_c,   (S + dN) δ_c = −R_c,   x = L⁻ᵀ (y_f, L_cᵀ x_c).
//!
//! Rows outside of c hold for every x_c. One half solve begins the iteration and one ends it; between them a step
//! costs a dense system, and a back-substitution for the unknowns that N reads.

use std::sync::Arc;

use crate::linear_algebra::{Condensation, PartialBackSubstitution};
use crate::solve::linear_solver::SolverError;

/// The state of such an iteration, with the factor that it belongs to.
#[derive(Debug)]
pub(in crate::solve) struct CondensedSystem {
    condensation: Arc<Condensation>,
    y: Vec<f64>,
    /// L_c D_c y_c.
    load: Vec<f64>,
    /// The unknowns that N reads, and how to get at them.
    watched: Vec<u32>,
    substitution: PartialBackSubstitution,
}

impl CondensedSystem {
    pub(super) fn new(
        condensation: &Arc<Condensation>,
        b: &[f64],
        watched: &[u32],
    ) -> Result<Self, SolverError> {
        let y = condensation.forward(b)?;
        Ok(CondensedSystem {
            condensation: condensation.clone(),
            load: condensation.condensed_load(&y),
            y,
            watched: watched.to_vec(),
            substitution: PartialBackSubstitution::new(condensation.factor(), watched)?,
        })
    }

    /// c, in the order of the vectors on it.
    pub fn unknowns(&self) -> &[u32] {
        self.condensation.unknowns()
    }

    pub(super) fn belongs_to(&self, condensation: &Arc<Condensation>) -> bool {
        Arc::ptr_eq(&self.condensation, condensation)
    }

    /// The entries of c in a vector of all unknowns.
    pub fn condensed(&self, x: &[f64]) -> Vec<f64> {
        self.unknowns().iter().map(|unknown| x[*unknown as usize]).collect()
    }

    /// The entries of x that N reads, brought up to date with x_c.
    ///
    /// # Errors
    /// Vectors of other sizes.
    pub fn update(&mut self, x_c: &[f64], x: &mut [f64]) -> Result<(), SolverError> {
        let first = self.y.len() - x_c.len();
        self.y[first..].copy_from_slice(&self.condensation.shifted(x_c));
        let values = self.substitution.solve(self.condensation.factor(), &self.y)?;
        let watched = self.watched.iter().zip(values);
        watched.for_each(|(unknown, value)| x[*unknown as usize] = value);
        Ok(())
    }

    /// x of all unknowns.
    pub(super) fn complete(mut self, x_c: &[f64]) -> Result<Vec<f64>, SolverError> {
        let first = self.y.len() - x_c.len();
        self.y[first..].copy_from_slice(&self.condensation.shifted(x_c));
        Ok(self.condensation.factor().solve_upper(self.y)?)
    }

    /// R_c for the x_c and N of all unknowns.
    pub fn residual(&self, x_c: &[f64], nonlinear: &[f64]) -> Vec<f64> {
        let product = self.condensation.schur_times(x_c);
        let nonlinear = self.condensed(nonlinear);
        product.iter().zip(nonlinear).zip(&self.load).map(|((s, n), load)| s + n - load).collect()
    }
}

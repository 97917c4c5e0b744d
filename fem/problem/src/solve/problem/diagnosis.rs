//! Errors of linear solvers told in a problem's own terms: field, component, position, rigid motions.

use super::Problem;
use crate::linear_algebra::LinearAlgebraError;
use crate::solve::{Elimination, Floating, NonlinearProblem, SolverError, WorstEquation};

impl<const D: usize, const N: usize> Problem<'_, D, N> {
    /// A singular matrix is reported with the field and the place of an unknown that it does not determine, an equation
    /// that does not hold with those of its unknown.
    pub(in crate::solve) fn named(&self, error: SolverError, elimination: &Elimination) -> SolverError {
        let unknown = match error {
            SolverError::LinearAlgebra(
                LinearAlgebraError::Singular { unknown, .. }
                | LinearAlgebraError::IllConditioned { unknown, .. }
                | LinearAlgebraError::Inaccurate { row: unknown, .. },
            ) => unknown,
            _ => return error,
        };
        let mut index = elimination.free().get(unknown).copied().unwrap_or(0);
        for (number, space) in self.system.spaces.iter().enumerate() {
            if index < space.unknowns() {
                let components = space.components();
                let field = self.system.unknown_name(number);
                let component = (components > 1).then_some(index % components);
                let position = space.positions()[index / components].to_vec();
                return match error {
                    SolverError::LinearAlgebra(LinearAlgebraError::Inaccurate { backward_error, .. }) => {
                        SolverError::Inaccurate { field, component, position, backward_error }
                    }
                    SolverError::LinearAlgebra(LinearAlgebraError::IllConditioned { condition, .. }) => {
                        // A body that can move rigidly is singular, whatever rounding makes of its matrix.
                        let floating = self.floating(number, index / components, elimination);
                        let ratio = 1.0 / condition;
                        match floating {
                            Floating::Nothing => {
                                SolverError::IllConditioned { field, component, position, condition }
                            }
                            floating => {
                                SolverError::Undetermined { field, component, position, ratio, floating }
                            }
                        }
                    }
                    SolverError::LinearAlgebra(LinearAlgebraError::Singular { ratio, .. }) => {
                        let floating = self.floating(number, index / components, elimination);
                        SolverError::Undetermined { field, component, position, ratio, floating }
                    }
                    error => error,
                };
            }
            index -= space.unknowns();
        }
        error
    }

    /// The field and the place of an equation that does not hold.
    pub(super) fn equation_that_is_off(&self, worst: WorstEquation) -> Option<String> {
        let (off, mut index) = (worst.off, worst.unknown);
        for (number, space) in self.system.spaces.iter().enumerate() {
            if index < space.unknowns() {
                let (components, field) = (space.components(), self.system.unknown_name(number));
                let (node, component) = (index / components, index % components);
                let of = if components > 1 { format!("component {component} of ") } else { String::new() };
                let position = space.positions()[node];
                return Some(format!(
                    "the equation of {of}`{field}` at {position:?} is off by {off:.1e} of its terms, more than that of any other \
                     unknown"
                ));
            }
            index -= space.unknowns();
        }
        None
    }

    /// The place of the first entry of the residual at u that is not finite, and what to do.
    pub(super) fn place_without_a_number(&mut self, u: &[f64]) -> Option<String> {
        // What cannot be said is left out: the failure is reported in any case.
        let residual = self.residual(u).ok()?;
        let mut index = residual.iter().position(|value| !value.is_finite())?;
        for (number, space) in self.system.spaces.iter().enumerate() {
            if index < space.unknowns() {
                let (components, field) = (space.components(), self.system.unknown_name(number));
                let (node, component) = (index / components, index % components);
                let position = space.positions()[node];
                return Some(format!(
                    "the forces on `{field}` at {position:?} (component {component}) are no numbers, as where a cell is turned \
                     inside out: come there in smaller steps (`LoadSteps`), or begin nearer to the solution (`Problem::start`)"
                ));
            }
            index -= space.unknowns();
        }
        None
    }

    /// Remarks on points that slide and have no opposite one at u.
    pub(super) fn lost_pairs(&self, u: &[f64]) -> Vec<String> {
        if u.iter().any(|u| !u.is_finite()) {
            return vec![];
        }
        // What cannot be said is left out: the failure is reported in any case.
        let pairs = self.system.pairs(u).unwrap_or_default();
        let lost = pairs.iter().filter(|pairs| pairs.displaced && pairs.report.open > 0);
        lost.flat_map(|pairs| [Some(pairs.to_string()), pairs.note()]).flatten().collect()
    }
}

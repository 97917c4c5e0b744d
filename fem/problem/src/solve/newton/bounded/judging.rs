//! Iterates that are no solution because of their bounds, and sets that repeat.

use super::{ActiveSet, Way};
use crate::linear_algebra::vector::norm;
use crate::solve::newton::Verdict;
use crate::solve::newton::line_search::SYMMETRIC;
use crate::solve::newton::{FreeEquations, NewtonFailure};

/// Iterates with the same set are the same if they differ by less than this part of their size.
const SAME_PLACE: f64 = 1e-8;

impl FreeEquations<'_> {
    /// The verdict on an iterate whose bounds are not settled; none where the rows decide.
    ///
    /// # Errors
    /// [`NewtonFailure::NotConverged`], [`NewtonFailure::BoundsCycle`], and those of assembly.
    pub(in crate::solve::newton) fn judge_bounds(&mut self) -> Result<Option<Verdict>, NewtonFailure> {
        let Some(set) = &self.bounds else { return Ok(None) };
        let total = self.iterates.history.last().map_or(f64::NAN, |last| last.residual);
        if !set.unsettled || !total.is_finite() {
            return Ok(None);
        }
        self.iterates.check_iterations()?;
        let size = norm(&self.iterates.u);
        if let Some((first, period)) = set.cycle(size) {
            if set.way == Way::Residual || !self.is_symmetric()? {
                let unknowns = self.bounds.take().map(|set| set.restless).unwrap_or_default();
                return Err(NewtonFailure::BoundsCycle { first, period, unknowns });
            }
            self.go_along_potential()?;
        }
        Ok(Some(Verdict::GoOn))
    }

    fn is_symmetric(&mut self) -> Result<bool, NewtonFailure> {
        let tangent = self.problem.tangent(&self.iterates.u)?;
        Ok(self.elimination.reduce_matrix(&tangent.matrix)?.asymmetry()? <= SYMMETRIC)
    }

    /// Goes on along the potential, from the last iterate moved between its bounds.
    fn go_along_potential(&mut self) -> Result<(), NewtonFailure> {
        if let Some(set) = &mut self.bounds {
            set.way = Way::Potential;
            set.unknowns.iter_mut().for_each(|one| one.held = None);
            set.project(&mut self.iterates.u);
        }
        self.elimination.impose_relations(&mut self.iterates.u);
        self.residuals = self.residuals_at_last()?;
        self.last_change = None;
        self.update_held()?;
        self.iterates.replace_last_residual(&self.elimination, &self.residuals.reduced);
        Ok(())
    }
}

impl ActiveSet {
    /// The earlier iterate that has the set and the place of the last one, with other sets in between, and the steps since.
    fn cycle(&self, size: f64) -> Option<(usize, usize)> {
        let (last, earlier) = self.visits.split_last()?;
        if self.way == Way::Potential {
            return None;
        }
        let first = earlier.iter().rposition(|visit| {
            visit.set == last.set && (visit.mark - last.mark).abs() <= SAME_PLACE * size
        })?;
        let differs = earlier[first..].iter().any(|visit| visit.set != last.set);
        differs.then_some((earlier[first].iteration, last.iteration - earlier[first].iteration))
    }
}

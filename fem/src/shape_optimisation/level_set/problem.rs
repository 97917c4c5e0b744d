//! Problems on a cut body, and their view as reduced problems.

use std::sync::Arc;

use crate::constraints::Constraints;
use crate::cut::Cut;
use crate::field::Field;
use crate::inverse::ReducedProblem;
use crate::shape_optimisation::{Derivatives, Failure, Values};
use crate::space::Space;
use crate::verification::Sample;

/// A criterion of a body {φ < 0}, perhaps with one constraint.
pub trait LevelSetProblem<const D: usize> {
    /// State of the problem: a displacement, say.
    type State;

    /// Solution on a body. It must depend on the cut only, to the last bit, if a descent that was interrupted is to end as one that was not.
    ///
    /// # Errors
    /// The reason why there is no solution; within a line search a shorter step is tried then.
    fn solve(&self, body: &Arc<Cut<D>>) -> Result<Values<Self::State>, Failure>;

    /// The derivatives by the nodal values of φ on a body that was solved for.
    ///
    /// # Errors
    /// The reason why there are none.
    fn derivatives(&self, body: &Arc<Cut<D>>, state: &mut Self::State) -> Result<Derivatives, Failure>;

    /// The topological derivatives on a body that was solved for, at the nodes of φ: the change by a hole of radius r is r^D times them. Only a
    /// descent that makes holes asks for them; [`means_at_nodes`](super::means_at_nodes) of a form make them.
    ///
    /// # Errors
    /// The reason why there are none.
    fn topological_derivatives(
        &self,
        _body: &Arc<Cut<D>>,
        _state: &mut Self::State,
    ) -> Result<Derivatives, Failure> {
        Err("new holes need the topological derivative, which this problem does not state".into())
    }

    /// Zero changes of φ where the body must stay: none unless a problem holds some.
    ///
    /// # Errors
    /// A region that does not exist.
    fn hold(&self, _changes: &mut Constraints<D>) -> Result<(), Failure> {
        Ok(())
    }
}

/// A problem on a cut body as a [`ReducedProblem`] whose controls are the nodal values of φ, for Taylor tests, bounds and moving asymptotes.
/// Its switches are the sides of cells: J jumps by a little where a node changes sides. The constraint is not part of it.
pub struct LevelSetControls<'a, P, const D: usize> {
    /// The problem.
    pub problem: &'a P,
    /// φ to begin with.
    pub start: Field<D>,
}

impl<P: LevelSetProblem<D>, const D: usize> LevelSetControls<'_, P, D> {
    fn solved(&self, m: &[f64]) -> Result<(Arc<Cut<D>>, Values<P::State>), LevelSetFailure> {
        let space: &Arc<Space<D>> = self.start.space();
        let phi = Field::from_values(space, m.to_vec()).map_err(failure)?;
        let body = Cut::by(&phi).map_err(failure)?;
        let values = self.problem.solve(&body).map_err(LevelSetFailure)?;
        Ok((body, values))
    }
}

/// Error of a problem on a cut body.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub struct LevelSetFailure(Failure);

fn failure<E: std::error::Error + Send + Sync + 'static>(error: E) -> LevelSetFailure {
    LevelSetFailure(Box::new(error))
}

impl<P: LevelSetProblem<D>, const D: usize> ReducedProblem for LevelSetControls<'_, P, D> {
    type Error = LevelSetFailure;

    fn start(&self) -> Vec<f64> {
        self.start.values().to_vec()
    }

    fn sample(&mut self, m: &[f64]) -> Result<Sample, LevelSetFailure> {
        let (body, values) = self.solved(m)?;
        Ok(Sample { value: vec![values.criterion], active_set: Some(body.sides().collect()) })
    }

    fn value_and_gradient(&mut self, m: &[f64]) -> Result<(f64, Vec<f64>), LevelSetFailure> {
        let (body, mut values) = self.solved(m)?;
        let derivatives = self.problem.derivatives(&body, &mut values.state).map_err(LevelSetFailure)?;
        Ok((values.criterion, derivatives.criterion))
    }
}

//! The direction of a descent at a shape, on the pattern and along the wall.

use std::sync::Arc;

use super::descent::Descent;
use super::descent::remeshed::Base;
use super::direction::{Constrained, Direction, check_length};
use super::error::ShapeOptimisationError;
use super::history::DescentState;
use super::problem::{ShapeProblem, Values};
use crate::constraints::Constraints;
use crate::dimension::{Dim, Dimension};
use crate::space::Space;

impl<P: ShapeProblem<D>, const D: usize> Descent<'_, P, D>
where
    Dim: Dimension<D>,
{
    /// The direction at a shape, with nodes held that would go into the wall.
    pub(super) fn direction(
        &self,
        state: &DescentState,
        movements: &Arc<Space<D>>,
        values: &mut Values<P::State>,
        penalty: f64,
        base: &Base<D>,
    ) -> Result<Direction, ShapeOptimisationError> {
        let iteration = state.iterations();
        let of_problem = |source| ShapeOptimisationError::Problem { iteration, source };
        let mut derivatives = self.problem.derivatives(movements, &mut values.state).map_err(of_problem)?;
        let unknowns = movements.unknowns();
        check_length("the criterion", &derivatives.criterion, unknowns)?;
        let mut held = Constraints::new(movements);
        self.problem.fix(&mut held).map_err(of_problem)?;
        if let Some(pattern) = &base.pattern {
            pattern.average(&mut derivatives.criterion)?;
        }
        let mut functionals: Vec<&[f64]> = vec![&derivatives.criterion];
        if let Some(constraint) = &mut derivatives.constraint {
            check_length("the constraint", constraint, unknowns)?;
            if let Some(pattern) = &base.pattern {
                pattern.average(constraint)?;
            }
            functionals.push(constraint);
        }
        let mut nodes_held = vec![];
        loop {
            let direction = self.direction_held(&held, &functionals, values.constraint, penalty, base)?;
            let Some(wall) = &self.wall else { return Ok(direction) };
            // Nodes that the descent takes into the wall slide along it; then others may be pushed.
            let along = direction.movement(1.0);
            if wall.hold(&mut held, &mut nodes_held, &along, self.options.longest_move)? == 0 {
                return Ok(direction);
            }
        }
    }

    /// The direction of what these constraints let move, by the derivatives of the criterion and, perhaps, the constraint.
    fn direction_held(
        &self,
        held: &Constraints<D>,
        functionals: &[&[f64]],
        value: Option<f64>,
        penalty: f64,
        base: &Base<D>,
    ) -> Result<Direction, ShapeOptimisationError> {
        let (product, movements) = (&self.options.inner_product, held.space());
        let mut found = product.represent(held, functionals)?;
        for movement in &mut found {
            *movement = product.extend(movements, movement)?;
        }
        if let Some(pattern) = &base.pattern {
            // The inner product keeps the pattern, except for rounding, which would add up.
            found.iter_mut().try_for_each(|movement| pattern.average(movement))?;
        }
        let mut found = found.into_iter();
        let movement = found.next().unwrap_or_default();
        let gradient = found.next().unwrap_or_default();
        let constraint = value.zip(functionals.get(1)).map(|(value, derivative)| Constrained {
            value,
            derivative,
            movement: &gradient,
        });
        let longest_move = self.options.longest_move;
        let criterion = functionals.first().copied().unwrap_or_default();
        Ok(Direction::new(criterion, movement, constraint, penalty, longest_move, D))
    }

    /// A movement that is shortened at the wall; inner nodes follow.
    pub(super) fn clear(
        &self,
        movements: &Arc<Space<D>>,
        mut movement: Vec<f64>,
    ) -> Result<Vec<f64>, ShapeOptimisationError> {
        match &self.wall {
            Some(wall) if wall.shorten(movements, &mut movement)? => {
                self.options.inner_product.extend(movements, &movement)
            }
            _ => Ok(movement),
        }
    }
}

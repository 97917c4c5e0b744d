//! Descent with Armijo's step control, on the nodal values of φ.

use std::sync::Arc;

use super::history::{LevelSetRow, LevelSetState};
use super::holes::{HolePlaces, NewHoles};
use super::inner_product::ChangeProduct;
use super::options::LevelSetOptions;
use super::problem::LevelSetProblem;
use crate::constraints::Constraints;
use crate::cut::{Cut, CutBand, CutError};
use crate::dimension::{Dim, Dimension};
use crate::field::Field;
use crate::linear_algebra::vector::add_scaled;
use crate::shape_optimisation::descent::MOST_TRIALS;
use crate::shape_optimisation::direction::{Constrained, Direction, check_length, longest};
use crate::shape_optimisation::{Derivatives, Failure, ShapeOptimisationError, Step, StopReason, Values};

/// The least promised decrease of a step, relative to the augmented Lagrangian.
const LEAST_DECREASE: f64 = 1e-12;

/// Callback at the start and after each step; an error ends the run.
pub type LevelSetListener<'a, S, const D: usize> =
    dyn FnMut(&LevelSetReport<S, D>) -> Result<(), Failure> + 'a;

/// A descent on φ: dJ by the nodal values becomes a change w by an inner product, and φ + τ w takes the place of φ where J falls by
/// Armijo's rule.
///
/// - Within a step active cells and ghost facets of a band are fixed ([`Cut::band`]), so that the values are of one discrete problem.
/// - A constraint, such as [`LevelSetVolume`](super::LevelSetVolume), enters by an augmented Lagrangian.
/// - Where options ask for it, new holes come as steps of their own ([`HoleOptions`](super::HoleOptions)).
/// - Where |∇φ| on cut cells leaves a range φ becomes a distance ([`Cut::distance`]): a step of its own, with J before in the history.
pub struct LevelSetDescent<'a, P, const D: usize> {
    /// The problem to optimise.
    pub problem: &'a P,
    /// φ at the start.
    pub initial: Field<D>,
    /// The options.
    pub options: LevelSetOptions,
}

/// A report at the start, after each step and at the end: the moment to write a
/// [`Checkpoint`](crate::shape_optimisation::Checkpoint).
pub struct LevelSetReport<'a, S, const D: usize> {
    /// All that it needs to go on.
    pub state: &'a LevelSetState,
    /// φ.
    pub phi: &'a Field<D>,
    /// The body.
    pub body: &'a Arc<Cut<D>>,
    /// The state on it.
    pub solved: &'a S,
}

/// Result of a descent.
pub struct LevelSetOptimised<S, const D: usize> {
    /// The history, and why it stopped.
    pub state: LevelSetState,
    /// φ.
    pub phi: Field<D>,
    /// The body.
    pub body: Arc<Cut<D>>,
    /// The values on it.
    pub values: Values<S>,
}

/// A body with its band and its values.
struct Shape<S, const D: usize> {
    phi: Field<D>,
    band: Arc<CutBand<D>>,
    body: Arc<Cut<D>>,
    values: Values<S>,
}

impl<P: LevelSetProblem<D>, const D: usize> LevelSetDescent<'_, P, D>
where
    Dim: Dimension<D>,
{
    /// The descent from the initial φ, or from a state of an earlier run with the same problem and options; then the result is that of
    /// a run without interruption, to the last bit. One that stopped for its number of iterations goes on if there are more now.
    ///
    /// # Errors
    /// [`ShapeOptimisationError`]: options without meaning, a state of another space, a problem without solution at the start. That a
    /// step fails is no error, but shortens it.
    pub fn run(
        &self,
        from: Option<LevelSetState>,
        hear: &mut LevelSetListener<P::State, D>,
    ) -> Result<LevelSetOptimised<P::State, D>, ShapeOptimisationError> {
        self.options.check()?;
        let space = self.initial.space();
        let mut held = Constraints::new(space);
        let failed = |source| ShapeOptimisationError::Problem { iteration: 0, source };
        self.problem.hold(&mut held).map_err(failed)?;
        let mut product = ChangeProduct::new(&self.options, &held)?;
        let holes = self.options.holes.as_ref().map(|options| HolePlaces::new(options, &held)).transpose()?;
        let goes_on = from.is_some();
        let mut state = from.unwrap_or_else(|| LevelSetState {
            values: self.initial.values().to_vec(),
            step: None,
            history: vec![],
            finish: None,
        });
        let (expected, found) = (space.unknowns(), state.values.len());
        if expected != found {
            return Err(ShapeOptimisationError::OtherMesh { expected, found });
        }
        let mut shape = self.shape(&state)?;
        let mut tell = |state: &LevelSetState, shape: &Shape<P::State, D>| {
            let Shape { phi, body, values, .. } = shape;
            let iteration = state.iterations();
            hear(&LevelSetReport { state, phi, body, solved: &values.state })
                .map_err(|source| ShapeOptimisationError::Problem { iteration, source })
        };
        if !goes_on || state.history.is_empty() {
            state.history = vec![row(&shape, None, None, None)];
            tell(&state, &shape)?;
        }
        if state.finish == Some(StopReason::Iterations) && state.iterations() < self.options.iterations {
            state.finish = None;
        }
        let mut is_new = false;
        while state.finish.is_none() {
            match self.step(&mut state, &mut shape, &mut product, holes.as_ref())? {
                Some(finish) => state.finish = Some(finish),
                None => tell(&state, &shape)?,
            }
            is_new = true;
        }
        if is_new {
            tell(&state, &shape)?;
        }
        let Shape { phi, body, values, .. } = shape;
        Ok(LevelSetOptimised { state, phi, body, values })
    }

    /// The largest change of φ in a step, with the way back to the constraint.
    fn width(&self) -> f64 {
        2.0 * self.options.largest_change
    }

    /// The body of a state with its own band.
    fn shape(&self, state: &LevelSetState) -> Result<Shape<P::State, D>, ShapeOptimisationError> {
        let iteration = state.iterations();
        let failed = |source| ShapeOptimisationError::Problem { iteration, source };
        let cut = |error: CutError| failed(Box::new(error));
        let phi = Field::from_values(self.initial.space(), state.values.clone())
            .map_err(|error| failed(Box::new(error)))?;
        let band = Cut::by(&phi).map_err(cut)?.band(self.width());
        let body = Cut::within(&phi, &band).map_err(cut)?;
        let values = self.problem.solve(&body).map_err(failed)?;
        for (what, value) in
            [("the criterion", values.criterion), ("the constraint", values.constraint.unwrap_or(0.0))]
        {
            if !value.is_finite() {
                return Err(ShapeOptimisationError::NotFinite { iteration, what, value });
            }
        }
        Ok(Shape { phi, band, body, values })
    }

    fn direction(
        &self,
        iteration: usize,
        shape: &mut Shape<P::State, D>,
        product: &mut ChangeProduct<D>,
        penalty: f64,
    ) -> Result<Direction, ShapeOptimisationError> {
        let failed = |source| ShapeOptimisationError::Problem { iteration, source };
        let Derivatives { criterion, constraint } =
            self.problem.derivatives(&shape.body, &mut shape.values.state).map_err(failed)?;
        let expected = shape.phi.values().len();
        check_length("the criterion", &criterion, expected)?;
        product.change_interface(&shape.body).map_err(failed)?;
        let movement = product.represent(&criterion)?;
        let by = match (&constraint, shape.values.constraint) {
            (Some(derivative), Some(value)) => {
                check_length("the constraint", derivative, expected)?;
                Some((value, derivative, product.represent(derivative)?))
            }
            _ => None,
        };
        let constrained = by.as_ref().map(|(value, derivative, movement)| Constrained {
            value: *value,
            derivative,
            movement,
        });
        Ok(Direction::new(&criterion, movement, constrained, penalty, self.options.largest_change, 1))
    }

    /// One step, or why there is none.
    fn step(
        &self,
        state: &mut LevelSetState,
        shape: &mut Shape<P::State, D>,
        product: &mut ChangeProduct<D>,
        holes: Option<&HolePlaces<D>>,
    ) -> Result<Option<StopReason>, ShapeOptimisationError> {
        let start = state.history[0].criterion.abs();
        let scale = if start > 0.0 { start } else { 1.0 };
        let direction = self.direction(state.iterations(), shape, product, self.options.penalty * scale)?;
        let holes = holes.filter(|_| state.iterations() < self.options.iterations);
        let is_due = |holes: &&HolePlaces<D>| state.iterations().is_multiple_of(holes.options.every);
        let due = holes.filter(is_due);
        if let Some(holes) = due
            && self.make_holes(state, shape, &direction, holes)?
        {
            return Ok(None);
        }
        let finish = self.move_interface(state, shape, &direction)?;
        // Where the interface has no way to go, a hole may be one.
        if let (Some(StopReason::Converged | StopReason::NoStep(_)), Some(holes), None) =
            (&finish, holes, due)
            && self.make_holes(state, shape, &direction, holes)?
        {
            return Ok(None);
        }
        Ok(finish)
    }

    /// New holes in the shape of a state, if the augmented Lagrangian falls by them.
    fn make_holes(
        &self,
        state: &mut LevelSetState,
        shape: &mut Shape<P::State, D>,
        direction: &Direction,
        holes: &HolePlaces<D>,
    ) -> Result<bool, ShapeOptimisationError> {
        let iteration = state.iterations();
        let failed = |source| ShapeOptimisationError::Problem { iteration, source };
        let Derivatives { criterion: mut by_holes, constraint } =
            self.problem.topological_derivatives(&shape.body, &mut shape.values.state).map_err(failed)?;
        let expected = shape.phi.values().len();
        check_length("the criterion by holes", &by_holes, expected)?;
        if let Some(value) = shape.values.constraint {
            let of_constraint = constraint.unwrap_or_default();
            check_length("the constraint by holes", &of_constraint, expected)?;
            add_scaled(&mut by_holes, direction.price(value), &of_constraint);
        }
        if let Some(value) = by_holes.iter().copied().find(|value| !value.is_finite()) {
            let what = "the topological derivative";
            return Err(ShapeOptimisationError::NotFinite { iteration, what, value });
        }
        let solved = |phi: &Field<D>| -> Result<(f64, f64), Failure> {
            let Values { criterion, constraint, .. } = self.problem.solve(&Cut::by(phi)?)?;
            Ok((criterion, direction.lagrangian(criterion, constraint)))
        };
        let mut centres = holes.centres(&shape.body, &shape.phi, &by_holes).map_err(failed)?;
        if centres.is_empty() {
            return Ok(false);
        }
        // A band's ghost penalty stiffens the body: before and after are compared without one.
        let (before, merit) = solved(&shape.phi).map_err(failed)?;
        while !centres.is_empty() {
            let values = holes.raised(&shape.phi, &centres);
            let phi = Field::from_values(shape.phi.space(), values.clone())
                .map_err(|error| failed(Box::new(error)))?;
            // Without a solution, or with a merit that is not a number, fewer holes are tried.
            if let Ok((after, reached)) = solved(&phi)
                && reached < merit
            {
                let slopes: f64 = centres.iter().map(|node| by_holes[*node]).sum();
                let promised = holes.options.radius.powi(D as i32) * slopes;
                state.values = values;
                *shape = self.shape(state)?;
                let made = NewHoles { count: centres.len(), before, after, promised };
                state.history.push(row(shape, None, None, Some(made)));
                return Ok(true);
            }
            centres.truncate(centres.len() / 2);
        }
        Ok(false)
    }

    /// One step of the interface, or why there is none.
    fn move_interface(
        &self,
        state: &mut LevelSetState,
        shape: &mut Shape<P::State, D>,
        direction: &Direction,
    ) -> Result<Option<StopReason>, ShapeOptimisationError> {
        let options = &self.options;
        let first = state.history.iter().find_map(|row| row.step.as_ref());
        let first_norm = first.map_or(direction.norm, |step| step.gradient_norm);
        let most = direction.factor_for(options.largest_change, 1);
        if shape.values.constraint.unwrap_or(0.0).abs() <= options.constraint_tolerance {
            let converged = first.is_some() && direction.norm <= options.gradient_tolerance * first_norm;
            if converged || direction.norm == 0.0 || most.is_none() {
                return Ok(Some(StopReason::Converged));
            }
        }
        if state.iterations() >= options.iterations {
            return Ok(Some(StopReason::Iterations));
        }
        let most = most.unwrap_or(0.0);
        let mut factor = state.step.unwrap_or(most).min(most);
        let before = direction.lagrangian(shape.values.criterion, shape.values.constraint);
        let mut why = "steps have become too short".to_owned();
        for trials in 1..=MOST_TRIALS {
            // A decrease below rounding is none: steps would become shorter for ever in front of a jump of J.
            if -direction.slope(factor) <= LEAST_DECREASE * before.abs() {
                break;
            }
            let movement = direction.movement(factor);
            match self.attempt(shape, &movement) {
                Ok((phi, values)) => {
                    let after = direction.lagrangian(values.criterion, values.constraint);
                    if after <= before + options.sufficient_decrease * direction.slope(factor) {
                        let step = Step {
                            factor,
                            trials,
                            longest_move: longest(&movement, 1),
                            multiplier: direction.multiplier,
                            gradient_norm: direction.norm,
                        };
                        self.accept(state, shape, (phi, values), step)?;
                        return Ok(None);
                    }
                    why = format!("the augmented Lagrangian went from {before} to {after}");
                }
                Err(reason) => why = reason.to_string(),
            }
            factor *= 0.5;
        }
        Ok(Some(StopReason::NoStep(why)))
    }

    /// The values after a change of φ, in the band of the start, or why there are none.
    fn attempt(
        &self,
        shape: &Shape<P::State, D>,
        change: &[f64],
    ) -> Result<(Field<D>, Values<P::State>), Failure> {
        let values = shape.phi.values().iter().zip(change).map(|(phi, change)| phi + change).collect();
        let phi = Field::from_values(shape.phi.space(), values)?;
        let body = Cut::within(&phi, &shape.band)?;
        let values = self.problem.solve(&body)?;
        Ok((phi, values))
    }

    /// Takes a step, makes φ a distance where its slopes ask for it, and solves in the next band.
    fn accept(
        &self,
        state: &mut LevelSetState,
        shape: &mut Shape<P::State, D>,
        (phi, values): (Field<D>, Values<P::State>),
        step: Step,
    ) -> Result<(), ShapeOptimisationError> {
        let iteration = state.iterations() + 1;
        let cut = |error: CutError| ShapeOptimisationError::Problem { iteration, source: Box::new(error) };
        let grows = if step.trials == 1 { 2.0 } else { 1.0 };
        state.step = Some(grows * step.factor);
        let body = Cut::by(&phi).map_err(cut)?;
        let [least, most] = body.slopes();
        let mut before_distance = None;
        let distance = least < self.options.slopes[0] || most > self.options.slopes[1];
        state.values = match distance && !body.cut_cells().is_empty() {
            true => {
                before_distance = Some(values.criterion);
                body.distance(&phi).map_err(cut)?.values().to_vec()
            }
            false => phi.values().to_vec(),
        };
        *shape = self.shape(state)?;
        state.history.push(row(shape, before_distance, Some(step), None));
        Ok(())
    }
}

fn row<S, const D: usize>(
    shape: &Shape<S, D>,
    before_distance: Option<f64>,
    step: Option<Step>,
    holes: Option<NewHoles>,
) -> LevelSetRow {
    let Values { criterion, constraint, .. } = shape.values;
    LevelSetRow { criterion, constraint, parts: shape.body.parts().len(), before_distance, step, holes }
}

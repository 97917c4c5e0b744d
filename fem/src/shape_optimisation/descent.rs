//! Descent with Armijo's step control, on shapes.

pub(super) mod remeshed;

use std::sync::Arc;

use self::remeshed::Base;
pub use self::remeshed::{Remesh, Remesher};
use super::descent_options::DescentOptions;
use super::direction::longest;
use super::error::{Failure, ShapeOptimisationError};
use super::history::{DescentState, Row, Step, StopReason};
use super::problem::{ShapeProblem, Values};
use super::rotations::Rotations;
use super::smoothing::smoothed;
use super::wall::Wall;
use crate::dimension::{Dim, Dimension};
use crate::field::Field;
use crate::mesh::Mesh;
use crate::space::Space;

/// Steps over which a stalled descent is judged.
const STALLED_STEPS: usize = 5;
/// Halvings of a step before it is given up.
pub(super) const MOST_TRIALS: usize = 25;
/// The factor of a step, relative to the largest so far, below which it is given up: what ends there does not go on.
const SMALLEST_FACTOR: f64 = 1e-4;

/// Callback at the start and after each step; an error ends the run.
pub type Listener<'a, S, const D: usize> = dyn FnMut(&Report<S, D>) -> Result<(), Failure> + 'a;

/// A descent.
pub struct Descent<'a, P, const D: usize> {
    /// The problem to optimise.
    pub problem: &'a P,
    /// The shape at the start; its cells, numbers and regions are those of all shapes until the mesh is made again.
    pub initial: Mesh<D>,
    /// The options.
    pub options: DescentOptions,
    /// The pattern that is kept, if any.
    pub pattern: Option<Rotations<D>>,
    /// A boundary that must not go everywhere, if there is one.
    pub wall: Option<Wall<'a, D>>,
    /// New meshes where cells have suffered; without this the descent ends there.
    pub remesh: Option<Remesh<'a, D>>,
}

/// A report after each step and at the end: the moment to write a [`super::Checkpoint`].
pub struct Report<'a, S, const D: usize> {
    /// All that it needs to go on.
    pub state: &'a DescentState,
    /// The shape.
    pub mesh: &'a Mesh<D>,
    /// The state on it.
    pub solved: &'a S,
}

/// A descent's progress.
pub struct Optimised<S, const D: usize> {
    /// The history, and why it stopped.
    pub state: DescentState,
    /// The shape.
    pub mesh: Mesh<D>,
    /// The values on it.
    pub values: Values<S>,
}

/// A shape with its values.
pub(super) struct Shape<S, const D: usize> {
    pub mesh: Mesh<D>,
    pub values: Values<S>,
    pub quality: f64,
}

impl<P: ShapeProblem<D>, const D: usize> Descent<'_, P, D>
where
    Dim: Dimension<D>,
{
    /// The descent from the initial mesh, or from a state of an earlier run with the same problem and options; then
    /// the result is that of a run without interruption, to the last bit. One that stopped for its number of iterations
    /// goes on if there are more now. `hear` is called at the start and after each step; its error ends the run.
    ///
    /// # Errors
    /// [`ShapeOptimisationError`]: options without meaning, a state of another mesh, a problem without solution at the
    /// start. That a step fails is no error, but shortens it.
    pub fn run(
        &self,
        from: Option<DescentState>,
        hear: &mut Listener<P::State, D>,
    ) -> Result<Optimised<P::State, D>, ShapeOptimisationError> {
        self.options.check()?;
        let goes_on = from.is_some();
        let mut state = match from {
            Some(state) => state,
            None => {
                let nodes = coordinates(&self.initial);
                DescentState { nodes, mesh: None, step: None, history: vec![], finish: None }
            }
        };
        let mut base = Base::of(&state, &self.initial, self.pattern.as_ref())?;
        let mut shape = self.first(&state, &base)?;
        let mut tell = |state: &DescentState, shape: &Shape<P::State, D>| {
            let report = Report { state, mesh: &shape.mesh, solved: &shape.values.state };
            let iteration = state.iterations();
            hear(&report).map_err(|source| ShapeOptimisationError::Problem { iteration, source })
        };
        if !goes_on || state.history.is_empty() {
            state.history = vec![row(&shape, false, None)];
            tell(&state, &shape)?;
        }
        if state.finish == Some(StopReason::Iterations) && state.iterations() < self.options.iterations {
            state.finish = None;
        }
        let mut is_new = false;
        while state.finish.is_none() {
            match self.step(&mut state, &mut shape, &mut base)? {
                Some(finish) => state.finish = Some(finish),
                None => tell(&state, &shape)?,
            }
            is_new = true;
        }
        if is_new {
            tell(&state, &shape)?;
        }
        Ok(Optimised { state, mesh: shape.mesh, values: shape.values })
    }

    /// The shape of a state.
    fn first(
        &self,
        state: &DescentState,
        base: &Base<D>,
    ) -> Result<Shape<P::State, D>, ShapeOptimisationError> {
        let (expected, found) = (base.mesh.node_count() * D, state.nodes.len());
        if expected != found {
            return Err(ShapeOptimisationError::OtherMesh { expected, found });
        }
        let nodes = state.nodes.chunks(D).map(|node| std::array::from_fn(|k| node[k])).collect();
        let mesh = base.mesh.with_nodes(nodes)?;
        let iteration = state.iterations();
        let values = self
            .problem
            .solve(&mesh)
            .map_err(|source| ShapeOptimisationError::Problem { iteration, source })?;
        for (what, value) in
            [("the criterion", values.criterion), ("the constraint", values.constraint.unwrap_or(0.0))]
        {
            if !value.is_finite() {
                return Err(ShapeOptimisationError::NotFinite { iteration, what, value });
            }
        }
        let quality = mesh.quality().scaled_jacobian()[0];
        Ok(Shape { mesh, values, quality })
    }

    /// One step, or why there is none.
    fn step(
        &self,
        state: &mut DescentState,
        shape: &mut Shape<P::State, D>,
        base: &mut Base<D>,
    ) -> Result<Option<StopReason>, ShapeOptimisationError> {
        let options = &self.options;
        let movements = Space::of_geometry(&shape.mesh)?;
        let start = state.history[0].criterion.abs();
        let scale = if start > 0.0 { start } else { 1.0 };
        let direction =
            self.direction(state, &movements, &mut shape.values, options.penalty * scale, base)?;
        let first = state.history.get(1).and_then(|row| row.step.as_ref());
        let first_norm = first.map_or(direction.norm, |step| step.gradient_norm);
        let constraint = shape.values.constraint.unwrap_or(0.0).abs();
        let on_constraint = constraint <= options.constraint_tolerance;
        let factor_for = |length| direction.factor_for(length, D);
        let most = factor_for(options.longest_move);
        let converged = first.is_some() && direction.norm <= options.gradient_tolerance * first_norm;
        if on_constraint && (converged || direction.norm == 0.0 || most.is_none()) {
            return Ok(Some(StopReason::Converged));
        }
        if on_constraint && stalled(&state.history, options.decrease_tolerance * scale) {
            return Ok(Some(StopReason::Stalled));
        }
        if state.iterations() >= options.iterations {
            return Ok(Some(StopReason::Iterations));
        }
        let wanted = state.step.or_else(|| factor_for(options.first_move)).unwrap_or(0.0);
        let mut factor = wanted.min(most.unwrap_or(wanted));
        let before = direction.lagrangian(shape.values.criterion, shape.values.constraint);
        // Ever shorter steps end before any is tried: where cells have come to their limit, it is they.
        let mut why = "steps have become too short".to_owned();
        let mut is_quality = shape.quality < 1.05 * options.least_quality;
        let taken = state.history.iter().filter_map(|row| row.step.as_ref()).map(|step| step.factor);
        let smallest = SMALLEST_FACTOR * taken.fold(0.0, f64::max);
        for trials in 1..=MOST_TRIALS {
            if factor < smallest {
                break;
            }
            let movement = self.clear(&movements, direction.movement(factor))?;
            let allowed = before + options.sufficient_decrease * direction.slope(factor);
            is_quality = false;
            match self.attempt(&movements, &movement) {
                Ok(next) if next.quality < options.least_quality => is_quality = true,
                Ok(next) => {
                    let after = direction.lagrangian(next.values.criterion, next.values.constraint);
                    if after <= allowed {
                        let step = Step {
                            factor,
                            trials,
                            longest_move: longest(&movement, D),
                            multiplier: direction.multiplier,
                            gradient_norm: direction.norm,
                        };
                        self.accept(state, shape, base, next, step)?;
                        return Ok(None);
                    }
                    why = format!("the augmented Lagrangian went from {before} to {after}");
                }
                Err(reason) => why = reason.to_string(),
            }
            factor *= 0.5;
        }
        if !is_quality {
            return Ok(Some(StopReason::NoStep(why)));
        }
        let Some(remesh) = &self.remesh else { return Ok(Some(StopReason::MeshQuality)) };
        let is_new = state.history.last().is_some_and(|row| row.remeshed.is_some());
        match self.remeshed(remesh, state, shape, base)? {
            // A new mesh that helps no further would be made again and again.
            Ok(remeshed) if !is_new => {
                if let Some(last) = state.history.last_mut() {
                    *last = Row { remeshed: Some(remeshed), ..row(shape, last.smoothed, last.step.clone()) };
                }
                Ok(None)
            }
            Ok(_) => Ok(Some(StopReason::MeshQuality)),
            Err(why) => Ok(Some(StopReason::NoNewMesh(why))),
        }
    }

    /// The shape after a movement, or why it is none.
    fn attempt(&self, movements: &Arc<Space<D>>, movement: &[f64]) -> Result<Shape<P::State, D>, Failure> {
        let mesh = Field::from_values(movements, movement.to_vec())?.move_mesh(1.0)?;
        let quality = mesh.quality().scaled_jacobian()[0];
        let values = self.problem.solve(&mesh)?;
        Ok(Shape { mesh, values, quality })
    }

    /// Takes a step, and smooths the mesh where its quality asks for it.
    fn accept(
        &self,
        state: &mut DescentState,
        shape: &mut Shape<P::State, D>,
        base: &mut Base<D>,
        next: Shape<P::State, D>,
        step: Step,
    ) -> Result<(), ShapeOptimisationError> {
        *shape = next;
        let mut is_smoothed = false;
        if shape.quality < self.options.smooth_below
            && let Ok(mesh) = smoothed(&base.mesh, &shape.mesh, &self.options.inner_product)
        {
            let quality = mesh.quality().scaled_jacobian()[0];
            // On cells that are hardly better nothing is gained, and on better ones the problem may still fail.
            if quality > 1.05 * shape.quality
                && let Ok(values) = self.problem.solve(&mesh)
            {
                *shape = Shape { mesh, values, quality };
                is_smoothed = true;
            }
        }
        let grows = if step.trials == 1 { 2.0 } else { 1.0 };
        state.step = Some(grows * step.factor);
        state.nodes = coordinates(&shape.mesh);
        let mut remeshed = None;
        if let Some(remesh) = &self.remesh
            && shape.quality < remesh.below
        {
            // Where there is no new mesh yet the descent goes on with this one as far as it will go.
            remeshed = self.remeshed(remesh, state, shape, base)?.ok();
        }
        state.history.push(Row { remeshed, ..row(shape, is_smoothed, Some(step)) });
        Ok(())
    }
}

fn row<S, const D: usize>(shape: &Shape<S, D>, smoothed: bool, step: Option<Step>) -> Row {
    let Values { criterion, constraint, .. } = shape.values;
    Row { criterion, constraint, quality: shape.quality, smoothed, remeshed: None, step }
}

pub(super) fn coordinates<const D: usize>(mesh: &Mesh<D>) -> Vec<f64> {
    mesh.nodes().iter().flatten().copied().collect()
}

/// Whether the last steps together brought less than a decrease: of J + λ c, λ that of the last step, since what the way back to the
/// constraint costs J is no sign of an end. What a new mesh changes is no step's.
fn stalled(history: &[Row], decrease: f64) -> bool {
    if history.len() <= STALLED_STEPS {
        return false;
    }
    let last = &history[history.len() - STALLED_STEPS - 1..];
    let multiplier = last.last().and_then(|row| row.step.as_ref()).map_or(0.0, |step| step.multiplier);
    let lagrangian =
        |criterion: f64, constraint: Option<f64>| criterion + multiplier * constraint.unwrap_or(0.0);
    let before = |row: &Row| lagrangian(row.criterion, row.constraint);
    let after = |row: &Row| match &row.remeshed {
        Some(old) => lagrangian(old.criterion, old.constraint),
        None => before(row),
    };
    let sum: f64 = last.windows(2).map(|pair| before(&pair[0]) - after(&pair[1])).sum();
    sum.abs() < decrease
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(values: impl Iterator<Item = (f64, f64)>) -> Vec<Row> {
        let step = Step { factor: 1.0, trials: 1, longest_move: 0.1, multiplier: 50.0, gradient_norm: 1.0 };
        let row = |(criterion, constraint)| Row {
            criterion,
            constraint: Some(constraint),
            quality: 1.0,
            smoothed: false,
            remeshed: None,
            step: Some(step.clone()),
        };
        values.map(row).collect()
    }

    /// While the constraint is restored, J may not change: with λ = 50 five steps that take c by 0.05 down win 2.5.
    #[test]
    fn the_way_back_to_the_constraint_is_no_end() {
        let restored = rows((0..6).map(|k| (7.0, 0.01 * f64::from(5 - k))));
        assert!(!stalled(&restored, 2.4) && stalled(&restored, 2.6));
        let still = rows((0..6).map(|_| (7.0, 0.01)));
        assert!(stalled(&still, 1e-9) && !stalled(&still[1..], 1e-9));
        // A fall of J that the constraint pays for brings nothing.
        let exchanged = rows((0..6).map(|k| (7.0 - 0.5 * f64::from(k), 0.01 * f64::from(k))));
        assert!(stalled(&exchanged, 1e-9));
    }
}

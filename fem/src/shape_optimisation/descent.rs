//! Descent with Armijo's step control, on shapes.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::direction::{Constrained, Direction, check_length, longest};
use super::error::{Failure, ShapeOptimisationError};
use super::history::{DescentState, Finish, Row, Step};
use super::inner_product::InnerProduct;
use super::problem::{ShapeProblem, Values};
use super::rotations::Rotations;
use super::smoothing::smoothed;
use crate::constraints::Constraints;
use crate::dimension::{Dim, Dimension};
use crate::field::Field;
use crate::mesh::Mesh;
use crate::space::Space;

/// Steps over which a stalled descent is judged.
const STALLED_STEPS: usize = 5;
/// Halvings of a step before it is given up.
const MOST_TRIALS: usize = 25;
/// The factor of a step, relative to the largest so far, below which it is given up: what ends there does not go on.
const SMALLEST_FACTOR: f64 = 1e-4;

/// Callback at the start and after each step; an error ends the run.
pub type Listener<'a, S, const D: usize> = dyn FnMut(&Report<S, D>) -> Result<(), Failure> + 'a;

/// Options of a descent. Lengths are in the mesh's unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DescentOptions {
    /// Steps, at most.
    pub iterations: usize,
    /// The inner product that turns derivatives into movements.
    pub inner_product: InnerProduct,
    /// The longest way of a node in the first step that is tried \[length\].
    pub first_move: f64,
    /// The longest way of a node in any step, and on the way back to the constraint \[length\].
    pub longest_move: f64,
    /// The part of the decrease that the derivative promises which a step must bring, in (0, 1/2).
    pub sufficient_decrease: f64,
    /// r of the augmented Lagrangian, in units of the criterion at the start.
    pub penalty: f64,
    /// |constraint| up to which a shape may be called optimal.
    pub constraint_tolerance: f64,
    /// The norm of the derivative along the constraint, relative to the first, at which the descent has converged.
    pub gradient_tolerance: f64,
    /// The decrease of the criterion over five steps, relative to its value at the start, below which it has stalled.
    pub decrease_tolerance: f64,
    /// The mesh is smoothed when the least scaled Jacobian falls below this.
    pub smooth_below: f64,
    /// No step may let the least scaled Jacobian fall below this.
    pub least_quality: f64,
}

impl DescentOptions {
    /// For a mesh whose cells may move by so much in a step \[length\]; the elastic inner product.
    pub fn new(longest_move: f64) -> Self {
        DescentOptions {
            iterations: 100,
            inner_product: InnerProduct::elasticity(0.0),
            first_move: longest_move,
            longest_move,
            sufficient_decrease: 1e-4,
            penalty: 10.0,
            constraint_tolerance: 5e-4,
            gradient_tolerance: 1e-3,
            decrease_tolerance: 1e-6,
            smooth_below: 0.3,
            least_quality: 0.1,
        }
    }

    fn check(&self) -> Result<(), ShapeOptimisationError> {
        let fail = |name, value, why| Err(ShapeOptimisationError::Option { name, value, why });
        let positive =
            [("first_move", self.first_move), ("longest_move", self.longest_move), ("penalty", self.penalty)];
        for (name, value) in positive {
            if !(value > 0.0 && value.is_finite()) {
                return fail(name, value, "it must be positive");
            }
        }
        if !(self.sufficient_decrease > 0.0 && self.sufficient_decrease < 0.5) {
            return fail("sufficient_decrease", self.sufficient_decrease, "it lies between 0 and 1/2");
        }
        for (name, value) in [
            ("constraint_tolerance", self.constraint_tolerance),
            ("gradient_tolerance", self.gradient_tolerance),
            ("decrease_tolerance", self.decrease_tolerance),
            ("smooth_below", self.smooth_below),
            ("least_quality", self.least_quality),
        ] {
            if !(value >= 0.0 && value.is_finite()) {
                return fail(name, value, "it must not be negative");
            }
        }
        Ok(())
    }
}

/// A descent.
pub struct Descent<'a, P, const D: usize> {
    /// The problem to optimise.
    pub problem: &'a P,
    /// The shape at the start; its cells, numbers and regions are those of all shapes.
    pub initial: Arc<Mesh<D>>,
    /// The options.
    pub options: DescentOptions,
    /// The pattern that is kept, if any.
    pub pattern: Option<Rotations<D>>,
}

/// A report after each step and at the end: the moment to write a [`super::Checkpoint`].
pub struct Report<'a, S, const D: usize> {
    /// All that it needs to go on.
    pub state: &'a DescentState,
    /// The shape.
    pub mesh: &'a Arc<Mesh<D>>,
    /// The state on it.
    pub solved: &'a S,
}

/// A descent's progress.
pub struct Optimised<S, const D: usize> {
    /// The history, and why it stopped.
    pub state: DescentState,
    /// The shape.
    pub mesh: Arc<Mesh<D>>,
    /// The values on it.
    pub values: Values<S>,
}

/// A shape with its values.
struct Shape<S, const D: usize> {
    mesh: Arc<Mesh<D>>,
    values: Values<S>,
    quality: f64,
}

impl<P: ShapeProblem<D>, const D: usize> Descent<'_, P, D>
where
    Dim: Dimension<D>,
{
    /// Descends from the initial mesh, or goes on from a state of an earlier run with the same problem and options; then
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
                DescentState { nodes, step: None, history: vec![], finish: None }
            }
        };
        let mut shape = self.first(&state)?;
        let mut tell = |state: &DescentState, shape: &Shape<P::State, D>| {
            let report = Report { state, mesh: &shape.mesh, solved: &shape.values.state };
            let iteration = state.iterations();
            hear(&report).map_err(|source| ShapeOptimisationError::Problem { iteration, source })
        };
        if !goes_on || state.history.is_empty() {
            state.history = vec![row(&shape, false, None)];
            tell(&state, &shape)?;
        }
        if state.finish == Some(Finish::Iterations) && state.iterations() < self.options.iterations {
            state.finish = None;
        }
        let mut is_new = false;
        while state.finish.is_none() {
            match self.step(&mut state, &mut shape)? {
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
    fn first(&self, state: &DescentState) -> Result<Shape<P::State, D>, ShapeOptimisationError> {
        let (expected, found) = (self.initial.node_count() * D, state.nodes.len());
        if expected != found {
            return Err(ShapeOptimisationError::OtherMesh { expected, found });
        }
        let nodes = state.nodes.chunks(D).map(|node| std::array::from_fn(|k| node[k])).collect();
        let mesh = Arc::new(self.initial.with_nodes(nodes)?);
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
    ) -> Result<Option<Finish>, ShapeOptimisationError> {
        let options = &self.options;
        let movements = Space::of_geometry(&shape.mesh)?;
        let start = state.history[0].criterion.abs();
        let scale = if start > 0.0 { start } else { 1.0 };
        let direction = self.direction(state, &movements, &mut shape.values, options.penalty * scale)?;
        let first = state.history.get(1).and_then(|row| row.step.as_ref());
        let first_norm = first.map_or(direction.norm, |step| step.gradient_norm);
        let constraint = shape.values.constraint.unwrap_or(0.0).abs();
        let on_constraint = constraint <= options.constraint_tolerance;
        let factor_for = |length| direction.factor_for(length, D);
        let most = factor_for(options.longest_move);
        let converged = first.is_some() && direction.norm <= options.gradient_tolerance * first_norm;
        if on_constraint && (converged || direction.norm == 0.0 || most.is_none()) {
            return Ok(Some(Finish::Converged));
        }
        if on_constraint && stalled(&state.history, options.decrease_tolerance * scale) {
            return Ok(Some(Finish::Stalled));
        }
        if state.iterations() >= options.iterations {
            return Ok(Some(Finish::Iterations));
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
            let movement = direction.movement(factor);
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
                        self.accept(state, shape, next, step)?;
                        return Ok(None);
                    }
                    why = format!("the augmented Lagrangian went from {before} to {after}");
                }
                Err(reason) => why = reason.to_string(),
            }
            factor *= 0.5;
        }
        Ok(Some(if is_quality { Finish::MeshQuality } else { Finish::NoStep(why) }))
    }

    fn direction(
        &self,
        state: &DescentState,
        movements: &Arc<Space<D>>,
        values: &mut Values<P::State>,
        penalty: f64,
    ) -> Result<Direction, ShapeOptimisationError> {
        let iteration = state.iterations();
        let of_problem = |source| ShapeOptimisationError::Problem { iteration, source };
        let mut derivatives = self.problem.derivatives(movements, &mut values.state).map_err(of_problem)?;
        let unknowns = movements.unknowns();
        check_length("the criterion", &derivatives.criterion, unknowns)?;
        let mut held = Constraints::new(movements);
        self.problem.fix(&mut held).map_err(of_problem)?;
        if let Some(pattern) = &self.pattern {
            pattern.average(&mut derivatives.criterion)?;
        }
        let mut functionals: Vec<&[f64]> = vec![&derivatives.criterion];
        if let Some(constraint) = &mut derivatives.constraint {
            check_length("the constraint", constraint, unknowns)?;
            if let Some(pattern) = &self.pattern {
                pattern.average(constraint)?;
            }
            functionals.push(constraint);
        }
        let product = &self.options.inner_product;
        let mut found = product.represent(&held, &functionals)?;
        for movement in &mut found {
            *movement = product.extend(movements, movement)?;
        }
        if let Some(pattern) = &self.pattern {
            // The inner product keeps the pattern, but for rounding, which would add up.
            found.iter_mut().try_for_each(|movement| pattern.average(movement))?;
        }
        let mut found = found.into_iter();
        let movement = found.next().unwrap_or_default();
        let gradient = found.next().unwrap_or_default();
        let constraint = values
            .constraint
            .zip(derivatives.constraint.as_ref())
            .map(|(value, derivative)| Constrained { value, derivative, movement: &gradient });
        let longest_move = self.options.longest_move;
        Ok(Direction::new(&derivatives.criterion, movement, constraint, penalty, longest_move, D))
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
        next: Shape<P::State, D>,
        step: Step,
    ) -> Result<(), ShapeOptimisationError> {
        *shape = next;
        let mut is_smoothed = false;
        if shape.quality < self.options.smooth_below
            && let Ok(mesh) = smoothed(&self.initial, &shape.mesh, &self.options.inner_product)
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
        state.history.push(row(shape, is_smoothed, Some(step)));
        Ok(())
    }
}

fn row<S, const D: usize>(shape: &Shape<S, D>, smoothed: bool, step: Option<Step>) -> Row {
    let Values { criterion, constraint, .. } = shape.values;
    Row { criterion, constraint, quality: shape.quality, smoothed, step }
}

fn coordinates<const D: usize>(mesh: &Mesh<D>) -> Vec<f64> {
    mesh.nodes().iter().flatten().copied().collect()
}

/// Whether the last steps together brought less than a decrease.
fn stalled(history: &[Row], decrease: f64) -> bool {
    match history {
        [.., earlier, _, _, _, _, last] if history.len() > STALLED_STEPS => {
            (earlier.criterion - last.criterion).abs() < decrease
        }
        _ => false,
    }
}

//! Points of a branch: solutions at a parameter and on a plane, the branch's direction there, null vectors of the tangent.

use super::arc::{ArcEquations, ArrowPattern, Plane};
use super::bordered_solver::BorderedSolver;
use super::family::{Direction, Family, Place, Reached};
use super::inertia::Inertia;
use super::metric::Metric;
use super::turns::orient;
use crate::linear_algebra::spectrum::irregular;
use crate::linear_algebra::vector::{dot, norm};
use crate::solve::{
    Elimination, FieldUnknowns, LineSearch, LinearSolver, NewtonError, NewtonFailure, NewtonOptions,
    NewtonStep, NonlinearProblem, SolverError, Start, newton_eliminating,
};

/// Directions with a smaller cosine between them are those of a kink, or of a step that is too long.
pub(super) const TURN: f64 = 0.5;

/// Steps with a smaller cosine, or a point that is farther off by this part of the step, are too long: they may lead to another branch.
pub(super) const BEND: f64 = 0.8;
pub(super) const OFF: f64 = 0.5;

/// Corrections of this multiple of the tolerance are left by Newton's method.
const CORRECTION: f64 = 100.0;

/// Steps of inverse iteration.
const INVERSE_ITERATIONS: usize = 5;

/// A solution, before its tangent was looked at.
pub(super) struct Solution {
    pub at: Place,
    /// R on all unknowns of the family.
    pub residual: Vec<f64>,
    /// Newton steps.
    pub iterations: usize,
}

/// A point beyond another.
pub(super) struct Beyond {
    pub reached: Reached,
    /// The cosine between the directions of both.
    pub cosine: f64,
    /// The distance of the point from the tangent of the other, relative to the step.
    pub off: f64,
}

/// The search for points.
pub(super) struct Points<'f> {
    pub family: &'f mut dyn Family,
    elimination: Elimination,
    extended: Elimination,
    pub fields: Vec<FieldUnknowns>,
    pub metric: Metric,
    pattern: ArrowPattern,
    pub solver: BorderedSolver,
    options: NewtonOptions,
}

impl<'f> Points<'f> {
    /// Points of a family under constraints, where the parameter changes by about `scale`.
    pub fn new(
        family: &'f mut dyn Family,
        elimination: Elimination,
        scale: f64,
        options: NewtonOptions,
        solver: BorderedSolver,
    ) -> Self {
        let fields = family.equations().fields();
        let metric = Metric::of_parameter(elimination.size(), scale);
        let extended = elimination.with_one_more();
        let pattern = ArrowPattern::default();
        Points { family, elimination, extended, fields, metric, pattern, solver, options }
    }

    /// A search with steps of Newton's method that a line search shortens.
    pub fn with_line_search<T>(&mut self, find: impl FnOnce(&mut Self) -> T) -> T {
        let usual = std::mem::replace(&mut self.options.line_search, LineSearch::OnResidual);
        let found = find(self);
        self.options.line_search = usual;
        found
    }

    /// The accuracy of parameters, by Newton's criterion.
    pub fn accuracy(&self) -> f64 {
        CORRECTION * self.options.relative_tolerance * self.metric.parameter
    }

    /// The solution at a parameter, by Newton's method.
    ///
    /// # Errors
    /// [`NewtonError`].
    pub fn at_parameter(&mut self, start: Vec<f64>, parameter: f64) -> Result<Solution, NewtonError> {
        let normal = Direction { u: vec![0.0; start.len()], parameter: self.metric.parameter };
        let base = Place { u: start, parameter };
        let plane = Plane { normal, base: base.clone(), distance: 0.0 };
        self.on_plane(&plane, &base)
    }

    /// The solution on a plane.
    ///
    /// # Errors
    /// [`NewtonError`], with the iterate without its parameter.
    pub fn on_plane(&mut self, plane: &Plane, guess: &Place) -> Result<Solution, NewtonError> {
        let mut equations = ArcEquations::new(self.family, &self.metric, plane, &mut self.pattern);
        let start = Start::at(equations.unknowns(guess));
        let elimination = self.elimination.with_one_more();
        let (solver, ignored) = (&mut self.solver, &mut |_: &NewtonStep| ());
        match newton_eliminating(&mut equations, elimination, start, solver, &self.options, ignored) {
            Ok(mut found) => {
                found.residual.pop();
                let iterations = found.iterations();
                Ok(Solution { at: equations.place(found.u), residual: found.residual, iterations })
            }
            Err(mut error) => {
                error.u.pop();
                Err(error)
            }
        }
    }

    /// A solution with the direction of its branch, on the side of a given one, and the signs of its tangent's eigenvalues. The solver
    /// keeps its tangent.
    ///
    /// # Errors
    /// [`NewtonFailure`]: assembly, or a bordered matrix that is singular, as at a bifurcation.
    pub fn analyse(
        &mut self,
        solution: Solution,
        toward: &Direction,
        arc_length: f64,
    ) -> Result<Reached, NewtonFailure> {
        let Solution { at, residual, iterations } = solution;
        let plane = Plane { normal: toward.clone(), base: at.clone(), distance: 0.0 };
        let mut equations = ArcEquations::new(self.family, &self.metric, &plane, &mut self.pattern);
        let x = equations.unknowns(&at);
        let matrix = self.extended.reduce_matrix(&equations.tangent(&x)?.matrix)?;
        self.solver.set_matrix(matrix)?;
        let mut load = vec![0.0; self.extended.free().len()];
        if let Some(last) = load.last_mut() {
            *last = 1.0;
        }
        let found = self.solver.solve(&load, 0.0)?.solution;
        let inertia = self.solver.inertia()?;
        let mut u = self.extended.extend_by_zero(&found)?;
        let parameter = u.pop().unwrap_or(0.0) * self.metric.parameter;
        let direction = self.metric.unit(Direction { u, parameter });
        let direction = direction.ok_or(NewtonFailure::NotFinite)?;
        Ok(Reached { at, residual, direction, inertia, arc_length, iterations })
    }

    /// The point at a distance along the direction of another.
    ///
    /// # Errors
    /// [`NewtonError`].
    pub fn beyond(&mut self, from: &Reached, distance: f64) -> Result<Beyond, NewtonError> {
        let plane = Plane { normal: from.direction.clone(), base: from.at.clone(), distance };
        let guess = from.at.moved(&from.direction, distance);
        let solution = self.on_plane(&plane, &guess)?;
        let off = self.metric.length(&solution.at.since(&guess)) / distance;
        let way = self.metric.length(&solution.at.since(&from.at));
        let mut reached = self.analyse(solution, &from.direction, from.arc_length + way)?;
        let mut cosine = self.metric.inner(&from.direction, &reached.direction);
        if cosine < TURN && orient(&self.metric, from, &mut reached) {
            cosine = self.metric.inner(&from.direction, &reached.direction);
        }
        Ok(Beyond { reached, cosine, off })
    }

    /// The amount of the eigenvalue of the solver's tangent that is nearest to zero, and vectors that belong to it and to the next ones, by
    /// inverse iteration from given ones. Vectors are of the free unknowns.
    ///
    /// # Errors
    /// [`SolverError`]: the tangent is singular.
    pub fn nearest_to_zero(
        &mut self,
        count: usize,
        start: &[Vec<f64>],
    ) -> Result<(f64, Vec<Vec<f64>>), SolverError> {
        let size = self.elimination.free().len();
        let mut vectors = start.to_vec();
        for number in vectors.len()..count {
            let turned = irregular(size + number).skip(number);
            vectors
                .push(turned.enumerate().map(|(k, sign)| sign * (1.0 + (k % (7 + number)) as f64)).collect());
        }
        orthonormalise(&mut vectors);
        let mut amount = 0.0;
        for _ in 0..INVERSE_ITERATIONS {
            let mut growth = 0.0;
            for vector in &mut vectors {
                *vector = self.solver.inner.solve(vector, 0.0)?.solution;
                growth = norm(vector).max(growth);
            }
            amount = 1.0 / growth;
            orthonormalise(&mut vectors);
        }
        Ok((amount, vectors))
    }

    /// A vector of the free unknowns on all unknowns, with its largest entry one.
    ///
    /// # Errors
    /// [`NewtonFailure`]: a vector of another length.
    pub fn mode(&self, vector: &[f64]) -> Result<Vec<f64>, NewtonFailure> {
        let mut mode = self.elimination.extend_by_zero(vector)?;
        let largest =
            mode.iter().fold(0.0, |most: f64, value| if value.abs() > most.abs() { *value } else { most });
        if largest != 0.0 {
            mode.iter_mut().for_each(|value| *value /= largest);
        }
        Ok(mode)
    }

    /// The distance of a rate from the difference of residuals near a place, as a part of the larger of both.
    ///
    /// # Errors
    /// If assembly fails.
    pub fn error_of_rate(&mut self, at: &Place) -> Result<f64, NewtonFailure> {
        let step = DIFFERENCE * self.metric.parameter;
        let mut residual = |parameter: f64| -> Result<Vec<f64>, NewtonFailure> {
            self.family.set_parameter(parameter)?;
            Ok(self.family.equations().residual(&at.u)?)
        };
        let (above, below) = (residual(at.parameter + step)?, residual(at.parameter - step)?);
        self.family.set_parameter(at.parameter)?;
        let rate = self.family.rate(&at.u)?;
        let differences = above.iter().zip(&below).map(|(above, below)| (above - below) / (2.0 * step));
        let (mut off, mut most) = (0.0_f64, 0.0_f64);
        for (difference, rate) in differences.zip(&rate) {
            off = off.max((difference - rate).abs());
            most = most.max(difference.abs()).max(rate.abs());
        }
        Ok(if most == 0.0 { 0.0 } else { off / most })
    }
}

/// The step of differences by λ, as a part of Λ.
const DIFFERENCE: f64 = 1e-3;

fn orthonormalise(vectors: &mut [Vec<f64>]) {
    for number in 0..vectors.len() {
        let (before, after) = vectors.split_at_mut(number);
        let Some(vector) = after.first_mut() else { continue };
        for other in before {
            let part = dot(vector, other);
            vector.iter_mut().zip(other).for_each(|(value, other)| *value -= part * *other);
        }
        let length = norm(vector);
        if length > 0.0 {
            vector.iter_mut().for_each(|value| *value /= length);
        }
    }
}

/// Whether a tangent's signs can be compared with another's.
pub(super) fn is_judged(inertia: Inertia) -> bool {
    inertia != Inertia::Singular
}

//! The first point of a branch: at a parameter, or next to a bifurcation on the other branch.

use super::arc::Plane;
use super::bordered_solver::BorderedSolver;
use super::branch::{Branch, BranchEvent, ContinuationError, ContinuationFailure};
use super::family::{Direction, Place, Reached};
use super::metric::Metric;
use super::of_forms::{FamilyOfForms, Measure};
use super::points::Points;
use super::tracing::{Steps, Traced};
use super::{BranchEnd, Continuation};
use crate::contract::Form;
use crate::field::Field;
use crate::history::reads_history;
use crate::instantiate::instantiate;
use crate::solve::{Elimination, NewtonFailure, TangentSolver};

/// The start of a branch.
pub(super) enum Origin<'a, const D: usize, const N: usize> {
    Parameter { value: f64, start: Option<[&'a Field<D>; N]> },
    Bifurcation { event: &'a BranchEvent<D, N>, mode: usize, amplitude: f64 },
}

/// A difference of residuals that is off by more than this part says that the rate is another form's.
const WRONG_RATE: f64 = 1e-2;

/// A first point on another branch is at most this multiple of its distance along the null vector away: one farther off is on the branch
/// that it was to leave.
const FAR: f64 = 2.0;

/// The first point, in vectors.
pub(super) enum First {
    /// A start of Newton's method at a parameter.
    At(Place),
    /// A bifurcation with the branch's direction and the change along a null vector.
    Beyond { bifurcation: Place, direction: Direction, change: Vec<f64>, amplitude: f64 },
}

impl First {
    /// The first point, with the length of the first step. The metric is that of the first step.
    ///
    /// # Errors
    /// [`ContinuationFailure`]: no such point, or a rate of another form.
    pub fn find(
        self,
        points: &mut Points<'_>,
        step: f64,
        form: &'static str,
    ) -> Result<(Reached, f64), ContinuationFailure> {
        match self {
            First::At(Place { u, parameter }) => {
                let solution = points.at_parameter(u, parameter)?;
                let off = points.error_of_rate(&solution.at)?;
                if off > WRONG_RATE {
                    return Err(ContinuationFailure::NotTheRate { form, off });
                }
                let zero = vec![0.0; solution.at.u.len()];
                let toward = Direction { u: zero, parameter: step };
                let again = super::points::Solution { at: solution.at.clone(), ..solution };
                let mut first = points.analyse(again, &toward, 0.0)?;
                // The same in the metric of the first step: ds = Λ along λ.
                let length = step / first.direction.parameter;
                first.direction.u.iter_mut().for_each(|value| *value *= length);
                first.direction.parameter *= length;
                points.metric = Metric::of_change(&points.fields, &first.direction.u, step);
                let length = points.metric.length(&first.direction);
                first.direction = points.metric.unit(first.direction).ok_or(NewtonFailure::NotFinite)?;
                Ok((first, length))
            }
            First::Beyond { bifurcation, direction, change, amplitude } => {
                points.metric = Metric::of_change(&points.fields, &change, step);
                let along = points.metric.unit(direction).ok_or(NewtonFailure::NotFinite)?;
                let mut change = Direction { u: change, parameter: 0.0 };
                let part = points.metric.inner(&change, &along);
                change.u.iter_mut().zip(&along.u).for_each(|(value, along)| *value -= part * along);
                change.parameter -= part * along.parameter;
                let distance = points.metric.length(&change);
                let normal = points.metric.unit(change).ok_or(NewtonFailure::NotFinite)?;
                let guess = bifurcation.moved(&normal, distance);
                let plane = Plane { normal: normal.clone(), base: bifurcation.clone(), distance };
                let solution = points.on_plane(&plane, &guess)?;
                let way = points.metric.length(&solution.at.since(&bifurcation));
                if way > FAR * distance {
                    return Err(ContinuationFailure::FarFromBifurcation { amplitude });
                }
                Ok((points.analyse(solution, &normal, way)?, distance))
            }
        }
    }
}

impl<const D: usize, const N: usize> Continuation<'_, D, N> {
    fn first(&self) -> Result<First, ContinuationFailure> {
        let values = |fields: &[Field<D>; N]| -> Vec<f64> {
            fields.iter().flat_map(|field| field.values()).copied().collect()
        };
        match &self.origin {
            Origin::Parameter { value, start } => {
                let u = match start {
                    Some(start) => {
                        self.problem.check_spaces("start", start.map(|field| field.space()))?;
                        start.iter().flat_map(|field| field.values()).copied().collect()
                    }
                    None => vec![0.0; self.problem.system.unknowns()],
                };
                Ok(First::At(Place { u, parameter: *value }))
            }
            Origin::Bifurcation { event, mode, amplitude } => {
                self.problem
                    .check_spaces("bifurcation", event.fields.each_ref().map(|field| field.space()))?;
                let known = event.modes.len();
                let fields =
                    event.modes.get(*mode).ok_or(ContinuationFailure::NoMode { number: *mode, known })?;
                let change = values(fields).iter().map(|value| amplitude * value).collect();
                let bifurcation = Place { u: values(&event.fields), parameter: event.parameter };
                let direction = event.direction.clone();
                Ok(First::Beyond { bifurcation, direction, change, amplitude: *amplitude })
            }
        }
    }

    /// Follows the branch.
    #[inline(never)]
    pub(super) fn trace<M>(
        mut self,
        measure: Measure<'_, M, D, N>,
    ) -> Result<Branch<M, D, N>, ContinuationError<M, D, N>> {
        let mut branch = Branch { points: vec![], events: vec![], fields: None, end: None };
        match self.trace_into(&mut branch, measure) {
            Ok(end) => {
                branch.end = Some(end);
                Ok(branch)
            }
            Err(why) => Err(ContinuationError { why, branch }),
        }
    }

    fn trace_into<M>(
        &mut self,
        branch: &mut Branch<M, D, N>,
        measure: Measure<'_, M, D, N>,
    ) -> Result<BranchEnd, ContinuationFailure> {
        let step = self.step;
        if step == 0.0 || !step.is_finite() {
            return Err(ContinuationFailure::FirstStep { step });
        }
        let first = self.first()?;
        let parameter = match &first {
            First::At(place) => place.parameter,
            First::Beyond { bifurcation, .. } => bifurcation.parameter,
        };
        let [form, rate] = (self.forms)(parameter);
        if let Some(form) = [&form, &rate].into_iter().find(|form: &&Form<D>| reads_history(form.inputs())) {
            return Err(ContinuationFailure::History { form: form.name() });
        }
        let constraints = self.problem.all_constraints()?;
        let elimination = Elimination::of(&constraints.each_ref().map(|one| &**one))?;
        let solver = BorderedSolver::new(TangentSolver::new(self.solver.clone()));
        let mut family = FamilyOfForms::new(&mut self.problem, &self.forms, parameter, step.abs(), measure);
        let mut traced = Traced::default();
        let mut points = Points::new(&mut family, elimination, step, self.options.clone(), solver);
        let end = follow(&mut traced, &mut points, first, step, &self.steps, form.name());
        drop(points);
        branch.points = family.points;
        let system = &self.problem.system;
        if let Some(last) = traced.points.last() {
            branch.fields = Some(system.fields(&last.at.u));
        }
        let event = |(after, event): (usize, super::events::Located)| BranchEvent {
            kind: event.kind,
            parameter: event.at.parameter,
            uncertainty: event.uncertainty,
            arc_length: event.arc_length,
            after,
            fields: system.fields(&event.at.u),
            modes: event.modes.iter().map(|mode| system.fields(mode)).collect(),
            direction: event.direction,
        };
        branch.events = traced.events.into_iter().map(event).collect();
        end
    }
}

/// Finds the first point and follows its branch.
pub(super) fn follow(
    traced: &mut Traced,
    points: &mut Points<'_>,
    first: First,
    step: f64,
    steps: &Steps,
    form: &'static str,
) -> Result<BranchEnd, ContinuationFailure> {
    let (first, length) = first.find(points, step, form)?;
    traced.follow(points, first, length, steps)
}

instantiate!(
    continuation:
    Continuation::<D, 1>::of_boxed,
    Continuation::<D, 2>::of_boxed,
);

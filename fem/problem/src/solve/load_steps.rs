//! Load stepping: a sequence of load factors, with steps that begin on secants and are halved where the solution fails.

mod increment;

use std::error::Error;
use std::fmt;

use increment::Secant;
pub use increment::{Extrapolate, Increment, StepStart};

use crate::output::Failure;

/// Load factors to be reached one after the other, and how a step that fails is repeated.
///
/// A failed step is tried again with half its increment, down to a smallest one; after two successes in a row the
/// increment doubles, until the factor asked for is reached. Factors may fall (unloading).
///
/// Fields take [`LoadSteps::advance`] with [`Problem::increment`](super::Problem::increment): Newton's method then begins on the secant
/// through the last two states, and from the last one where it fails; and a step in which sliding pairs may have passed through each
/// other, which has a solution, too, is refused, so that it is halved. [`LoadSteps::run`] is for any state.
///
/// The state S is what one step hands to the next, and what [`LoadPath::state`] is at the end: whatever the closure returns. For
/// [`LoadSteps::advance`] it is continued along secants ([`Extrapolate`]): a number, a [`Field`](crate::field::Field), or an array of fields,
/// `[u, p]`, which is what [`Solved::fields`](super::Solved::fields) of a problem with several unknowns is. For [`LoadSteps::run`] it may be anything,
/// as a tuple of a field and a count.
///
/// ```
/// use forms_fem::solve::LoadSteps;
/// // The state after a step is the factor's square; steps above 0.3 fail.
/// let solve = |factor: f64, before: &f64| match (factor - before.sqrt()).abs() > 0.3 {
///     true => Err("too large a step".to_string()),
///     false => Ok(factor * factor),
/// };
/// let path = LoadSteps::uniform(2, 1.0).run(0.0, solve);
/// let reached = path.map_err(|error| error.to_string())?;
/// assert_eq!(reached.state, 1.0);
/// assert_eq!(reached.steps.iter().filter(|step| step.failure.is_none()).count(), 4);
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct LoadSteps {
    /// The factor at the start.
    pub start: f64,
    /// To be reached in this order.
    pub factors: Vec<f64>,
    /// A step whose increment, in amount, is at most this is not halved: it fails for good.
    pub smallest_increment: f64,
    /// Start of Newton's method in each step of [`LoadSteps::advance`].
    pub start_of_steps: StepStart,
}

/// One attempt.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadStep {
    /// 0 for the first attempt.
    pub number: usize,
    /// The factor before.
    pub from: f64,
    /// The factor aimed at.
    pub factor: f64,
    /// The number of halvings of the way to the next factor asked for.
    pub halvings: u32,
    /// The reason of a failure; `None` for a success.
    pub failure: Option<String>,
}

/// The end of a load path.
#[derive(Clone, Debug)]
pub struct LoadPath<S> {
    /// The state at the last factor.
    pub state: S,
    /// All attempts.
    pub steps: Vec<LoadStep>,
}

/// A reason why a load path ended early.
pub struct LoadStepError<S, E> {
    /// The last factor with a solution.
    pub factor: f64,
    /// The state there.
    pub state: S,
    /// The factor that could not be reached.
    pub failed: f64,
    /// The failure at the smallest increment.
    pub why: E,
    /// All attempts.
    pub steps: Vec<LoadStep>,
}

impl<S, E: fmt::Display> fmt::Display for LoadStepError<S, E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let LoadStepError { factor, failed, why, steps, .. } = self;
        write!(
            f,
            "the load factor {failed} could not be reached from {factor} (attempt {}): {why}",
            steps.len()
        )
    }
}

/// Attempts that [`LoadStepError`] prints.
const PRINTED: usize = 6;

// It is what `main` prints of an error that it returns: the last attempts one a line, without the state.
impl<S, E: fmt::Debug> fmt::Debug for LoadStepError<S, E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let LoadStepError { factor, failed, why, steps, .. } = self;
        writeln!(f, "the load factor {failed} could not be reached from {factor}")?;
        let earlier = steps.len().saturating_sub(PRINTED);
        if earlier > 0 {
            writeln!(f, "  ({earlier} attempts before)")?;
        }
        for step in &steps[earlier..] {
            let outcome = step.failure.as_deref().unwrap_or("reached");
            writeln!(f, "  attempt {}: from {} to {}: {outcome}", step.number, step.from, step.factor)?;
        }
        write!(f, "{why:?}")
    }
}

impl<S, E: Error + 'static> Error for LoadStepError<S, E> {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        Some(&self.why)
    }
}

// So that `?` ends a program whose steps fail with a [`Failure`].
impl<S> From<LoadStepError<S, Failure>> for Failure {
    fn from(error: LoadStepError<S, Failure>) -> Self {
        Failure::from(error.to_string())
    }
}

/// The smallest increment is this part of the first one asked for.
const SMALLEST: f64 = 1.0 / 1024.0;

impl LoadSteps {
    /// These factors, from 0 on. The smallest increment is 1/1024 of the largest requested one.
    pub fn through(factors: impl IntoIterator<Item = f64>) -> Self {
        let factors: Vec<f64> = factors.into_iter().collect();
        let start_of_steps = StepStart::default();
        let mut steps = LoadSteps { start: 0.0, factors, smallest_increment: 0.0, start_of_steps };
        let before = [steps.start].into_iter().chain(steps.factors.iter().copied());
        let increments = before.zip(&steps.factors).map(|(before, factor)| (factor - before).abs());
        steps.smallest_increment = SMALLEST * increments.fold(0.0, f64::max);
        steps
    }

    /// `count` equal steps from 0 to `end`.
    pub fn uniform(count: usize, end: f64) -> Self {
        Self::through((1..=count).map(|step| end * step as f64 / count as f64))
    }

    /// These steps from the given factor instead of 0.
    pub fn starting_at(self, start: f64) -> Self {
        LoadSteps { start, ..self }
    }

    /// These steps with the given start of Newton's method in each step.
    pub fn starting_steps_from(self, start_of_steps: StepStart) -> Self {
        LoadSteps { start_of_steps, ..self }
    }

    /// The steps through the factors. `solve(increment)` gives the state at the increment's factor, or fails:
    ///
    /// ```no_run
    /// # use forms_fem::prelude::*;
    /// # #[forms(dimension = 2)]
    /// # mod bar {
    /// #     #[cells]
    /// #     pub struct Omega;
    /// #     pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
    /// #         integral(Omega, (1 + inner(grad(u), grad(u))) * inner(grad(u), grad(v)))
    /// #     }
    /// # }
    /// # fn pulled(space: &Arc<Space<2>>) -> Result<Field<2>, Box<dyn std::error::Error>> {
    /// let form = bar::Model::default().balance();
    /// let path = LoadSteps::uniform(10, 0.5).advance(Field::zero(space), |step| {
    ///     let mut constraints = Constraints::new(space);
    ///     constraints.fix("left", |_| [0.0; 2])?;
    ///     constraints.fix("right", |_| [step.factor, 0.0])?;
    ///     let solved = Problem::new(&form, space).constrained(&constraints).increment(step).solve()?;
    ///     Ok::<_, Box<dyn std::error::Error>>(solved.into_field())
    /// });
    /// # Ok(path.map_err(|error| error.to_string())?.state)
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`LoadStepError`] with the reason and the last state that was reached.
    pub fn advance<S: Extrapolate, E: fmt::Display>(
        &self,
        state: S,
        solve: impl FnMut(&Increment<'_, S>) -> Result<S, E>,
    ) -> Result<LoadPath<S>, LoadStepError<S, E>> {
        self.go_through(state, self.start_of_steps.rule(), solve, &mut |_| (), &mut |_| ())
    }

    /// The steps through the factors with any state. `solve(factor, state)` gives the state at a factor from the last one, or fails.
    ///
    /// # Errors
    /// [`LoadStepError`] with the reason and the last state that was reached.
    pub fn run<S, E: fmt::Display>(
        &self,
        state: S,
        mut solve: impl FnMut(f64, &S) -> Result<S, E>,
    ) -> Result<LoadPath<S>, LoadStepError<S, E>> {
        self.go_through(state, None, |step| solve(step.factor, step.before), &mut |_| (), &mut |_| ())
    }

    /// Load steps with something done at each success, before the next step: histories are committed there.
    ///
    /// ```
    /// use forms_fem::solve::LoadSteps;
    ///
    /// // Two unknowns, [u, p]; a step above ¼ fails.
    /// let (mut committed, mut told) = (vec![], vec![]);
    /// let steps = LoadSteps::through([0.5, 1.0]);
    /// let path = steps
    ///     .each_attempt(|attempt| told.push((attempt.factor, attempt.failure.is_none())))
    ///     .committing(|[u, _]: &[f64; 2]| committed.push(*u))
    ///     .advance([0.0, 0.0], |step| match step.factor - step.from > 0.25 {
    ///         true => Err("too large a step"),
    ///         false => Ok([step.factor, step.before[1] + 1.0]),
    ///     })
    ///     .map_err(|error| error.to_string())?;
    /// assert_eq!(path.state, [1.0, 4.0]);
    /// assert_eq!(told[..3], [(0.5, false), (0.25, true), (0.5, true)]);
    /// assert_eq!(committed, [0.25, 0.5, 0.75, 1.0]);
    /// # Ok::<(), String>(())
    /// ```
    pub fn committing<'a, S>(&'a self, commit: impl FnMut(&S) + 'a) -> CommittingSteps<'a, S> {
        CommittingSteps { steps: self, commit: Box::new(commit), each_attempt: Box::new(|_| ()) }
    }

    /// Load steps with something done at each attempt, whether it succeeds or fails, as printing it.
    pub fn each_attempt<'a, S>(&'a self, progress: impl FnMut(&LoadStep) + 'a) -> CommittingSteps<'a, S> {
        self.committing(|_: &S| ()).each_attempt(progress)
    }

    fn go_through<S, E: fmt::Display>(
        &self,
        state: S,
        secant: Option<Secant<S>>,
        mut solve: impl FnMut(&Increment<'_, S>) -> Result<S, E>,
        commit: &mut dyn FnMut(&S),
        progress: &mut dyn FnMut(&LoadStep),
    ) -> Result<LoadPath<S>, LoadStepError<S, E>> {
        let mut path = LoadPath { state, steps: vec![] };
        let mut at = self.start;
        let mut earlier: Option<(f64, S)> = None;
        for &target in &self.factors {
            let whole = target - at;
            let (mut halvings, mut successes) = (0, 0);
            loop {
                let increment = whole / 2.0_f64.powi(halvings as i32);
                // No crumb is left for a step of its own.
                let rest = target - at;
                let last = rest.abs() <= increment.abs() * (1.0 + 1e-9);
                let factor = if last { target } else { at + increment };
                let number = path.steps.len();
                let mut step = LoadStep { number, from: at, factor, halvings, failure: None };
                let before = &path.state;
                let on_secant = |(secant, (earlier_factor, earlier)): (Secant<S>, &(f64, S))| {
                    secant(before, earlier, (factor - at) / (at - earlier_factor))
                };
                let predicted = secant.zip(earlier.as_ref()).and_then(on_secant);
                match solve(&Increment { from: at, factor, before, predicted }) {
                    Ok(state) => {
                        commit(&state);
                        progress(&step);
                        path.steps.push(step);
                        let before = std::mem::replace(&mut path.state, state);
                        earlier = secant.map(|_| (at, before));
                        at = factor;
                        if last {
                            break;
                        }
                        successes += 1;
                        if successes == 2 {
                            (halvings, successes) = (halvings.saturating_sub(1), 0);
                        }
                    }
                    Err(why) => {
                        step.failure = Some(why.to_string());
                        progress(&step);
                        path.steps.push(step);
                        // Not so for NaN, which ends the path, too.
                        let halvable = (factor - at).abs() > self.smallest_increment;
                        if !halvable || halvings >= 1000 {
                            let LoadPath { state, steps } = path;
                            return Err(LoadStepError { factor: at, state, failed: factor, why, steps });
                        }
                        (halvings, successes) = (halvings + 1, 0);
                    }
                }
            }
        }
        Ok(path)
    }
}

/// Load steps with actions at each success and each attempt: [`LoadSteps::committing`], [`LoadSteps::each_attempt`].
pub struct CommittingSteps<'a, S> {
    steps: &'a LoadSteps,
    commit: Box<dyn FnMut(&S) + 'a>,
    each_attempt: Box<dyn FnMut(&LoadStep) + 'a>,
}

impl<'a, S> CommittingSteps<'a, S> {
    /// These steps with the given action at each success, as [`LoadSteps::committing`].
    pub fn committing(mut self, commit: impl FnMut(&S) + 'a) -> Self {
        self.commit = Box::new(commit);
        self
    }

    /// Load steps with something done at each attempt: [`LoadSteps::each_attempt`].
    pub fn each_attempt(mut self, progress: impl FnMut(&LoadStep) + 'a) -> Self {
        self.each_attempt = Box::new(progress);
        self
    }

    /// [`LoadSteps::advance`].
    ///
    /// # Errors
    /// As there.
    pub fn advance<E: fmt::Display>(
        mut self,
        state: S,
        solve: impl FnMut(&Increment<'_, S>) -> Result<S, E>,
    ) -> Result<LoadPath<S>, LoadStepError<S, E>>
    where
        S: Extrapolate,
    {
        let rule = self.steps.start_of_steps.rule();
        self.steps.go_through(state, rule, solve, &mut *self.commit, &mut *self.each_attempt)
    }

    /// [`LoadSteps::run`].
    ///
    /// # Errors
    /// As there.
    pub fn run<E: fmt::Display>(
        mut self,
        state: S,
        mut solve: impl FnMut(f64, &S) -> Result<S, E>,
    ) -> Result<LoadPath<S>, LoadStepError<S, E>> {
        let solve = |step: &Increment<'_, S>| solve(step.factor, step.before);
        self.steps.go_through(state, None, solve, &mut *self.commit, &mut *self.each_attempt)
    }
}

impl<S> fmt::Debug for CommittingSteps<'_, S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("CommittingSteps").field("steps", self.steps).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests;

//! One load step that is to be solved, and the states on a secant with which Newton's method may begin it.

use crate::field::Field;

/// The start of Newton's method in a load step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StepStart {
    /// The state on the secant through the last two, u_n + (Δt_{n+1}/Δt_n) (u_n − u_{n−1}), and the last state where Newton's method
    /// fails from there. The first step begins with the state given.
    #[default]
    Secant,
    /// The last state.
    LastState,
}

/// Gives the state beyond the first by a part of the way from the second.
pub(super) type Secant<S> = fn(&S, &S, f64) -> Option<S>;

impl StepStart {
    pub(super) fn rule<S: Extrapolate>(self) -> Option<Secant<S>> {
        match self {
            StepStart::Secant => Some(S::beyond),
            StepStart::LastState => None,
        }
    }
}

/// A state that can be continued along a straight line: a number, a field, an array of either.
pub trait Extrapolate: Sized {
    /// `self` + part (`self` − `earlier`); none where the two do not belong together, as fields on different spaces, or the result
    /// is not finite.
    fn beyond(&self, earlier: &Self, part: f64) -> Option<Self>;
}

impl Extrapolate for f64 {
    fn beyond(&self, earlier: &Self, part: f64) -> Option<Self> {
        Some(self + part * (self - earlier)).filter(|state| state.is_finite())
    }
}

impl<const D: usize> Extrapolate for Field<D> {
    fn beyond(&self, earlier: &Self, part: f64) -> Option<Self> {
        if !self.space().numbers_as(earlier.space()) {
            return None;
        }
        let values = self.values().iter().zip(earlier.values()).map(|(u, old)| u + part * (u - old));
        Field::from_values(self.space(), values.collect()).ok()
    }
}

impl<S: Extrapolate, const N: usize> Extrapolate for [S; N] {
    fn beyond(&self, earlier: &Self, part: f64) -> Option<Self> {
        let states = self.iter().zip(earlier).map(|(state, earlier)| state.beyond(earlier, part));
        states.collect::<Option<Vec<S>>>()?.try_into().ok()
    }
}

/// A load step that is to be solved: [`Problem::increment`](crate::solve::Problem::increment) takes it.
#[derive(Clone, Debug)]
pub struct Increment<'a, S> {
    /// The factor of the state before.
    pub from: f64,
    /// The factor to be reached.
    pub factor: f64,
    /// The state at the last factor: slips and histories are counted from it.
    pub before: &'a S,
    pub(super) predicted: Option<S>,
}

impl<S> Increment<'_, S> {
    /// The state with which Newton's method begins, on which constraints are yet to be imposed.
    pub fn start(&self) -> &S {
        self.predicted.as_ref().unwrap_or(self.before)
    }

    /// The state on the secant; none in a first step, or if secants are switched off.
    pub fn predicted(&self) -> Option<&S> {
        self.predicted.as_ref()
    }
}

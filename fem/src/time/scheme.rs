//! Schemes of time integration as tables of numbers.

use std::fmt::Debug;
use std::rc::Rc;

use thiserror::Error;

use super::error::StepFailure;

/// A scheme: formulas that give a step's evaluated and final value, rate and second rate by the step's unknown x and the states
/// before it.
pub trait Scheme: Debug {
    /// The number of states before a step that the scheme reads once it has them; it has to begin with one.
    fn states(&self) -> usize {
        1
    }

    /// Whether second rates of states are read, so that the first state needs one that agrees with the form.
    fn reads_second_rates(&self) -> bool;

    /// Meaning of the step's unknown.
    fn solved_for(&self) -> SolvedFor {
        SolvedFor::Value
    }

    /// The formulas of a step. `steps` are step sizes, newest first: that of the step to be taken, then those that led to the last
    /// states, one for each known state but the oldest.
    fn formulas(&self, steps: &[f64]) -> Formulas;

    /// The factor C of C Δt² (ü₁ − ü₀), the leading error of a step's value, where such a rule is known.
    fn error_factor(&self) -> Option<f64> {
        None
    }
}

/// A scheme that is chosen when the program runs.
impl<S: Scheme + ?Sized> Scheme for Box<S> {
    fn states(&self) -> usize {
        (**self).states()
    }

    fn reads_second_rates(&self) -> bool {
        (**self).reads_second_rates()
    }

    fn solved_for(&self) -> SolvedFor {
        (**self).solved_for()
    }

    fn formulas(&self, steps: &[f64]) -> Formulas {
        (**self).formulas(steps)
    }

    fn error_factor(&self) -> Option<f64> {
        (**self).error_factor()
    }
}

/// Meaning of a step's unknown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolvedFor {
    /// The value at the end of the step: an implicit step.
    Value,
    /// The second rate there, on which the value does not depend: an explicit step, with the mass as its matrix.
    SecondRate,
}

/// The formulas of one step.
#[derive(Clone, Debug, PartialEq)]
pub struct Formulas {
    /// Value, rate and second rate at which the form is evaluated.
    pub evaluated: [Combination; 3],
    /// Value, rate and second rate at the end of the step.
    pub end: [Combination; 3],
    /// The part of the step that has passed where loads are evaluated: 1 at its end.
    pub load_at: f64,
}

impl Formulas {
    /// Whether values and rates are free of the states' second rates, which then enter inertia alone.
    pub(super) fn second_rates_are_for_inertia(&self) -> bool {
        let Formulas { evaluated: [value, rate, _], end: [last, last_rate, _], .. } = self;
        let mut states = [value, rate, last, last_rate].into_iter().flat_map(|all| &all.states);
        states.all(|weights| weights[2] == 0.0)
    }

    /// The number of states that they read.
    pub(crate) fn states(&self) -> usize {
        let all = self.evaluated.iter().chain(&self.end);
        all.map(|combination| combination.states.len()).max().unwrap_or(0)
    }
}

/// a x + Σ_k (a_k u_k + b_k u̇_k + c_k ü_k) over the states before the step, newest first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Combination {
    /// a, the weight of the step's unknown.
    pub unknown: f64,
    /// (a_k, b_k, c_k) of each state.
    pub states: Vec<[f64; 3]>,
}

impl Combination {
    /// a x + b u₀ + c u̇₀ + d ü₀ with the last state.
    pub fn new(unknown: f64, last: [f64; 3]) -> Self {
        Combination { unknown, states: vec![last] }
    }

    /// The sum of multiples of combinations.
    pub fn sum(terms: &[(f64, &Combination)]) -> Self {
        let count = terms.iter().map(|(_, term)| term.states.len()).max().unwrap_or(0);
        let mut sum = Combination { unknown: 0.0, states: vec![[0.0; 3]; count] };
        for (factor, term) in terms {
            sum.unknown += factor * term.unknown;
            for (sum, state) in sum.states.iter_mut().zip(&term.states) {
                sum.iter_mut().zip(state).for_each(|(sum, weight)| *sum += factor * weight);
            }
        }
        sum
    }
}

/// The meaning of the unknowns of a step, on which the schemes of all unknowns have to agree, as on the time of loads.
pub(crate) fn agreed_unknown(
    schemes: &[Rc<dyn Scheme + '_>],
    formulas: &[Formulas],
) -> Result<SolvedFor, StepFailure> {
    let solved_for = schemes[0].solved_for();
    let agree = |(scheme, own): (&Rc<dyn Scheme + '_>, &Formulas)| {
        scheme.solved_for() == solved_for && own.load_at == formulas[0].load_at
    };
    match schemes.iter().zip(formulas).position(|both| !agree(both)) {
        None => Ok(solved_for),
        Some(unknown) => Err(StepFailure::Schemes {
            unknown,
            scheme: format!("{:?}", schemes[unknown]),
            first: format!("{:?}", schemes[0]),
        }),
    }
}

/// A parameter with which a scheme would not be one.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs)]
pub enum SchemeError {
    /// Outside the range in which the scheme is stable.
    #[error("{name} = {value} of {scheme}: it lies between {from} and {to}")]
    Parameter {
        scheme: &'static str,
        name: &'static str,
        value: f64,
        /// Its smallest value.
        from: f64,
        /// Its largest value.
        to: f64,
    },
}

/// A parameter in its range.
pub(super) fn within(
    (scheme, name): (&'static str, &'static str),
    value: f64,
    [from, to]: [f64; 2],
) -> Result<f64, SchemeError> {
    match (from..=to).contains(&value) {
        true => Ok(value),
        false => Err(SchemeError::Parameter { scheme, name, value, from, to }),
    }
}

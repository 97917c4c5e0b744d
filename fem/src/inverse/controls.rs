//! Controls: the named numbers and fields that the data of a history's forms are made of.

use std::cell::Cell;
use std::sync::Arc;

use thiserror::Error;

use super::differentiable_map::Part;
use crate::field::{Field, FieldError};
use crate::space::Space;

/// The controls of a problem with their values m, one after the other in one vector.
///
/// A form's rates name them: the derivative by the control `load` is tested with the function `by_load`.
#[derive(Clone, Debug, Default)]
pub struct Controls<const D: usize> {
    entries: Vec<Entry<D>>,
    values: Vec<f64>,
}

/// One control.
#[derive(Clone, Debug)]
struct Entry<const D: usize> {
    name: String,
    kind: Kind<D>,
    /// The place of its first value.
    from: usize,
}

/// Kind of a control's values.
#[derive(Clone, Debug)]
enum Kind<const D: usize> {
    /// One number at all steps.
    Number,
    /// A number for each step.
    PerStep(usize),
    /// The coefficients of a field.
    Field(Arc<Space<D>>),
    /// Those of the state before the first step, or of its rate.
    Start(Start, Arc<Space<D>>),
}

/// Part of the first state that is a control.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Start {
    Value,
    Rate,
}

impl<const D: usize> Entry<D> {
    fn count(&self) -> usize {
        match &self.kind {
            Kind::Number => 1,
            Kind::PerStep(count) => *count,
            Kind::Field(space) | Kind::Start(_, space) => space.unknowns(),
        }
    }
}

/// Errors of controls.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs)]
pub enum ControlError {
    /// No control of this name and kind.
    #[error("there is no {kind} `{name}` among the controls; they are {known}")]
    Unknown {
        name: String,
        /// "number" or "field".
        kind: &'static str,
        known: String,
    },
    /// Two controls of one name.
    #[error("two controls are named `{name}`")]
    Twice { name: String },
    /// A control with the name of what a step reads.
    #[error(
        "a control cannot be named `{name}`: `by_{name}` tests the derivative by something that steps read"
    )]
    Reserved { name: String },
    /// Another number of values than of steps.
    #[error("the control `{name}` has {found} values, one per step, and there are {steps} steps")]
    Steps { name: String, found: usize, steps: usize },
    /// Another number of values than the controls have.
    #[error("the controls have {expected} values, and {found} were given")]
    Length {
        /// The controls' own.
        expected: usize,
        found: usize,
    },
    /// A value that is not finite.
    #[error("the value {value} of the control `{name}` is not finite (its number {index})")]
    NotFinite {
        name: String,
        /// The number of the value among its own.
        index: usize,
        value: f64,
    },
    /// A start on another space than the history's.
    #[error("the start `{name}` is on another space than the history")]
    Space { name: String },
    /// The state before a step, where there is none.
    #[error(
        "the state before the step is no part of a criterion: a criterion is one of the state after the step"
    )]
    NoBefore,
    /// The rate of the start of a history that has no rates.
    #[error("the control `{name}` is a rate at the start, and steps of loads have no rates")]
    NoRate { name: String },
    /// The steps of another number of unknowns than a motion has.
    #[error("the steps of {asked} unknowns are asked for, and the motion has {count}")]
    StepsOfUnknowns {
        /// The number asked for.
        asked: usize,
        count: usize,
    },
    /// Fields that do not fit.
    #[error(transparent)]
    Field(#[from] FieldError),
}

impl<const D: usize> Controls<D> {
    /// No controls yet.
    pub fn new() -> Self {
        Controls { entries: vec![], values: vec![] }
    }

    fn with(mut self, name: &str, kind: Kind<D>, values: &[f64]) -> Self {
        self.entries.push(Entry { name: name.to_owned(), kind, from: self.values.len() });
        self.values.extend(values);
        self
    }

    /// A number, the same at all steps.
    pub fn number(self, name: &str, value: f64) -> Self {
        self.with(name, Kind::Number, &[value])
    }

    /// A number for each step, as a load that changes.
    pub fn per_step(self, name: &str, values: &[f64]) -> Self {
        self.with(name, Kind::PerStep(values.len()), values)
    }

    /// A field, the same at all steps, by its coefficients: per cell on discontinuous fields of degree zero, per node on others.
    pub fn field(self, name: &str, field: &Field<D>) -> Self {
        self.with(name, Kind::Field(Arc::clone(field.space())), field.values())
    }

    /// The state before the first step, which is zero unless it is a control.
    pub fn start(self, name: &str, state: &Field<D>) -> Self {
        self.with(name, Kind::Start(Start::Value, Arc::clone(state.space())), state.values())
    }

    /// The rate of that, of motions.
    pub fn start_rate(self, name: &str, rate: &Field<D>) -> Self {
        self.with(name, Kind::Start(Start::Rate, Arc::clone(rate.space())), rate.values())
    }

    /// The names, each with its number of values, in their order in m.
    pub fn parts(&self) -> Vec<Part> {
        self.entries.iter().map(|entry| Part::new(entry.name.as_str(), entry.count())).collect()
    }

    /// m.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The places of a control's values in m.
    ///
    /// # Errors
    /// [`ControlError::Unknown`].
    pub fn places(&self, name: &str) -> Result<std::ops::Range<usize>, ControlError> {
        let entry = self.entries.iter().find(|entry| entry.name == name);
        let entry = entry.ok_or_else(|| self.unknown(name, "control"))?;
        Ok(entry.from..entry.from + entry.count())
    }

    /// Other values of the controls.
    ///
    /// # Errors
    /// [`ControlError::Length`]; [`ControlError::NotFinite`], which names the control.
    pub fn set_values(&mut self, values: &[f64]) -> Result<(), ControlError> {
        if values.len() != self.values.len() {
            return Err(ControlError::Length { expected: self.values.len(), found: values.len() });
        }
        for entry in &self.entries {
            let own = &values[entry.from..entry.from + entry.count()];
            if let Some(index) = own.iter().position(|value| !value.is_finite()) {
                return Err(ControlError::NotFinite { name: entry.name.clone(), index, value: own[index] });
            }
        }
        self.values.copy_from_slice(values);
        Ok(())
    }

    /// A direction of the controls, as values of them. Their names are not those that a form of second rates tests otherwise.
    pub(super) fn directed(&self, direction: &[f64], others: &[&str]) -> Result<Self, ControlError> {
        self.are_not(others)?;
        let mut along = self.clone();
        along.set_values(direction)?;
        Ok(along)
    }

    /// Whether none has a name that tests something else.
    pub(super) fn are_not(&self, others: &[&str]) -> Result<(), ControlError> {
        match self.tested().find(|name| others.contains(name)) {
            Some(name) => Err(ControlError::Reserved { name: name.to_owned() }),
            None => Ok(()),
        }
    }

    fn unknown(&self, name: &str, kind: &'static str) -> ControlError {
        let known: Vec<_> = self.entries.iter().map(|entry| format!("`{}`", entry.name)).collect();
        let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
        ControlError::Unknown { name: name.to_owned(), kind, known }
    }

    /// Whether they fit a history of unknowns on these spaces.
    pub(super) fn check(&self, spaces: &[&Arc<Space<D>>], steps: usize) -> Result<(), ControlError> {
        for (place, entry) in self.entries.iter().enumerate() {
            let name = || entry.name.clone();
            if self.entries[..place].iter().any(|earlier| earlier.name == entry.name) {
                return Err(ControlError::Twice { name: name() });
            }
            match &entry.kind {
                Kind::PerStep(found) if *found != steps => {
                    return Err(ControlError::Steps { name: name(), found: *found, steps });
                }
                Kind::Start(_, own) if !spaces.iter().any(|space| own.numbers_as(space)) => {
                    return Err(ControlError::Space { name: name() });
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// The start of each unknown that is a control: the first one on the unknown's space that is none of an earlier one.
    fn starts(&self, which: Start, spaces: &[&Arc<Space<D>>]) -> Vec<Option<&Entry<D>>> {
        let mut taken = vec![false; self.entries.len()];
        let mut start = |space: &&Arc<Space<D>>| {
            let fits = |entry: &Entry<D>| matches!(&entry.kind, Kind::Start(own, on) if *own == which && on.numbers_as(space));
            let place = (0..taken.len()).find(|place| !taken[*place] && fits(&self.entries[*place]))?;
            taken[place] = true;
            Some(&self.entries[place])
        };
        spaces.iter().map(&mut start).collect()
    }

    /// The coefficients of the state before the first step, or of its rate, of all unknowns.
    pub(super) fn start_values(&self, which: Start, spaces: &[&Arc<Space<D>>]) -> Vec<f64> {
        let starts = self.starts(which, spaces).into_iter().zip(spaces);
        let values = |(start, space): (Option<&Entry<D>>, &&Arc<Space<D>>)| match start {
            Some(entry) => self.values[entry.from..entry.from + entry.count()].to_vec(),
            None => vec![0.0; space.unknowns()],
        };
        starts.flat_map(values).collect()
    }

    /// The name of the first control that is a first state, or its rate.
    pub(super) fn start_name(&self, which: Start) -> Option<&str> {
        let is_start = |entry: &&Entry<D>| matches!(entry.kind, Kind::Start(own, _) if own == which);
        self.entries.iter().find(is_start).map(|entry| &*entry.name)
    }

    /// The spaces of controls that are fields or starts, with the places of their values.
    pub(super) fn fields(&self) -> impl Iterator<Item = (&Arc<Space<D>>, std::ops::Range<usize>)> {
        self.entries.iter().filter_map(|entry| match &entry.kind {
            Kind::Field(space) | Kind::Start(_, space) => {
                Some((space, entry.from..entry.from + entry.count()))
            }
            Kind::Number | Kind::PerStep(_) => None,
        })
    }

    /// The names of the controls whose rates a form has to give.
    pub(super) fn tested(&self) -> impl Iterator<Item = &str> {
        self.entries.iter().filter(|entry| !matches!(entry.kind, Kind::Start(..))).map(|entry| &*entry.name)
    }

    /// The space of the function that tests the rate by a control; that of `numbers` for what does not vary in space.
    pub(super) fn space_of_test<'a>(
        &'a self,
        name: &str,
        numbers: &'a Arc<Space<D>>,
    ) -> Option<&'a Arc<Space<D>>> {
        self.entries.iter().find(|entry| entry.name == name).and_then(|entry| match &entry.kind {
            Kind::Number | Kind::PerStep(_) => Some(numbers),
            Kind::Field(space) => Some(space),
            Kind::Start(..) => None,
        })
    }

    /// Whether a control is a field.
    pub(super) fn is_field(&self, name: &str) -> bool {
        self.entries.iter().any(|entry| entry.name == name && matches!(entry.kind, Kind::Field(_)))
    }

    /// Adds a step's rates by a control to the gradient: one by a number, those by the coefficients of a field.
    pub(super) fn add_rates(&self, name: &str, step: usize, rates: &[f64], gradient: &mut [f64]) {
        let Some(entry) = self.entries.iter().find(|entry| entry.name == name) else { return };
        let first = match &entry.kind {
            Kind::Number | Kind::Field(_) => entry.from,
            Kind::PerStep(_) => entry.from + step,
            Kind::Start(..) => return,
        };
        gradient[first..].iter_mut().zip(rates).for_each(|(sum, rate)| *sum += rate);
    }

    /// Adds the slope of the criterion by the first state of all unknowns, or by its rate.
    pub(super) fn add_start(
        &self,
        which: Start,
        spaces: &[&Arc<Space<D>>],
        slope: &[f64],
        gradient: &mut [f64],
    ) {
        let mut rest = slope;
        for (start, space) in self.starts(which, spaces).into_iter().zip(spaces) {
            let (own, others) = rest.split_at(space.unknowns());
            if let Some(entry) = start {
                gradient[entry.from..].iter_mut().zip(own).for_each(|(sum, rate)| *sum += rate);
            }
            rest = others;
        }
    }
}

/// Data of a step's form: the controls, the step's number, the state before it.
#[derive(Clone, Copy, Debug)]
pub struct ControlValues<'a, const D: usize> {
    controls: &'a Controls<D>,
    step: usize,
    /// Of each unknown, and the number of those that were asked for, from the first on.
    before: Option<(&'a [Field<D>], &'a Cell<usize>)>,
}

impl<'a, const D: usize> ControlValues<'a, D> {
    pub(super) fn new(
        controls: &'a Controls<D>,
        step: usize,
        before: Option<(&'a [Field<D>], &'a Cell<usize>)>,
    ) -> Self {
        ControlValues { controls, step, before }
    }

    /// The number of the step, from 0.
    pub fn step(&self) -> usize {
        self.step
    }

    /// The state before the step, of a load history: that of the first unknown. If no step asks for more, the states before of other unknowns need no
    /// test functions.
    ///
    /// # Errors
    /// [`ControlError::NoBefore`] in a criterion, which is one of the state after the step.
    pub fn before(&self) -> Result<&'a Field<D>, ControlError> {
        Ok(&self.first_before(1)?[0])
    }

    /// The states of all unknowns before the step, of a load history.
    ///
    /// # Errors
    /// As [`ControlValues::before`].
    pub fn before_of_all(&self) -> Result<&'a [Field<D>], ControlError> {
        self.first_before(usize::MAX)
    }

    fn first_before(&self, count: usize) -> Result<&'a [Field<D>], ControlError> {
        let (before, read) = self.before.ok_or(ControlError::NoBefore)?;
        read.set(read.get().max(count));
        Ok(before)
    }

    /// The value of a number at this step.
    ///
    /// # Errors
    /// [`ControlError::Unknown`].
    pub fn number(&self, name: &str) -> Result<f64, ControlError> {
        let entry = self.controls.entries.iter().find(|entry| entry.name == name);
        match entry.map(|entry| (&entry.kind, entry.from)) {
            Some((Kind::Number, from)) => Ok(self.controls.values[from]),
            Some((Kind::PerStep(_), from)) => Ok(self.controls.values[from + self.step]),
            _ => Err(self.controls.unknown(name, "number")),
        }
    }

    /// The field of a control.
    ///
    /// # Errors
    /// [`ControlError::Unknown`].
    pub fn field(&self, name: &str) -> Result<Field<D>, ControlError> {
        let entry = self.controls.entries.iter().find(|entry| entry.name == name);
        match entry.map(|entry| (&entry.kind, entry)) {
            Some((Kind::Field(space), entry)) => {
                let values = &self.controls.values[entry.from..entry.from + entry.count()];
                Ok(Field::from_values(space, values.to_vec())?)
            }
            _ => Err(self.controls.unknown(name, "field")),
        }
    }
}

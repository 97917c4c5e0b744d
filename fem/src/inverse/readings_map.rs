//! Readings of the states of a history as a map of several outputs.

use super::differentiable_map::{DifferentiableMap, MapError, Part, check, finite, length};
use super::error::{HistoryError, HistoryFailure};
use super::evolution::{ControlledEvolution, Evolution};
use super::readings::Readings;
use super::sweep::{gradient_of, value_of};
use crate::assemble::AssemblyError;
use crate::mesh::TAKE_THE_WHOLE;

/// Readings of the states after some steps of a history as a map of its controls. A product F′ᵀ w is the gradient of their sum
/// with the weights w: one way back.
pub struct ReadingsMap<H, const D: usize> {
    history: H,
    outputs: Vec<Output<D>>,
    last: Option<Trajectory>,
}

struct Output<const D: usize> {
    name: String,
    step: usize,
    readings: Readings<D>,
}

/// All states of the last controls, the first among them, and what was read of them.
struct Trajectory {
    m: Vec<f64>,
    states: Vec<Vec<f64>>,
    values: Vec<f64>,
}

impl<H: ControlledEvolution<D>, const D: usize> ReadingsMap<H, D> {
    /// The map of a history without a criterion.
    ///
    /// # Errors
    /// [`HistoryFailure::OwnCriterion`].
    pub fn new(history: H) -> Result<Self, HistoryError> {
        if let Some(space) = history.spaces().first() {
            let whole = space.mesh().without_pieces("a reading of a history", TAKE_THE_WHOLE);
            let failed = |source| AssemblyError::Mesh { form: "readings", source };
            whole.map_err(|source| HistoryFailure::from(failed(source)).at(0))?;
        }
        if history.has_criterion() {
            return Err(HistoryFailure::OwnCriterion.at(0));
        }
        Ok(ReadingsMap { history, outputs: vec![], last: None })
    }

    /// One more output: readings of the state after a step, numbered from 0.
    ///
    /// # Errors
    /// [`HistoryFailure::ObservedLater`], [`HistoryFailure::ObservedElsewhere`].
    pub fn output(mut self, name: &str, step: usize, readings: Readings<D>) -> Result<Self, HistoryError> {
        let steps = self.history.steps();
        if step >= steps {
            return Err(HistoryFailure::ObservedLater { step, steps }.at(step));
        }
        if !readings.fit(self.history.spaces()[0]) {
            return Err(HistoryFailure::ObservedElsewhere { step }.at(step));
        }
        self.outputs.push(Output { name: name.to_owned(), step, readings });
        Ok(self)
    }

    /// Goes forward, unless these were the last controls; all states are kept if the history may keep them.
    fn forward(&mut self, m: &[f64]) -> Result<&Trajectory, MapError> {
        check("vector of controls", &self.inputs(), m)?;
        let same = |last: &Trajectory| last.m.iter().map(|v| v.to_bits()).eq(m.iter().map(|v| v.to_bits()));
        if !self.last.as_ref().is_some_and(same) {
            self.last = None;
            self.history.begin(m).map_err(problem)?;
            let keeps = self.history.most_stored() >= self.history.steps();
            let values = vec![0.0; length(&self.outputs())];
            let weights = vec![0.0; values.len()];
            let (states, outputs) = (if keeps { Kept::All(vec![]) } else { Kept::None }, &self.outputs);
            let mut read = Read { history: &mut self.history, outputs, weights: &weights, states, values };
            value_of(&mut read).map_err(problem)?;
            let Read { states, values, .. } = read;
            let values = finite("value", values)?;
            let states = if let Kept::All(states) = states { states } else { vec![] };
            self.last = Some(Trajectory { m: m.to_vec(), states, values });
        }
        // What was missing has just been found.
        self.last.as_ref().ok_or(MapError::ResultNotFinite { result: "value" })
    }
}

fn problem(why: HistoryError) -> MapError {
    MapError::Problem(Box::new(why))
}

impl<H: ControlledEvolution<D>, const D: usize> DifferentiableMap for ReadingsMap<H, D> {
    fn inputs(&self) -> Vec<Part> {
        self.history.controls().parts()
    }

    fn outputs(&self) -> Vec<Part> {
        self.outputs.iter().map(|output| Part::new(output.name.as_str(), output.readings.count())).collect()
    }

    fn start(&self) -> Vec<f64> {
        self.history.controls().values().to_vec()
    }

    fn value(&mut self, m: &[f64]) -> Result<Vec<f64>, MapError> {
        Ok(self.forward(m)?.values.clone())
    }

    fn vjp(&mut self, m: &[f64], cotangent: &[f64]) -> Result<Vec<f64>, MapError> {
        check("cotangent", &self.outputs(), cotangent)?;
        self.forward(m)?;
        let stored = self.history.most_stored();
        let states = match &self.last {
            Some(last) if !last.states.is_empty() => Kept::Known(&last.states),
            _ => Kept::None,
        };
        let (history, outputs) = (&mut self.history, &self.outputs);
        let values = vec![0.0; cotangent.len()];
        let mut read = Read { history, outputs, weights: cotangent, states, values };
        finite("gradient", gradient_of(&mut read, stored).map_err(problem)?.gradient)
    }
}

/// States kept on the way.
enum Kept<'a> {
    None,
    /// The states as they are found.
    All(Vec<Vec<f64>>),
    /// They have been found before.
    Known(&'a [Vec<f64>]),
}

/// A history whose criterion is a weighted sum of readings.
struct Read<'a, H, const D: usize> {
    history: &'a mut H,
    outputs: &'a [Output<D>],
    weights: &'a [f64],
    states: Kept<'a>,
    values: Vec<f64>,
}

impl<H, const D: usize> Read<'_, H, D> {
    /// The outputs of a step, each with the place of its first value.
    fn outputs_of(&self, step: usize) -> impl Iterator<Item = (usize, &Readings<D>)> {
        let mut from = 0;
        let placed = self.outputs.iter().map(move |output| {
            let place = from;
            from += output.readings.count();
            (place, output)
        });
        placed.filter(move |(_, output)| output.step == step).map(|(place, output)| (place, &output.readings))
    }

    fn keep(&mut self, state: &[f64]) {
        if let Kept::All(states) = &mut self.states {
            states.push(state.to_vec());
        }
    }
}

impl<H: ControlledEvolution<D>, const D: usize> Evolution for Read<'_, H, D> {
    type Error = HistoryError;

    fn steps(&self) -> usize {
        self.history.steps()
    }

    fn control_count(&self) -> usize {
        self.history.control_count()
    }

    fn start(&mut self) -> Result<Vec<f64>, HistoryError> {
        if let Kept::Known(states) = self.states {
            return Ok(states[0].clone());
        }
        let start = self.history.start()?;
        self.keep(&start);
        Ok(start)
    }

    fn advance(&mut self, step: usize, before: &[f64]) -> Result<Vec<f64>, HistoryError> {
        if let Kept::Known(states) = self.states {
            return Ok(states[step + 1].clone());
        }
        let after = self.history.advance(step, before)?;
        self.keep(&after);
        Ok(after)
    }

    fn cost(&mut self, step: usize, _: &[f64], after: &[f64]) -> Result<f64, HistoryError> {
        let read: Vec<_> =
            self.outputs_of(step).map(|(place, readings)| (place, readings.of(after))).collect();
        for (place, values) in read {
            self.values[place..place + values.len()].copy_from_slice(&values);
        }
        Ok(0.0)
    }

    fn reverse(
        &mut self,
        step: usize,
        before: &[f64],
        after: &[f64],
        mut slope: Vec<f64>,
        gradient: &mut [f64],
    ) -> Result<Vec<f64>, HistoryError> {
        for (place, readings) in self.outputs_of(step) {
            readings.add_slope(&self.weights[place..place + readings.count()], &mut slope);
        }
        self.history.reverse(step, before, after, slope, gradient)
    }

    fn reverse_start(
        &mut self,
        start: &[f64],
        slope: &[f64],
        gradient: &mut [f64],
    ) -> Result<(), HistoryError> {
        self.history.reverse_start(start, slope, gradient)
    }
}

//! The step's unknown in a form of motion: read by the operators of [`time`](crate::time), or directly.
//!
//! The state before enters a form of motion by the known parts of what the operators give. With weights zero they give numbers that the
//! unknown does not change, and a form that still depends on it reads it in addition to them. Its derivative by it is then the tangent T₀ of
//! the form with weights zero, and that by the known part of an operator the tangent with the weight one there, less T₀.

use std::sync::Arc;

use super::error::HistoryFailure;
use super::sensitivities::names_of_unknowns;
use super::step_equations::views;
use crate::assemble::{Assembler, Parts};
use crate::contract::Form;
use crate::field::Field;
use crate::space::Space;
use crate::time::Step;

/// The fields that the operators evaluate of one unknown: value, rate and second rate.
pub(super) type Evaluated<const D: usize> = [Field<D>; 3];

/// The fields that the operators evaluate in a step, of each unknown: weight times unknown and known part of value, rate and second rate.
pub(super) fn evaluated<const D: usize>(
    steps: &[Step<D>],
    unknowns: &[Field<D>],
) -> Result<Vec<Evaluated<D>>, HistoryFailure> {
    let of_one = |(step, unknown): (&Step<D>, &Field<D>)| {
        let mut evaluated = step.known.clone();
        for (field, weight) in evaluated.iter_mut().zip(step.weights) {
            *field = Field::combination(&[(weight, unknown), (1.0, field)])?;
        }
        Ok(evaluated)
    };
    steps.iter().zip(unknowns).map(of_one).collect()
}

/// Steps with weights zero, in which the operators give what they evaluate whatever the unknowns are.
pub(super) fn fixed<const D: usize>(steps: &[Step<D>], evaluated: &[Evaluated<D>]) -> Vec<Step<D>> {
    let of_one = |(step, known): (&Step<D>, &Evaluated<D>)| Step {
        weights: [0.0; 3],
        known: known.clone(),
        ..step.clone()
    };
    steps.iter().zip(evaluated).map(of_one).collect()
}

/// The first unknown that changes the residual of a form with weights zero, where it is replaced by a field that is evaluated, or by zero.
pub(super) fn unknown_read_itself<const D: usize>(
    without_weights: &Form<D>,
    unknowns: &[Field<D>],
    evaluated: &[Evaluated<D>],
    assembler: &Assembler<D>,
) -> Result<Option<usize>, HistoryFailure> {
    let spaces: Vec<&Arc<Space<D>>> = unknowns.iter().map(Field::space).collect();
    let residual = |at: &[Field<D>]| assembler.residual_of(without_weights, &views(at), &spaces, Parts::ALL);
    let here = residual(unknowns)?;
    for (number, (unknown, evaluated)) in unknowns.iter().zip(evaluated).enumerate() {
        let zero = Field::zero(unknown.space());
        let mut tried = vec![unknown];
        for other in evaluated.iter().chain([&zero]) {
            // At a start from rest the value is zero, and the acceleration is the unknown.
            if tried.iter().any(|tried| tried.values() == other.values()) {
                continue;
            }
            let mut at = unknowns.to_vec();
            at[number] = other.clone();
            if residual(&at)? != here {
                return Ok(Some(number));
            }
            tried.push(other);
        }
    }
    Ok(None)
}

/// The error of a form that reads an unknown itself, where that may not be.
pub(super) fn refused<const D: usize>(form: &Form<D>, unknown: usize) -> HistoryFailure {
    let unknown = names_of_unknowns(form).get(unknown).copied().unwrap_or("u");
    HistoryFailure::UnknownItself { form: form.name(), unknown }
}

//! The step's unknown in a form of motion: read by the operators of [`time`](crate::time), or directly.
//!
//! The state before enters a form of motion by the known parts of what the operators give. With weights zero they give numbers that the
//! unknown does not change, and a form that still depends on it reads it in addition to them. Its derivative by it is then the tangent T₀ of
//! the form with weights zero, and that by the known part of an operator the tangent with the weight one there, less T₀.

use super::error::HistoryFailure;
use crate::assemble::{Assembler, Parts};
use crate::contract::{Form, Role};
use crate::field::Field;
use crate::time::Step;

/// The fields that the operators evaluate in a step: weight times unknown and known part of value, rate and second rate.
pub(super) fn evaluated<const D: usize>(
    step: &Step<D>,
    unknown: &Field<D>,
) -> Result<[Field<D>; 3], HistoryFailure> {
    let mut evaluated = step.known.clone();
    for (field, weight) in evaluated.iter_mut().zip(step.weights) {
        *field = Field::combination(&[(weight, unknown), (1.0, field)])?;
    }
    Ok(evaluated)
}

/// Whether a form with weights zero has another residual at the unknown than at other fields: those that it evaluates, and zero.
pub(super) fn reads_unknown_itself<const D: usize>(
    without_weights: &Form<D>,
    unknown: &Field<D>,
    evaluated: &[Field<D>; 3],
    assembler: &Assembler<D>,
) -> Result<bool, HistoryFailure> {
    let space = unknown.space();
    let residual = |at: &Field<D>| assembler.residual_of(without_weights, &[at.view()], &[space], Parts::ALL);
    let (here, zero) = (residual(unknown)?, Field::zero(space));
    let mut tried = vec![unknown];
    for other in evaluated.iter().chain([&zero]) {
        // At a start from rest the value is zero, and the acceleration is the unknown.
        if tried.iter().any(|tried| tried.values() == other.values()) {
            continue;
        }
        if residual(other)? != here {
            return Ok(true);
        }
        tried.push(other);
    }
    Ok(false)
}

/// The error of a form that reads its unknown itself, where that may not be.
pub(super) fn refused<const D: usize>(form: &Form<D>) -> HistoryFailure {
    let of_step = form.fields().iter().find(|field| field.role == Role::Unknown(0));
    HistoryFailure::UnknownItself { form: form.name(), unknown: of_step.map_or("u", |field| field.name) }
}

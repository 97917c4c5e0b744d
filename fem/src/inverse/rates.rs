//! The rates of a step: which test function belongs to which control, and the rows that they give.

use std::sync::Arc;

use super::controls::Controls;
use super::error::HistoryFailure;
use crate::assemble::{Assembler, Parts};
use crate::contract::Role;
use crate::solve::any_form::AnyForm;
use crate::space::Space;

/// The test function of the derivative by the state before.
const BEFORE: &str = "before";
/// Prefix of the names of test functions of rates.
const BY: &str = "by_";

/// Assembles the rates of a step: adds those by the controls to the gradient, and gives that by the state before, on the space
/// of the states. Rates by numbers are tested with `constants`.
pub(super) fn add_rates<const D: usize>(
    rates: &dyn AnyForm<D>,
    step: usize,
    (controls, remembers): (&Controls<D>, bool),
    [states, constants]: [&Arc<Space<D>>; 2],
    assembler: &Assembler<D>,
    gradient: &mut [f64],
) -> Result<Vec<f64>, HistoryFailure> {
    let tests = tests(rates, controls, remembers)?;
    let space_of = |name: &&'static str| match *name {
        BEFORE => Some(states),
        name => controls.space_of_test(name, constants),
    };
    let spaces: Vec<&Arc<Space<D>>> = tests.iter().filter_map(space_of).collect();
    let rows = rates.residual(assembler, &[], &spaces, Parts::ALL)?;
    let mut rest = &rows[..];
    let mut by_before = vec![0.0; states.unknowns()];
    for (name, space) in tests.iter().zip(&spaces) {
        let (row, others) = rest.split_at(space.unknowns());
        match *name {
            BEFORE => by_before.copy_from_slice(row),
            name => controls.add_rate(name, step, row, gradient),
        }
        rest = others;
    }
    Ok(by_before)
}

/// The names of the controls, or [`BEFORE`], that the test functions of the rates belong to.
fn tests<const D: usize>(
    rates: &dyn AnyForm<D>,
    controls: &Controls<D>,
    remembers: bool,
) -> Result<Vec<&'static str>, HistoryFailure> {
    let mut tests = vec![];
    for field in rates.fields() {
        let name = field.name.strip_prefix(BY).unwrap_or("");
        match field.role {
            Role::Unknown(_) => {
                return Err(HistoryFailure::RateOfUnknown { form: rates.name(), unknown: field.name });
            }
            Role::Test(_) if name != BEFORE && !controls.tested().any(|own| own == name) => {
                return Err(HistoryFailure::UnknownTest { form: rates.name(), test: field.name });
            }
            Role::Test(_) => tests.push(name),
            _ => {}
        }
    }
    let missing = |name: &str, meaning| HistoryFailure::NotTested {
        form: rates.name(),
        name: name.to_owned(),
        meaning,
    };
    if let Some(name) = controls.tested().find(|name| !tests.contains(name)) {
        return Err(missing(name, "the derivative by this control is wanted"));
    }
    if remembers && !tests.contains(&BEFORE) {
        return Err(missing(BEFORE, "each step may depend on the state before it"));
    }
    Ok(tests)
}

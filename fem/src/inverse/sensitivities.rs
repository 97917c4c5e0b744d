//! The sensitivities of a step: which test function belongs to which control, and the rows that they give.

use std::sync::Arc;

use super::controls::{ControlError, Controls};
use super::error::HistoryFailure;
use super::step_equations::StepEquations;
use crate::contract::{Form, Role};
use crate::space::Space;

/// The test function of the derivative by the state before.
pub(super) const BEFORE: &str = "before";
/// Reason why it is wanted.
pub(super) const OF_BEFORE: &str = "each step may depend on the state before it";
/// Quantities that the operators of [`time`](crate::time) evaluate, as test functions of the derivatives by it are named.
pub(super) const OPERATORS: [&str; 3] = ["value", "rate", "second_rate"];
/// Prefix of the names of test functions of rates.
const BY: &str = "by_";

/// Whether a form of rates has the test function of the derivative by this.
pub(super) fn is_tested<const D: usize>(rates: &Form<D>, name: &str) -> bool {
    rates.fields().iter().any(|field| field.name.strip_prefix(BY) == Some(name))
}

/// The names of the test functions of derivatives by a quantity of each of these unknowns: that of the quantity, or of several unknowns
/// `before_u` and so on.
pub(super) fn names_of(quantity: &str, unknowns: &[&str]) -> Vec<String> {
    match unknowns {
        [_] => vec![quantity.to_owned()],
        _ => unknowns.iter().map(|unknown| format!("{quantity}_{unknown}")).collect(),
    }
}

/// The names of a form's unknowns, in their order.
pub(super) fn names_of_unknowns<const D: usize>(form: &Form<D>) -> Vec<&'static str> {
    let unknowns = form.fields().iter().filter_map(|field| match field.role {
        Role::Unknown(number) => Some((number, field.name)),
        _ => None,
    });
    let mut unknowns: Vec<_> = unknowns.collect();
    unknowns.sort_unstable();
    unknowns.into_iter().map(|(_, name)| name).collect()
}

/// A form with as many unknowns as a history has.
///
/// # Errors
/// [`HistoryFailure::Unknowns`].
pub(super) fn has_unknowns<const D: usize>(
    form: Form<D>,
    expected: usize,
) -> Result<Form<D>, HistoryFailure> {
    let found = names_of_unknowns(&form).len();
    match found == expected {
        true => Ok(form),
        false => Err(HistoryFailure::Unknowns { form: form.name(), found, expected }),
    }
}

/// Assembles the rates of a step: adds those by the controls to the gradient, and gives those by the states before, one after the other.
/// Rates by numbers are tested with `constants`.
pub(super) fn add_sensitivities<const D: usize>(
    rates: &Form<D>,
    step: usize,
    controls: &Controls<D>,
    before: &[(String, &Arc<Space<D>>, Wanted)],
    constants: &Arc<Space<D>>,
    equations: &StepEquations<'_, D>,
    gradient: &mut [f64],
) -> Result<Vec<f64>, HistoryFailure> {
    let own = before.iter();
    let own = own.map(|(name, space, wanted)| Own { name, meaning: OF_BEFORE, wanted: *wanted, space });
    let own: Vec<Own<'_, D>> = own.collect();
    Ok(rows_of(rates, &own, step, controls, constants, equations, gradient)?.concat())
}

/// A test function of a form of rates that belongs to no control, and why it is wanted, if it is.
pub(super) struct Own<'a, const D: usize> {
    pub name: &'a str,
    pub meaning: &'static str,
    pub wanted: Wanted,
    pub space: &'a Arc<Space<D>>,
}

/// The use of a test function's row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wanted {
    /// It has to be there.
    Yes,
    /// Zero where the form does not test it.
    IfTested,
    /// None: zero, and not assembled.
    No,
}

impl Wanted {
    /// Wanted, if so; else given where it is tested.
    pub fn when(so: bool) -> Self {
        if so { Wanted::Yes } else { Wanted::IfTested }
    }
}

/// Assembles a form of sensitivities. It adds the rows by the controls to the gradient, and returns those of its own test functions on their
/// spaces, zeros for one that is not wanted or missing.
pub(super) fn rows_of<const D: usize>(
    rates: &Form<D>,
    own: &[Own<'_, D>],
    step: usize,
    controls: &Controls<D>,
    constants: &Arc<Space<D>>,
    equations: &StepEquations<'_, D>,
    gradient: &mut [f64],
) -> Result<Vec<Vec<f64>>, HistoryFailure> {
    let tests = tests(rates, controls, own)?;
    let place = |name: &str| own.iter().position(|own| own.name == name);
    let space_of = |name: &&'static str| match place(name) {
        Some(place) => Some(own[place].space),
        None => controls.space_of_test(name, constants),
    };
    let spaces: Vec<&Arc<Space<D>>> = tests.iter().filter_map(space_of).collect();
    let unread = |name: &str| own.iter().any(|own| own.name == name && own.wanted == Wanted::No);
    let left_out: Vec<usize> = (0..tests.len()).filter(|number| unread(tests[*number])).collect();
    equations.check_given(rates)?;
    let rows = equations.assembler.residual_without(rates, &spaces, &left_out)?;
    let mut rest = &rows[..];
    let mut own_rows: Vec<Vec<f64>> = own.iter().map(|own| vec![0.0; own.space.unknowns()]).collect();
    let mut by_numbers = vec![];
    for (name, space) in tests.iter().zip(&spaces) {
        let (row, others) = rest.split_at(space.unknowns());
        match place(name) {
            Some(place) => own_rows[place] = equations.completed(Some(space), row.to_vec())?,
            None if controls.is_field(name) => {
                controls.add_rates(name, step, &equations.completed(Some(space), row.to_vec())?, gradient);
            }
            // The test functions of a space add up to one: the sum is the rate by a constant.
            None => by_numbers.push((*name, row.iter().sum::<f64>())),
        }
        rest = others;
    }
    let totals = equations.totals(by_numbers.iter().map(|(_, own)| *own).collect())?;
    by_numbers
        .iter()
        .zip(totals)
        .for_each(|((name, _), rate)| controls.add_rates(name, step, &[rate], gradient));
    Ok(own_rows)
}

/// The names of the controls, or of what else is tested, that the test functions of the rates belong to.
fn tests<const D: usize>(
    rates: &Form<D>,
    controls: &Controls<D>,
    own: &[Own<'_, D>],
) -> Result<Vec<&'static str>, HistoryFailure> {
    let mut tests = vec![];
    let known = |name: &str| {
        own.iter().any(|own| own.name == name) || controls.tested().any(|control| control == name)
    };
    for field in rates.fields() {
        let name = field.name.strip_prefix(BY).unwrap_or("");
        match field.role {
            Role::Unknown(_) => {
                return Err(HistoryFailure::RateOfUnknown { form: rates.name(), unknown: field.name });
            }
            Role::Test(_) if !known(name) => {
                return Err(HistoryFailure::UnknownTest { form: rates.name(), test: field.name });
            }
            Role::Test(_) => tests.push(name),
            _ => {}
        }
    }
    if let Some(name) = controls.tested().find(|name| own.iter().any(|own| own.name == *name)) {
        return Err(ControlError::Reserved { name: name.to_owned() }.into());
    }
    let missing = |name: &str, meaning| HistoryFailure::NotTested {
        form: rates.name(),
        name: name.to_owned(),
        meaning,
    };
    if let Some(name) = controls.tested().find(|name| !tests.contains(name)) {
        return Err(missing(name, "the derivative by this control is wanted"));
    }
    match own.iter().find(|own| own.wanted == Wanted::Yes && !tests.contains(&own.name)) {
        Some(own) => Err(missing(own.name, own.meaning)),
        None => Ok(tests),
    }
}

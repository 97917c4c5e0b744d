//! Next to the stages: [`Module`] → formulas, as its author would write them. Functions and `let`s stay names,
//! whose definitions are listed below; derivatives are taken by the rules of `differentiate`.

mod equations;
mod formula;
mod latex;
mod mathml;
mod names;
mod notation;
mod outlines;
mod page;
mod read;
mod same;
mod symbols;
#[cfg(test)]
mod tests;
mod unicode;

use crate::check::is_building_block;
use crate::parse::syntax::Module;
pub use equations::Shown;
use equations::{left_out, show};
use outlines::Outlines;

/// The formulas of each function that becomes one of the emitted module, where it has no mistake.
pub fn formulas(module: &Module, dimension: usize) -> Vec<Option<Shown>> {
    let mut outlines = Outlines::new(module, dimension);
    let functions = module.functions.iter().enumerate();
    let shown = |(index, function)| match is_building_block(function) {
        true => None,
        false => Some(show(&mut outlines, index).unwrap_or_else(|| left_out(&outlines, index))),
    };
    functions.map(shown).collect()
}

//! Beside the stages: [`Module`] → formulas, as its author would write them. Functions and `let`s stay names,
//! whose definitions are listed below; derivatives are taken by the rules of `differentiate`.

mod equations;
mod formula;
mod latex;
mod mathml;
mod notation;
mod outlines;
mod page;
mod read;
mod same;
mod simplify;
mod symbols;
#[cfg(test)]
mod tests;
mod unicode;

use crate::parse::syntax::Module;
pub use equations::Shown;
use equations::show;
use outlines::Outlines;

/// The formulas of each function of a module, where it has no mistake.
pub fn formulas(module: &Module, dimension: usize) -> Vec<Option<Shown>> {
    let mut outlines = Outlines::new(module, dimension);
    (0..module.functions.len()).map(|function| show(&mut outlines, function)).collect()
}

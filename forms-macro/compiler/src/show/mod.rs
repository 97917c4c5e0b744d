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

use crate::check::is_building_block;
use crate::parse::syntax::Module;
pub use equations::Shown;
use equations::show;
use outlines::Outlines;

/// The formulas of each function that becomes one of the emitted module, where it has no mistake.
pub fn formulas(module: &Module, dimension: usize) -> Vec<Option<Shown>> {
    let mut outlines = Outlines::new(module, dimension);
    let functions = module.functions.iter().enumerate();
    let shown =
        |(index, function)| if is_building_block(function) { None } else { show(&mut outlines, index) };
    functions.map(shown).collect()
}

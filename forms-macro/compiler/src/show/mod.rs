//! Beside the stages: [`Module`] → formulas, as its author would write them. Functions and `let`s stay names,
//! whose definitions are listed below; derivatives are taken by the rules of `differentiate`.

mod equations;
mod formula;
mod latex;
mod mathml;
mod notation;
mod outlines;
mod read;
mod simplify;
mod symbols;
#[cfg(test)]
mod tests;
mod unicode;

use crate::parse::syntax::Module;
pub use equations::Shown;
use equations::{Equation, show};
use notation::Notation;
use outlines::Outlines;

/// The formulas of each function of a module, where it has no mistake.
pub fn formulas(module: &Module, dimension: usize) -> Vec<Option<Shown>> {
    let mut outlines = Outlines::new(module, dimension);
    (0..module.functions.len()).map(|function| show(&mut outlines, function)).collect()
}

impl Shown {
    /// As lines of plain text.
    pub fn unicode(&self) -> String {
        let line = |equation: &Equation| {
            format!(
                "{} = {}",
                unicode::Unicode.print(&equation.left),
                unicode::Unicode.print(&equation.right)
            )
        };
        let mut lines = vec![line(&self.content)];
        lines.extend(self.derivatives.iter().map(|(_, equation)| line(equation)));
        if !self.definitions.is_empty() {
            lines.push("where".into());
            lines.extend(self.definitions.iter().map(|equation| format!("  {}", line(equation))));
        }
        lines.join("\n")
    }
}

//! After `differentiate`: the additive parts of the residual with their tangents.

use super::Dump;
use super::checked::term_lines;
use super::tensors::{field_lines, lines};
use crate::differentiate::Derived;
use crate::parse::syntax::Module;

impl Dump {
    /// Fields with the trial functions, nodes free of derivatives, parts and their tangents.
    pub fn differentiated(&mut self, module: &Module, derived: &Derived) {
        let name = module.functions[derived.function].name.to_string();
        if !self.wants(&name, derived.dimension) {
            return;
        }
        self.heading("differentiated", &name, derived.dimension);
        let parts = derived.residual.iter();
        let mut roots: Vec<_> = parts
            .flat_map(|part| part.tangent.iter().map(|(_, node)| *node).chain([part.term.density]))
            .chain(derived.density.iter().map(|term| term.density))
            .chain(derived.value)
            .collect();
        roots.sort_unstable();
        self.text += &format!("fields:\n{}nodes:\n", field_lines(&derived.fields));
        self.text += &lines(&derived.arena, &derived.fields, &roots);
        for part in &derived.residual {
            self.text +=
                &format!("residual on {}: t{}\n", module.regions[part.term.region].name, part.term.density.0);
            for (trial, node) in &part.tangent {
                self.text += &format!("  tangent by {}: t{}\n", derived.fields[*trial].name, node.0);
            }
        }
        self.text += &term_lines(module, &derived.density);
        if let Some(value) = derived.value {
            self.text += &format!("value: t{}\n", value.0);
        }
    }
}

//! After `check`: the function with its calls inlined.

use super::Dump;
use super::tensors::{field_lines, lines};
use crate::check::{CheckedFunction, Content, Term};
use crate::parse::syntax::Module;
use crate::tensor::Tensor;

impl Dump {
    /// Fields, nodes, and the integrals made of them.
    pub fn checked(&mut self, module: &Module, function: &CheckedFunction) {
        let name = module.functions[function.function].name.to_string();
        if !self.wants(&name, function.dimension) {
            return;
        }
        self.heading("checked", &name, function.dimension);
        let (kind, terms): (&str, &[Term]) = match &function.content {
            Content::Form(terms) => ("Form", terms),
            Content::Energy(terms) => ("Energy", terms),
            Content::Functional(terms) => ("Functional", terms),
            Content::Value(_) => ("Value", &[]),
        };
        let mut roots: Vec<Tensor> = terms.iter().map(|term| term.density).collect();
        if let Content::Value(value) = &function.content {
            roots.push(*value);
        }
        self.text += &format!("{kind}, fields:\n{}nodes:\n", field_lines(&function.fields));
        self.text += &lines(&function.arena, &function.fields, &roots);
        self.text += &term_lines(module, terms);
    }
}

/// `integral(Omega, t7)`
pub fn term_lines(module: &Module, terms: &[Term]) -> String {
    terms
        .iter()
        .map(|term| format!("integral({}, t{})\n", module.regions[term.region].name, term.density.0))
        .collect()
}

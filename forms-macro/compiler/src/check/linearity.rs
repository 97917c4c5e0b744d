//! Linearity in the test functions, as a small algebra: each node is free of test functions, or linear
//! in a set of them; anything else is a mistake on that node's tokens.

use std::collections::HashMap;

use super::Term;
use crate::diagnostics::{Diagnostics, Place};
use crate::parse::syntax::{ArgumentRole, Function};
use crate::tensor::{Arena, FieldInfo, FieldRole, Operator, Tensor, Variable};

/// The test functions (by field index) in which a node is linear; empty: free of them.
type Tests = Vec<usize>;

struct Algebra<'a> {
    arena: &'a Arena,
    fields: &'a [FieldInfo],
    diagnostics: &'a mut Diagnostics,
    known: HashMap<Tensor, Option<Tests>>,
}

/// A `Form`: every term is linear in exactly one test function.
pub fn check_form(
    function: &Function,
    arena: &Arena,
    fields: &[FieldInfo],
    terms: &[Term],
    diagnostics: &mut Diagnostics,
) -> bool {
    let tests: Vec<&str> = fields
        .iter()
        .filter(|field| matches!(field.role, FieldRole::Test(_)))
        .map(|field| field.name.as_str())
        .collect();
    if tests.is_empty() {
        diagnostics.error_with_help(
            Place::of(&function.name),
            format!("the form `{}` has no test function", function.name),
            "add an argument `v: Test<..>`, or declare it `-> Functional` or `-> Energy`",
        );
        return false;
    }
    let mut algebra = Algebra { arena, fields, diagnostics, known: HashMap::new() };
    let mut right = true;
    for term in terms {
        match algebra.tests(term.density) {
            Some(found) if found.is_empty() && !arena.is_zero(term.density) => {
                algebra.without(term.density, &tests);
                right = false;
            }
            Some(_) => {}
            None => right = false,
        }
    }
    right
}

/// An `Energy` or `Functional`: no test function at all.
pub fn check_functional(function: &Function, diagnostics: &mut Diagnostics) -> bool {
    let mut right = true;
    for argument in function.arguments.iter().filter(|argument| argument.role == ArgumentRole::Test) {
        diagnostics.error_with_help(
            Place::of(&argument.name),
            format!("`{}` is a number: it has no test function", function.name),
            "declare it `-> Form`, or drop this argument",
        );
        right = false;
    }
    right
}

impl Algebra<'_> {
    /// The tests in which a node is linear; `None` after a report.
    fn tests(&mut self, tensor: Tensor) -> Option<Tests> {
        if let Some(known) = self.known.get(&tensor) {
            return known.clone();
        }
        let found = self.find(tensor);
        self.known.insert(tensor, found.clone());
        found
    }

    fn find(&mut self, tensor: Tensor) -> Option<Tests> {
        use Operator::*;
        let operator = self.arena.node(tensor).operator.clone();
        match operator {
            Number(_) | Zero | Identity | SymmetricIdentity | Parameter(_) | Geometry(_) => Some(vec![]),
            Field { field, .. } => Some(match self.fields[field].role {
                FieldRole::Test(_) => vec![field],
                _ => vec![],
            }),
            Negate(a)
            | Map(_, a)
            | Component(a, _)
            | Slice(a, _)
            | Restrict(_, a)
            | Gradient(a)
            | Partial(a, _) => self.tests(a),
            Scale(a, b)
            | Contract(a, b)
            | DoubleContract(a, b)
            | Cross(a, b)
            | MixedCofactor(a, b)
            | Inner(a, b)
            | Outer(a, b) => self.product(tensor, a, b),
            Add(a, b) => self.sum(&[a, b]),
            Stack(entries) => self.sum(&entries),
            Select(truth, a, b) => {
                for operand in truth.operands() {
                    self.free(operand, "a comparison")?;
                }
                self.sum(&[a, b])
            }
            Divide(a, b) | DivideOrZero(a, b) => {
                self.free(b, "a denominator")?;
                self.tests(a)
            }
            Determinant(a) | Inverse(a) | Cofactor(a) => self.free(a, "a nonlinear operation"),
            Apply(_, a) | Norm(a) => self.free(a, "a nonlinear function"),
            Power(a, b) | Atan2(a, b) | Minimum(a, b) | Maximum(a, b) => {
                self.free(a, "a nonlinear function")?;
                self.free(b, "a nonlinear function")
            }
            External { arguments, .. } => {
                for argument in arguments {
                    self.free(argument, "a function that may be nonlinear")?;
                }
                Some(vec![])
            }
            // The derivative is linear in its direction, and in what the expression was linear in.
            Gateaux { expression, variable, direction } => {
                // A derivative by a test function puts the direction in its place.
                if let Variable::Field(varied) = variable
                    && matches!(self.fields[varied].role, FieldRole::Test(_))
                {
                    return match self.tests(expression)?.contains(&varied) {
                        true => self.tests(direction),
                        false => Some(vec![]),
                    };
                }
                self.product(tensor, expression, direction)
            }
            // Formulas are made of what was checked already.
            Named(_) => Some(vec![]),
        }
    }

    fn product(&mut self, whole: Tensor, a: Tensor, b: Tensor) -> Option<Tests> {
        let (first, second) = (self.tests(a), self.tests(b));
        let (first, second) = (first?, second?);
        match (first.first(), second.first()) {
            (Some(v), Some(w)) if v == w => {
                let name = &self.fields[*v].name;
                let message = format!(
                    "this product is not linear in the test function: `{name}` stands in both factors"
                );
                let help = "keep it in one of them; for an energy declare `-> Energy` and leave the test function out";
                self.diagnostics.error_with_help(self.arena.place(whole), message, help);
                None
            }
            (Some(v), Some(w)) => {
                let (v, w) = (&self.fields[*v].name, &self.fields[*w].name);
                let message = format!("two different test functions in one term: `{v}` and `{w}`");
                self.diagnostics.error_with_help(
                    self.arena.place(whole),
                    message,
                    "each term has one test function: one of the two was meant to be an unknown, or another term",
                );
                None
            }
            _ => Some([first, second].concat()),
        }
    }

    fn sum(&mut self, parts: &[Tensor]) -> Option<Tests> {
        let found: Vec<_> = parts.iter().map(|part| self.tests(*part)).collect();
        let mut all: Tests = Vec::new();
        for tests in &found {
            all.extend(tests.as_ref()?);
        }
        all.sort_unstable();
        all.dedup();
        if all.is_empty() {
            return Some(all);
        }
        let mut right = true;
        for (part, tests) in parts.iter().zip(&found) {
            if tests.as_ref().is_some_and(Vec::is_empty) && !self.arena.is_zero(*part) {
                let names: Vec<&str> = all.iter().map(|test| self.fields[*test].name.as_str()).collect();
                self.without(*part, &names);
                right = false;
            }
        }
        right.then_some(all)
    }

    fn without(&mut self, part: Tensor, names: &[&str]) {
        let message = format!("this term does not contain the test function `{}`", names.join("` or `"));
        let help = "every term of a form is linear in a test function: multiply by it, or move the term out";
        self.diagnostics.error_with_help(self.arena.place(part), message, help);
    }

    fn free(&mut self, a: Tensor, user: &str) -> Option<Tests> {
        let found = self.tests(a)?;
        if let Some(test) = found.first() {
            let name = &self.fields[*test].name;
            let message = format!("not linear in the test function `{name}`: it stands inside {user}");
            let help = "a form is a sum of terms, each a product of one test function with things free of it";
            self.diagnostics.error_with_help(self.arena.place(a), message, help);
            return None;
        }
        Some(found)
    }
}

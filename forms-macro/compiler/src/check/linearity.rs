//! Linearity in the test functions, as a small algebra: each node is free of test functions, or linear
//! in a set of them; anything else is a mistake on that node's tokens.

use std::collections::HashMap;

use super::Term;
use crate::diagnostics::{Diagnostics, SourceSpan};
use crate::parse::syntax::{ArgumentRole, Function};
use crate::tensor::{Arena, FieldInfo, FieldRole, Operator, Tensor, Variable};

/// Dependence of a node on the test functions.
#[derive(Clone)]
enum Dependence {
    /// It is zero whatever they are: linear in each of them, and free of them, too.
    Zero,
    /// It holds none.
    Free,
    /// It is linear in these, by field index.
    Linear(Vec<usize>),
}

use Dependence::{Free, Linear, Zero};

struct Algebra<'a> {
    arena: &'a Arena,
    fields: &'a [FieldInfo],
    diagnostics: &'a mut Diagnostics,
    known: HashMap<Tensor, Option<Dependence>>,
    regular: HashMap<Tensor, bool>,
    /// The argument of the innermost nonlinear operation around the node at hand, and what that operation is.
    inside: Option<(Tensor, &'static str)>,
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
            SourceSpan::of(&function.name),
            format!("the form `{}` has no test function", function.name),
            "add an argument `v: Test<..>`, or declare it `-> Functional` or `-> Energy`",
        );
        return false;
    }
    let mut algebra =
        Algebra { arena, fields, diagnostics, known: HashMap::new(), regular: HashMap::new(), inside: None };
    let mut right = true;
    for term in terms {
        match algebra.dependence(term.density) {
            Some(Free) => {
                algebra.without(term.density, &tests);
                right = false;
            }
            Some(Zero | Linear(_)) => {}
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
            SourceSpan::of(&argument.name),
            format!("`{}` is a number: it has no test function", function.name),
            "declare it `-> Form`, or drop this argument",
        );
        right = false;
    }
    right
}

impl Algebra<'_> {
    /// Dependence of a node on the test functions; `None` after a report.
    fn dependence(&mut self, tensor: Tensor) -> Option<Dependence> {
        if let Some(known) = self.known.get(&tensor) {
            return known.clone();
        }
        let found = self.find(tensor);
        self.known.insert(tensor, found.clone());
        found
    }

    fn find(&mut self, tensor: Tensor) -> Option<Dependence> {
        use Operator::*;
        let operator = self.arena.node(tensor).operator.clone();
        match operator {
            Number(_) | Operator::Zero if self.arena.is_zero(tensor) => Some(Dependence::Zero),
            Number(_)
            | Operator::Zero
            | Identity
            | SymmetricIdentity
            | Parameter(_)
            | Geometry(_)
            | Sliding(..) => Some(Free),
            Field { field, .. } => Some(match self.fields[field].role {
                FieldRole::Test(_) => Linear(vec![field]),
                _ => Free,
            }),
            Negate(a)
            | Map(_, a)
            | Component(a, _)
            | Slice(a, _)
            | CellMean(a)
            | FacetMean(a)
            | Restrict(_, a)
            | Opposite(a, _)
            | Gradient(a)
            | Partial(a, _) => self.dependence(a),
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
                match self.dependence(a)? {
                    Dependence::Zero if !self.is_constant(b) => Some(Free),
                    other => Some(other),
                }
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
                Some(Free)
            }
            // The derivative is linear in its direction, and in what the expression was linear in.
            Gateaux { expression, variable, direction } => {
                // A derivative by a test function puts the direction in its place.
                if let Variable::Field(varied) = variable
                    && matches!(self.fields[varied].role, FieldRole::Test(_))
                {
                    return match self.dependence(expression)? {
                        Linear(tests) if tests.contains(&varied) => self.dependence(direction),
                        _ => Some(Dependence::Zero),
                    };
                }
                self.product(tensor, expression, direction)
            }
            // Formulas are made of what was checked already.
            Named(_) => Some(Free),
        }
    }

    fn product(&mut self, whole: Tensor, a: Tensor, b: Tensor) -> Option<Dependence> {
        let (first, second) = (self.dependence(a), self.dependence(b));
        let (first, second) = match (first?, second?) {
            (Zero, Zero) => return Some(Zero),
            // Zero times a test function is linear in it.
            (Zero, Linear(tests)) | (Linear(tests), Zero) => return Some(Linear(tests)),
            (Zero, Free) => return Some(if self.is_regular(b) { Zero } else { Free }),
            (Free, Zero) => return Some(if self.is_regular(a) { Zero } else { Free }),
            (Free, other) | (other, Free) => return Some(other),
            (Linear(first), Linear(second)) => (first, second),
        };
        let span = self.arena.span(whole);
        let shared = first.iter().find(|test| second.contains(test));
        if let Some(test) = shared {
            let name = &self.fields[*test].name;
            let message =
                format!("this product is not linear in the test function: `{name}` stands in both factors");
            let help =
                "keep it in one of them; for an energy declare `-> Energy` and leave the test function out";
            self.diagnostics.error_with_help(span, message, help);
            return None;
        }
        let [v, w] =
            [&first, &second].map(|tests| tests.first().map(|test| self.fields[*test].name.as_str()));
        let message = format!(
            "two different test functions in one term: `{}` and `{}`",
            v.unwrap_or_default(),
            w.unwrap_or_default()
        );
        let help =
            "each term has one test function: one of the two was meant to be an unknown, or another term";
        self.diagnostics.error_with_help(span, message, help);
        None
    }

    /// Is it a number wherever fields are? Zero times anything else may be none, and stays in the form. Some that are
    /// regular are not known to be.
    fn is_regular(&mut self, tensor: Tensor) -> bool {
        use Operator::*;
        if let Some(known) = self.regular.get(&tensor) {
            return *known;
        }
        let operator = self.arena.node(tensor).operator.clone();
        let itself = match &operator {
            Divide(_, divisor) => self.is_constant(*divisor),
            DivideOrZero(..) | Inverse(_) | Apply(..) | Norm(_) | Power(..) | External { .. } => false,
            Gateaux { .. } | Partial(..) => false,
            _ => true,
        };
        let found = itself && operator.operands().into_iter().all(|operand| self.is_regular(operand));
        self.regular.insert(tensor, found);
        found
    }

    /// Is it a number or a parameter? Forms divide by those that are not zero.
    fn is_constant(&self, tensor: Tensor) -> bool {
        matches!(self.arena.node(tensor).operator, Operator::Number(_) | Operator::Parameter(_))
    }

    /// Zeros are linear in whatever the other parts are.
    fn sum(&mut self, parts: &[Tensor]) -> Option<Dependence> {
        let found: Vec<_> = parts.iter().map(|part| self.dependence(*part)).collect();
        let found = found.into_iter().collect::<Option<Vec<_>>>()?;
        let mut all: Vec<usize> = Vec::new();
        for one in &found {
            if let Linear(tests) = one {
                all.extend(tests);
            }
        }
        all.sort_unstable();
        all.dedup();
        if all.is_empty() {
            let vanishes = found.iter().all(|one| matches!(one, Zero));
            return Some(if vanishes { Zero } else { Free });
        }
        // A sum with other terms inside of a nonlinear operation: what is wrong is that the test function is there at all.
        if let Some((argument, user)) = self.inside
            && found.iter().any(|one| matches!(one, Free))
        {
            self.not_linear(argument, all[0], user);
            return None;
        }
        let mut right = true;
        for (part, one) in parts.iter().zip(&found) {
            if matches!(one, Free) {
                let names: Vec<&str> = all.iter().map(|test| self.fields[*test].name.as_str()).collect();
                self.without(*part, &names);
                right = false;
            }
        }
        right.then_some(Linear(all))
    }

    fn without(&mut self, part: Tensor, names: &[&str]) {
        let message = format!("this term does not contain the test function `{}`", names.join("` or `"));
        let help = "every term of a form is linear in a test function: multiply by it, or move the term out";
        self.diagnostics.error_with_help(self.arena.span(part), message, help);
    }

    fn free(&mut self, a: Tensor, user: &'static str) -> Option<Dependence> {
        let outside = self.inside.replace((a, user));
        let found = self.dependence(a);
        self.inside = outside;
        if let Linear(tests) = &found? {
            let test = tests.first().copied().unwrap_or_default();
            self.not_linear(a, test, user);
            return None;
        }
        Some(Free)
    }

    fn not_linear(&mut self, argument: Tensor, test: usize, user: &str) {
        let name = &self.fields[test].name;
        let message = format!("not linear in the test function `{name}`: it stands inside {user}");
        let help = "a form is a sum of terms, each a product of one test function with things free of it";
        self.diagnostics.error_with_help(self.arena.span(argument), message, help);
    }
}

//! Walks a function's body with its arguments bound, inlining the functions that it calls.

use std::collections::HashMap;

use proc_macro2::Ident;

use super::Term;
use super::builtins::{self, Builtin, Constant};
use super::operators::{describe, rank_name};
use crate::diagnostics::{Diagnostics, Place};
use crate::parse::syntax::*;
use crate::tensor::{Arena, FieldInfo, Geometry, Operator, Shape, Tensor, Truth, Variable};

/// What an expression stands for.
#[derive(Clone)]
pub enum Value {
    Tensor(Tensor),
    /// Integrals.
    Form(Vec<Term>),
}

/// The state of a walk. Methods return `None` after a report.
pub struct Evaluator<'a> {
    pub(super) module: &'a Module,
    pub(super) dimension: usize,
    pub(super) arena: Arena,
    pub(super) diagnostics: &'a mut Diagnostics,
    /// Functions being inlined, outermost first.
    calls: Vec<usize>,
    /// Where the operands of the operation at hand stand (a `let` name's value stands elsewhere).
    pub(super) uses: HashMap<Tensor, Place>,
    /// Field index of each `Given` member.
    given: HashMap<String, (usize, Shape)>,
}

/// Names of one function: arguments and `let`s. `None`: its value had a mistake, which was reported.
type Scope = HashMap<String, Option<Value>>;

impl<'a> Evaluator<'a> {
    pub fn new(module: &'a Module, dimension: usize, diagnostics: &'a mut Diagnostics) -> Self {
        Evaluator {
            module,
            dimension,
            arena: Arena::default(),
            diagnostics,
            calls: vec![],
            uses: HashMap::new(),
            given: HashMap::new(),
        }
    }

    /// The function by itself: its arguments are the leading `fields`.
    pub fn enter(&mut self, function: usize, fields: &[FieldInfo]) -> Option<Value> {
        let arguments = &self.module.functions[function].arguments;
        let mut values = Vec::new();
        for (index, argument) in arguments.iter().enumerate() {
            let operator = Operator::Field { field: index, gradient: false };
            let node = self.arena.push(operator, fields[index].shape.clone(), Place::of(&argument.name));
            values.push(Some(Value::Tensor(node)));
        }
        for (index, field) in fields.iter().enumerate().skip(arguments.len()) {
            self.given.insert(field.name.clone(), (index, field.shape.clone()));
        }
        self.inline(function, values)
    }

    fn inline(&mut self, index: usize, values: Vec<Option<Value>>) -> Option<Value> {
        let function = &self.module.functions[index];
        let body = function.body.as_ref()?;
        let names = function.arguments.iter().map(|argument| argument.name.to_string());
        let scope: Scope = names.zip(values).collect();
        self.calls.push(index);
        let value = self.block(body, &scope);
        self.calls.pop();
        let value = value?;
        match (&value, function.output) {
            (Value::Tensor(tensor), Output::Value(rank)) => {
                if self.arena.shape(*tensor) != rank.shape(self.dimension) {
                    let message = format!(
                        "`{}` is declared to give a `{}`, its body gives {}",
                        function.name,
                        rank_name(rank),
                        self.describe(*tensor)
                    );
                    self.diagnostics.error(body.result.place, message);
                    return None;
                }
            }
            (Value::Form(_), Output::Form | Output::Energy | Output::Functional) => {}
            (Value::Tensor(_), _) => {
                self.diagnostics.error_with_help(
                    body.result.place,
                    format!("`{}` is declared to give integrals, its body gives a density", function.name),
                    "write `integral(Region, density)`",
                );
                return None;
            }
            (Value::Form(_), Output::Value(rank)) => {
                let message = format!(
                    "`{}` is declared to give a `{}`, its body gives integrals",
                    function.name,
                    rank_name(rank)
                );
                self.diagnostics.error(body.result.place, message);
                return None;
            }
        }
        Some(value)
    }

    fn block(&mut self, block: &Block, outer: &Scope) -> Option<Value> {
        let mut scope = outer.clone();
        for (name, expression) in &block.lets {
            super::check_not_built_in(name, self.diagnostics);
            let value = self.evaluate(expression, &scope);
            scope.insert(name.to_string(), value);
        }
        self.evaluate(&block.result, &scope)
    }

    fn evaluate(&mut self, expression: &Expression, scope: &Scope) -> Option<Value> {
        let place = expression.place;
        let tensor = match &expression.kind {
            ExpressionKind::Mistake => return None,
            ExpressionKind::Number(value) => self.arena.push(Operator::Number(*value), vec![], place),
            ExpressionKind::Name(name) => return self.name(name, place, scope),
            ExpressionKind::Call(name, arguments) => return self.call(name, arguments, place, scope),
            ExpressionKind::Block(block) => return self.block(block, scope),
            ExpressionKind::Negate(inner) => match self.evaluate(inner, scope)? {
                Value::Form(terms) => return Some(Value::Form(self.scale_terms(terms, None, place))),
                Value::Tensor(inner) => {
                    let shape = self.arena.shape(inner).to_vec();
                    self.arena.push(Operator::Negate(inner), shape, place)
                }
            },
            ExpressionKind::Declared(rank, inner) => {
                let tensor = self.tensor(inner, scope, "`let`")?;
                if self.arena.shape(tensor) != rank.shape(self.dimension) {
                    let message =
                        format!("declared to be a `{}`, this is {}", rank_name(*rank), self.describe(tensor));
                    self.diagnostics.error(inner.place, message);
                    return None;
                }
                tensor
            }
            ExpressionKind::Binary(operator, left, right) => {
                let places = [left.place, right.place];
                let (left, right) = (self.evaluate(left, scope), self.evaluate(right, scope));
                match (left?, right?) {
                    (Value::Tensor(left), Value::Tensor(right)) => {
                        self.uses = [left, right].into_iter().zip(places).collect();
                        self.binary(*operator, left, right, place)?
                    }
                    (left, right) => return self.binary_form(*operator, left, right, place),
                }
            }
            ExpressionKind::Index(base, indices) => {
                let base = self.tensor(base, scope, "an index")?;
                self.component(base, indices, place)?
            }
            ExpressionKind::Array(entries) => {
                let entries: Vec<_> =
                    entries.iter().map(|entry| self.tensor(entry, scope, "an array")).collect();
                self.stack(entries.into_iter().collect::<Option<_>>()?, place)?
            }
            ExpressionKind::If(condition, taken, otherwise) => {
                let truth = self.condition(condition, scope);
                let (taken, otherwise) = (self.block(taken, scope), self.block(otherwise, scope));
                match (truth?, taken?, otherwise?) {
                    (truth, Value::Tensor(taken), Value::Tensor(otherwise)) => {
                        self.select(truth, taken, otherwise, place)?
                    }
                    _ => {
                        let help =
                            "put the `if` into the density: `integral(Region, if .. { .. } else { .. })`";
                        self.diagnostics.error_with_help(
                            place,
                            "an `if` cannot choose between integrals",
                            help,
                        );
                        return None;
                    }
                }
            }
        };
        Some(Value::Tensor(tensor))
    }

    /// An expression that must not be an integral.
    fn tensor(&mut self, expression: &Expression, scope: &Scope, user: &str) -> Option<Tensor> {
        match self.evaluate(expression, scope)? {
            Value::Tensor(tensor) => Some(tensor),
            Value::Form(_) => {
                self.diagnostics
                    .error(expression.place, format!("{user} takes a value, this is a sum of integrals"));
                None
            }
        }
    }

    /// `if c { 0 } else { A }`: a literal zero takes the other branch's shape.
    fn select(&mut self, truth: Truth, taken: Tensor, otherwise: Tensor, place: Place) -> Option<Tensor> {
        let (first, second) = (self.arena.shape(taken).to_vec(), self.arena.shape(otherwise).to_vec());
        let shape = match (self.arena.is_zero(taken), self.arena.is_zero(otherwise)) {
            _ if first == second => first,
            (true, _) => second,
            (_, true) => first,
            _ => {
                let message = format!(
                    "the two branches of `if` differ: {} and {}",
                    self.describe(taken),
                    self.describe(otherwise)
                );
                self.diagnostics.error(place, message);
                return None;
            }
        };
        let mut fit = |branch: Tensor| match self.arena.shape(branch) == shape {
            true => branch,
            false => self.arena.push(Operator::Zero, shape.clone(), place),
        };
        let (taken, otherwise) = (fit(taken), fit(otherwise));
        Some(self.arena.push(Operator::Select(truth, taken, otherwise), shape, place))
    }

    fn condition(&mut self, condition: &Condition, scope: &Scope) -> Option<Truth> {
        Some(match condition {
            Condition::Compare(comparison, left, right) => {
                let left = self.tensor(left, scope, "a comparison");
                let right = self.tensor(right, scope, "a comparison");
                let left = left.and_then(|left| self.expect_scalar(left, "a comparison"));
                let right = right.and_then(|right| self.expect_scalar(right, "a comparison"));
                Truth::Compare(*comparison, left?, right?)
            }
            Condition::And(first, second) => {
                let (first, second) = (self.condition(first, scope), self.condition(second, scope));
                Truth::And(Box::new(first?), Box::new(second?))
            }
            Condition::Or(first, second) => {
                let (first, second) = (self.condition(first, scope), self.condition(second, scope));
                Truth::Or(Box::new(first?), Box::new(second?))
            }
            Condition::Not(inner) => Truth::Not(Box::new(self.condition(inner, scope)?)),
        })
    }

    fn name(&mut self, name: &Ident, place: Place, scope: &Scope) -> Option<Value> {
        let text = name.to_string();
        if let Some(value) = scope.get(&text) {
            // A field is a field wherever it is named: mistakes are told where it is used.
            if let Some(Value::Tensor(tensor)) = value {
                let node = self.arena.node(*tensor).clone();
                if matches!(node.operator, Operator::Field { gradient: false, .. } | Operator::Parameter(_)) {
                    return Some(Value::Tensor(self.arena.push(node.operator, node.shape, place)));
                }
            }
            return value.clone();
        }
        if let Some((field, shape)) = self.given.get(&text).cloned() {
            let operator = Operator::Field { field, gradient: false };
            return Some(Value::Tensor(self.arena.push(operator, shape, place)));
        }
        let members = self.module.data.iter().flat_map(|data| &data.members);
        if let Some((index, member)) = members.enumerate().find(|(_, member)| member.name == *name) {
            let shape = member.rank.shape(self.dimension);
            return Some(Value::Tensor(self.arena.push(Operator::Parameter(index), shape, place)));
        }
        if let Some(constant) = builtins::constant(&text) {
            let d = self.dimension;
            let (operator, shape) = match constant {
                Constant::Geometry(geometry) => {
                    let vector = matches!(geometry, Geometry::Normal | Geometry::Position);
                    (Operator::Geometry(geometry), if vector { vec![d] } else { vec![] })
                }
                Constant::Identity => (Operator::Identity, vec![d, d]),
                Constant::Dimension => (Operator::Number(d as f64), vec![]),
                Constant::Pi => (Operator::Number(std::f64::consts::PI), vec![]),
            };
            return Some(Value::Tensor(self.arena.push(operator, shape, place)));
        }
        if !self.module.is_mistaken(name) {
            self.unknown_name(name, place, scope);
        }
        None
    }

    fn unknown_name(&mut self, name: &Ident, place: Place, scope: &Scope) {
        let text = name.to_string();
        if text.contains('·') {
            let help = format!("write `dot({})`", text.replace('·', ", "));
            self.diagnostics.error_with_help(
                place,
                format!("`{text}` is one identifier to Rust, not a product"),
                help,
            );
        } else if self.module.regions.iter().any(|region| region.name == *name) {
            let help = format!("write `integral({text}, density)`");
            self.diagnostics.error_with_help(place, format!("`{text}` is a region, not a value"), help);
        } else if builtins::builtin(&text).is_some() || self.function(name).is_some() {
            self.diagnostics.error_with_help(
                place,
                format!("`{text}` is a function, not a value"),
                format!("write `{text}(..)`"),
            );
        } else {
            let members =
                self.module.data.iter().flat_map(|data| &data.members).map(|member| member.name.to_string());
            let known: Vec<String> = scope
                .keys()
                .cloned()
                .chain(members)
                .chain(builtins::CONSTANTS.iter().map(|entry| entry.0.to_string()))
                .collect();
            let message = format!("the name `{text}` is not known here");
            match builtins::nearest(&text, known.iter().map(String::as_str)) {
                Some(near) => {
                    self.diagnostics.error_with_help(place, message, format!("did you mean `{near}`?"))
                }
                None => {
                    let help =
                        "arguments, `let` names, members of the data struct and built-in names are known";
                    self.diagnostics.error_with_help(place, message, help);
                }
            }
        }
    }

    fn function(&self, name: &Ident) -> Option<usize> {
        self.module.functions.iter().position(|function| function.name == *name)
    }

    fn call(&mut self, name: &Ident, arguments: &[Expression], place: Place, scope: &Scope) -> Option<Value> {
        let text = name.to_string();
        if let Some(index) = self.function(name) {
            return self.call_function(index, name, arguments, place, scope);
        }
        let Some((builtin, count, usage)) = builtins::builtin(&text) else {
            if !self.module.is_mistaken(name) {
                self.unknown_function(name);
            }
            return None;
        };
        if builtin == Builtin::Integral && arguments.len() == 1 {
            let help = match self.module.regions.first() {
                Some(region) => format!("write `integral({}, density)`", region.name),
                None => "declare `#[cells] pub struct Omega;` and write `integral(Omega, density)`".into(),
            };
            self.diagnostics.error_with_help(place, "this integral has no region", help);
            return None;
        }
        if arguments.len() != count {
            let message = format!(
                "`{text}` takes {count} argument{}, not {}",
                if count == 1 { "" } else { "s" },
                arguments.len()
            );
            self.diagnostics.error_with_help(place, message, format!("write `{usage}`"));
            return None;
        }
        match builtin {
            Builtin::Integral => return self.integral(&arguments[0], &arguments[1], place, scope),
            Builtin::Derivative => return self.derivative(arguments, place, scope),
            Builtin::Partial => return self.partial(arguments, place, scope).map(Value::Tensor),
            _ => {}
        }
        let values: Vec<_> =
            arguments.iter().map(|argument| self.tensor(argument, scope, &format!("`{text}`"))).collect();
        let values = values.into_iter().collect::<Option<Vec<_>>>()?;
        self.uses = values.iter().copied().zip(arguments.iter().map(|argument| argument.place)).collect();
        let a = values[0];
        let tensor = match builtin {
            Builtin::Dot => self.dot(a, values[1], place)?,
            Builtin::Inner => self.inner(a, values[1], place)?,
            Builtin::Outer => self.outer(a, values[1], place)?,
            Builtin::Map(map) => self.of_tensor(a, place, &text, |a| Operator::Map(map, a))?,
            Builtin::Determinant => self.of_tensor(a, place, &text, Operator::Determinant)?,
            Builtin::Inverse => self.of_tensor(a, place, &text, Operator::Inverse)?,
            Builtin::Cofactor => self.of_tensor(a, place, &text, Operator::Cofactor)?,
            Builtin::Gradient => self.gradient(a, place)?,
            Builtin::Divergence => self.divergence(a, place)?,
            Builtin::Strain => self.strain(a, place)?,
            Builtin::Apply(function) => {
                let a = self.expect_scalar(a, &text)?;
                self.arena.push(Operator::Apply(function, a), vec![], place)
            }
            Builtin::Power | Builtin::Minimum | Builtin::Maximum => {
                let (a, b) = (self.expect_scalar(a, &text), self.expect_scalar(values[1], &text));
                let (a, b) = (a?, b?);
                let operator = match builtin {
                    Builtin::Power => Operator::Power(a, b),
                    Builtin::Minimum => Operator::Minimum(a, b),
                    _ => Operator::Maximum(a, b),
                };
                self.arena.push(operator, vec![], place)
            }
            Builtin::Integral | Builtin::Derivative | Builtin::Partial => return None,
        };
        Some(Value::Tensor(tensor))
    }

    fn unknown_function(&mut self, name: &Ident) {
        let functions: Vec<String> =
            self.module.functions.iter().map(|function| function.name.to_string()).collect();
        let known =
            functions.iter().map(String::as_str).chain(builtins::BUILTINS.iter().map(|entry| entry.0));
        let message = format!("the function `{name}` is not known here");
        match builtins::nearest(&name.to_string(), known) {
            Some(near) => {
                self.diagnostics.error_with_help(Place::of(name), message, format!("did you mean `{near}`?"))
            }
            None => {
                let help = format!("declare `fn {name}(..)` in this module");
                self.diagnostics.error_with_help(Place::of(name), message, help);
            }
        }
    }

    fn call_function(
        &mut self,
        index: usize,
        name: &Ident,
        arguments: &[Expression],
        place: Place,
        scope: &Scope,
    ) -> Option<Value> {
        let function = &self.module.functions[index];
        if self.calls.contains(&index) {
            let message = match self.calls.last() {
                Some(last) if *last == index => {
                    format!("`{name}` calls itself: a weak form cannot be recursive")
                }
                _ => format!("`{name}` is being computed already: a weak form cannot be recursive"),
            };
            let help = "a function may only call functions that do not lead back to it";
            self.diagnostics.error_with_help(place, message, help);
            return None;
        }
        let expected = function.arguments.len();
        if arguments.len() != expected {
            let list: Vec<String> =
                function.arguments.iter().map(|argument| argument.name.to_string()).collect();
            let message = format!(
                "`{name}` takes {expected} argument{}, not {}",
                if expected == 1 { "" } else { "s" },
                arguments.len()
            );
            self.diagnostics.error_with_help(place, message, format!("write `{name}({})`", list.join(", ")));
            return None;
        }
        let mut values = Vec::new();
        for (expression, argument) in arguments.iter().zip(&function.arguments) {
            let value = self.tensor(expression, scope, &format!("`{name}`"));
            let value = value.and_then(|value| {
                let shape = argument.rank.shape(self.dimension);
                if self.arena.shape(value) == shape {
                    return Some(Value::Tensor(value));
                }
                let message = format!(
                    "the argument `{}` of `{name}` is {}, this is {}",
                    argument.name,
                    describe(&shape, self.dimension),
                    self.describe(value)
                );
                self.diagnostics.error(expression.place, message);
                None
            });
            values.push(value);
        }
        // A mistake in an argument has been told; the call itself gives nothing.
        if values.iter().any(Option::is_none) {
            return None;
        }
        self.inline(index, values)
    }

    fn integral(
        &mut self,
        region: &Expression,
        density: &Expression,
        place: Place,
        scope: &Scope,
    ) -> Option<Value> {
        let regions = &self.module.regions;
        let found = match &region.kind {
            ExpressionKind::Name(name) => regions.iter().position(|region| region.name == *name),
            _ => None,
        };
        let swapped = match &density.kind {
            ExpressionKind::Name(name) => regions.iter().find(|region| region.name == *name),
            _ => None,
        };
        if let (None, Some(swapped)) = (found, swapped) {
            let help = format!("write `integral({}, density)`", swapped.name);
            self.diagnostics.error_with_help(density.place, "the region comes first in `integral`", help);
            self.tensor(region, scope, "`integral`");
            return None;
        }
        let Some(index) = found else {
            let names: Vec<String> = regions.iter().map(|region| region.name.to_string()).collect();
            let near = match &region.kind {
                ExpressionKind::Name(name) => {
                    builtins::nearest(&name.to_string(), names.iter().map(String::as_str))
                }
                _ => None,
            };
            let help = match (near, names.is_empty()) {
                (Some(near), _) => format!("did you mean `{near}`?"),
                (None, false) => format!("the regions of this module are `{}`", names.join("`, `")),
                (None, true) => {
                    "declare `#[cells] pub struct Omega;` or `#[facets] pub struct Gamma;`".into()
                }
            };
            self.diagnostics.error_with_help(
                region.place,
                "the first argument of `integral` is not a declared region",
                help,
            );
            self.tensor(density, scope, "`integral`");
            return None;
        };
        let density = self.tensor(density, scope, "`integral`")?;
        let density = self.expect_scalar(density, "integral")?;
        if self.module.is_mistaken(&regions[index].name) {
            return None;
        }
        if !regions[index].facets {
            self.check_cell_geometry(density, &regions[index].name);
        }
        // The whole call is the density's place: errors on linearity speak of the integral.
        let _ = place;
        Some(Value::Form(vec![Term { region: index, density }]))
    }

    fn check_cell_geometry(&mut self, density: Tensor, region: &Ident) {
        for node in self.arena.reachable(&[density]) {
            let what = match self.arena.node(node).operator {
                Operator::Geometry(Geometry::Normal) => "the normal",
                Operator::Geometry(Geometry::FacetArea) => "the area of a facet",
                Operator::Geometry(Geometry::Curvature) => "the curvature",
                _ => continue,
            };
            self.diagnostics.error_with_help(
                self.arena.place(node),
                format!("{what} does not exist inside cells, and `{region}` consists of cells"),
                "integrate this over a region declared `#[facets]`",
            );
        }
    }

    fn derivative(&mut self, arguments: &[Expression], place: Place, scope: &Scope) -> Option<Value> {
        let form = self.evaluate(&arguments[0], scope);
        let field = self.tensor(&arguments[1], scope, "`derivative`");
        let direction = self.tensor(&arguments[2], scope, "`derivative`");
        let (form, field, direction) = (form?, field?, direction?);
        let variable = match self.arena.node(field).operator {
            Operator::Field { field, gradient: false } => Variable::Field(field),
            Operator::Parameter(index) => Variable::Parameter(index),
            _ => {
                self.diagnostics.error_with_help(
                    arguments[1].place,
                    "`derivative` differentiates with respect to a field, and this is not one",
                    "name an argument of the form; `diff(expression, name)` differentiates by any `let` name",
                );
                return None;
            }
        };
        if self.arena.shape(field) != self.arena.shape(direction) {
            let message = format!(
                "the direction has the field's rank: the field is {}, this is {}",
                self.describe(field),
                self.describe(direction)
            );
            self.diagnostics.error(arguments[2].place, message);
            return None;
        }
        let mut gateaux = |expression: Tensor| {
            let shape = self.arena.shape(expression).to_vec();
            self.arena.push(Operator::Gateaux { expression, variable, direction }, shape, place)
        };
        Some(match form {
            Value::Tensor(density) => Value::Tensor(gateaux(density)),
            Value::Form(terms) => Value::Form(
                terms
                    .iter()
                    .map(|term| Term { region: term.region, density: gateaux(term.density) })
                    .collect(),
            ),
        })
    }

    fn partial(&mut self, arguments: &[Expression], place: Place, scope: &Scope) -> Option<Tensor> {
        let expression = self.tensor(&arguments[0], scope, "`diff`");
        let name = self.tensor(&arguments[1], scope, "`diff`");
        let (expression, name) = (expression?, name?);
        let local = match &arguments[1].kind {
            ExpressionKind::Name(text) => scope.contains_key(&text.to_string()),
            _ => false,
        };
        let variable = match self.arena.node(name).operator {
            Operator::Field { field, gradient: false } => Variable::Field(field),
            Operator::Parameter(index) => Variable::Parameter(index),
            // Even a constant: an argument that is the identity here is something else elsewhere.
            _ if local => Variable::Node(name),
            Operator::Number(_) | Operator::Identity | Operator::Geometry(_) => {
                self.diagnostics.error(arguments[1].place, "`diff` by a constant: there is nothing to vary");
                return None;
            }
            _ => {
                self.diagnostics.error_with_help(
                    arguments[1].place,
                    "`diff` differentiates by a name, and this is an expression",
                    "give it a name first: `let w = ..; diff(f(w), w)`",
                );
                return None;
            }
        };
        if matches!(variable, Variable::Node(node) if !self.arena.reachable(&[expression]).contains(&node)) {
            self.diagnostics.error_with_help(
                arguments[1].place,
                "this name does not stand in the expression: the derivative would be zero everywhere",
                "use the name itself in the expression, not what it stands for: `let w = ..; diff(f(w), w)`",
            );
            return None;
        }
        let shape = [self.arena.shape(expression), self.arena.shape(name)].concat();
        if shape.len() > 4 {
            self.diagnostics.error(place, "`diff` would give a tensor of rank above 4");
            return None;
        }
        Some(self.arena.push(Operator::Partial(expression, variable), shape, place))
    }

    /// Terms times a factor, or negated.
    fn scale_terms(&mut self, terms: Vec<Term>, factor: Option<Tensor>, place: Place) -> Vec<Term> {
        let mut scaled = Vec::new();
        for term in terms {
            let operator = match factor {
                Some(factor) => Operator::Scale(factor, term.density),
                None => Operator::Negate(term.density),
            };
            // Keep the density's own place: that is where a later mistake is.
            let own = self.arena.place(term.density);
            scaled.push(Term { region: term.region, density: self.arena.push(operator, vec![], own) });
        }
        let _ = place;
        scaled
    }

    fn binary_form(
        &mut self,
        operator: BinaryOperator,
        left: Value,
        right: Value,
        place: Place,
    ) -> Option<Value> {
        use BinaryOperator::*;
        match (operator, left, right) {
            (Add, Value::Form(mut left), Value::Form(right)) => {
                left.extend(right);
                Some(Value::Form(left))
            }
            (Subtract, Value::Form(mut left), Value::Form(right)) => {
                left.extend(self.scale_terms(right, None, place));
                Some(Value::Form(left))
            }
            (Multiply, Value::Tensor(factor), Value::Form(terms))
            | (Multiply, Value::Form(terms), Value::Tensor(factor)) => {
                let factor = self.constant_factor(factor)?;
                Some(Value::Form(self.scale_terms(terms, Some(factor), place)))
            }
            (Divide, Value::Form(terms), Value::Tensor(divisor)) => {
                let divisor = self.constant_factor(divisor)?;
                let one = self.arena.push(Operator::Number(1.0), vec![], place);
                let factor = self.arena.push(Operator::Divide(one, divisor), vec![], place);
                Some(Value::Form(self.scale_terms(terms, Some(factor), place)))
            }
            _ => {
                let help = "integrals are added, subtracted, and multiplied or divided by a constant";
                self.diagnostics.error_with_help(
                    place,
                    "this operation between integrals has no meaning",
                    help,
                );
                None
            }
        }
    }

    /// What stands before an integral must not vary in space.
    fn constant_factor(&mut self, factor: Tensor) -> Option<Tensor> {
        let factor = self.expect_scalar(factor, "a factor of an integral")?;
        for node in self.arena.reachable(&[factor]) {
            if matches!(self.arena.node(node).operator, Operator::Field { .. } | Operator::Geometry(_)) {
                self.diagnostics.error_with_help(
                    self.arena.place(node),
                    "this varies in space and cannot stand outside the integral",
                    "move it into the density",
                );
                return None;
            }
        }
        Some(factor)
    }
}

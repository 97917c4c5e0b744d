//! Integrals and their arithmetic, and the derivatives that are asked for by name.

use std::fmt::Display;

use super::builtins::{self, Constant};
use super::evaluate::{Evaluator, Scope, Value};
use super::regions::check_existence;
use super::sliding::displaced;
use super::{Means, Term};
use crate::diagnostics::SourceSpan;
use crate::parse::syntax::*;
use crate::tensor::{Geometry, Operator, Tensor, Variable};

impl Evaluator<'_> {
    pub(super) fn integral(
        &mut self,
        region: &Expression,
        density: &Expression,
        means: Option<Means>,
        scope: &Scope,
    ) -> Option<Value> {
        let written = if means.is_some() { "means" } else { "integral" };
        let user = &format!("`{written}`");
        let example = |region: &dyn Display| match means {
            Some(_) => format!("means({region}(u), 0, density)"),
            None => format!("integral({region}, density)"),
        };
        let regions = &self.module.regions;
        let (name, displacement) = displaced(region);
        let found = name.and_then(|name| regions.iter().position(|region| region.name == *name));
        let swapped = match &density.kind {
            ExpressionKind::Name(name) => regions.iter().find(|region| region.name == *name),
            _ => None,
        };
        if let (None, Some(swapped)) = (found, swapped) {
            let help = format!("write `{}`", example(&swapped.name));
            let message = format!("the region comes first in {user}");
            self.diagnostics.error_with_help(density.span, message, help);
            self.tensor(region, scope, user);
            return None;
        }
        let Some(index) = found else {
            let names: Vec<String> = regions.iter().map(|region| region.name.to_string()).collect();
            let near =
                name.and_then(|name| builtins::nearest(&name.to_string(), names.iter().map(String::as_str)));
            let help = match (near, names.is_empty()) {
                (Some(near), _) => format!("did you mean `{near}`?"),
                (None, false) => format!("the regions of this module are `{}`", names.join("`, `")),
                (None, true) => {
                    "declare `#[cells] pub struct Omega;` or `#[facets] pub struct Gamma;`".into()
                }
            };
            self.diagnostics.error_with_help(
                region.span,
                format!("the first argument of {user} is not a declared region"),
                help,
            );
            self.tensor(density, scope, user);
            return None;
        };
        let displacement =
            displacement.map(|one| self.displacement(one, &regions[index], region.span, scope));
        let density = self.tensor(density, scope, user)?;
        let mut density = self.expect_scalar(density, written)?;
        if self.module.is_mistaken(&regions[index].name) {
            return None;
        }
        if means.is_some() {
            self.check_pairs(&regions[index], region.span)?;
            density = self.with_facet_means(density)?;
        }
        let mut fields = None;
        if let Some(displacement) = displacement {
            let (tensor, list) = displacement?;
            density = self.slide(density, tensor);
            fields = Some(list);
        }
        check_existence(&self.arena, density, &regions[index], self.diagnostics);
        Some(Value::Form(vec![Term { region: index, displacement: fields, means, density }]))
    }

    pub(super) fn derivative(
        &mut self,
        arguments: &[Expression],
        span: SourceSpan,
        scope: &Scope,
    ) -> Option<Value> {
        if self.is_shape(&arguments[1]) {
            return self.shape_derivative(arguments, span, scope);
        }
        let form = self.evaluate(&arguments[0], scope);
        let field = self.tensor(&arguments[1], scope, "`derivative`");
        let direction = self.tensor(&arguments[2], scope, "`derivative`");
        let (form, field, direction) = (form?, field?, direction?);
        let variable = match self.arena.node(field).operator {
            Operator::Field { field, order: 0 } => Variable::Field(field),
            Operator::Parameter(index) => Variable::Parameter(index),
            Operator::Geometry(size @ (Geometry::Diameter | Geometry::CellVolume | Geometry::FacetArea)) => {
                Variable::Size(size)
            }
            Operator::Geometry(_) => {
                self.diagnostics.error_with_help(
                    arguments[1].span,
                    "this moves with the shape of the domain, not by itself",
                    "write `derivative(form, shape, direction)` with a vector field as direction",
                );
                return None;
            }
            _ => {
                self.diagnostics.error_with_help(
                    arguments[1].span,
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
            self.diagnostics.error(arguments[2].span, message);
            return None;
        }
        // Outlined, a call hides what its function depends on; the check has been made.
        let stands = self.outlined || self.stands_in(variable, &form);
        if !stands && !self.is_named_in(&arguments[1], &arguments[0]) {
            self.diagnostics.error_with_help(
                arguments[1].span,
                "this field does not stand in what is differentiated: the derivative would be zero everywhere",
                "differentiate by a field of the first argument, or leave this derivative out",
            );
            return None;
        }
        let mut gateaux = |expression: Tensor| {
            let shape = self.arena.shape(expression).to_vec();
            // A term without the field is zero now, so that nothing is asked of it any more.
            let operator = match self.outlined || self.stands_in(variable, &Value::Tensor(expression)) {
                true => Operator::Gateaux { expression, variable, direction },
                false => Operator::Zero,
            };
            self.arena.push(operator, shape, span)
        };
        Some(match form {
            Value::Tensor(density) => Value::Tensor(gateaux(density)),
            Value::Form(terms) => {
                Value::Form(terms.iter().map(|term| term.with(gateaux(term.density))).collect())
            }
        })
    }

    /// Is it the built-in name `shape`?
    fn is_shape(&self, expression: &Expression) -> bool {
        match &expression.kind {
            ExpressionKind::Name(name) => builtins::constant(&name.to_string()) == Some(Constant::Shape),
            _ => false,
        }
    }

    /// `derivative(form, shape, direction)`: of integrals with their measures, of a value without.
    fn shape_derivative(
        &mut self,
        arguments: &[Expression],
        span: SourceSpan,
        scope: &Scope,
    ) -> Option<Value> {
        let form = self.evaluate(&arguments[0], scope);
        let direction = self.tensor(&arguments[2], scope, "`derivative`");
        let (form, direction) = (form?, direction?);
        if self.arena.shape(direction) != [self.dimension] {
            let message =
                format!("the shape moves along a vector field, this is {}", self.describe(direction));
            let help = "give a displacement of the points, `Theta: State<Vector>` or `Theta: Test<Vector>`";
            self.diagnostics.error_with_help(arguments[2].span, message, help);
            return None;
        }
        if let Value::Form(terms) = &form
            && terms.iter().any(|term| {
                let entity = self.module.regions[term.region].entity;
                entity == Entity::Pairs && term.displacement.is_none()
            })
        {
            self.diagnostics.error_with_help(
                arguments[0].span,
                "the derivative of integrals over pairs of fixed points by the shape is not available",
                "pairs of the deformed surfaces have it, `integral(Touch(u), density)`",
            );
            return None;
        }
        let mut gateaux = |expression: Tensor, entity: Option<Entity>| {
            let shape = self.arena.shape(expression).to_vec();
            let operator = Operator::Gateaux { expression, variable: Variable::Shape(entity), direction };
            self.arena.push(operator, shape, span)
        };
        Some(match form {
            Value::Tensor(value) => Value::Tensor(gateaux(value, None)),
            Value::Form(terms) => Value::Form(
                terms
                    .iter()
                    .map(|term| {
                        let entity = self.module.regions[term.region].entity;
                        term.with(gateaux(term.density, Some(entity)))
                    })
                    .collect(),
            ),
        })
    }

    /// Does a value, or one of its integrals, contain a field or parameter?
    fn stands_in(&self, variable: Variable, value: &Value) -> bool {
        let roots = match value {
            Value::Tensor(tensor) => vec![*tensor],
            Value::Form(terms) => terms.iter().map(|term| term.density).collect(),
        };
        self.arena.reachable(&roots).into_iter().any(|node| {
            match (&self.arena.node(node).operator, variable) {
                (Operator::Field { field, .. }, Variable::Field(varied)) => *field == varied,
                (Operator::Parameter(index), Variable::Parameter(varied)) => *index == varied,
                (Operator::Geometry(geometry), Variable::Size(varied)) => *geometry == varied,
                _ => false,
            }
        })
    }

    /// Is a name written in an expression? A form that is called with a field may not depend on it (a dead
    /// load does not depend on the displacement): its derivative is zero, and rightly so.
    fn is_named_in(&self, name: &Expression, expression: &Expression) -> bool {
        match (&name.kind, &expression.kind) {
            (ExpressionKind::Name(name), ExpressionKind::Name(other)) => name == other,
            _ => expression.parts().into_iter().any(|part| self.is_named_in(name, part)),
        }
    }

    pub(super) fn partial(
        &mut self,
        arguments: &[Expression],
        span: SourceSpan,
        scope: &Scope,
    ) -> Option<Tensor> {
        let expression = self.tensor(&arguments[0], scope, "`diff`");
        let name = self.tensor(&arguments[1], scope, "`diff`");
        let (expression, name) = (expression?, name?);
        let local = match &arguments[1].kind {
            ExpressionKind::Name(text) => scope.contains_key(&text.to_string()),
            _ => false,
        };
        let variable = match self.arena.node(name).operator {
            Operator::Field { field, order: 0 } => Variable::Field(field),
            Operator::Parameter(index) => Variable::Parameter(index),
            // Even a constant: an argument that is the identity here is something else elsewhere.
            _ if local => Variable::Node(name),
            Operator::Number(_)
            | Operator::Identity
            | Operator::SymmetricIdentity
            | Operator::Geometry(_) => {
                self.diagnostics.error(arguments[1].span, "`diff` by a constant: there is nothing to vary");
                return None;
            }
            _ => {
                self.diagnostics.error_with_help(
                    arguments[1].span,
                    "`diff` differentiates by a name, and this is an expression",
                    "give it a name first: `let w = ..; diff(f(w), w)`",
                );
                return None;
            }
        };
        if matches!(variable, Variable::Node(node) if !self.arena.reachable(&[expression]).contains(&node)) {
            self.diagnostics.error_with_help(
                arguments[1].span,
                "this name does not stand in the expression: the derivative would be zero everywhere",
                "use the name itself in the expression, not what it stands for: `let w = ..; diff(f(w), w)`",
            );
            return None;
        }
        let shape = [self.arena.shape(expression), self.arena.shape(name)].concat();
        self.limit_rank(&shape, "diff", span)?;
        Some(self.arena.push(Operator::Partial(expression, variable), shape, span))
    }

    /// Terms times a factor, or negated.
    pub(super) fn scale_terms(&mut self, terms: Vec<Term>, factor: Option<Tensor>) -> Vec<Term> {
        let mut scaled = Vec::new();
        for term in terms {
            let operator = match factor {
                Some(factor) => Operator::Scale(factor, term.density),
                None => Operator::Negate(term.density),
            };
            // Keep the density's own span: that is where a later mistake is.
            let own = self.arena.span(term.density);
            scaled.push(term.with(self.arena.push(operator, vec![], own)));
        }
        scaled
    }

    pub(super) fn binary_form(
        &mut self,
        operator: BinaryOperator,
        left: Value,
        right: Value,
        span: SourceSpan,
    ) -> Option<Value> {
        use BinaryOperator::*;
        match (operator, left, right) {
            (Add, Value::Form(mut left), Value::Form(right)) => {
                left.extend(right);
                Some(Value::Form(left))
            }
            (Subtract, Value::Form(mut left), Value::Form(right)) => {
                left.extend(self.scale_terms(right, None));
                Some(Value::Form(left))
            }
            (Multiply, Value::Tensor(factor), Value::Form(terms))
            | (Multiply, Value::Form(terms), Value::Tensor(factor)) => {
                let factor = self.constant_factor(factor)?;
                Some(Value::Form(self.scale_terms(terms, Some(factor))))
            }
            (Divide, Value::Form(terms), Value::Tensor(divisor)) => {
                let divisor = self.constant_factor(divisor)?;
                let one = self.arena.push(Operator::Number(1.0), vec![], span);
                let factor = self.arena.push(Operator::Divide(one, divisor), vec![], span);
                Some(Value::Form(self.scale_terms(terms, Some(factor))))
            }
            _ => {
                let help = "integrals are added, subtracted, and multiplied or divided by a constant";
                self.diagnostics.error_with_help(
                    span,
                    "this operation between integrals has no meaning",
                    help,
                );
                None
            }
        }
    }

    /// The factor of an integral must not vary in space.
    pub(super) fn constant_factor(&mut self, factor: Tensor) -> Option<Tensor> {
        let factor = self.expect_scalar(factor, "a factor of an integral")?;
        for node in self.arena.reachable(&[factor]) {
            if matches!(self.arena.node(node).operator, Operator::Field { .. } | Operator::Geometry(_)) {
                let help = match self.is_scalar_unknown(node) {
                    true => {
                        "move it into the density; an unknown that is one number for a whole body or boundary is not available"
                    }
                    false => "move it into the density",
                };
                let message = "this varies in space and cannot stand outside the integral";
                self.diagnostics.error_with_help(self.arena.span(node), message, help);
                return None;
            }
        }
        Some(factor)
    }

    /// Is it the value of an unknown or a state of one component, as the function at hand names it?
    fn is_scalar_unknown(&self, tensor: Tensor) -> bool {
        let Operator::Field { field, order: 0 } = self.arena.node(tensor).operator else { return false };
        let arguments = self.calls.first().map(|outermost| &self.module.functions[*outermost].arguments);
        let role = arguments.and_then(|arguments| arguments.get(field)).map(|argument| argument.role);
        self.arena.shape(tensor).is_empty()
            && matches!(role, Some(ArgumentRole::Unknown | ArgumentRole::State))
    }
}

//! Random derivatives: `derivative(e, u, direction)` and `diff(e, w)`.

use super::{Limits, Name, Writer};
use crate::proof::generator::Shape;

impl Writer<'_, '_> {
    /// `derivative(e, u, direction)`; one of expression and direction is linear in the test function.
    pub(super) fn derivative(&mut self, shape: Shape, limits: Limits) -> Option<String> {
        // A field's gradient moves with it, a parameter has none.
        let variables: Vec<Name> =
            self.names.iter().filter(|name| name.variable && name.shape != Shape::Fourth).cloned().collect();
        if variables.is_empty() {
            return None;
        }
        let variable = self.choices.one_of(&variables).clone();
        let order = self.choices.below(limits.order + 1);
        let expression = Limits { order, means: false, ..limits.smaller(2) };
        let direction = limits.inside(order)?.smaller(2);
        let test_in_direction = limits.test.is_some() && self.choices.below(2) == 0;
        let (expression, direction) = match test_in_direction {
            true => (expression.free(), direction),
            false => (expression, direction.free()),
        };
        let expression = self.expression(shape, expression);
        let direction = self.expression(variable.shape, direction);
        let factor = self.factor_of(&variable.text);
        Some(format!("derivative({factor} * {expression}, {}, {direction})", variable.text))
    }

    /// A scalar that holds a name: what is differentiated must hold what it is differentiated by.
    fn factor_of(&mut self, name: &str) -> String {
        match self.choices.below(3) {
            0 => format!("inner({name}, {name})"),
            1 => format!("sin(inner({name}, {name}))"),
            _ => format!("(2 - inner({name}, {name}))"),
        }
    }

    /// `diff(e, w)` of a shape.
    pub(super) fn partial(&mut self, shape: Shape, limits: Limits) -> Option<String> {
        let by = Shape::of_axes(self.choices.below(shape.axes() + 1))?;
        let of = Shape::of_axes(shape.axes().checked_sub(by.axes())?)?;
        self.partial_of(of, by, limits)
    }

    /// An entry of a `diff` of higher rank.
    pub(super) fn indexed_partial(&mut self, shape: Shape, limits: Limits) -> Option<String> {
        let by = *self.choices.one_of(&[Shape::Vector, Shape::Tensor]);
        let mut index = |count: usize| -> String {
            (0..count).map(|_| format!("[{}]", self.choices.below(self.dimension))).collect()
        };
        let index = index(by.axes());
        let of = if shape.axes() + by.axes() <= 4 { shape } else { return None };
        self.partial_of(of, by, limits).map(|partial| format!("({partial}){index}"))
    }

    fn partial_of(&mut self, of: Shape, by: Shape, limits: Limits) -> Option<String> {
        let inside = Limits { means: false, ..limits.smaller(2) };
        let names: Vec<Name> =
            self.names.iter().filter(|name| name.shape == by && name.variable).cloned().collect();
        if !names.is_empty() && self.choices.below(2) == 0 {
            let name = self.choices.one_of(&names).clone();
            let expression = self.expression(of, inside);
            let factor = self.factor_of(&name.text);
            return Some(format!("diff({factor} * {expression}, {})", name.text));
        }
        // By the argument of a helper, or by a `let` name: these must be in the expression.
        let plain: Vec<Name> = self
            .names
            .iter()
            .filter(|name| name.shape == by && name.field && !name.variable)
            .cloned()
            .collect();
        if !plain.is_empty() && self.choices.below(2) == 0 {
            let text = self.choices.one_of(&plain).text.clone();
            let expression = self.expression(of, inside);
            let factor = self.factor_of(&text);
            return Some(format!("diff({factor} * {expression}, {text})"));
        }
        let value = self.expression(by, inside.free());
        self.lets += 1;
        let text = format!("w{}", self.lets);
        let name = Name {
            text: text.clone(),
            shape: by,
            field: false,
            variable: false,
            order: inside.order,
            smooth: inside.smooth,
        };
        let before = self.names.len();
        self.names.push(name);
        let expression = self.expression(of, inside);
        self.names.truncate(before);
        let factor = self.factor_of(&text);
        Some(format!("({{ let {text} = {value}; diff({factor} * {expression}, {text}) }})"))
    }
}

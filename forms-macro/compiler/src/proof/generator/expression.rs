//! Random expressions of a shape, with bounded size and bounded derivatives.

mod derivatives;

use super::templates::{CONDITIONS, CONSTANTS, FACET_CONSTANTS, FREE, LINEAR, Template};
use super::{Choices, Shape};
use crate::check::builtins;

/// The kinds of expressions that are allowed at a place.
#[derive(Clone, Copy)]
pub struct Limits {
    /// Approximate number of operators.
    pub size: usize,
    /// The highest derivative of a field that may be read.
    pub order: usize,
    /// The expression is differentiated in space: it contains nothing without a gradient.
    pub smooth: bool,
    /// Normals and the like exist.
    pub facets: bool,
    /// On an interior facet, outside `this`, `other`, `jump` and `avg`: fields have no value yet.
    pub sideless: bool,
    /// Means over the cell may be read: not in what `derivative` and `diff` differentiate, by which they may not be.
    pub means: bool,
    /// The test function in which the expression is linear.
    pub test: Option<usize>,
}

impl Limits {
    fn free(self) -> Self {
        Limits { test: None, ..self }
    }

    /// Number of derivatives in space around it.
    fn inside(self, derivatives: usize) -> Option<Self> {
        let order = self.order.checked_sub(derivatives)?;
        Some(Limits { order, smooth: self.smooth || derivatives > 0, ..self })
    }

    fn smaller(self, parts: usize) -> Self {
        Limits { size: self.size.saturating_sub(1) / parts.max(1), ..self }
    }
}

/// A field, parameter or `let` name.
#[derive(Clone)]
pub struct Name {
    pub text: String,
    pub shape: Shape,
    /// Its derivatives in space may be read.
    pub field: bool,
    /// `derivative` and `diff` may name it, whether it is in the expression or not.
    pub variable: bool,
    /// The highest derivative that its value reads, and whether it has a gradient.
    pub order: usize,
    pub smooth: bool,
}

/// A function of the module that others may call.
pub struct Callable {
    pub text: String,
    pub arguments: Vec<Shape>,
    pub result: Shape,
    /// Number of derivatives that are taken of its arguments.
    pub order: usize,
}

/// Writes expressions of one function.
pub struct Writer<'c, 'l> {
    pub choices: &'c mut Choices<'l>,
    pub dimension: usize,
    pub names: Vec<Name>,
    pub tests: Vec<Name>,
    pub functions: &'c [Callable],
    /// For fresh `let` names.
    pub lets: usize,
}

/// Does the language have all names that a template calls?
fn known(template: &str) -> bool {
    let word = |character: char| character.is_alphanumeric() || character == '_';
    let mut rest = template;
    while let Some(open) = rest.find('(') {
        let head = &rest[..open];
        let start = head.rfind(|character| !word(character)).map_or(0, |at| at + 1);
        if !head[start..].is_empty() && builtins::builtin(&head[start..]).is_none() {
            return false;
        }
        rest = &rest[open + 1..];
    }
    true
}

/// The number of derivatives that a template takes of its holes.
fn derivatives(template: &str) -> usize {
    if template.contains("\"}") { 2 } else { usize::from(template.contains("'}")) }
}

impl Writer<'_, '_> {
    /// A random expression, in parentheses where that is needed.
    pub fn expression(&mut self, shape: Shape, limits: Limits) -> String {
        if limits.size == 0 {
            return self.leaf(shape, limits);
        }
        if limits.sideless && self.choices.below(4) == 0 {
            return self.restricted(shape, limits);
        }
        let list = if limits.test.is_some() { LINEAR } else { FREE };
        let dimension = self.dimension;
        let fits = |(result, only, text): &&Template| {
            *result == shape
                && only.is_none_or(|only| only == dimension)
                && derivatives(text) <= limits.order
                // A direction gets the sides of what it varies, and may not have its own.
                && !(limits.sideless && text.starts_with("derivative("))
                && known(text)
        };
        let templates: Vec<&str> = list.iter().filter(fits).map(|template| template.2).collect();
        if limits.sideless {
            let template = self.choices.one_of(&templates);
            return self.fill(template, limits);
        }
        // The special ones are as likely as two or three templates each.
        let choice = self.choices.below(templates.len() + 14);
        let special = match choice {
            0..2 => None,
            2..4 => self.call(shape, limits),
            4..6 => self.block(shape, limits),
            6..9 => self.derivative(shape, limits),
            9..12 => self.partial(shape, limits),
            12..14 => self.indexed_partial(shape, limits),
            other => Some(self.fill(templates[other - 14], limits)),
        };
        special.unwrap_or_else(|| self.leaf(shape, limits))
    }

    /// A template with its holes filled.
    fn fill(&mut self, template: &str, limits: Limits) -> String {
        let is_part = |(at, _): &(usize, &str)| {
            template[at + 1..].starts_with(['s', 'v', 't', 'q', 'c', 'S', 'V', 'T'])
        };
        let derived = template.contains("derivative(") || template.contains("diff(");
        let limits = Limits { means: limits.means && !derived, ..limits };
        let smaller = limits.smaller(template.match_indices('{').filter(is_part).count());
        let mut text = String::from("(");
        let mut rest = template;
        while let Some(open) = rest.find('{') {
            let hole: String = rest[open + 1..].chars().take_while(|character| *character != '}').collect();
            let (head, tail) = rest.split_at(open);
            text.push_str(head);
            let marks = hole.trim_start_matches(char::is_alphabetic);
            let letter = hole.chars().next().unwrap_or(' ');
            let is_hole = hole.len() <= 2
                && hole.len() == marks.len() + 1
                && marks.chars().all(|m| m == '\'' || m == '"');
            if !is_hole {
                text.push('{');
                rest = &tail[1..];
                continue;
            }
            rest = &tail[hole.len() + 2..];
            let inside = match marks {
                "'" => smaller.inside(1),
                "\"" => smaller.inside(2),
                _ => Some(smaller),
            };
            let inside = inside.unwrap_or(smaller);
            match (letter, Shape::of_letter(letter)) {
                ('i', _) => text.push_str(&self.choices.below(self.dimension).to_string()),
                ('c', _) => {
                    let condition = self.condition(inside.free());
                    text.push_str(&condition);
                }
                (_, Some(shape)) => {
                    let inside = if letter.is_lowercase() { inside.free() } else { inside };
                    let part = self.expression(shape, inside);
                    text.push_str(&part);
                }
                _ => panic!("a hole of no kind in {template}"),
            }
        }
        text.push_str(rest);
        text.push(')');
        text
    }

    fn condition(&mut self, limits: Limits) -> String {
        let template = *self.choices.one_of(CONDITIONS);
        if limits.size == 0 && template.contains("{c}") {
            return self.fill(CONDITIONS[0], limits);
        }
        self.fill(template, limits)
    }

    /// Without operators, or nearly so.
    fn leaf(&mut self, shape: Shape, limits: Limits) -> String {
        if limits.sideless {
            return match (shape, limits.test, self.choices.below(8)) {
                (Shape::Vector, None, 1) if !limits.smooth => "n".into(),
                (Shape::Vector, None, 2) => "x".into(),
                (Shape::Scalar, None, 1) if !limits.smooth => "facet_area".into(),
                (Shape::Scalar, None, 2) => "0.5".into(),
                _ => self.restricted(shape, limits),
            };
        }
        if let Some(test) = limits.test {
            return self.linear_leaf(shape, test, limits);
        }
        let mut leaves = Vec::new();
        for name in &self.names {
            if name.shape == shape && name.order <= limits.order && (name.smooth || !limits.smooth) {
                leaves.push(name.text.clone());
            }
            if name.field && limits.order >= 1 && name.shape.axes() + 1 == shape.axes() {
                leaves.push(format!("grad({})", name.text));
            }
            if name.field && name.variable && limits.means && name.shape == shape {
                leaves.push(format!("mean({})", name.text));
            }
            if name.field && name.variable && limits.means && name.shape.axes() + 1 == shape.axes() {
                leaves.push(format!("mean(h * grad({}))", name.text));
            }
            if name.field && limits.order >= 2 && name.shape.axes() + 2 == shape.axes() && known("hess(u)") {
                leaves.push(format!("hess({})", name.text));
            }
        }
        let further = if limits.facets && !limits.smooth { FACET_CONSTANTS } else { &[] };
        let constants = CONSTANTS.iter().chain(further).filter(|(other, _)| *other == shape);
        leaves.extend(
            constants
                .filter(|(_, text)| text.parse::<f64>().is_ok() || builtins::constant(text).is_some())
                .map(|(_, text)| text.to_string()),
        );
        if leaves.is_empty() {
            let half = (shape.axes() / 2).max(1);
            let part = Shape::of_axes(half).unwrap_or(Shape::Scalar);
            let (first, second) = (self.leaf(part, limits), self.leaf(part, limits));
            return format!("outer({first}, {second})");
        }
        // Fields come first and are the likelier choice.
        let choice = self.choices.below(2 * leaves.len());
        leaves[if choice < leaves.len() { choice } else { (choice - leaves.len()) / 2 }].clone()
    }

    /// A test function, brought to a shape.
    fn linear_leaf(&mut self, shape: Shape, test: usize, limits: Limits) -> String {
        let Name { text, shape: own, .. } = self.tests[test].clone();
        let averaged = limits.means && self.choices.below(3) == 0;
        if own == shape {
            return if averaged { format!("mean({text})") } else { text };
        }
        let letter = own.letter();
        let gradient = limits.order >= 1;
        let template = match (own, shape) {
            (Shape::Scalar, Shape::Vector) | (Shape::Vector, Shape::Tensor) if gradient && averaged => {
                "mean(grad(#))".to_string()
            }
            (Shape::Scalar, Shape::Vector) if gradient => "grad(#)".to_string(),
            (Shape::Scalar, Shape::Tensor) if limits.order >= 2 && known("hess(u)") => "hess(#)".to_string(),
            (Shape::Vector, Shape::Tensor) if gradient => "grad(#)".to_string(),
            (Shape::Vector, Shape::Scalar) if gradient => "div(#)".to_string(),
            (Shape::Scalar, _) => format!("# * {{{}}}", shape.letter()),
            (Shape::Vector, Shape::Tensor) => "outer(#, {v})".to_string(),
            (Shape::Tensor, Shape::Vector) => "# * {v}".to_string(),
            (_, Shape::Scalar) => format!("inner(#, {{{letter}}})"),
            _ => format!("inner(#, {{{letter}}}) * {{{}}}", shape.letter()),
        };
        self.fill(&template, limits.free()).replace('#', &text)
    }

    /// An expression seen from one side of a facet, or its jump or average.
    fn restricted(&mut self, shape: Shape, limits: Limits) -> String {
        let inside = Limits { sideless: false, ..limits.smaller(1) };
        let (along, of) = match (shape, limits.smooth) {
            (Shape::Scalar, false) => (true, Shape::Vector),
            (Shape::Vector, false) => (true, Shape::Scalar),
            _ => (false, shape),
        };
        match self.choices.below(5) {
            0 => format!("this({})", self.expression(shape, inside)),
            1 => format!("jump({})", self.expression(shape, inside)),
            2 => format!("avg({})", self.expression(shape, inside)),
            3 if along => format!("jump({}, n)", self.expression(of, inside)),
            _ => format!("other({})", self.expression(shape, inside)),
        }
    }

    fn call(&mut self, shape: Shape, limits: Limits) -> Option<String> {
        let functions = self.functions;
        let fits: Vec<&Callable> = functions
            .iter()
            .filter(|function| {
                function.result == shape && limits.test.is_none() && function.order <= limits.order
            })
            .collect();
        if fits.is_empty() {
            return None;
        }
        let function = *self.choices.one_of(&fits);
        let inside = Limits { means: false, ..limits };
        let inside = inside.inside(function.order)?.smaller(function.arguments.len());
        let arguments: Vec<String> =
            function.arguments.iter().map(|shape| self.expression(*shape, inside)).collect();
        Some(format!("{}({})", function.text, arguments.join(", ")))
    }

    /// `{ let w = ..; .. }`, where w may be used in what follows.
    fn block(&mut self, shape: Shape, limits: Limits) -> Option<String> {
        let inside = limits.smaller(2);
        let (name, value) = self.name_a_value(Limits { means: false, ..inside.free() });
        let before = self.names.len();
        self.names.push(name.clone());
        let result = self.expression(shape, inside);
        self.names.truncate(before);
        Some(format!("({{ let {} = {value}; {result} }})", name.text))
    }

    fn name_a_value(&mut self, limits: Limits) -> (Name, String) {
        let shape = *self.choices.one_of(&Shape::FIELDS);
        let value = self.expression(shape, limits);
        self.lets += 1;
        let name = Name {
            text: format!("w{}", self.lets),
            shape,
            field: false,
            variable: false,
            order: limits.order,
            smooth: limits.smooth,
        };
        (name, value)
    }
}

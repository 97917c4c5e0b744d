//! The functions of a module as their author wrote them, and their derivatives, each made once: what a
//! name in a formula means.

pub mod simplify;

use std::collections::HashMap;
use std::rc::Rc;

use self::simplify::Simplifier;
use super::names::Names;
use super::read::{Reader, Varied, varied};
use crate::check::{CheckedFunction, Content, outline};
use crate::diagnostics::Diagnostics;
use crate::differentiate::map_operands;
use crate::differentiate::rules::{Differentiation, Seed};
use crate::parse::syntax::{Module, Output};
use crate::tensor::{Arena, FieldInfo, FieldRole, Named, Operator, Tensor, Variable};

/// The highest derivative of a field that a node names.
const HIGHEST_ORDER: usize = 2;

/// A function or one of its derivatives, with its arguments and directions as fields.
pub struct Definition {
    pub arena: Arena,
    /// Arguments, then the module's `Given` members, then directions.
    pub fields: Vec<FieldInfo>,
    /// The field of each direction, per order and argument.
    pub directions: Vec<Vec<Option<usize>>>,
    /// `None`: zero.
    pub value: Option<Tensor>,
}

/// The definitions of a module's functions, in one dimension.
pub struct Outlines<'a> {
    pub module: &'a Module,
    pub dimension: usize,
    definitions: HashMap<(usize, Varied), Option<Rc<Definition>>>,
    linear: HashMap<(usize, Vec<bool>), bool>,
    /// Functions call functions: without this, a chain of calls would be followed once per way through it.
    vanishing: HashMap<(usize, Vec<bool>), bool>,
}

impl<'a> Outlines<'a> {
    pub fn new(module: &'a Module, dimension: usize) -> Self {
        Outlines {
            module,
            dimension,
            definitions: HashMap::new(),
            linear: HashMap::new(),
            vanishing: HashMap::new(),
        }
    }

    /// A reader of an arena's nodes.
    pub fn reader<'r>(&self, arena: &'r Arena, fields: &'r [FieldInfo], names: &'r Names) -> Reader<'r>
    where
        'a: 'r,
    {
        Reader { module: self.module, arena, fields, dimension: self.dimension, names }
    }

    /// A function that gives a value, or its derivative. `None` if the function has a mistake.
    pub fn definition(&mut self, function: usize, varied: &[Vec<bool>]) -> Option<Rc<Definition>> {
        let key = (function, varied.to_vec());
        if let Some(known) = self.definitions.get(&key) {
            return known.clone();
        }
        let made = self.make(function, varied).map(Rc::new);
        self.definitions.insert(key, made.clone());
        made
    }

    fn make(&mut self, function: usize, varied: &[Vec<bool>]) -> Option<Definition> {
        let Some((last, before)) = varied.split_last() else {
            let CheckedFunction { arena, fields, content, .. } =
                outline(self.module, function, self.dimension)?;
            let Content::Value(value) = content else { return None };
            return Some(Definition { arena, fields, directions: vec![], value: Some(value) });
        };
        let base = self.definition(function, before)?;
        let (mut arena, mut fields) = (base.arena.clone(), base.fields.clone());
        let mut directions = base.directions.clone();
        directions.push(vec![None; last.len()]);
        let mut sum: Option<Tensor> = None;
        for argument in (0..last.len()).filter(|argument| last[*argument]) {
            let name = direction_name(&fields[argument].name, varied.len());
            let shape = fields[argument].shape.clone();
            fields.push(FieldInfo { name, role: FieldRole::State, shape: shape.clone() });
            let field = fields.len() - 1;
            directions[varied.len() - 1][argument] = Some(field);
            let Some(value) = base.value else { continue };
            let operator = Operator::Field { field, order: 0 };
            let direction = arena.push(operator, shape, arena.span(value));
            let derivative = self.derive(&mut arena, value, Variable::Field(argument), direction, &fields)?;
            sum = match (sum, derivative) {
                (Some(sum), Some(one)) => {
                    let shape = arena.shape(sum).to_vec();
                    Some(arena.push(Operator::Add(sum, one), shape, arena.span(sum)))
                }
                (one, None) | (None, one) => one,
            };
        }
        let value = sum.map(|sum| Simplifier::new(self, &mut arena, &fields).simplify(sum));
        let value = value.filter(|value| !arena.is_zero(*value));
        Some(Definition { arena, fields, directions, value })
    }

    /// The derivative in a direction, by the rules of `differentiate`; the inner `None` is zero, the outer one
    /// a mistake.
    fn derive(
        &mut self,
        arena: &mut Arena,
        value: Tensor,
        variable: Variable,
        direction: Tensor,
        fields: &[FieldInfo],
    ) -> Option<Option<Tensor>> {
        let mut value = self.carry_out(arena, value, fields)?;
        // A function knows data and geometry by itself: they vary inside it.
        let data = match variable {
            Variable::Field(field) => fields[field].role.is_data(),
            Variable::Parameter(_) | Variable::Shape(_) | Variable::Size(_) => true,
            Variable::Node(_) => false,
        };
        if data {
            value = self.inlined(arena, value, fields)?;
        }
        let mut directions = vec![direction];
        for order in 0..HIGHEST_ORDER {
            let last = directions[order];
            let shape = [arena.shape(last), &[self.dimension]].concat();
            let operator = gradient(arena, last);
            directions.push(arena.push(operator, shape, arena.span(last)));
        }
        let seed = Seed::Toward { variable, direction, with_gradient: true };
        let mut diagnostics = Diagnostics::default();
        let mut differentiation =
            Differentiation::new(arena, self.dimension, seed, directions, fields, &mut diagnostics);
        Some(differentiation.derive_with_measure(value))
    }

    /// The expression with each `derivative(..)` carried out and simplified. `None` after a mistake.
    pub fn carry_out(&mut self, arena: &mut Arena, tensor: Tensor, fields: &[FieldInfo]) -> Option<Tensor> {
        let nodes = arena.reachable(&[tensor]);
        if !nodes.iter().any(|node| matches!(arena.node(*node).operator, Operator::Gateaux { .. })) {
            return Some(tensor);
        }
        // Operands come before what is made of them: each node is carried out once.
        let mut known: HashMap<Tensor, Tensor> = HashMap::new();
        for one in nodes {
            let node = arena.node(one).clone();
            let carried = match node.operator {
                Operator::Gateaux { expression, variable, direction } => {
                    let [expression, direction] = [expression, direction].map(|operand| known[&operand]);
                    match self.derive(arena, expression, variable, direction, fields)? {
                        Some(derivative) => Simplifier::new(self, arena, fields).simplify(derivative),
                        None => arena.push(Operator::Zero, node.shape, node.span),
                    }
                }
                operator => {
                    let mut changed = false;
                    let operator = map_operands(&operator, &mut |operand| {
                        changed |= known[&operand] != operand;
                        known[&operand]
                    });
                    if changed { arena.push(operator, node.shape, node.span) } else { one }
                }
            };
            known.insert(one, carried);
        }
        known.get(&tensor).copied()
    }

    /// The expression with all names replaced by their meanings. `None` after a mistake.
    pub fn inlined(&mut self, arena: &mut Arena, tensor: Tensor, fields: &[FieldInfo]) -> Option<Tensor> {
        self.inline(arena, tensor, fields, &mut HashMap::new())
    }

    fn inline(
        &mut self,
        arena: &mut Arena,
        tensor: Tensor,
        fields: &[FieldInfo],
        known: &mut HashMap<Tensor, Tensor>,
    ) -> Option<Tensor> {
        if let Some(known) = known.get(&tensor) {
            return Some(*known);
        }
        let node = arena.node(tensor).clone();
        let inlined = match node.operator {
            Operator::Named(Named::Value { value, .. }) => self.inline(arena, value, fields, known)?,
            Operator::Named(Named::Call { function, arguments, directions }) => {
                let body = self.body(arena, function, &arguments, &directions, fields)?;
                match body {
                    Some(body) => self.inline(arena, body, fields, known)?,
                    None => arena.push(Operator::Zero, node.shape, node.span),
                }
            }
            operator => {
                let mut complete = true;
                let mut changed = false;
                let mut change = |operand: Tensor| {
                    let inlined = self.inline(arena, operand, fields, known);
                    complete &= inlined.is_some();
                    let inlined = inlined.unwrap_or(operand);
                    changed |= inlined != operand;
                    inlined
                };
                let mut operator = map_operands(&operator, &mut change);
                if let Operator::Partial(_, Variable::Node(variable)) = &mut operator {
                    *variable = change(*variable);
                }
                match complete {
                    false => return None,
                    true if changed => arena.push(operator, node.shape, node.span),
                    true => tensor,
                }
            }
        };
        known.insert(tensor, inlined);
        Some(inlined)
    }

    /// The value of a call, with its arguments and directions in place; the inner `None` is zero.
    pub fn body(
        &mut self,
        arena: &mut Arena,
        function: usize,
        arguments: &[Tensor],
        directions: &[Vec<Tensor>],
        fields: &[FieldInfo],
    ) -> Option<Option<Tensor>> {
        let varied = varied(arena, directions);
        let definition = self.definition(function, &varied)?;
        let mut values: Vec<Option<Tensor>> = vec![None; definition.fields.len()];
        for (value, argument) in values.iter_mut().zip(arguments) {
            *value = Some(*argument);
        }
        for (row, given) in definition.directions.iter().zip(directions) {
            for (field, direction) in row.iter().zip(given) {
                if let Some(field) = field {
                    values[*field] = Some(*direction);
                }
            }
        }
        for (value, field) in values.iter_mut().zip(&definition.fields) {
            if field.role.is_data() && value.is_none() {
                let here = fields.iter().position(|one| one.role.is_data() && one.name == field.name)?;
                let span = arguments.first().map(|argument| arena.span(*argument));
                let span = span.or_else(|| definition.value.map(|value| definition.arena.span(value)))?;
                let operator = Operator::Field { field: here, order: 0 };
                *value = Some(arena.push(operator, field.shape.clone(), span));
            }
        }
        let Some(value) = definition.value else { return Some(None) };
        Some(Some(substitute(&definition.arena, value, &values, arena)))
    }

    /// Is the function linear in these arguments together? Proved: its derivative does not depend on them, and
    /// it vanishes where they do.
    pub fn is_linear(&mut self, function: usize, varied: &[bool]) -> bool {
        let key = (function, varied.to_vec());
        if let Some(known) = self.linear.get(&key) {
            return *known;
        }
        let linear = self.find_linear(function, varied).unwrap_or(false);
        self.linear.insert(key, linear);
        linear
    }

    fn find_linear(&mut self, function: usize, varied: &[bool]) -> Option<bool> {
        let derivative = self.definition(function, &[varied.to_vec()])?;
        if let Some(value) = derivative.value {
            let depends = |node: Tensor| match derivative.arena.node(node).operator {
                Operator::Field { field, .. } => varied.get(field).copied().unwrap_or(false),
                _ => false,
            };
            if derivative.arena.reachable(&[value]).into_iter().any(depends) {
                return Some(false);
            }
        }
        Some(self.vanishes(function, varied))
    }

    /// Is the function zero where these arguments are? Only what shows without arithmetic.
    pub fn vanishes(&mut self, function: usize, zero: &[bool]) -> bool {
        let key = (function, zero.to_vec());
        if let Some(known) = self.vanishing.get(&key) {
            return *known;
        }
        let vanishes = self.find_vanishing(function, zero);
        self.vanishing.insert(key, vanishes);
        vanishes
    }

    fn find_vanishing(&mut self, function: usize, zero: &[bool]) -> bool {
        let Some(definition) = self.definition(function, &[]) else { return false };
        let Some(value) = definition.value else { return true };
        let mut arena = Arena::default();
        let span = definition.arena.span(value);
        let mut values = Vec::new();
        for (index, field) in definition.fields.iter().enumerate() {
            let operator = match zero.get(index) {
                Some(true) => Operator::Zero,
                _ => Operator::Field { field: index, order: 0 },
            };
            values.push(Some(arena.push(operator, field.shape.clone(), span)));
        }
        let value = substitute(&definition.arena, value, &values, &mut arena);
        let value = Simplifier::new(self, &mut arena, &definition.fields).simplify(value);
        arena.is_zero(value)
    }

    /// Does the function give a value, so that formulas name it?
    pub fn gives_value(&self, function: usize) -> bool {
        matches!(self.module.functions[function].output, Output::Value(_))
    }
}

/// `δu`, `Δu`, and with numbers from the third on.
pub fn direction_name(name: &str, order: usize) -> String {
    match order {
        1 => format!("δ{name}"),
        2 => format!("Δ{name}"),
        _ => format!("δ{name}_{order}"),
    }
}

/// ∇ of the node's meaning.
pub fn gradient(arena: &Arena, tensor: Tensor) -> Operator {
    match arena.node(tensor).operator {
        Operator::Field { field, order } if order < HIGHEST_ORDER => {
            Operator::Field { field, order: order + 1 }
        }
        _ => Operator::Gradient(tensor),
    }
}

/// Copies an expression into another arena, with values in place of its fields.
fn substitute(source: &Arena, tensor: Tensor, values: &[Option<Tensor>], target: &mut Arena) -> Tensor {
    let mut copied: HashMap<Tensor, Tensor> = HashMap::new();
    for one in source.reachable(&[tensor]) {
        let node = source.node(one);
        let value = match node.operator {
            Operator::Field { field, .. } => values.get(field).copied().flatten(),
            _ => None,
        };
        let new = match (&node.operator, value) {
            (Operator::Field { order, .. }, Some(mut value)) => {
                for _ in 0..*order {
                    let shape = [target.shape(value), &[node.shape[node.shape.len() - 1]]].concat();
                    let operator = gradient(target, value);
                    value = target.push(operator, shape, node.span);
                }
                value
            }
            (operator, _) => {
                // Operands come before what is made of them.
                let mut operator = map_operands(operator, &mut |operand| copied[&operand]);
                if let Operator::Partial(_, Variable::Node(variable)) = &mut operator {
                    *variable = copied.get(variable).copied().unwrap_or(*variable);
                }
                target.push(operator, node.shape.clone(), node.span)
            }
        };
        copied.insert(one, new);
    }
    copied[&tensor]
}

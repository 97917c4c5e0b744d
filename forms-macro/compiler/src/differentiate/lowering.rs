//! Removal of the operators of differentiation from expressions.

use std::collections::{HashMap, HashSet};

use super::cell_mean::{CellMeans, check_variable};
use super::map_operands::map_operands;
use super::rules::{Differentiation, Seed};
use crate::check::Term;
use crate::check::regions::{check_existence, check_sides};
use crate::diagnostics::Diagnostics;
use crate::parse::syntax::Region;
use crate::tensor::{Arena, FieldInfo, FieldRole, Geometry, Operator, Tensor, Variable};

/// Removes the operators of differentiation, innermost first.
pub(super) struct Lowering<'a> {
    pub arena: Arena,
    pub dimension: usize,
    /// As checked.
    pub fields: Vec<FieldInfo>,
    pub known: HashMap<Tensor, Tensor>,
    /// The variable of `diff(e, w)`.
    pub names: HashSet<Tensor>,
    /// Too large to go on, which has been reported.
    pub exhausted: bool,
    pub diagnostics: &'a mut Diagnostics,
}

/// More nodes than the derivatives of any form have.
const MOST_NODES: usize = 1_000_000;

impl Lowering<'_> {
    /// Reports what does not exist where it is integrated. Derivatives that were asked for may have brought
    /// it there, so they are carried out first.
    pub(super) fn check_regions(&mut self, terms: &[Term], fields: &[FieldInfo], regions: &[Region]) {
        for term in terms {
            let (density, region) = (self.lower(term.density), &regions[term.region]);
            let is_test = |field: &&usize| matches!(fields[**field].role, FieldRole::Test(_));
            if let Some(test) = term.displacement.iter().flatten().find(is_test) {
                let message =
                    format!("`{}` is a test function, and displaces no surfaces", fields[*test].name);
                let help = "contact pairs are displaced by unknowns, states or data";
                self.diagnostics.error_with_help(self.arena.span(term.density), message, help);
            }
            check_existence(&self.arena, density, region, self.diagnostics);
            if term.means.is_some() {
                self.check_facet_means(fields, density);
            }
            if region.entity.is_two_sided() {
                check_sides(&self.arena, fields, density, Some(region), self.diagnostics);
            }
        }
    }

    /// Does it hold a limit from one side of a facet?
    pub(super) fn has_sides(&self, tensor: Tensor) -> bool {
        use Operator::{Opposite, Restrict};
        let restricted =
            |node: &Tensor| matches!(self.arena.node(*node).operator, Restrict(..) | Opposite(..));
        self.arena.reachable(&[tensor]).iter().any(restricted)
    }

    /// The node of a derivative in the direction of another field.
    pub(super) fn gateaux(
        &mut self,
        expression: Tensor,
        field: usize,
        direction: usize,
        fields: &[FieldInfo],
    ) -> Tensor {
        let span = self.arena.span(expression);
        let operator = Operator::Field { field: direction, order: 0 };
        let direction = self.arena.push(operator, fields[direction].shape.clone(), span);
        let shape = self.arena.shape(expression).to_vec();
        let operator = Operator::Gateaux { expression, variable: Variable::Field(field), direction };
        self.arena.push(operator, shape, span)
    }

    /// The same expression without operators of differentiation. A node without any keeps its identity,
    /// on which `diff(e, w)` by a `let` name relies.
    pub(super) fn lower(&mut self, tensor: Tensor) -> Tensor {
        if let Some(known) = self.known.get(&tensor) {
            return *known;
        }
        let node = self.arena.node(tensor).clone();
        let span = node.span;
        let lowered = match node.operator {
            Operator::Gateaux { expression, variable, direction } => {
                let expression = self.lower(expression);
                let direction = self.lower(direction);
                let variable = self.lower_variable(variable);
                let seed = Seed::Toward { variable, direction, with_gradient: true };
                self.derive(expression, seed)
                    .unwrap_or_else(|| self.arena.push(Operator::Zero, node.shape, span))
            }
            Operator::Gradient(expression) => {
                let expression = self.lower(expression);
                if let Operator::Field { field, order: order @ (0 | 1) } =
                    self.arena.node(expression).operator
                {
                    let operator = Operator::Field { field, order: order + 1 };
                    self.arena.push(operator, node.shape, span)
                } else {
                    let directions: Vec<_> =
                        (0..self.dimension).map(|axis| self.derive(expression, Seed::Along(axis))).collect();
                    self.with_trailing_axes(expression, &directions, &[self.dimension])
                }
            }
            Operator::Partial(expression, variable) => {
                check_variable(&self.arena, expression, variable, self.diagnostics);
                let expression = self.lower(expression);
                let variable = self.lower_variable(variable);
                let shape = node.shape[self.arena.shape(expression).len()..].to_vec();
                let count: usize = shape.iter().product();
                let mut directions = Vec::new();
                for entry in 0..count {
                    let direction = self.unit(&shape, entry, tensor);
                    let seed = Seed::Toward { variable, direction, with_gradient: false };
                    directions.push(self.derive(expression, seed));
                }
                self.with_trailing_axes(expression, &directions, &shape)
            }
            Operator::CellMean(operand) => {
                let operand = self.lower(operand);
                let mean = CellMeans::new(&mut self.arena, &self.fields, self.diagnostics).of(operand);
                mean.unwrap_or_else(|| self.arena.push(Operator::Zero, node.shape, span))
            }
            operator => {
                let mut changed = false;
                let mut change = |operand: Tensor| {
                    let new = self.lower(operand);
                    changed |= new != operand;
                    new
                };
                let operator = map_operands(&operator, &mut change);
                if changed { self.arena.push(operator, node.shape, span) } else { tensor }
            }
        };
        let lowered = self.apart(tensor, lowered);
        self.known.insert(tensor, lowered);
        lowered
    }

    /// A derivative may be a node that is used elsewhere, too (`derivative(u, u, v)` is `v`). A name for it that is
    /// differentiated by varies alone: it becomes a node of its own.
    fn apart(&mut self, tensor: Tensor, lowered: Tensor) -> Tensor {
        if lowered == tensor || !self.names.contains(&tensor) {
            return lowered;
        }
        let node = self.arena.node(lowered).clone();
        self.arena.push(node.operator, node.shape, node.span)
    }

    fn lower_variable(&mut self, variable: Variable) -> Variable {
        match variable {
            Variable::Node(node) => Variable::Node(self.lower(node)),
            other => other,
        }
    }

    fn derive(&mut self, expression: Tensor, seed: Seed) -> Option<Tensor> {
        if self.arena.len() > MOST_NODES {
            if !std::mem::replace(&mut self.exhausted, true) {
                let message = "the derivatives of this unfold to more than a million operations";
                let help = "differentiate fewer times, or by tensors of lower rank";
                self.diagnostics.error_with_help(self.arena.span(expression), message, help);
            }
            return None;
        }
        let mut directions = Vec::new();
        if let Seed::Toward { direction, with_gradient, .. } = seed {
            directions.push(direction);
            let highest = if with_gradient { self.highest_order(expression, seed) } else { 0 };
            for order in 1..=highest {
                let last = directions[order - 1];
                let shape = [self.arena.shape(last), &[self.dimension]].concat();
                let span = self.arena.span(last);
                let gradient = self.arena.push(Operator::Gradient(last), shape, span);
                directions.push(self.lower(gradient));
            }
        }
        let (arena, fields) = (&mut self.arena, &self.fields);
        Differentiation::new(arena, self.dimension, seed, directions, fields, self.diagnostics)
            .derive_with_measure(expression)
    }

    /// The highest derivative of the direction that the derivative of the expression reads.
    fn highest_order(&self, expression: Tensor, seed: Seed) -> usize {
        let Seed::Toward { variable, .. } = seed else { return 0 };
        let orders = self.arena.reachable(&[expression]).into_iter().filter_map(|node| {
            match (&self.arena.node(node).operator, variable) {
                (Operator::Field { field, order }, Variable::Field(varied)) if *field == varied => {
                    Some(*order)
                }
                (Operator::Field { field, order }, Variable::Shape(_)) => {
                    let fixed = self.fields.get(*field).is_some_and(|field| field.role == FieldRole::Given);
                    Some(if fixed { 0 } else { *order })
                }
                (Operator::Geometry(Geometry::Normal), Variable::Shape(_)) => Some(1),
                (Operator::Opposite(..) | Operator::Sliding(..), Variable::Field(_) | Variable::Shape(_)) => {
                    Some(1)
                }
                _ => None,
            }
        });
        let of_measure = usize::from(matches!(variable, Variable::Shape(Some(_))));
        orders.max().unwrap_or(0).max(of_measure)
    }

    /// The unit tensor of a shape whose `entry`-th component (row-major) is one.
    fn unit(&mut self, shape: &[usize], entry: usize, origin: Tensor) -> Tensor {
        let span = self.arena.span(origin);
        let Some((first, rest)) = shape.split_first() else {
            return self.arena.share(Operator::Number(1.0), vec![], span);
        };
        let stride: usize = rest.iter().product();
        let mut rows = Vec::new();
        for row in 0..*first {
            rows.push(if entry / stride == row {
                self.unit(rest, entry % stride, origin)
            } else {
                self.arena.share(Operator::Zero, rest.to_vec(), span)
            });
        }
        self.arena.share(Operator::Stack(rows), shape.to_vec(), span)
    }

    /// From one tensor like `model` per index of the trailing axes to one tensor with those axes.
    fn with_trailing_axes(
        &mut self,
        model: Tensor,
        directions: &[Option<Tensor>],
        trailing: &[usize],
    ) -> Tensor {
        let span = self.arena.span(model);
        let shape = self.arena.shape(model).to_vec();
        let mut entries = Vec::new();
        for index in multi_indices(&shape) {
            for direction in directions {
                entries.push(match direction {
                    Some(direction) if index.is_empty() => *direction,
                    Some(direction) => {
                        self.arena.share(Operator::Component(*direction, index.clone()), vec![], span)
                    }
                    None => self.arena.share(Operator::Zero, vec![], span),
                });
            }
        }
        self.nest(entries, &[&shape[..], trailing].concat(), model)
    }

    /// Row-major scalars as nested stacks.
    pub(super) fn nest(&mut self, entries: Vec<Tensor>, shape: &[usize], origin: Tensor) -> Tensor {
        let Some((first, rest)) = shape.split_first() else { return entries[0] };
        let stride = entries.len() / first;
        let rows = entries.chunks(stride).map(|row| self.nest(row.to_vec(), rest, origin)).collect();
        let span = self.arena.span(origin);
        self.arena.share(Operator::Stack(rows), shape.to_vec(), span)
    }
}

/// All index tuples of a shape, row-major.
pub fn multi_indices(shape: &[usize]) -> Vec<Vec<usize>> {
    shape.iter().fold(vec![vec![]], |indices, extent| {
        indices
            .iter()
            .flat_map(|index| (0..*extent).map(move |last| [&index[..], &[last]].concat()))
            .collect()
    })
}

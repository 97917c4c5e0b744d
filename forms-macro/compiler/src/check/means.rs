//! Means over the own facets of contact pairs, `means(Touch(u), degree, density)`: what `mean` means in them.

use std::collections::HashMap;

use super::Means;
use super::evaluate::{Evaluator, Scope, Value};
use crate::diagnostics::SourceSpan;
use crate::differentiate::map_operands;
use crate::parse::syntax::{Entity, Expression, ExpressionKind, Region};
use crate::tensor::{Operator, Tensor, Variable};

impl Evaluator<'_> {
    pub(super) fn means(&mut self, arguments: &[Expression], scope: &Scope) -> Option<Value> {
        let degree = match arguments[1].kind {
            ExpressionKind::Number(0.0) => 0,
            ExpressionKind::Number(1.0) => 1,
            _ => {
                self.diagnostics.error_with_help(
                    arguments[1].span,
                    "the degree of means is the number 0 or 1",
                    "0 is one mean per own facet, for displacements of degree 1; 1 is one per vertex of the facet, for degree 2",
                );
                return None;
            }
        };
        self.integral(&arguments[0], &arguments[2], Some(Means { number: 0, degree }), scope)
    }

    /// Only pairs have own facets.
    pub(super) fn check_pairs(&mut self, region: &Region, span: SourceSpan) -> Option<()> {
        let Region { name, entity, .. } = region;
        if *entity == Entity::Pairs {
            return Some(());
        }
        self.diagnostics.error_with_help(
            span,
            format!("`means` are over the own facets of contact pairs, and `{name}` consists of {}", entity.plural()),
            format!("write `integral({name}, density)`, in which `mean(e)` is the mean over a cell, or declare `{name}` as `#[pairs]`"),
        );
        None
    }

    /// The density in which `mean` is over the own facet, except inside of `this`, `other`, `jump` and `avg`: there it is over a cell.
    pub(super) fn with_facet_means(&mut self, density: Tensor) -> Option<Tensor> {
        self.facet_means(density, false, &mut HashMap::new())
    }

    fn facet_means(
        &mut self,
        tensor: Tensor,
        inside: bool,
        known: &mut HashMap<(Tensor, bool), Tensor>,
    ) -> Option<Tensor> {
        if let Some(known) = known.get(&(tensor, inside)) {
            return Some(*known);
        }
        let node = self.arena.node(tensor).clone();
        let changed = match node.operator {
            // What has a side is seen from one cell.
            Operator::Restrict(..) | Operator::Opposite(..) => tensor,
            Operator::CellMean(_) | Operator::FacetMean(_) if inside => {
                self.diagnostics.error_with_help(
                    node.span,
                    "means over an own facet are not nested",
                    "the mean is one number on the facet already: leave the inner or the outer `mean` out",
                );
                return None;
            }
            Operator::CellMean(a) => {
                let a = self.facet_means(a, true, known)?;
                self.arena.push(Operator::FacetMean(a), node.shape, node.span)
            }
            operator => {
                let (mut changes, mut failed) = (false, false);
                let mut change = |operand: Tensor| {
                    let new = self.facet_means(operand, inside, known);
                    failed |= new.is_none();
                    changes |= new.is_some_and(|new| new != operand);
                    new.unwrap_or(operand)
                };
                let mut operator = map_operands(&operator, &mut change);
                if let Operator::Partial(_, Variable::Node(varied))
                | Operator::Gateaux { variable: Variable::Node(varied), .. } = &mut operator
                {
                    let new = change(*varied);
                    *varied = new;
                }
                match (failed, changes) {
                    (true, _) => return None,
                    (false, true) => self.arena.push(operator, node.shape, node.span),
                    (false, false) => tensor,
                }
            }
        };
        known.insert((tensor, inside), changed);
        Some(changed)
    }
}

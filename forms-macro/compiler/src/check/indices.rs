//! Shape rules of indices, slices and arrays: from a tensor and what is taken of it to node.

use super::evaluate::Evaluator;
use crate::diagnostics::SourceSpan;
use crate::parse::syntax::{Index, IndexKind};
use crate::parse::whole_number::WholeNumber;
use crate::tensor::{Operator, Selection, Tensor};

impl Evaluator<'_> {
    /// `A[0]`, `A[(.., 1)]`, `u[0..2]`: axes that are not named are taken whole.
    pub(super) fn index(&mut self, a: Tensor, indices: &[Index], span: SourceSpan) -> Option<Tensor> {
        let shape = self.arena.shape(a).to_vec();
        if indices.len() > shape.len() {
            let count = if shape.is_empty() { "no".into() } else { shape.len().to_string() };
            let plural = if shape.len() == 1 { "index" } else { "indices" };
            let message = format!("{} has {count} {plural}, not {}", self.describe(a), indices.len());
            self.diagnostics.error(span, message);
            return None;
        }
        let selections: Vec<_> =
            indices.iter().zip(&shape).map(|(index, extent)| self.selection(index, *extent)).collect();
        let mut selections = selections.into_iter().collect::<Option<Vec<_>>>()?;
        let leading: Option<Vec<usize>> = selections
            .iter()
            .map(|selection| match selection {
                Selection::One(index) => Some(*index),
                Selection::Range { .. } => None,
            })
            .collect();
        if let Some(leading) = leading {
            let rest = shape[leading.len()..].to_vec();
            return Some(self.arena.push(Operator::Component(a, leading), rest, span));
        }
        let rest = shape[selections.len()..].iter().map(|extent| Selection::Range { start: 0, end: *extent });
        selections.extend(rest);
        let taken = selections
            .iter()
            .filter_map(|selection| match selection {
                Selection::One(_) => None,
                Selection::Range { start, end } => Some(end - start),
            })
            .collect();
        Some(self.arena.push(Operator::Slice(a, selections), taken, span))
    }

    fn selection(&mut self, index: &Index, extent: usize) -> Option<Selection> {
        let within = |number: i64| usize::try_from(number).ok().filter(|number| *number <= extent);
        let (message, selection, negative) = match index.kind {
            IndexKind::One(one) => {
                let one = self.whole(one, index.span)?;
                match within(one) {
                    Some(one) if one < extent => return Some(Selection::One(one)),
                    _ => (format!("the index {one} is out of range"), "it runs", one < 0),
                }
            }
            IndexKind::Range { start, end } => {
                let start = start.map_or(Some(0), |start| self.whole(start, index.span))?;
                let end = end.map_or(i64::try_from(extent).ok(), |end| self.whole(end, index.span))?;
                if start >= end {
                    let message = format!("the range {start}..{end} is empty: its end is not part of it");
                    let help = format!("`{start}..{}` takes one entry", start.saturating_add(1));
                    self.diagnostics.error_with_help(index.span, message, help);
                    return None;
                }
                if let (Some(start), Some(end)) = (within(start), within(end)) {
                    return Some(Selection::Range { start, end });
                }
                (format!("the range {start}..{end} is out of range"), "indices run", start < 0)
            }
        };
        let last = extent - 1;
        if negative {
            self.diagnostics.error_with_help(
                index.span,
                format!("{message} in dimension {}: {selection} from 0 to {last}", self.dimension),
                "the last component of a vector is `u[D - 1]`",
            );
        } else if extent == self.dimension {
            self.diagnostics.error_with_help(
                index.span,
                format!("{message} in dimension {}: {selection} from 0 to {last}", self.dimension),
                "`#[forms(dimension = 3)]` compiles a module for one dimension only",
            );
        } else {
            let message =
                format!("{message}: this axis has the extent {extent}, {selection} from 0 to {last}");
            self.diagnostics.error(index.span, message);
        }
        None
    }

    /// The number in this dimension; `None` after a report.
    fn whole(&mut self, number: WholeNumber, span: SourceSpan) -> Option<i64> {
        let found = number.at(self.dimension);
        if found.is_none() {
            let message = format!("this is no whole number in dimension {}", self.dimension);
            self.diagnostics.error(span, message);
        }
        found
    }

    /// `[a, b]`: a new leading axis. A literal zero takes the shape of the other entries.
    pub(super) fn stack(&mut self, entries: Vec<Tensor>, span: SourceSpan) -> Option<Tensor> {
        let is_zero = |entry: &Tensor| self.arena.is_zero(*entry) && self.arena.shape(*entry).is_empty();
        let Some(first) = entries.iter().copied().find(|entry| !is_zero(entry)).or(entries.first().copied())
        else {
            self.diagnostics.error(span, "an empty array is not a vector");
            return None;
        };
        let shape = self.arena.shape(first).to_vec();
        let mut fitted = Vec::new();
        for entry in entries {
            if self.arena.shape(entry) == shape {
                fitted.push(entry);
            } else if self.arena.is_zero(entry) && self.arena.shape(entry).is_empty() {
                fitted.push(self.arena.push(Operator::Zero, shape.clone(), span));
            } else {
                let message = format!(
                    "the entries of an array have one shape: the first is {}, this is {}",
                    self.describe(first),
                    self.describe(entry)
                );
                self.diagnostics.error(self.place_of(entry), message);
                return None;
            }
        }
        let shape = [&[fitted.len()], &shape[..]].concat();
        self.limit_rank(&shape, "[..]", span)?;
        Some(self.arena.push(Operator::Stack(fitted), shape, span))
    }
}

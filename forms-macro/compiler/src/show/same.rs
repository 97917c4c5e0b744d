//! Equality of two expressions, as far as it shows without arithmetic.

use std::collections::HashMap;

use crate::tensor::{Arena, Operator, Tensor};

/// The same expression, up to the order of factors.
pub fn same(arena: &Arena, a: Tensor, b: Tensor) -> bool {
    Comparison::default().are_same(arena, a, b)
}

/// Comparisons of one arena's nodes, of each pair once: nodes are shared, and two factors are compared in both orders.
#[derive(Default)]
pub struct Comparison {
    known: HashMap<(Tensor, Tensor), bool>,
}

impl Comparison {
    /// As [`same`].
    pub fn are_same(&mut self, arena: &Arena, a: Tensor, b: Tensor) -> bool {
        if a == b {
            return true;
        }
        if let Some(known) = self.known.get(&(a, b)) {
            return *known;
        }
        let found = compare(arena, a, b, &mut |a, b| self.are_same(arena, a, b));
        self.known.insert((a, b), found);
        found
    }
}

/// Two different nodes, whose operands `same` compares.
fn compare(arena: &Arena, a: Tensor, b: Tensor, same: &mut dyn FnMut(Tensor, Tensor) -> bool) -> bool {
    use Operator::*;
    let (first, second) = (arena.node(a), arena.node(b));
    if first.shape != second.shape {
        return false;
    }
    let mut pair = |a: Tensor, b: Tensor, c: Tensor, d: Tensor| same(a, c) && same(b, d);
    let scalar = |one: Tensor| arena.shape(one).is_empty();
    match (&first.operator, &second.operator) {
        (Number(a), Number(b)) => a == b,
        (Zero, Zero) | (Identity, Identity) => true,
        (Parameter(a), Parameter(b)) => a == b,
        (Geometry(a), Geometry(b)) => a == b,
        (Field { field: a, order: c }, Field { field: b, order: d }) => a == b && c == d,
        (Inner(a, b), Inner(c, d)) => pair(*a, *b, *c, *d) || pair(*a, *b, *d, *c),
        (Contract(a, b), Contract(c, d)) => {
            // Of two vectors.
            pair(*a, *b, *c, *d) || (first.shape.is_empty() && pair(*a, *b, *d, *c))
        }
        (Scale(a, b), Scale(c, d)) => {
            pair(*a, *b, *c, *d) || (scalar(*b) && scalar(*d) && pair(*a, *b, *d, *c))
        }
        (Add(a, b), Add(c, d)) => pair(*a, *b, *c, *d) || pair(*a, *b, *d, *c),
        (Divide(a, b), Divide(c, d)) | (Outer(a, b), Outer(c, d)) | (Power(a, b), Power(c, d)) => {
            pair(*a, *b, *c, *d)
        }
        (Negate(a), Negate(b))
        | (Gradient(a), Gradient(b))
        | (CellMean(a), CellMean(b))
        | (FacetMean(a), FacetMean(b)) => same(*a, *b),
        (Determinant(a), Determinant(b)) | (Inverse(a), Inverse(b)) | (Cofactor(a), Cofactor(b)) => {
            same(*a, *b)
        }
        (Opposite(a, b), Opposite(c, d)) => pair(*a, *b, *c, *d),
        (Sliding(m, a), Sliding(n, b)) => m == n && same(*a, *b),
        (Restrict(m, a), Restrict(n, b)) => m == n && same(*a, *b),
        (Map(m, a), Map(n, b)) => m == n && same(*a, *b),
        (Apply(f, a), Apply(g, b)) => f == g && same(*a, *b),
        (Component(a, i), Component(b, j)) => i == j && same(*a, *b),
        (
            Named(crate::tensor::Named::Call { function: f, arguments: a, directions: c }),
            Named(crate::tensor::Named::Call { function: g, arguments: b, directions: d }),
        ) => {
            let mut all =
                |a: &[Tensor], b: &[Tensor]| a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(*a, *b));
            f == g && all(a, b) && all(&c.concat(), &d.concat()) && c.len() == d.len()
        }
        _ => false,
    }
}

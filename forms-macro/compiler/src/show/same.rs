//! Whether two expressions are the same, as far as shows without arithmetic.

use crate::tensor::{Arena, Operator, Tensor};

/// The same expression, up to the order of factors.
pub fn same(arena: &Arena, a: Tensor, b: Tensor) -> bool {
    use Operator::*;
    if a == b {
        return true;
    }
    let (first, second) = (arena.node(a), arena.node(b));
    if first.shape != second.shape {
        return false;
    }
    let pair = |a: Tensor, b: Tensor, c: Tensor, d: Tensor| same(arena, a, c) && same(arena, b, d);
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
        (Negate(a), Negate(b)) | (Gradient(a), Gradient(b)) => same(arena, *a, *b),
        (Determinant(a), Determinant(b)) | (Inverse(a), Inverse(b)) | (Cofactor(a), Cofactor(b)) => {
            same(arena, *a, *b)
        }
        (Restrict(m, a), Restrict(n, b)) => m == n && same(arena, *a, *b),
        (Map(m, a), Map(n, b)) => m == n && same(arena, *a, *b),
        (Apply(f, a), Apply(g, b)) => f == g && same(arena, *a, *b),
        (Component(a, i), Component(b, j)) => i == j && same(arena, *a, *b),
        (
            Named(crate::tensor::Named::Call { function: f, arguments: a, directions: c }),
            Named(crate::tensor::Named::Call { function: g, arguments: b, directions: d }),
        ) => {
            let all = |a: &[Tensor], b: &[Tensor]| {
                a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(arena, *a, *b))
            };
            f == g && all(a, b) && all(&c.concat(), &d.concat()) && c.len() == d.len()
        }
        _ => false,
    }
}

//! Determinants, cofactors and inverses of square matrices, up to three by three.

use super::Scalariser;
use crate::differentiate::multi_indices;
use crate::optimise::scalar::Scalar;

impl Scalariser<'_> {
    /// det A, along the first row.
    pub(super) fn determinant(&mut self, a: &[Scalar], size: usize) -> Scalar {
        if size == 1 {
            return a[0];
        }
        let cofactors = self.cofactors(a, size);
        let pairs: Vec<_> = (0..size).map(|column| (a[column], cofactors[column])).collect();
        self.sum_of_products(&pairs)
    }

    /// cof A = det(A) A⁻ᵀ, without a division.
    pub(super) fn cofactors(&mut self, a: &[Scalar], size: usize) -> Vec<Scalar> {
        match size {
            1 => vec![self.graph.number(1.0)],
            2 => {
                let (minus_b, minus_c) = (self.graph.negate(a[1]), self.graph.negate(a[2]));
                vec![a[3], minus_c, minus_b, a[0]]
            }
            _ => multi_indices(&[3, 3])
                .iter()
                .map(|ij| {
                    // Cyclic indices carry the sign.
                    let at = |row: usize, column: usize| a[(ij[0] + row) % 3 * 3 + (ij[1] + column) % 3];
                    let first = self.graph.multiply(at(1, 1), at(2, 2));
                    let second = self.graph.multiply(at(1, 2), at(2, 1));
                    let minus = self.graph.negate(second);
                    self.graph.add(first, minus)
                })
                .collect(),
        }
    }
    /// The bilinear cof(A, B) of 3×3 matrices. cof A is quadratic: its polar form has each product of two entries in both
    /// orders.
    pub(super) fn mixed_cofactors(&mut self, a: &[Scalar], b: &[Scalar]) -> Vec<Scalar> {
        let entry = |ij: &Vec<usize>| {
            let place = |row: usize, column: usize| (ij[0] + row) % 3 * 3 + (ij[1] + column) % 3;
            let (first, second) = ([place(1, 1), place(2, 2)], [place(1, 2), place(2, 1)]);
            let plus = self.sum_of_products(&[(a[first[0]], b[first[1]]), (b[first[0]], a[first[1]])]);
            let minus = self.sum_of_products(&[(a[second[0]], b[second[1]]), (b[second[0]], a[second[1]])]);
            let minus = self.graph.negate(minus);
            self.graph.add(plus, minus)
        };
        multi_indices(&[3, 3]).iter().map(entry).collect()
    }

    /// A⁻¹ = cof(A)ᵀ / det A.
    pub(super) fn inverse(&mut self, a: &[Scalar], size: usize) -> Vec<Scalar> {
        let determinant = self.determinant(a, size);
        let cofactors = self.cofactors(a, size);
        (0..size * size)
            .map(|entry| self.graph.divide(cofactors[(entry % size) * size + entry / size], determinant))
            .collect()
    }
}

//! Sums of monomials at points that differ from lane to lane.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lane values are plain.
#![allow(clippy::needless_range_loop)]

use forms_core::contract::Lane;

use super::LaneBasis;
use crate::element::Table;

/// The highest exponent, and one more.
const POWERS: usize = 7;

/// Some functions of a table.
#[derive(Clone, Debug)]
pub(super) struct Monomials {
    exponents: Vec<[u8; 3]>,
    /// Function after function.
    coefficients: Vec<f64>,
    functions: usize,
}

impl Monomials {
    pub fn new(table: &Table, functions: &[usize]) -> Self {
        let coefficients = functions.iter().flat_map(|function| table.coefficients_of(*function)).copied();
        Monomials {
            exponents: table.exponents().to_vec(),
            coefficients: coefficients.collect(),
            functions: functions.len(),
        }
    }

    /// Sums of the functions in their place, with coefficients row after row.
    pub fn combine(&mut self, rows: &[f64]) {
        let (count, old) = (self.exponents.len(), self.coefficients.clone());
        for (i, row) in rows.chunks(self.functions).enumerate() {
            for monomial in 0..count {
                let terms = row.iter().enumerate();
                let sum = terms.map(|(j, factor)| factor * old[j * count + monomial]).sum();
                self.coefficients[i * count + monomial] = sum;
            }
        }
    }

    /// Derivatives at a point up to `ORDER`, two at most.
    #[inline(always)]
    pub fn evaluate<L: Lane, const ORDER: usize, const D: usize>(
        &self,
        point: &[L; D],
        basis: &mut LaneBasis<L, D>,
    ) {
        let (zero, one) = (L::splat(0.0), L::splat(1.0));
        let mut powers = [[[one, zero, zero]; POWERS]; D];
        for axis in 0..D {
            for n in 1..POWERS {
                let [p, dp, ddp] = powers[axis][n - 1];
                let x = point[axis];
                powers[axis][n] = [p * x, dp * x + p, ddp * x + (dp + dp)];
            }
        }
        basis.value.clear();
        basis.value.resize(self.functions, zero);
        basis.gradient.clear();
        basis.gradient.resize(if ORDER > 0 { self.functions } else { 0 }, [zero; D]);
        basis.hessian.clear();
        basis.hessian.resize(if ORDER > 1 { self.functions } else { 0 }, [[zero; D]; D]);
        let count = self.exponents.len();
        for monomial in 0..count {
            let exponents = &self.exponents[monomial];
            let mut value = one;
            let mut gradient = [one; D];
            let mut hessian = [[one; D]; D];
            for axis in 0..D {
                let power = &powers[axis][exponents[axis] as usize];
                value = value * power[0];
                for k in 0..D {
                    gradient[k] = gradient[k] * power[usize::from(k == axis)];
                    if ORDER > 1 {
                        for l in 0..D {
                            let order = usize::from(k == axis) + usize::from(l == axis);
                            hessian[k][l] = hessian[k][l] * power[order];
                        }
                    }
                }
            }
            for function in 0..self.functions {
                let factor = L::splat(self.coefficients[function * count + monomial]);
                basis.value[function] = value.multiply_add(factor, basis.value[function]);
                if ORDER > 0 {
                    for k in 0..D {
                        let sum = &mut basis.gradient[function][k];
                        *sum = gradient[k].multiply_add(factor, *sum);
                        if ORDER > 1 {
                            for l in 0..D {
                                let sum = &mut basis.hessian[function][k][l];
                                *sum = hessian[k][l].multiply_add(factor, *sum);
                            }
                        }
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::{CellShape, Elements};

    fn agrees<const D: usize>(kind: &Elements, shape: CellShape, point: [f64; D]) {
        let Ok(element) = kind.on(shape) else { return };
        let Some(table) = element.as_table() else { return };
        let tables = element.tabulate_with_hessians(&[point]);
        let all: Vec<usize> = (0..element.nodes()).rev().collect();
        let mut basis = LaneBasis::default();
        Monomials::new(table, &all).evaluate::<f64, 2, D>(&point, &mut basis);
        for (place, node) in all.into_iter().enumerate() {
            let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-11, "{kind} {shape:?}: {a} is not {b}");
            close(basis.value[place], tables.value[node]);
            for k in 0..D {
                close(basis.gradient[place][k], tables.gradient[node][k]);
                for l in 0..D {
                    close(basis.hessian[place][k][l], tables.hessian[node][k][l]);
                }
            }
        }
    }

    #[test]
    fn lanes_and_tables_agree() {
        for kind in [Elements::Mini(1), Elements::Mini(2), Elements::CrouzeixRaviart, Elements::Serendipity] {
            for shape in CellShape::ALL {
                match shape.dimension() {
                    2 => agrees(&kind, shape, [0.3, 0.45]),
                    _ => agrees(&kind, shape, [0.3, 0.15, 0.4]),
                }
            }
        }
    }
}

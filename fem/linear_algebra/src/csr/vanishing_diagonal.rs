//! Diagonals with zeros where rounding is all that they have, as those of multipliers.

use super::CsrMatrix;

/// The part of a product of two entries off the diagonal below which the product of both diagonal entries is rounding.
const ROUNDING: f64 = 1e-15;

impl CsrMatrix {
    /// The diagonal, with zeros for entries at the level of rounding: of two unknowns i and j with |a_ii a_jj| ≤ 10⁻¹⁵ |a_ij a_ji| the
    /// smaller one. It is lost next to a_ij a_ji / a_jj, what elimination of the other unknown adds to it. Units of unknowns and of equations do not
    /// change the products' ratio. A positive definite matrix has |a_ij|² ≤ a_ii a_jj, and so no such entry.
    pub fn diagonal_above_rounding(&self) -> Vec<f64> {
        let diagonal = self.diagonal();
        let mut found = diagonal.clone();
        // Nothing is compared with a zero.
        let factor = |value: &f64| if *value == 0.0 { 0.0 } else { ROUNDING.powf(0.25) / value.abs().sqrt() };
        let factors: Vec<f64> = diagonal.iter().map(factor).collect();
        for row in 0..diagonal.len() {
            let (columns, values) = self.row(row);
            for (column, value) in columns.iter().zip(values) {
                let column = *column as usize;
                let scale = factors[row] * factors.get(column).copied().unwrap_or_default();
                // Of two entries with such a product at least one is that large.
                let is_large = value.abs() * scale >= 1.0 && column != row;
                if is_large && (value.abs() * scale) * (self.get(column, row).abs() * scale) >= 1.0 {
                    let is_smaller = diagonal[row].abs() <= diagonal[column].abs();
                    found[if is_smaller { row } else { column }] = 0.0;
                }
            }
        }
        found
    }
}

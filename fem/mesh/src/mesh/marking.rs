//! Marking of the cells whose shares of an estimated error are large.

use thiserror::Error;

use super::{Mesh, MeshError};

/// The least set of cells whose indicators sum up to a fraction of the sum of all, in ascending order: bulk marking after
/// W. Dörfler, A convergent adaptive algorithm for Poisson's equation, SIAM J. Numer. Anal. 33 (1996).
///
/// Indicators are numbers that add up: the squares η_T² where the estimated error is the root of their sum, the sizes |η_T| where it
/// is the sum itself. A fraction is usually between 0.3 and 0.7. Of equal indicators those of cells with lower
/// numbers come first, and an indicator of zero is not marked: where all are zero, nothing is.
///
/// ```
/// # use forms_mesh as forms_fem;
/// use forms_fem::mesh::doerfler;
///
/// assert_eq!(doerfler(&[1.0, 4.0, 3.0, 2.0], 0.6)?, [1, 2]);
/// # Ok::<(), forms_fem::mesh::MarkingError>(())
/// ```
///
/// # Errors
/// [`MarkingError`]: a fraction that is not above 0 and at most 1, an indicator that is negative or not finite.
pub fn doerfler(indicators: &[f64], fraction: f64) -> Result<Vec<u32>, MarkingError> {
    if !(fraction > 0.0 && fraction <= 1.0) {
        return Err(MarkingError::Fraction { fraction });
    }
    if u32::try_from(indicators.len()).is_err() {
        return Err(MarkingError::TooMany { count: indicators.len() });
    }
    if let Some(cell) = indicators.iter().position(|value| !(value.is_finite() && *value >= 0.0)) {
        return Err(MarkingError::Indicator { cell, value: indicators[cell] });
    }
    // No sum of as many as there can be overflows, and a power of two rounds nothing.
    let largest = indicators.iter().copied().fold(0.0, f64::max);
    let scale = if largest > 1e280 { 0.5_f64.powi(64) } else { 1.0 };
    let mut cells: Vec<u32> = (0..indicators.len() as u32).collect();
    cells.retain(|cell| indicators[*cell as usize] > 0.0);
    let indicator = |cell: &u32| indicators[*cell as usize];
    cells.sort_unstable_by(|a, b| indicator(b).total_cmp(&indicator(a)).then(a.cmp(b)));
    // Both sums are formed in one order, so that a fraction of 1 is reached by rounding, too.
    let share = |cell: &u32| indicator(cell) * scale;
    let bulk = fraction * cells.iter().map(share).sum::<f64>();
    let mut sum = 0.0;
    let enough = cells.iter().position(|cell| {
        sum += share(cell);
        sum >= bulk
    });
    cells.truncate(enough.map_or(cells.len(), |last| last + 1));
    cells.sort_unstable();
    Ok(cells)
}

/// Indicators or fractions by which nothing can be marked.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs)]
pub enum MarkingError {
    /// The fraction is not one.
    #[error("a fraction of the error above 0 and at most 1 can be marked, not {fraction}")]
    Fraction {
        /// The fraction asked for.
        fraction: f64,
    },
    /// An indicator is no share of an error.
    #[error("the indicator of cell {cell} is {value}: indicators are finite and not negative")]
    Indicator {
        cell: usize,
        /// The indicator.
        value: f64,
    },
    /// More indicators than a mesh can have cells.
    #[error("{count} indicators are more than a mesh can have cells")]
    TooMany {
        /// Number of indicators.
        count: usize,
    },
}

impl<const D: usize> Mesh<D> {
    /// Cells in ascending order, each once, where all of them exist.
    pub(super) fn marked_cells(&self, cells: &[u32]) -> Result<Vec<u32>, MeshError> {
        let count = self.cell_count();
        if let Some(&cell) = cells.iter().find(|cell| **cell as usize >= count) {
            return Err(MeshError::MarkedCell { cell, count });
        }
        let mut cells = cells.to_vec();
        cells.sort_unstable();
        cells.dedup();
        Ok(cells)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The least number of cells with the bulk, by all subsets.
    fn least(indicators: &[f64], fraction: f64) -> u32 {
        let sum = |set: u32| -> f64 {
            indicators
                .iter()
                .enumerate()
                .filter(|(cell, _)| set >> cell & 1 == 1)
                .map(|(_, value)| value)
                .sum()
        };
        let all = (1 << indicators.len()) - 1;
        (0..=all).filter(|set| sum(*set) >= fraction * sum(all)).map(u32::count_ones).min().unwrap_or(0)
    }

    #[test]
    fn no_smaller_set_has_the_bulk() {
        let mut state = 7_u32;
        for _ in 0..200 {
            let mut indicators = [0.0; 9];
            for value in &mut indicators {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                // Whole numbers, so that sums are exact and many are equal.
                *value = f64::from(state >> 29);
            }
            for fraction in [0.125, 0.5, 0.75, 1.0] {
                let marked = doerfler(&indicators, fraction).unwrap();
                assert_eq!(marked.len() as u32, least(&indicators, fraction), "{indicators:?}, {fraction}");
                let sum: f64 = marked.iter().map(|cell| indicators[*cell as usize]).sum();
                assert!(sum >= fraction * indicators.iter().sum::<f64>());
                assert!(marked.is_sorted());
            }
        }
    }

    #[test]
    fn equal_indicators_by_number_and_zeros_never() {
        assert_eq!(doerfler(&[2.0; 6], 0.5), Ok(vec![0, 1, 2]));
        assert_eq!(doerfler(&[0.0, 1.0, 0.0, 1.0], 1.0), Ok(vec![1, 3]));
        assert_eq!(doerfler(&[0.0; 3], 0.5), Ok(vec![]));
        assert_eq!(doerfler(&[], 0.5), Ok(vec![]));
        // Neither sums that overflow nor numbers without a reciprocal.
        assert_eq!(doerfler(&[f64::MAX; 4], 0.5), Ok(vec![0, 1]));
        assert_eq!(doerfler(&[5e-324; 4], 0.5), Ok(vec![0, 1]));
    }

    #[test]
    fn what_is_no_share_of_an_error_is_named() {
        let message = |indicators: &[f64], fraction| doerfler(indicators, fraction).unwrap_err().to_string();
        assert_eq!(
            message(&[1.0, f64::NAN], 0.5),
            "the indicator of cell 1 is NaN: indicators are finite and not negative"
        );
        assert!(message(&[-1e-30], 0.5).starts_with("the indicator of cell 0 is -"));
        assert!(message(&[1.0, 2.0, f64::INFINITY], 0.5).starts_with("the indicator of cell 2 is inf"));
        for fraction in [0.0, -0.5, 1.5, f64::NAN] {
            assert!(message(&[1.0], fraction).starts_with("a fraction of the error above 0 and at most 1"));
        }
    }
}

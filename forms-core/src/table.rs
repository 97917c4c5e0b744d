//! Tabulated laws: data points interpolated by a piecewise polynomial, with derivatives.

use std::fmt;
use std::sync::Arc;

use crate::real::Real;

/// A function of one scalar given by data points: a member of `Data` declared `law: Table` is called in a form
/// as `law(s)`.
///
/// Outside the range of the points the law goes on along a straight line with the slope at the end, or stays
/// constant after [`Table::constant_outside`]. At a data point a derivative that jumps is that of the interval
/// on the right (at the last point: on the left). Clones share the points.
///
/// ```
/// use forms_core::contract::Table;
/// let conductivity = Table::monotone_cubic(&[[20.0, 52.0], [100.0, 51.0], [400.0, 43.0], [800.0, 27.0]])?;
/// assert_eq!(conductivity.value(100.0), 51.0);
/// assert!(conductivity.derivative(1, 300.0) < 0.0);
/// # Ok::<(), forms_core::contract::TableError>(())
/// ```
#[derive(Clone)]
pub struct Table {
    law: Arc<Law>,
}

struct Law {
    /// Increasing.
    points: Vec<f64>,
    /// Per interval, and one before and one after all points: Σ c_k (s − point)^k.
    pieces: Vec<[f64; 4]>,
}

/// Errors of a table's data points.
#[derive(Clone, Debug, PartialEq)]
pub enum TableError {
    /// Fewer than two points.
    TooFew {
        /// Their number.
        found: usize,
    },
    /// A coordinate is NaN or infinite.
    NotFinite {
        /// Index of the point.
        index: usize,
        /// The point.
        point: [f64; 2],
    },
    /// The arguments do not increase.
    NotIncreasing {
        /// Index of the point whose argument is not larger than the one before.
        index: usize,
        /// The argument before.
        before: f64,
        /// Its own.
        argument: f64,
    },
}

impl fmt::Display for TableError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TableError::TooFew { found } => {
                write!(f, "a table needs at least two points, it has {found}")
            }
            TableError::NotFinite { index, point } => {
                write!(f, "point {index} of the table is not finite: ({}, {})", point[0], point[1])
            }
            TableError::NotIncreasing { index, before, argument } => write!(
                f,
                "the arguments of a table increase, but point {index} has {argument} after {before}"
            ),
        }
    }
}

impl std::error::Error for TableError {}

impl Table {
    /// Straight lines between the points: continuous, its slope jumps.
    ///
    /// # Errors
    /// A [`TableError`] that names the index of the point.
    pub fn linear(points: &[[f64; 2]]) -> Result<Self, TableError> {
        check(points)?;
        let pieces = points.windows(2).map(|pair| [pair[0][1], secant(pair), 0.0, 0.0]);
        Ok(Self::from_pieces(points, pieces.collect()))
    }

    /// Cubics with a continuous slope that are monotone wherever the data are: no overshoot
    /// (Fritsch and Carlson, SIAM J. Numer. Anal. 17, 1980; slopes by Fritsch and Butland, 1984).
    ///
    /// # Errors
    /// A [`TableError`] that names the index of the point.
    pub fn monotone_cubic(points: &[[f64; 2]]) -> Result<Self, TableError> {
        check(points)?;
        let lengths: Vec<f64> = points.windows(2).map(|pair| pair[1][0] - pair[0][0]).collect();
        let secants: Vec<f64> = points.windows(2).map(secant).collect();
        let last = secants.len() - 1;
        let mut slopes = vec![secants[0]];
        for k in 1..=last {
            let (before, after) = (secants[k - 1], secants[k]);
            let (first, second) = (2.0 * lengths[k] + lengths[k - 1], lengths[k] + 2.0 * lengths[k - 1]);
            // A weighted harmonic mean; zero at an extremum of the data.
            let mean = (first + second) / (first / before + second / after);
            slopes.push(if before * after > 0.0 { mean } else { 0.0 });
        }
        slopes.push(secants[last]);
        if last > 0 {
            slopes[0] = end_slope(lengths[0], lengths[1], secants[0], secants[1]);
            slopes[last + 1] = end_slope(lengths[last], lengths[last - 1], secants[last], secants[last - 1]);
        }
        Ok(Self::hermite(points, &slopes))
    }

    /// The natural cubic spline: two continuous derivatives, the second zero at both ends. It may overshoot
    /// between points that rise steeply.
    ///
    /// # Errors
    /// A [`TableError`] that names the index of the point.
    pub fn natural_spline(points: &[[f64; 2]]) -> Result<Self, TableError> {
        check(points)?;
        let count = points.len();
        let lengths: Vec<f64> = points.windows(2).map(|pair| pair[1][0] - pair[0][0]).collect();
        let secants: Vec<f64> = points.windows(2).map(secant).collect();
        // Second derivatives m: h₋ m₋ + 2 (h₋ + h₊) m + h₊ m₊ = 6 (s₊ − s₋), by the Thomas algorithm.
        let (mut factor, mut right) = (vec![0.0; count], vec![0.0; count]);
        for k in 1..count - 1 {
            let pivot = 2.0 * (lengths[k - 1] + lengths[k]) - lengths[k - 1] * factor[k - 1];
            factor[k] = lengths[k] / pivot;
            right[k] = (6.0 * (secants[k] - secants[k - 1]) - lengths[k - 1] * right[k - 1]) / pivot;
        }
        let mut bends = vec![0.0; count];
        for k in (1..count - 1).rev() {
            bends[k] = right[k] - factor[k] * bends[k + 1];
        }
        let pieces = (0..count - 1).map(|k| {
            let slope = secants[k] - lengths[k] * (2.0 * bends[k] + bends[k + 1]) / 6.0;
            [points[k][1], slope, bends[k] / 2.0, (bends[k + 1] - bends[k]) / (6.0 * lengths[k])]
        });
        Ok(Self::from_pieces(points, pieces.collect()))
    }

    /// This law, constant outside the range of its points: the derivatives are zero there.
    pub fn constant_outside(self) -> Self {
        let mut pieces = self.law.pieces.clone();
        let last = pieces.len() - 1;
        for end in [0, last] {
            pieces[end][1] = 0.0;
        }
        Table { law: Arc::new(Law { points: self.law.points.clone(), pieces }) }
    }

    /// The law at `argument`.
    pub fn value(&self, argument: f64) -> f64 {
        self.derivative(0, argument)
    }

    /// The law's derivative of some order; order 0 is the law itself.
    pub fn derivative(&self, order: usize, argument: f64) -> f64 {
        let (piece, start) = self.piece(argument);
        let s = argument - start;
        // Horner's scheme with the factors k (k − 1) … of each power.
        (order..4).rev().fold(0.0 * s, |sum, k| {
            let factor: usize = (k - order + 1..=k).product();
            sum * s + factor as f64 * piece[k]
        })
    }

    /// The law in a function written in Rust.
    pub fn at<R: Real>(&self, argument: R) -> R {
        let (piece, start) = self.piece(argument.value());
        let s = argument - start;
        piece.iter().rev().fold(s * 0.0, |sum, coefficient| sum * s + *coefficient)
    }

    /// First and last argument.
    pub fn range(&self) -> [f64; 2] {
        let points = &self.law.points;
        [points[0], points[points.len() - 1]]
    }

    /// Coefficients around a point, and that point.
    fn piece(&self, argument: f64) -> (&[f64; 4], f64) {
        let Law { points, pieces } = &*self.law;
        let [_, last] = self.range();
        let mut index = points.partition_point(|point| *point <= argument);
        if argument == last {
            index -= 1;
        }
        (&pieces[index], points[index.saturating_sub(1)])
    }

    fn hermite(points: &[[f64; 2]], slopes: &[f64]) -> Self {
        let pieces = points.windows(2).zip(slopes.windows(2)).map(|(pair, slopes)| {
            let (length, secant) = (pair[1][0] - pair[0][0], secant(pair));
            let second = (3.0 * secant - 2.0 * slopes[0] - slopes[1]) / length;
            let third = (slopes[0] + slopes[1] - 2.0 * secant) / (length * length);
            [pair[0][1], slopes[0], second, third]
        });
        Self::from_pieces(points, pieces.collect())
    }

    /// Adds the straight lines outside.
    fn from_pieces(points: &[[f64; 2]], inner: Vec<[f64; 4]>) -> Self {
        let last = inner.len() - 1;
        let length = points[last + 1][0] - points[last][0];
        let [_, b, c, d] = inner[last];
        let slope = b + length * (2.0 * c + length * 3.0 * d);
        let mut pieces = vec![[points[0][1], inner[0][1], 0.0, 0.0]];
        pieces.extend(inner);
        pieces.push([points[last + 1][1], slope, 0.0, 0.0]);
        Table { law: Arc::new(Law { points: points.iter().map(|point| point[0]).collect(), pieces }) }
    }
}

impl fmt::Debug for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [first, last] = self.range();
        write!(f, "Table({} points from {first} to {last})", self.law.points.len())
    }
}

fn check(points: &[[f64; 2]]) -> Result<(), TableError> {
    if points.len() < 2 {
        return Err(TableError::TooFew { found: points.len() });
    }
    if let Some(index) = points.iter().position(|point| !point.iter().all(|x| x.is_finite())) {
        return Err(TableError::NotFinite { index, point: points[index] });
    }
    match points.windows(2).position(|pair| pair[0][0] >= pair[1][0]) {
        Some(index) => {
            let (before, argument) = (points[index][0], points[index + 1][0]);
            Err(TableError::NotIncreasing { index: index + 1, before, argument })
        }
        None => Ok(()),
    }
}

fn secant(pair: &[[f64; 2]]) -> f64 {
    (pair[1][1] - pair[0][1]) / (pair[1][0] - pair[0][0])
}

/// One-sided slope of three points, limited so that the end stays monotone.
fn end_slope(length: f64, next_length: f64, secant: f64, next_secant: f64) -> f64 {
    let slope = ((2.0 * length + next_length) * secant - length * next_secant) / (length + next_length);
    if slope * secant <= 0.0 {
        0.0
    } else if secant * next_secant <= 0.0 && slope.abs() > 3.0 * secant.abs() {
        3.0 * secant
    } else {
        slope
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::{Dual, Seeded};

    type Outcome = Result<(), TableError>;
    type Make = fn(&[[f64; 2]]) -> Result<Table, TableError>;
    const KINDS: [Make; 3] = [Table::linear, Table::monotone_cubic, Table::natural_spline];
    const POINTS: [[f64; 2]; 5] = [[-1.0, 0.0], [0.0, 1.0], [0.5, 1.2], [2.0, 5.0], [3.0, 5.5]];

    #[test]
    fn a_law_passes_through_its_points_and_goes_on_straight() -> Outcome {
        for kind in KINDS {
            let law = kind(&POINTS)?;
            for [s, value] in POINTS {
                assert!((law.value(s) - value).abs() < 1e-14);
                assert!((law.value(s - 1e-9) - value).abs() < 1e-7);
            }
            for (inside, outside) in [(-1.0, -4.0), (3.0, 7.0)] {
                let line = law.value(inside) + law.derivative(1, inside) * (outside - inside);
                assert!((law.value(outside) - line).abs() < 1e-13);
                assert_eq!(law.derivative(1, outside), law.derivative(1, inside));
                assert_eq!(law.derivative(2, outside), 0.0);
            }
            assert!(law.value(f64::NAN).is_nan() && law.derivative(3, f64::NAN).is_nan());
            let constant = law.constant_outside();
            assert_eq!((constant.value(9.0), constant.derivative(1, 9.0)), (5.5, 0.0));
            assert_eq!((constant.value(-9.0), constant.derivative(1, -9.0)), (0.0, 0.0));
        }
        Ok(())
    }

    #[test]
    fn derivatives_agree_with_differences_and_with_dual_numbers() -> Outcome {
        let h = 1e-5;
        for kind in KINDS {
            let law = kind(&POINTS)?;
            for s in [-2.0, -0.3, 0.2, 0.7, 1.9, 2.5, 4.0] {
                for order in 0..3 {
                    let difference =
                        (law.derivative(order, s + h) - law.derivative(order, s - h)) / (2.0 * h);
                    assert!((law.derivative(order + 1, s) - difference).abs() < 1e-7);
                }
                let dual = law.at(<Dual<Dual<f64>>>::seed(s, 0, &[0, 0]));
                assert!((dual.value() - law.value(s)).abs() < 1e-14);
                assert!((dual.highest() - law.derivative(2, s)).abs() < 1e-12);
            }
        }
        Ok(())
    }

    #[test]
    fn straight_data_give_a_straight_law_and_a_spline_follows_a_smooth_one() -> Outcome {
        let line: Vec<[f64; 2]> = [0.0, 0.3, 1.0, 4.0].iter().map(|s| [*s, 2.0 - 3.0 * s]).collect();
        for kind in KINDS {
            let law = kind(&line)?;
            for s in [-1.0, 0.1, 0.9, 3.0, 5.0] {
                assert!((law.value(s) - (2.0 - 3.0 * s)).abs() < 1e-13);
                assert!((law.derivative(1, s) + 3.0).abs() < 1e-13 && law.derivative(2, s).abs() < 1e-12);
            }
        }
        // sin has no curvature at 0 and π, as the natural spline.
        let sine: Vec<[f64; 2]> =
            (0..=32).map(|k| std::f64::consts::PI * f64::from(k) / 32.0).map(|s| [s, s.sin()]).collect();
        let spline = Table::natural_spline(&sine)?;
        for s in [0.05, 1.0, 2.222, 3.1] {
            assert!((spline.value(s) - s.sin()).abs() < 1e-6);
            assert!((spline.derivative(1, s) - s.cos()).abs() < 1e-4);
            assert!((spline.derivative(2, s) + s.sin()).abs() < 2e-3);
        }
        Ok(())
    }

    #[test]
    fn a_monotone_law_does_not_overshoot_and_keeps_a_continuous_slope() -> Outcome {
        let steps = [[0.0, 0.0], [1.0, 0.0], [1.1, 1.0], [2.0, 1.0], [3.0, 1.5]];
        let law = Table::monotone_cubic(&steps)?;
        for k in 0..=300 {
            let s = f64::from(k) / 100.0;
            assert!((-1e-14..=1.5 + 1e-14).contains(&law.value(s)) && law.derivative(1, s) >= -1e-12);
        }
        for [s, _] in steps {
            assert!((law.derivative(1, s) - law.derivative(1, s - 1e-10)).abs() < 1e-6);
        }
        Ok(())
    }

    #[test]
    fn errors_name_the_point() {
        let message = |points: &[[f64; 2]]| Table::linear(points).err().map(|error| error.to_string());
        assert_eq!(message(&[[1.0, 2.0]]).as_deref(), Some("a table needs at least two points, it has 1"));
        assert_eq!(
            message(&[[1.0, 2.0], [2.0, f64::NAN]]).as_deref(),
            Some("point 1 of the table is not finite: (2, NaN)")
        );
        assert_eq!(
            message(&[[1.0, 2.0], [3.0, 1.0], [3.0, 4.0]]).as_deref(),
            Some("the arguments of a table increase, but point 2 has 3 after 3")
        );
    }
}

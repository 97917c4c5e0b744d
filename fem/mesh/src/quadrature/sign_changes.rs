//! Sign changes of a polynomial on [0, 1].

/// Halvings of an interval, after which it is as short as doubles allow.
const HALVINGS: usize = 60;

/// The points at which a polynomial of degree n on \[0, 1\] is sampled: n + 1 of Chebyshev's, both ends among them (the
/// middle for n = 0).
pub fn samples(degree: usize) -> Vec<f64> {
    match degree {
        0 => vec![0.5],
        _ => (0..=degree)
            .map(|k| 0.5 - 0.5 * (std::f64::consts::PI * k as f64 / degree as f64).cos())
            .collect(),
    }
}

/// A polynomial on \[0, 1\], by its coefficients of powers of 2s − 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Polynomial {
    coefficients: Vec<f64>,
}

impl Polynomial {
    /// The polynomial with these values at [`samples`].
    pub fn through(values: &[f64]) -> Polynomial {
        let points: Vec<f64> =
            samples(values.len().saturating_sub(1)).iter().map(|s| 2.0 * s - 1.0).collect();
        // Newton's divided differences, then Horner's rule on polynomials.
        let mut differences = values.to_vec();
        for order in 1..values.len() {
            for k in (order..values.len()).rev() {
                differences[k] = (differences[k] - differences[k - 1]) / (points[k] - points[k - order]);
            }
        }
        let mut coefficients: Vec<f64> = vec![];
        for (difference, point) in differences.iter().zip(&points).rev() {
            let mut product = vec![0.0; coefficients.len() + 1];
            for (power, coefficient) in coefficients.iter().enumerate() {
                product[power + 1] += coefficient;
                product[power] -= point * coefficient;
            }
            product[0] += difference;
            coefficients = product;
        }
        Polynomial { coefficients }
    }

    /// The value at s.
    pub fn at(&self, s: f64) -> f64 {
        value(&self.coefficients, 2.0 * s - 1.0)
    }

    /// The derivative at s.
    pub fn slope(&self, s: f64) -> f64 {
        2.0 * value(&derivative(&self.coefficients), 2.0 * s - 1.0)
    }

    /// The points inside (0, 1) where it goes from positive to not positive or back, ascending: at most as many as its
    /// degree.
    pub fn sign_changes(&self) -> Vec<f64> {
        changes(&self.coefficients)
            .into_iter()
            .map(|t| 0.5 + 0.5 * t)
            .filter(|s| *s > 0.0 && *s < 1.0)
            .collect()
    }
}

fn value(coefficients: &[f64], t: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * t + coefficient)
}

fn derivative(coefficients: &[f64]) -> Vec<f64> {
    coefficients.iter().enumerate().skip(1).map(|(power, coefficient)| power as f64 * coefficient).collect()
}

/// A value at an extremum below this part of the coefficients' sum is rounding: the polynomial touches zero there.
const TOUCHING: f64 = 1e-14;

/// Sign changes in (−1, 1): one at most between neighbouring extrema. Where the polynomial only touches zero, its sign is
/// that of rounding, and there is no end of an interval.
fn changes(coefficients: &[f64]) -> Vec<f64> {
    if coefficients.len() < 2 {
        return vec![];
    }
    let scale: f64 = coefficients.iter().map(|coefficient| coefficient.abs()).sum();
    let mut ends = changes(&derivative(coefficients));
    ends.retain(|t| value(coefficients, *t).abs() > TOUCHING * scale);
    ends.insert(0, -1.0);
    ends.push(1.0);
    let positive = |t: f64| value(coefficients, t) > 0.0;
    let between = |pair: &[f64]| {
        let [mut low, mut high] = [pair[0], pair[1]];
        let side = positive(low);
        (side != positive(high)).then(|| {
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                if positive(middle) == side { low = middle } else { high = middle }
            }
            0.5 * (low + high)
        })
    };
    ends.windows(2).filter_map(between).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(degree: usize, f: impl Fn(f64) -> f64) -> Vec<f64> {
        let values: Vec<f64> = samples(degree).into_iter().map(f).collect();
        Polynomial::through(&values).sign_changes()
    }

    #[test]
    fn every_root_of_odd_order_is_found() {
        let roots = [0.1, 0.1004, 0.5, 0.93];
        let product = |s: f64| roots.iter().map(|root| s - root).product::<f64>();
        let all = found(4, product);
        assert_eq!(all.len(), 4, "{all:?}");
        for (found, root) in all.iter().zip(roots) {
            assert!((found - root).abs() < 1e-11, "{all:?}");
        }
        // A double root is no change of sign, a triple one is one.
        for root in [0.25, 0.3, 0.7, 0.123] {
            assert_eq!(found(2, |s| (s - root) * (s - root)), Vec::<f64>::new());
            assert_eq!(found(4, |s| -(s - root) * (s - root) * (s * s + 0.1)), Vec::<f64>::new());
        }
        let triple = found(3, |s| (s - 0.25_f64).powi(3));
        assert!(triple.len() == 1 && (triple[0] - 0.25).abs() < 1e-5, "{triple:?}");
    }

    #[test]
    fn a_constant_and_roots_outside_give_none() {
        assert_eq!(found(0, |_| -3.0), Vec::<f64>::new());
        assert_eq!(found(2, |s| (s - 1.5) * (s + 0.2)), Vec::<f64>::new());
        // At an end nothing lies on the other side.
        assert_eq!(found(1, |s| s), Vec::<f64>::new());
    }

    #[test]
    fn values_and_slopes_are_the_polynomials() {
        let f = |s: f64| 2.0 - 3.0 * s + 0.5 * s.powi(5);
        let values: Vec<f64> = samples(7).into_iter().map(f).collect();
        let polynomial = Polynomial::through(&values);
        for s in [0.0, 0.31, 1.0] {
            assert!((polynomial.at(s) - f(s)).abs() < 1e-14);
            assert!((polynomial.slope(s) + 3.0 - 2.5 * s.powi(4)).abs() < 1e-13);
        }
    }
}

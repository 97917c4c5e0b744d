//! Backward differences (BDF) of order one to five, with steps of any sizes.

use super::scheme::{Combination, Formulas, Scheme, SchemeError, within};

/// The rate as the derivative, at the end of a step, of the polynomial through the last `order` + 1 values, and the second rate as
/// that of the polynomial through rates (Gear 1971). Stiff components vanish; A-stable to order two.
///
/// A run begins with fewer states than the order asks for, and with that lower order, unless it is given earlier states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BackwardDifferences {
    order: usize,
}

impl BackwardDifferences {
    /// The method of this order, 1 to 5.
    ///
    /// # Errors
    /// [`SchemeError`] for another order.
    pub fn new(order: usize) -> Result<Self, SchemeError> {
        within(("backward differences", "order"), order as f64, [1.0, 5.0])?;
        Ok(BackwardDifferences { order })
    }
}

impl Scheme for BackwardDifferences {
    fn states(&self) -> usize {
        self.order
    }

    fn reads_second_rates(&self) -> bool {
        false
    }

    fn formulas(&self, steps: &[f64]) -> Formulas {
        let weights = derivative_weights(&steps[..steps.len().min(self.order)]);
        let (first, earlier) = weights.split_first().unwrap_or((&0.0, &[]));
        let value = Combination { unknown: 1.0, states: vec![[0.0; 3]; earlier.len()] };
        let rate = Combination { unknown: *first, states: earlier.iter().map(|&a| [a, 0.0, 0.0]).collect() };
        let of_rates = Combination { unknown: 0.0, states: earlier.iter().map(|&a| [0.0, a, 0.0]).collect() };
        let second_rate = Combination::sum(&[(*first, &rate), (1.0, &of_rates)]);
        let all = [value, rate, second_rate];
        Formulas { evaluated: all.clone(), end: all, load_at: 1.0 }
    }
}

/// The weights of values at t, t − Δt₀, t − Δt₀ − Δt₁, … in the derivative at t of the polynomial through them (Lagrange).
fn derivative_weights(steps: &[f64]) -> Vec<f64> {
    let mut before = 0.0;
    let mut times = vec![0.0];
    for step in steps {
        before -= step;
        times.push(before);
    }
    // In addition to the newest point l_k'(0) = Π_{m≠0,k} (−t_m) / Π_{m≠k} (t_k − t_m).
    let others = |k: usize| (0..times.len()).filter(move |&m| m != k);
    let earlier = |k: usize| {
        let above: f64 = others(k).filter(|&m| m != 0).map(|m| -times[m]).product();
        above / others(k).map(|m| times[k] - times[m]).product::<f64>()
    };
    let weights: Vec<f64> = (1..times.len()).map(earlier).collect();
    // The derivative of a constant is zero.
    std::iter::once(-weights.iter().sum::<f64>()).chain(weights.iter().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_steps_give_the_known_tables() {
        let tables: [&[f64]; 5] = [
            &[1.0, -1.0],
            &[1.5, -2.0, 0.5],
            &[11.0 / 6.0, -3.0, 1.5, -1.0 / 3.0],
            &[25.0 / 12.0, -4.0, 3.0, -4.0 / 3.0, 0.25],
            &[137.0 / 60.0, -5.0, 5.0, -10.0 / 3.0, 1.25, -0.2],
        ];
        for table in tables {
            let weights = derivative_weights(&vec![0.5; table.len() - 1]);
            for (weight, known) in weights.iter().zip(table) {
                assert!((weight * 0.5 - known).abs() < 1e-14, "{weights:?} {table:?}");
            }
        }
    }

    #[test]
    fn unequal_steps_differentiate_polynomials() {
        let steps = [0.3, 0.1, 0.45];
        let weights = derivative_weights(&steps);
        let polynomial = |t: f64| 2.0 - t + 3.0 * t * t - 0.7 * t.powi(3);
        let (mut t, mut sum) = (1.2, weights[0] * polynomial(1.2));
        for (step, weight) in steps.iter().zip(&weights[1..]) {
            t -= step;
            sum += weight * polynomial(t);
        }
        assert!((sum - (-1.0 + 6.0 * 1.2 - 2.1 * 1.44)).abs() < 1e-13, "{sum}");
    }
}

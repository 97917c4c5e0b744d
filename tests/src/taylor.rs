//! Taylor tests: f(t) − f(0) − t f′(0) must fall with t².

/// Halvings of the step.
const STEPS: i32 = 6;

/// Asserts that the remainder of a number or vector f falls with order 2 from the step `first` on, over
/// several halvings, and gives the lowest order found. `derivative` is f′(0).
pub fn assert_second_order(
    label: &str,
    first: f64,
    value: impl Fn(f64) -> Vec<f64>,
    derivative: &[f64],
) -> f64 {
    let start = value(0.0);
    let remainders: Vec<f64> = (0..=STEPS)
        .map(|k| {
            let step = first * 0.5_f64.powi(k);
            let parts = value(step).into_iter().zip(&start).zip(derivative);
            parts.map(|((moved, start), slope)| (moved - start - step * slope).powi(2)).sum::<f64>().sqrt()
        })
        .collect();
    // Rounding, or a function that is affine, would make any order.
    let scale = start.iter().chain(derivative).fold(0.0_f64, |largest, value| largest.max(value.abs()));
    let last = remainders[STEPS as usize];
    assert!(last > 1e-12 * scale, "{label}: the remainder {last:.1e} is rounding, the test says nothing");
    let orders: Vec<f64> = remainders.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect();
    let lowest = orders.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(lowest > 1.9, "{label}: orders {orders:?} of the remainders {remainders:?}");
    lowest
}

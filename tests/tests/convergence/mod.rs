//! Orders of convergence: their fit, and errors for a printed table.
#![allow(dead_code, reason = "each test uses a part")]

/// The slope of log(error) over log(1/divisions), by least squares.
pub fn order(divisions: &[usize], errors: &[f64]) -> f64 {
    let count = errors.len() as f64;
    let x: Vec<f64> = divisions.iter().map(|&n| -(n as f64).ln()).collect();
    let y: Vec<f64> = errors.iter().map(|error| error.ln()).collect();
    let (mean_x, mean_y) = (x.iter().sum::<f64>() / count, y.iter().sum::<f64>() / count);
    let covariance: f64 = x.iter().zip(&y).map(|(x, y)| (x - mean_x) * (y - mean_y)).sum();
    covariance / x.iter().map(|x| (x - mean_x).powi(2)).sum::<f64>()
}

/// Errors for a printed table.
pub fn digits(errors: &[f64]) -> String {
    errors.iter().map(|error| format!("{error:.2e}")).collect::<Vec<_>>().join(" ")
}

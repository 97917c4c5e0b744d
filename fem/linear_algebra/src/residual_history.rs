//! Printing of residuals' histories, in errors and Krylov methods' reports: the last of what may be a thousand.

use std::fmt;

use super::gmres::GmresReport;
use super::krylov::KrylovReport;

/// Residuals that are printed.
const LAST: usize = 5;

/// Norms of the residuals of an iteration. It prints its length and its end.
#[derive(Clone, Default, PartialEq)]
pub struct ResidualHistory(pub Vec<f64>);

impl fmt::Debug for ResidualHistory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(&History(&self.0), f)
    }
}

/// A history by its length and its end.
struct History<'a>(&'a [f64]);

impl fmt::Debug for History<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let last = &self.0[self.0.len().saturating_sub(LAST)..];
        match self.0.len() - last.len() {
            0 => {}
            before => write!(f, "{before} residuals, then ")?,
        }
        fmt::Debug::fmt(last, f)
    }
}

impl fmt::Debug for KrylovReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("KrylovReport")
            .field("iterations", &self.iterations)
            .field("relative_residual", &self.relative_residual)
            .field("history", &History(&self.history))
            .finish()
    }
}

impl fmt::Debug for GmresReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("GmresReport")
            .field("iterations", &self.iterations)
            .field("relative_residual", &self.relative_residual)
            .field("history", &History(&self.history))
            .field("at_rounding", &self.at_rounding)
            .finish()
    }
}

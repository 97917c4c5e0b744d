//! Sizes of the steps of a motion.

/// The sizes of the steps of a motion, from time zero on: `(200, 0.01).into()` are equal ones, a list has a size for each.
#[derive(Clone, Debug, PartialEq)]
pub struct StepSizes {
    sizes: Vec<f64>,
    /// Of the start, and of the end of each step.
    times: Vec<f64>,
}

impl StepSizes {
    /// The number of steps.
    pub fn count(&self) -> usize {
        self.sizes.len()
    }

    /// The first size that is no positive number.
    pub(super) fn unfit(&self) -> Option<f64> {
        self.sizes.iter().copied().find(|size| !(*size > 0.0 && size.is_finite()))
    }

    /// The times before and after a step.
    pub(super) fn times(&self, step: usize) -> [f64; 2] {
        [self.times[step], self.times[step + 1]]
    }

    /// The sizes of a step and of those before it, newest first, as many as lie between states that a scheme knows.
    pub(super) fn newest_first(&self, step: usize, states: usize) -> Vec<f64> {
        self.sizes[..=step].iter().rev().take(states).copied().collect()
    }
}

impl From<(usize, f64)> for StepSizes {
    fn from((steps, size): (usize, f64)) -> Self {
        let times = (0..=steps).map(|step| size * step as f64).collect();
        StepSizes { sizes: vec![size; steps], times }
    }
}

impl From<Vec<f64>> for StepSizes {
    fn from(sizes: Vec<f64>) -> Self {
        let mut times = vec![0.0];
        times.extend(sizes.iter().scan(0.0, |time, size| {
            *time += size;
            Some(*time)
        }));
        StepSizes { sizes, times }
    }
}

impl From<&[f64]> for StepSizes {
    fn from(sizes: &[f64]) -> Self {
        sizes.to_vec().into()
    }
}

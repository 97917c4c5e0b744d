//! Numbers over time, as energies, forces and probes: named columns, their CSV file, and the times at which one passes a threshold.

use std::fmt::Write as _;
use std::io::{self, Write as _};
use std::path::Path;

use thiserror::Error;

use super::write_whole;

/// Columns of numbers over ascending times.
///
/// ```
/// use forms_fem::output::TimeSeries;
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let mut series = TimeSeries::new(["force", "height"]);
/// for (t, force, height) in [(0.0, 0.0, 1.0), (0.5, 0.0, 0.2), (1.0, 4.0, 0.0), (1.5, 0.0, 0.3)] {
///     series.push(t, &[force, height])?;
/// }
/// let touches = series.passages("force", 1.0)?;
/// assert!(touches[0].rises && (touches[0].time - 0.625).abs() < 1e-15);
/// assert_eq!(series.csv().lines().next(), Some("t,force,height"));
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct TimeSeries {
    names: Vec<String>,
    times: Vec<f64>,
    /// Row after row.
    values: Vec<f64>,
}

/// A time at which a column passes a threshold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// The time, between two rows by the straight line.
    pub time: f64,
    /// Whether the column comes from the threshold or below, and is above it afterwards.
    pub rises: bool,
}

impl Crossing {
    /// The passage of zero between two values at two times, if one is positive and the other is not.
    #[doc(hidden)]
    pub fn of_zero(times: [f64; 2], values: [f64; 2]) -> Option<Self> {
        let part = values[0] / (values[0] - values[1]);
        ((values[0] > 0.0) != (values[1] > 0.0))
            .then(|| Crossing { time: times[0] + part * (times[1] - times[0]), rises: values[1] > 0.0 })
    }
}

/// A row or a column that a series does not have.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs)]
pub enum TimeSeriesError {
    /// Another number of values than columns.
    #[error("at the time {time} there are {found} values for {expected} columns")]
    Length {
        /// The time of the row.
        time: f64,
        /// The number of columns.
        expected: usize,
        found: usize,
    },
    /// A time that is not after the last one.
    #[error("the time {time} is not after the last one, {last}")]
    NotLater {
        /// The time of the row.
        time: f64,
        /// The time of the last row.
        last: f64,
    },
    /// A value that is no number.
    #[error("at the time {time} the column `{column}` would be {value}")]
    NotFinite {
        /// The time of the row.
        time: f64,
        /// The column, or `t`.
        column: String,
        value: f64,
    },
    /// No such column.
    #[error("there is no column `{name}`; there are {known}")]
    Unknown { name: String, known: String },
}

impl TimeSeries {
    /// Columns without rows; the time is a column of its own, `t`.
    pub fn new<N: Into<String>>(columns: impl IntoIterator<Item = N>) -> Self {
        let names = columns.into_iter().map(Into::into).collect();
        TimeSeries { names, times: vec![], values: vec![] }
    }

    /// A further row.
    ///
    /// # Errors
    /// [`TimeSeriesError`], and the series is as it was.
    pub fn push(&mut self, time: f64, values: &[f64]) -> Result<(), TimeSeriesError> {
        if values.len() != self.names.len() {
            let (expected, found) = (self.names.len(), values.len());
            return Err(TimeSeriesError::Length { time, expected, found });
        }
        let named = self.names.iter().map(String::as_str).zip(values.iter().copied());
        let wrong = [("t", time)].into_iter().chain(named).find(|(_, value)| !value.is_finite());
        if let Some((column, value)) = wrong {
            return Err(TimeSeriesError::NotFinite { time, column: column.to_owned(), value });
        }
        if let Some(&last) = self.times.last().filter(|last| time <= **last) {
            return Err(TimeSeriesError::NotLater { time, last });
        }
        self.times.push(time);
        self.values.extend_from_slice(values);
        Ok(())
    }

    /// The times.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// A column by its name.
    ///
    /// # Errors
    /// [`TimeSeriesError::Unknown`].
    pub fn column(&self, name: &str) -> Result<Vec<f64>, TimeSeriesError> {
        let place = self.names.iter().position(|own| own == name).ok_or_else(|| {
            TimeSeriesError::Unknown { name: name.to_owned(), known: self.names.join(", ") }
        })?;
        Ok(self.values.iter().skip(place).step_by(self.names.len()).copied().collect())
    }

    /// The times at which a column passes a threshold: a force that begins and ends, a body that touches and leaves.
    ///
    /// # Errors
    /// [`TimeSeriesError::Unknown`].
    pub fn passages(&self, name: &str, threshold: f64) -> Result<Vec<Crossing>, TimeSeriesError> {
        let column = self.column(name)?;
        let pairs = self.times.windows(2).zip(column.windows(2));
        let passages = pairs.filter_map(|(times, values)| {
            let above = [values[0] - threshold, values[1] - threshold];
            Crossing::of_zero([times[0], times[1]], above)
        });
        Ok(passages.collect())
    }

    /// The rows as comma-separated values with a line of names; numbers read back to the last bit.
    pub fn csv(&self) -> String {
        let mut csv = "t".to_owned();
        self.names.iter().for_each(|name| csv.extend([",", name.as_str()]));
        csv.push('\n');
        let width = self.names.len();
        for (row, time) in self.times.iter().enumerate() {
            // Writing to a string does not fail.
            let _ = write!(csv, "{time:e}");
            for value in &self.values[row * width..(row + 1) * width] {
                let _ = write!(csv, ",{value:e}");
            }
            csv.push('\n');
        }
        csv
    }

    /// The file, written whole or not at all.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn write(&self, path: impl AsRef<Path>) -> io::Result<()> {
        let csv = self.csv();
        write_whole(path, |file| file.write_all(csv.as_bytes()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_reads_back_and_passages_lie_on_the_line() {
        let mut series = TimeSeries::new(["a", "b"]);
        let rows = [(0.0, [1.0 / 3.0, -1.0]), (0.1, [2e-300, 1.0]), (0.4, [5.0, -2.0]), (0.5, [6.0, -2.0])];
        rows.iter().for_each(|(t, values)| series.push(*t, values).unwrap());
        let csv = series.csv();
        let read: Vec<f64> = csv
            .lines()
            .skip(1)
            .flat_map(|line| line.split(',').map(|number| number.parse().unwrap()))
            .collect();
        let expected: Vec<f64> = rows.iter().flat_map(|(t, [a, b])| [*t, *a, *b]).collect();
        assert_eq!(read, expected);
        assert_eq!(series.column("b").unwrap(), [-1.0, 1.0, -2.0, -2.0]);
        let found = series.passages("b", 0.0).unwrap();
        let close = |a: f64, b: f64| (a - b).abs() < 1e-15;
        assert!(found.len() == 2 && found[0].rises && !found[1].rises, "{found:?}");
        assert!(close(found[0].time, 0.05) && close(found[1].time, 0.2), "{found:?}");
    }

    #[test]
    fn wrong_rows_and_names_are_refused() {
        let mut series = TimeSeries::new(["force"]);
        series.push(1.0, &[0.0]).unwrap();
        let before = series.clone();
        for (time, values, message) in [
            (2.0, &[1.0, 2.0][..], "at the time 2 there are 2 values for 1 columns"),
            (1.0, &[1.0], "the time 1 is not after the last one, 1"),
            (2.0, &[f64::NAN], "at the time 2 the column `force` would be NaN"),
            (f64::NAN, &[1.0], "at the time NaN the column `t` would be NaN"),
        ] {
            assert_eq!(series.push(time, values).unwrap_err().to_string(), message);
        }
        assert_eq!(series, before);
        let unknown = series.passages("forces", 0.0).unwrap_err().to_string();
        assert_eq!(unknown, "there is no column `forces`; there are force");
    }
}

//! Parameters: named numbers, with defaults, that a caller in another language gives to the constructor of a problem.

use thiserror::Error;

/// Numbers by name. A constructor reads those that it knows; a given name that it does not read is an error.
#[derive(Clone, Debug, Default)]
pub struct Parameters {
    given: Vec<(String, f64)>,
    /// Those asked for, with their defaults.
    asked: Vec<(String, f64)>,
}

/// Parameters that do not fit.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs)]
pub enum ParameterError {
    /// A parameter that the constructor does not read.
    #[error("there is no parameter `{name}`; there are {known}")]
    Unknown {
        name: String,
        /// The names that there are, with their defaults.
        known: String,
    },
    /// A name given twice.
    #[error("the parameter `{name}` is given twice")]
    Twice { name: String },
    /// A value that is not finite.
    #[error("the parameter `{name}` is {value}, which is not finite")]
    NotFinite { name: String, value: f64 },
    /// A value that is not a count.
    #[error("the parameter `{name}` is {value}, which is no whole number from 1 to {MOST}")]
    NoCount { name: String, value: f64 },
}

/// The largest number of things.
const MOST: u32 = u32::MAX;

impl Parameters {
    /// Parameters from outside.
    ///
    /// # Errors
    /// [`ParameterError::Twice`], [`ParameterError::NotFinite`].
    pub fn new(given: Vec<(String, f64)>) -> Result<Self, ParameterError> {
        for (place, (name, value)) in given.iter().enumerate() {
            if given[..place].iter().any(|(earlier, _)| earlier == name) {
                return Err(ParameterError::Twice { name: name.clone() });
            }
            if !value.is_finite() {
                return Err(ParameterError::NotFinite { name: name.clone(), value: *value });
            }
        }
        Ok(Parameters { given, asked: vec![] })
    }

    /// A number.
    pub fn number(&mut self, name: &str, default: f64) -> f64 {
        self.asked.push((name.to_owned(), default));
        self.given.iter().find(|(given, _)| given == name).map_or(default, |(_, value)| *value)
    }

    /// A number of things, at least one.
    ///
    /// # Errors
    /// [`ParameterError::NoCount`].
    pub fn count(&mut self, name: &str, default: u32) -> Result<usize, ParameterError> {
        let value = self.number(name, f64::from(default));
        if value.fract() == 0.0 && (1.0..=f64::from(MOST)).contains(&value) {
            Ok(value as usize)
        } else {
            Err(ParameterError::NoCount { name: name.to_owned(), value })
        }
    }

    /// Check that each given parameter was read.
    pub(crate) fn all_known(&self) -> Result<(), ParameterError> {
        let unknown = self.given.iter().find(|(given, _)| self.asked.iter().all(|(name, _)| name != given));
        let Some((name, _)) = unknown else { return Ok(()) };
        let known: Vec<_> =
            self.asked.iter().map(|(name, default)| format!("`{name}` ({default})")).collect();
        let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
        Err(ParameterError::Unknown { name: name.clone(), known })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_counts_and_mistakes() {
        let given = |name: &str, value| vec![(name.to_owned(), value)];
        let mut parameters = Parameters::new(given("cells", 8.0)).unwrap();
        assert_eq!((parameters.count("cells", 4).unwrap(), parameters.number("load", 0.5)), (8, 0.5));
        parameters.all_known().unwrap();

        let mut wrong = Parameters::new(given("cels", 8.0)).unwrap();
        wrong.number("cells", 4.0);
        let message = wrong.all_known().unwrap_err().to_string();
        assert_eq!(message, "there is no parameter `cels`; there are `cells` (4)");
        for value in [0.0, -3.0, 2.5, 1e12] {
            let found = Parameters::new(given("cells", value)).unwrap().count("cells", 4);
            assert_eq!(found, Err(ParameterError::NoCount { name: "cells".into(), value }));
        }
        assert!(matches!(Parameters::new(given("load", f64::NAN)), Err(ParameterError::NotFinite { .. })));
        let twice = [given("load", 1.0), given("load", 2.0)].concat();
        assert!(matches!(Parameters::new(twice), Err(ParameterError::Twice { .. })));
    }
}

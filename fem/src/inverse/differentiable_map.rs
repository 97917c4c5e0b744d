//! Differentiable maps: a compiled problem as a function of plain arrays with its products of Jacobian and vector.

use std::error::Error;

use thiserror::Error;

/// A part of the vector that a map takes or gives: a control, or an output, by its name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// The name.
    pub name: String,
    /// The number of its values.
    pub length: usize,
}

impl Part {
    /// A part of a name and a number of values.
    pub fn new(name: impl Into<String>, length: usize) -> Self {
        Part { name: name.into(), length }
    }
}

/// An error of a map.
#[derive(Debug, Error)]
#[allow(missing_docs)]
pub enum MapError {
    /// A vector of another length than the map's.
    #[error("the {vector} has {found} values; the map has {expected}: {parts}")]
    Length {
        /// "vector of controls", "cotangent" or "direction".
        vector: &'static str,
        /// The map's number.
        expected: usize,
        /// That of the vector.
        found: usize,
        /// The names of the parts, each with its number of values.
        parts: String,
    },
    /// A value that is not finite.
    #[error("the value {value} of `{name}` in the {vector} is not finite (its number {index})")]
    NotFinite {
        /// As above.
        vector: &'static str,
        /// The name of the part.
        name: String,
        /// The number of the value in its part, from 0.
        index: usize,
        value: f64,
    },
    /// A result that is not finite.
    #[error("the {result} of the map is not finite there")]
    ResultNotFinite {
        /// "value" or "gradient".
        result: &'static str,
    },
    /// The problem could not be solved.
    #[error(transparent)]
    Problem(Box<dyn Error + 'static>),
}

/// A map F from controls m to outputs, as other programs use a problem.
///
/// Products with the Jacobian F′ are those of the discrete problem, by adjoints; there are no difference quotients in them. A map
/// remembers the last m: asking for its value and then for products with its Jacobian solves the equations once.
pub trait DifferentiableMap {
    /// The controls, in their order in m.
    fn inputs(&self) -> Vec<Part>;

    /// The outputs, in their order in F(m).
    fn outputs(&self) -> Vec<Part>;

    /// The controls to begin with.
    fn start(&self) -> Vec<f64>;

    /// F(m).
    ///
    /// # Errors
    /// [`MapError`].
    fn value(&mut self, m: &[f64]) -> Result<Vec<f64>, MapError>;

    /// F′(m)ᵀ w for a cotangent w, a value per output: one adjoint.
    ///
    /// # Errors
    /// [`MapError`].
    fn vjp(&mut self, m: &[f64], cotangent: &[f64]) -> Result<Vec<f64>, MapError>;

    /// F′(m), a row per output: an adjoint each.
    ///
    /// # Errors
    /// [`MapError`].
    fn jacobian(&mut self, m: &[f64]) -> Result<Vec<Vec<f64>>, MapError> {
        let count = length(&self.outputs());
        let mut cotangent = vec![0.0; count];
        let mut rows = Vec::with_capacity(count);
        for row in 0..count {
            cotangent[row] = 1.0;
            rows.push(self.vjp(m, &cotangent)?);
            cotangent[row] = 0.0;
        }
        Ok(rows)
    }

    /// F′(m) δ for a direction δ of the controls, by the rows of the Jacobian: an adjoint per output, exact.
    ///
    /// # Errors
    /// [`MapError`].
    fn jvp(&mut self, m: &[f64], direction: &[f64]) -> Result<Vec<f64>, MapError> {
        check("direction", &self.inputs(), direction)?;
        let along = |row: &Vec<f64>| row.iter().zip(direction).map(|(rate, along)| rate * along).sum();
        Ok(self.jacobian(m)?.iter().map(along).collect())
    }
}

impl<M: DifferentiableMap + ?Sized> DifferentiableMap for Box<M> {
    fn inputs(&self) -> Vec<Part> {
        (**self).inputs()
    }

    fn outputs(&self) -> Vec<Part> {
        (**self).outputs()
    }

    fn start(&self) -> Vec<f64> {
        (**self).start()
    }

    fn value(&mut self, m: &[f64]) -> Result<Vec<f64>, MapError> {
        (**self).value(m)
    }

    fn vjp(&mut self, m: &[f64], cotangent: &[f64]) -> Result<Vec<f64>, MapError> {
        (**self).vjp(m, cotangent)
    }

    fn jacobian(&mut self, m: &[f64]) -> Result<Vec<Vec<f64>>, MapError> {
        (**self).jacobian(m)
    }

    fn jvp(&mut self, m: &[f64], direction: &[f64]) -> Result<Vec<f64>, MapError> {
        (**self).jvp(m, direction)
    }
}

/// The number of values of all parts.
pub fn length(parts: &[Part]) -> usize {
    parts.iter().map(|part| part.length).sum()
}

/// Whether a vector fits its parts, and is finite.
///
/// # Errors
/// [`MapError::Length`], [`MapError::NotFinite`].
pub fn check(vector: &'static str, parts: &[Part], values: &[f64]) -> Result<(), MapError> {
    let expected = length(parts);
    if values.len() != expected {
        let named: Vec<_> = parts.iter().map(|part| format!("`{}` ({})", part.name, part.length)).collect();
        return Err(MapError::Length { vector, expected, found: values.len(), parts: named.join(", ") });
    }
    let mut rest = values;
    for part in parts {
        let (own, others) = rest.split_at(part.length);
        if let Some(index) = own.iter().position(|value| !value.is_finite()) {
            return Err(MapError::NotFinite { vector, name: part.name.clone(), index, value: own[index] });
        }
        rest = others;
    }
    Ok(())
}

/// Hands a result on, if it is finite.
pub(super) fn finite(result: &'static str, values: Vec<f64>) -> Result<Vec<f64>, MapError> {
    if values.iter().all(|value| value.is_finite()) {
        Ok(values)
    } else {
        Err(MapError::ResultNotFinite { result })
    }
}

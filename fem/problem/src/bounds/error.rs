//! Errors of bounds.

use std::fmt;

use thiserror::Error;

use super::Side;
use crate::constraints::ConstraintsError;

/// Errors of a bound. The bounds stay as they were.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs)]
pub enum BoundsError {
    /// No such region or component, or a value that does not fit the space.
    #[error(transparent)]
    Place(#[from] ConstraintsError),
    /// NaN, or an infinite value on the wrong side.
    #[error("{place}: the bound of component {component} at {position:?} is {value}")]
    NoBound {
        /// The region, or the field.
        place: String,
        component: usize,
        position: Vec<f64>,
        value: f64,
    },
    /// A lower bound above an upper one.
    #[error(
        "{place}: component {component} at {position:?} has the {side} bound {value}, but {earlier} gave it the {} bound {other}",
        side.other()
    )]
    Crossing {
        /// The region, or the field.
        place: String,
        component: usize,
        position: Vec<f64>,
        /// The new bound.
        value: f64,
        side: Side,
        /// The origin of the other bound.
        earlier: String,
        other: f64,
    },
    /// A field on another space.
    #[error("the field has another space than the bounds")]
    OtherSpace,
}

impl Side {
    fn other(self) -> Side {
        match self {
            Side::Lower => Side::Upper,
            Side::Upper => Side::Lower,
        }
    }
}

impl fmt::Display for Side {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if *self == Side::Lower { "lower" } else { "upper" })
    }
}

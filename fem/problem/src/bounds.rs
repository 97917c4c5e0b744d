//! Bounds on the unknowns of a space: obstacles, irreversible damage, amounts that stay between two values.

mod error;

use std::collections::BTreeMap;
use std::sync::Arc;

pub use error::BoundsError;
use forms_core::contract::FieldValue;

use crate::constraints::{Constraints, ConstraintsError};
use crate::field::Field;
use crate::instantiate::instantiate;
use crate::space::Space;

/// Lower and upper bounds on unknowns of a space. [`Problem::bounded`](crate::solve::Problem::bounded) takes them.
///
/// Bounds hold at nodes. Between the nodes of a linear element a field is between its values there; a polynomial of higher degree may leave
/// the bounds inside a cell. Of several bounds on one unknown the strictest counts.
///
/// ```
/// use forms_fem::prelude::*;
///
/// let mesh = rectangle([0.0; 2], [1.0; 2], [8, 8], CellShape::Triangle, 1)?;
/// let space = Space::scalar(&mesh, 1)?;
/// let mut held = Constraints::new(&space);
/// held.fix("boundary", |_| 0.0)?;
/// // A membrane over an obstacle.
/// let mut bounds = Bounds::new(&space);
/// bounds.at_least("all", |x| 0.1 - (x[0] - 0.5).powi(2) - (x[1] - 0.5).powi(2))?;
/// let form = form!(|u: Unknown<Scalar>, v: Test<Scalar>| integral(cells("all"), dot(grad(u), grad(v))));
/// let solved = Problem::new(&form, &space).constrained(&held).bounded(&bounds).solve()?;
/// assert!(solved.field().evaluate(&[0.5, 0.5])?[0] >= 0.1);
/// assert!(!solved.held().is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Bounds<const D: usize> {
    space: Arc<Space<D>>,
    limits: Arc<Limits>,
}

/// The numbers of bounds. Of no dimension, as the conditions of constraints.
#[derive(Clone, Debug, Default)]
struct Limits {
    lower: BTreeMap<usize, Limit>,
    upper: BTreeMap<usize, Limit>,
}

#[derive(Clone, Debug)]
struct Limit {
    value: f64,
    origin: Arc<str>,
}

/// The side of a bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Side {
    /// The unknown is at least the bound.
    Lower,
    /// The unknown is at most the bound.
    Upper,
}

impl<const D: usize> Bounds<D> {
    /// No bound at all.
    #[inline(never)]
    pub fn new(space: &Arc<Space<D>>) -> Self {
        Bounds { space: Arc::clone(space), limits: Arc::default() }
    }

    /// The space.
    pub fn space(&self) -> &Arc<Space<D>> {
        &self.space
    }

    /// A lower bound of all components on a region of facets or cells, at its nodes \[unit of the unknown\]. −∞ is no bound.
    ///
    /// # Errors
    /// An unknown region, a value that does not fit the space or is no bound, or one above an upper bound.
    pub fn at_least<V: FieldValue>(
        &mut self,
        region: &str,
        value: impl Fn(&[f64; D]) -> V,
    ) -> Result<&mut Self, BoundsError> {
        self.on_region(Side::Lower, region, V::COMPONENTS, &|x, written| value(x).write(written))
    }

    /// An upper bound of all components on a region of facets or cells, at its nodes \[unit of the unknown\]. ∞ is no bound.
    ///
    /// # Errors
    /// As [`Bounds::at_least`]; a value below a lower bound.
    pub fn at_most<V: FieldValue>(
        &mut self,
        region: &str,
        value: impl Fn(&[f64; D]) -> V,
    ) -> Result<&mut Self, BoundsError> {
        self.on_region(Side::Upper, region, V::COMPONENTS, &|x, written| value(x).write(written))
    }

    /// A lower bound of one component (counted from 0, row-major) on a region.
    ///
    /// # Errors
    /// As [`Bounds::at_least`], or a component that the space does not have.
    pub fn component_at_least(
        &mut self,
        region: &str,
        component: usize,
        value: impl Fn(&[f64; D]) -> f64,
    ) -> Result<&mut Self, BoundsError> {
        self.component_on_region(Side::Lower, region, component, &value)
    }

    /// An upper bound of one component (counted from 0, row-major) on a region.
    ///
    /// # Errors
    /// As [`Bounds::at_most`], or a component that the space does not have.
    pub fn component_at_most(
        &mut self,
        region: &str,
        component: usize,
        value: impl Fn(&[f64; D]) -> f64,
    ) -> Result<&mut Self, BoundsError> {
        self.component_on_region(Side::Upper, region, component, &value)
    }

    /// The values of a field on this space as a lower bound of every unknown, as the damage of the last load step.
    ///
    /// # Errors
    /// A field on another space, a value that is no bound, or one above an upper bound.
    pub fn at_least_field(&mut self, field: &Field<D>) -> Result<&mut Self, BoundsError> {
        self.by_field(Side::Lower, field)
    }

    /// The values of a field on this space as an upper bound of every unknown.
    ///
    /// # Errors
    /// A field on another space, a value that is no bound, or one below a lower bound.
    pub fn at_most_field(&mut self, field: &Field<D>) -> Result<&mut Self, BoundsError> {
        self.by_field(Side::Upper, field)
    }

    /// The lower and the upper bound of an unknown of the space; −∞ and ∞ where there is none.
    pub fn of(&self, unknown: usize) -> (f64, f64) {
        let value = |limits: &BTreeMap<usize, Limit>, none| limits.get(&unknown).map_or(none, |l| l.value);
        (value(&self.limits.lower, f64::NEG_INFINITY), value(&self.limits.upper, f64::INFINITY))
    }

    /// Unknowns with a bound, ascending.
    pub fn unknowns(&self) -> Vec<usize> {
        let mut all: Vec<usize> = self.limits.lower.keys().chain(self.limits.upper.keys()).copied().collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    #[inline(never)]
    fn on_region(
        &mut self,
        side: Side,
        region: &str,
        count: usize,
        write: &dyn Fn(&[f64; D], &mut [f64]),
    ) -> Result<&mut Self, BoundsError> {
        let place = format!("region \"{region}\"");
        let constraints = Constraints::new(&self.space);
        let components = self.space.components();
        if count != components {
            return Err(ConstraintsError::Components { place, space: components, value: count }.into());
        }
        let mut written = vec![0.0; count];
        let mut entries = Vec::new();
        for node in constraints.nodes_on(region, &place)? {
            write(&self.space.positions()[node as usize], &mut written);
            let first = node as usize * count;
            entries.extend(written.iter().enumerate().map(|(component, value)| (first + component, *value)));
        }
        self.insert(side, &place, entries)
    }

    #[inline(never)]
    fn component_on_region(
        &mut self,
        side: Side,
        region: &str,
        component: usize,
        value: &dyn Fn(&[f64; D]) -> f64,
    ) -> Result<&mut Self, BoundsError> {
        let place = format!("region \"{region}\"");
        let constraints = Constraints::new(&self.space);
        let components = constraints.check_component(&place, component)?;
        let entry = |node: u32| {
            let node = node as usize;
            (node * components + component, value(&self.space.positions()[node]))
        };
        let entries: Vec<_> = constraints.nodes_on(region, &place)?.into_iter().map(entry).collect();
        self.insert(side, &place, entries)
    }

    #[inline(never)]
    fn by_field(&mut self, side: Side, field: &Field<D>) -> Result<&mut Self, BoundsError> {
        if !self.space.numbers_as(field.space()) {
            return Err(BoundsError::OtherSpace);
        }
        let entries = field.values().iter().copied().enumerate().collect();
        self.insert(side, "the field", entries)
    }

    fn insert(
        &mut self,
        side: Side,
        place: &str,
        entries: Vec<(usize, f64)>,
    ) -> Result<&mut Self, BoundsError> {
        let components = self.space.components();
        let position = |unknown: usize| self.space.positions()[unknown / components].to_vec();
        let none = if side == Side::Lower { f64::NEG_INFINITY } else { f64::INFINITY };
        for (unknown, value) in entries.iter().copied() {
            if !value.is_finite() && value != none {
                return Err(BoundsError::NoBound {
                    place: place.to_owned(),
                    component: unknown % components,
                    position: position(unknown),
                    value,
                });
            }
            let (lower, upper) = self.of(unknown);
            let (crosses, other, limits) = match side {
                Side::Lower => (value > upper, upper, &self.limits.upper),
                Side::Upper => (value < lower, lower, &self.limits.lower),
            };
            if crosses {
                return Err(BoundsError::Crossing {
                    place: place.to_owned(),
                    component: unknown % components,
                    position: position(unknown),
                    value,
                    side,
                    earlier: limits.get(&unknown).map_or_else(String::new, |limit| limit.origin.to_string()),
                    other,
                });
            }
        }
        let limits = Arc::make_mut(&mut self.limits);
        let origin: Arc<str> = place.into();
        let limits = if side == Side::Lower { &mut limits.lower } else { &mut limits.upper };
        for (unknown, value) in entries.into_iter().filter(|(_, value)| value.is_finite()) {
            let is_weaker = |earlier: &Limit| match side {
                Side::Lower => earlier.value >= value,
                Side::Upper => earlier.value <= value,
            };
            if !limits.get(&unknown).is_some_and(is_weaker) {
                limits.insert(unknown, Limit { value, origin: Arc::clone(&origin) });
            }
        }
        Ok(self)
    }
}

instantiate!(
    bounds:
    Bounds::<D>::new,
    Bounds::<D>::on_region,
    Bounds::<D>::component_on_region,
    Bounds::<D>::by_field
);

#[cfg(test)]
mod tests;

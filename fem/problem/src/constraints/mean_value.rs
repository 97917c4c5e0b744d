//! Linear conditions on unknowns: a mean value, any sum that is prescribed, an unknown that others give.

use super::{Constraints, ConstraintsError};
use crate::dimension::{Dim, Dimension};
use crate::norms::basis_integrals;

/// A condition makes the unknowns it relates depend on each other: with more of them than this the tangent would be a
/// dense matrix that no solver is made for.
const MOST: usize = 4096;

impl<const D: usize> Constraints<D> {
    /// Prescribed mean of one component (counted from 0, row-major) over a region of cells or facets:
    /// ∫_ω u_c = value · |ω|. One unknown is given by all others there, which so get to know each other: the tangent
    /// has a dense block of the size of the region. On larger regions state the mean as an equation of an unknown m of the whole body, from
    /// [`Scope::Body`](crate::space::Scope): with its test function w, `integral(Omega, m * v + (u - value) * w)`.
    ///
    /// # Errors
    /// An unknown region, a component that the space does not have, a value that is not finite, more than 4096
    /// unknowns, or a contradiction to earlier conditions.
    pub fn mean_value(&mut self, region: &str, component: usize, value: f64) -> Result<(), ConstraintsError>
    where
        Dim: Dimension<D>,
    {
        let place = format!("the mean value over region \"{region}\"");
        let components = self.check_component(&place, component)?;
        let instead = "state the mean as an equation of an unknown of the whole body, `Scope::Body`";
        self.space.mesh().without_pieces("a mean value", instead)?;
        self.nodes_on(region, &place)?;
        let weights = basis_integrals(&self.space, region)
            .map_err(|error| ConstraintsError::Integral { place: place.clone(), why: error.to_string() })?;
        let size: f64 = weights.iter().sum();
        let terms: Vec<(usize, f64)> = weights
            .iter()
            .enumerate()
            .filter(|(_, weight)| **weight != 0.0)
            .map(|(node, weight)| (node * components + component, weight / size))
            .collect();
        self.sum(&place, &terms, value)
    }

    /// Prescribed sum: Σ coefficient × unknown = `value`, with unknowns by their numbers. `name` is what messages call
    /// it.
    ///
    /// # Errors
    /// No term, an unknown that the space does not have, a number that is not finite, more than 4096 terms, or a
    /// contradiction to earlier conditions.
    pub fn sum(&mut self, name: &str, terms: &[(usize, f64)], value: f64) -> Result<(), ConstraintsError> {
        self.check_terms(name, terms, value)?;
        let mut changed = self.clone();
        changed.add_equation(name, terms, value)?;
        *self = changed;
        Ok(())
    }

    /// Relation of one unknown to others: u_dependent = Σ coefficient × unknown + `value`, with unknowns by their numbers. It is this unknown
    /// that is eliminated, where [`Constraints::sum`] chooses. Unknowns on the right that are given already, or prescribed, are
    /// put in; a relation that follows from earlier conditions changes nothing. `name` is what messages call it.
    ///
    /// ```
    /// use forms_fem::prelude::*;
    ///
    /// let mesh = rectangle([0.0, 0.0], [1.0, 1.0], [1, 1], CellShape::Quadrilateral, 1)?;
    /// let space = Space::scalar(&mesh, 1)?;
    /// let mut constraints = Constraints::new(&space);
    /// constraints.relate("the middle", 3, &[(0, 0.5), (2, 0.5)], 0.0)?;
    /// let mut values = vec![1.0, 0.0, 5.0, 0.0];
    /// constraints.apply(&mut values);
    /// assert_eq!(values[3], 3.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`Constraints::sum`]; [`ConstraintsError::AlreadyGiven`] where earlier conditions give the dependent unknown otherwise.
    pub fn relate(
        &mut self,
        name: &str,
        dependent: usize,
        terms: &[(usize, f64)],
        value: f64,
    ) -> Result<(), ConstraintsError> {
        self.check_terms(name, terms, value)?;
        self.check_terms(name, &[(dependent, 1.0)], value)?;
        self.add_relation(name, dependent, terms, value)
    }

    fn check_terms(&self, name: &str, terms: &[(usize, f64)], value: f64) -> Result<(), ConstraintsError> {
        let (name, size) = (name.to_owned(), self.space.unknowns());
        if terms.is_empty() || terms.len() > MOST {
            return Err(ConstraintsError::Terms { name, count: terms.len(), most: MOST });
        }
        if let Some(&(unknown, _)) = terms.iter().find(|(unknown, _)| *unknown >= size) {
            return Err(ConstraintsError::Unknown { name, unknown, count: size });
        }
        let numbers = terms.iter().map(|(_, coefficient)| *coefficient).chain([value]);
        match numbers.into_iter().find(|number| !number.is_finite()) {
            Some(number) => Err(ConstraintsError::SumNotFinite { name, number }),
            None => Ok(()),
        }
    }
}

//! Sums and multiples of fields on one space.

use super::{Field, FieldError};
use crate::instantiate::instantiate;
use crate::space::Space;

impl<const D: usize> Field<D> {
    /// Σ aₖ uₖ of fields uₖ on one space: those of the same mesh, family, degree and number of components.
    ///
    /// ```
    /// # use forms_fem::prelude::*;
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # let mesh = rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Triangle, 1)?;
    /// # let space = Space::scalar(&mesh, 1)?;
    /// let (old, new) = (Field::interpolate(&space, |x| x[0])?, Field::interpolate(&space, |x| x[1])?);
    /// let middle = Field::combination(&[(0.5, &old), (0.5, &new)])?;
    /// assert!((middle.evaluate(&[1.0, 0.5])?[0] - 0.75).abs() < 1e-12);
    /// let rate = new.minus(&old)?.times(1.0 / 0.1)?;
    /// assert!((rate.evaluate(&[1.0, 0.5])?[0] + 5.0).abs() < 1e-12);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`FieldError::NothingToAdd`], [`FieldError::OtherSpace`] says in what two spaces differ, [`FieldError::NotFinite`]
    /// names the node where the sum is too large to be a number.
    #[inline(never)]
    pub fn combination(terms: &[(f64, &Field<D>)]) -> Result<Self, FieldError> {
        let Some(((factor, first), others)) = terms.split_first() else {
            return Err(FieldError::NothingToAdd);
        };
        let mut values: Vec<f64> = first.values().iter().map(|value| factor * value).collect();
        for (factor, other) in others {
            first.check_space(other)?;
            values.iter_mut().zip(other.values()).for_each(|(sum, value)| *sum += factor * value);
        }
        Field::from_values(&first.space, values)
    }

    /// The sum with another field on the same space.
    ///
    /// # Errors
    /// As [`Field::combination`].
    #[inline(never)]
    pub fn plus(&self, other: &Field<D>) -> Result<Self, FieldError> {
        Field::combination(&[(1.0, self), (1.0, other)])
    }

    /// The difference from another field on the same space.
    ///
    /// # Errors
    /// As [`Field::combination`].
    #[inline(never)]
    pub fn minus(&self, other: &Field<D>) -> Result<Self, FieldError> {
        Field::combination(&[(1.0, self), (-1.0, other)])
    }

    /// The field times a number.
    ///
    /// # Errors
    /// As [`Field::combination`].
    #[inline(never)]
    pub fn times(&self, factor: f64) -> Result<Self, FieldError> {
        Field::combination(&[(factor, self)])
    }

    fn check_space(&self, other: &Field<D>) -> Result<(), FieldError> {
        let (one, two) = (&self.space, &other.space);
        if one.numbers_as(two) {
            return Ok(());
        }
        let of = |space: &Space<D>| {
            format!("{}, {} component(s) {}", space.elements(), space.components(), space.scope())
        };
        let differ = match (of(one), of(two)) {
            (one, two) if one == two => "they lie on different meshes".to_owned(),
            (one, two) => format!("one has {one}, the other {two}"),
        };
        Err(FieldError::OtherSpace { differ })
    }
}

instantiate!(sums: Field::<D>::combination, Field::<D>::plus, Field::<D>::minus, Field::<D>::times);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::CellShape;
    use crate::mesh::rectangle;

    #[test]
    fn sums_are_those_of_functions_and_keep_to_one_space() -> Result<(), Box<dyn std::error::Error>> {
        let mesh = rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Triangle, 1)?;
        let space = Space::vector(&mesh, 2)?;
        let a = Field::interpolate(&space, |x| [x[0] * x[1], 2.0])?;
        // Another space that numbers its nodes alike.
        let b = Field::interpolate(&Space::vector(&mesh, 2)?, |x| [x[1] - 3.0, x[0]])?;
        let at = [0.3, 0.8];
        for (field, expected) in [
            (a.plus(&b)?, [0.24 + 0.8 - 3.0, 2.3]),
            (a.minus(&b)?, [0.24 - 0.8 + 3.0, 1.7]),
            (a.times(-2.0)?, [-0.48, -4.0]),
            (Field::combination(&[(2.0, &a), (-1.0, &b), (0.5, &a)])?, [0.6 - 0.8 + 3.0, 4.7]),
        ] {
            for (value, expected) in field.evaluate(&at)?.into_iter().zip(expected) {
                assert!((value - expected).abs() < 1e-14, "{value} is not {expected}");
            }
        }
        let message = |field: Result<Field<2>, FieldError>| field.err().map(|error| error.to_string());
        // As many coefficients, but others.
        let same = rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Triangle, 1)?;
        assert_eq!(
            message(a.plus(&Field::zero(&Space::vector(&same, 2)?))).as_deref(),
            Some("the fields are not on one space: they lie on different meshes")
        );
        let scalars = Field::zero(&Space::scalar(&mesh, 2)?);
        let linear = Field::zero(&Space::discontinuous_scalar(&mesh, 1)?);
        assert_eq!(
            message(scalars.minus(&linear)).as_deref(),
            Some(
                "the fields are not on one space: one has Lagrange elements of degree 2, 1 component(s) with \
                 continuous values, the other Lagrange elements of degree 1, 1 component(s) with discontinuous values"
            )
        );
        assert!(
            message(a.times(f64::MAX / 2.0)?.plus(&a.times(f64::MAX / 2.0)?))
                .is_some_and(|m| m.contains("is not finite: inf"))
        );
        assert!(message(a.times(f64::NAN)).is_some_and(|m| m.contains("is not finite: NaN")));
        assert_eq!(Field::<2>::combination(&[]).err(), Some(FieldError::NothingToAdd));
        Ok(())
    }
}

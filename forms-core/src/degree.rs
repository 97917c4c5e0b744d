//! Polynomial degree of an integrand, as numbers that a compiled form hands over: from the degrees of the fields that it is bound
//! to, a backend finds that of its quadrature rule.

/// Degree of an integrand as a polynomial: the largest of several sums, or 0. For what is not a polynomial, an estimate as in UFL.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Degree(pub &'static [DegreeSum]);

/// One product's degree: a constant and multiples of the degrees of its factors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DegreeSum {
    /// The part that does not depend on the fields.
    pub constant: usize,
    /// The number of factors that are the place of a point.
    pub positions: usize,
    /// The number of factors of one degree less than the place, as normals are.
    pub normals: usize,
    /// Of each field among the factors: index, order of the derivative, and how often.
    pub fields: &'static [[usize; 3]],
}

impl Degree {
    /// The degree for fields of these degrees (by index) and a geometry map of this one. On simplices a derivative lowers a
    /// field's degree by its order; on tensor-product cells, where it lowers that of one direction only, it does not.
    ///
    /// # Panics
    /// If a field's index is not below the number of degrees.
    pub fn of(&self, fields: &[usize], geometry: usize, simplex: bool) -> usize {
        self.0.iter().map(|sum| sum.of(fields, geometry, simplex)).max().unwrap_or(0)
    }
}

impl DegreeSum {
    fn of(&self, fields: &[usize], geometry: usize, simplex: bool) -> usize {
        let factors = self.fields.iter().map(|[field, order, count]| {
            let lowered = if simplex { *order } else { 0 };
            count * fields[*field].saturating_sub(lowered)
        });
        self.constant
            + self.positions * geometry
            + self.normals * geometry.saturating_sub(1)
            + factors.sum::<usize>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// u ∇v · x against 1 + n: on simplices of degree 2, 2 + (3 − 1) + 2; elsewhere 2 + 3 + 2.
    const PRODUCT: Degree = Degree(&[
        DegreeSum { constant: 0, positions: 1, normals: 0, fields: &[[0, 0, 1], [1, 1, 1]] },
        DegreeSum { constant: 1, positions: 0, normals: 1, fields: &[] },
    ]);

    #[test]
    fn derivatives_lower_the_degree_on_simplices() {
        assert_eq!(PRODUCT.of(&[2, 3], 2, true), 6);
        assert_eq!(PRODUCT.of(&[2, 3], 2, false), 7);
        // The degree of a constant's derivative is none.
        assert_eq!(PRODUCT.of(&[0, 0], 1, true), 1);
        assert_eq!(PRODUCT.of(&[0, 0], 4, true), 4);
        assert_eq!(Degree(&[]).of(&[], 1, true), 0);
    }
}

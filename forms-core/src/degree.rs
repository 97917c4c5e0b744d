//! Polynomial degree of an integrand, as numbers that a compiled form hands over: from the degrees of the fields that it is bound
//! to, a backend finds that of its quadrature rule.

/// Degree of an integrand as a polynomial: the largest of several sums, or 0. For what is not a polynomial, an estimate as in UFL.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Degree(pub &'static [DegreeSum]);

/// One product's degree: a constant and multiples of the degrees of its factors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct DegreeSum {
    /// The part that does not depend on the fields.
    pub constant: usize,
    /// The number of factors that are the position of a point.
    pub positions: usize,
    /// The number of factors whose degree is one less than that of the position, such as normals.
    pub normals: usize,
    /// Of each field among the factors: index, order of the derivative, and how often.
    pub fields: &'static [[usize; 3]],
}

/// Effect of a derivative on a field's degree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Derivatives {
    /// On simplices, whose polynomials have a total degree.
    LowerDegrees,
    /// On tensor-product cells, where a derivative lowers the degree of one direction only.
    KeepDegrees,
}

/// Degrees of the geometry where an integrand is integrated. A backend finds them from its cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GeometryDegrees {
    /// Degree of the position of a point.
    pub position: usize,
    /// Degree of the normal.
    pub normal: usize,
    /// Degree of the measure, the determinant of the Jacobian or the surface element: a factor of each integrand.
    pub measure: usize,
    /// Effect of a derivative on a field's degree.
    pub derivatives: Derivatives,
}

impl GeometryDegrees {
    /// Degrees of the measure on cells whose map is affine, in a mesh of a given degree: it is constant.
    pub fn affine(degree: usize, derivatives: Derivatives) -> Self {
        GeometryDegrees { position: degree, normal: degree.saturating_sub(1), measure: 0, derivatives }
    }
}

impl Degree {
    /// The degree on cells whose map is affine, for fields of these degrees (by index) and a geometry of this one. On simplices a
    /// derivative lowers a field's degree by its order; on tensor-product cells, where it lowers that of one direction only, it
    /// does not.
    ///
    /// # Panics
    /// If a field's index is not below the number of degrees.
    pub fn of(&self, fields: &[usize], geometry: usize, simplex: bool) -> usize {
        let derivatives = if simplex { Derivatives::LowerDegrees } else { Derivatives::KeepDegrees };
        self.over(fields, &GeometryDegrees::affine(geometry, derivatives))
    }

    /// The degree with that of the measure, for fields of these degrees (by index) on some geometry.
    ///
    /// # Panics
    /// If a field's index is not below the number of degrees.
    pub fn over(&self, fields: &[usize], geometry: &GeometryDegrees) -> usize {
        geometry.measure + self.0.iter().map(|sum| sum.over(fields, geometry)).max().unwrap_or(0)
    }
}

impl DegreeSum {
    fn over(&self, fields: &[usize], geometry: &GeometryDegrees) -> usize {
        let factors = self.fields.iter().map(|[field, order, count]| {
            let lowered = if geometry.derivatives == Derivatives::LowerDegrees { *order } else { 0 };
            count * fields[*field].saturating_sub(lowered)
        });
        self.constant
            + self.positions * geometry.position
            + self.normals * geometry.normal
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

    #[test]
    fn measure_and_normal_count_where_the_geometry_varies() {
        let curved =
            GeometryDegrees { position: 2, normal: 3, measure: 5, derivatives: Derivatives::KeepDegrees };
        assert_eq!(PRODUCT.over(&[2, 3], &curved), 5 + 7);
        // 1 + n.
        assert_eq!(PRODUCT.over(&[0, 0], &curved), 5 + 4);
        assert_eq!(Degree(&[]).over(&[], &curved), 5);
    }
}

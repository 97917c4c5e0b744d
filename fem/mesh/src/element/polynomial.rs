//! Polynomials of the reference coordinates, from which elements are made.

/// A polynomial of up to three reference coordinates: terms with their exponents.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Polynomial {
    pub terms: Vec<([u8; 3], f64)>,
}

impl Polynomial {
    /// x^a y^b z^c.
    pub fn monomial(exponents: [u8; 3]) -> Self {
        Polynomial { terms: vec![(exponents, 1.0)] }
    }

    /// The barycentric coordinates of the simplex of some dimension: 1 − Σ x_k, then each x_k.
    pub fn barycentric(dimension: usize) -> Vec<Self> {
        let unit = |axis: usize| std::array::from_fn(|k| u8::from(k == axis));
        let mut first = Polynomial::monomial([0; 3]);
        first.terms.extend((0..dimension).map(|axis| (unit(axis), -1.0)));
        let others = (0..dimension).map(|axis| Polynomial::monomial(unit(axis)));
        std::iter::once(first).chain(others).collect()
    }

    /// The product with another one.
    pub fn times(&self, other: &Self) -> Self {
        let mut terms: Vec<([u8; 3], f64)> = Vec::new();
        for (a, x) in &self.terms {
            for (b, y) in &other.terms {
                let exponents = std::array::from_fn(|k| a[k] + b[k]);
                match terms.iter_mut().find(|(known, _)| *known == exponents) {
                    Some((_, sum)) => *sum += x * y,
                    None => terms.push((exponents, x * y)),
                }
            }
        }
        Polynomial { terms }
    }

    /// The value at a point.
    pub fn at(&self, point: &[f64; 3]) -> f64 {
        let power =
            |exponents: &[u8; 3]| (0..3).map(|k| point[k].powi(i32::from(exponents[k]))).product::<f64>();
        self.terms.iter().map(|(exponents, coefficient)| coefficient * power(exponents)).sum()
    }
}

/// The monomials of a total degree at most, in some coordinates.
pub(super) fn complete(dimension: usize, degree: usize) -> Vec<Polynomial> {
    exponents(dimension, degree).filter(|e| total(e) <= degree).map(Polynomial::monomial).collect()
}

/// The monomials of degree 1 at most in each coordinate.
pub(super) fn products(dimension: usize) -> Vec<Polynomial> {
    exponents(dimension, 1).map(Polynomial::monomial).collect()
}

/// The monomials of the serendipity element of degree 2: those whose degree, without the coordinates that are linear, is 2 at most.
pub(super) fn serendipity(dimension: usize) -> Vec<Polynomial> {
    let superlinear = |e: &[u8; 3]| e.iter().filter(|e| **e > 1).map(|e| usize::from(*e)).sum::<usize>();
    exponents(dimension, 2).filter(|e| superlinear(e) <= 2).map(Polynomial::monomial).collect()
}

fn total(exponents: &[u8; 3]) -> usize {
    exponents.iter().map(|e| usize::from(*e)).sum()
}

/// All exponents up to a degree in each coordinate, the first one running fastest.
fn exponents(dimension: usize, degree: usize) -> impl Iterator<Item = [u8; 3]> {
    let last = move |axis: usize| if axis < dimension { degree as u8 } else { 0 };
    (0..=last(2)).flat_map(move |z| (0..=last(1)).flat_map(move |y| (0..=last(0)).map(move |x| [x, y, z])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_those_of_the_textbook() {
        assert_eq!([complete(2, 2).len(), complete(3, 2).len()], [6, 10]);
        assert_eq!([serendipity(2).len(), serendipity(3).len()], [8, 20]);
    }

    #[test]
    fn barycentric_coordinates_add_up_to_one() {
        let point = [0.2, 0.3, 0.4];
        let values: Vec<f64> = Polynomial::barycentric(3).iter().map(|p| p.at(&point)).collect();
        assert!((values.iter().sum::<f64>() - 1.0).abs() < 1e-15);
        let bubble = Polynomial::barycentric(3).iter().fold(Polynomial::monomial([0; 3]), |a, b| a.times(b));
        assert!((bubble.at(&point) - values.iter().product::<f64>()).abs() < 1e-16);
    }
}

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

    /// The product with a number.
    fn scaled(mut self, factor: f64) -> Self {
        self.terms.iter_mut().for_each(|(_, coefficient)| *coefficient *= factor);
        self
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

/// Bernstein's polynomial of degree 2 of a node: on simplices the product of two barycentric coordinates, twice where they differ, whose nodes are
/// those of vertices and edges; on others the product of those along each axis.
pub(super) fn bernstein(is_simplex: bool, dimension: usize, node: &[f64; 3]) -> Polynomial {
    let product = |coordinates: &[Polynomial], values: &[f64]| {
        let count = |value: f64| (2.0 * value).round() as usize;
        let factors = coordinates.iter().zip(values).flat_map(|(factor, value)| vec![factor; count(*value)]);
        let all = factors.fold(Polynomial::monomial([0; 3]), |product, factor| product.times(factor));
        if values.contains(&1.0) { all } else { all.scaled(2.0) }
    };
    let coordinates = Polynomial::barycentric(dimension);
    if is_simplex {
        let values: Vec<f64> = coordinates.iter().map(|coordinate| coordinate.at(node)).collect();
        return product(&coordinates, &values);
    }
    let along = |axis: usize| {
        let coordinate = Polynomial::monomial(std::array::from_fn(|k| u8::from(k == axis)));
        let mut rest = Polynomial::monomial([0; 3]);
        rest.terms.extend(coordinate.clone().scaled(-1.0).terms);
        product(&[rest, coordinate], &[1.0 - node[axis], node[axis]])
    };
    (0..dimension).fold(Polynomial::monomial([0; 3]), |all, axis| all.times(&along(axis)))
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
    fn bernstein_polynomials_are_positive_and_sum_to_one() {
        for (is_simplex, dimension) in [(true, 2), (false, 2), (true, 3), (false, 3)] {
            let steps = |last: u8| {
                exponents(dimension, 2).filter(move |e| !is_simplex || total(e) <= usize::from(last))
            };
            let nodes: Vec<[f64; 3]> = steps(2).map(|e| e.map(|step| f64::from(step) / 2.0)).collect();
            let at = |point: &[f64; 3]| -> Vec<f64> {
                nodes.iter().map(|node| bernstein(is_simplex, dimension, node).at(point)).collect()
            };
            for point in [[0.2, 0.3, 0.4], [0.05, 0.9, 0.02], [0.5, 0.0, 0.0]] {
                let point = std::array::from_fn(|k| if k < dimension { point[k] } else { 0.0 });
                let values = at(&point);
                assert!(
                    (values.iter().sum::<f64>() - 1.0).abs() < 1e-15
                        && values.iter().all(|value| *value >= 0.0)
                );
                // The coefficients of a linear function are its values at the nodes.
                for axis in 0..dimension {
                    let linear: f64 = values.iter().zip(&nodes).map(|(value, node)| value * node[axis]).sum();
                    assert!((linear - point[axis]).abs() < 1e-15);
                }
            }
        }
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

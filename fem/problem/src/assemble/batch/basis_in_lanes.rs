//! Basis functions at points that differ from lane to lane, where tables at common points do not serve.

// Closures and iterator adaptors do not inherit a caller's target features, and copies of slices may become calls:
// loops over lane values are plain.
#![allow(clippy::needless_range_loop, clippy::manual_memcpy)]

mod monomials;

use forms_core::contract::Lane;

use self::monomials::Monomials;
use crate::element::{Element, Lagrange, MAXIMUM_DEGREE, lattice};

/// Value, slope and second derivative of one factor per number of steps.
type Factors<L> = [[L; 3]; MAXIMUM_DEGREE + 1];

/// The basis functions of an element as products of factors of its barycentric coordinates, or of its coordinates.
#[derive(Clone, Debug)]
pub(crate) struct LaneElement {
    degree: usize,
    simplex: bool,
    /// Of each node: steps along λ₀ (none on quadrilaterals and hexahedra), then along each coordinate.
    steps: Vec<[u8; 4]>,
    /// Of elements that are no Lagrange elements.
    monomials: Option<Monomials>,
}

/// The basis at one point per lane.
#[derive(Clone, Debug)]
pub(crate) struct LaneBasis<L, const D: usize> {
    pub value: Vec<L>,
    /// In reference coordinates; this too only where it was asked for.
    pub gradient: Vec<[L; D]>,
    /// In reference coordinates; only where it was asked for.
    pub hessian: Vec<[[L; D]; D]>,
}

impl<L, const D: usize> Default for LaneBasis<L, D> {
    fn default() -> Self {
        LaneBasis { value: vec![], gradient: vec![], hessian: vec![] }
    }
}

impl LaneElement {
    /// All functions of an element, or those of the nodes on a facet.
    pub(crate) fn new(element: &Element, facet: Option<usize>) -> Self {
        let kept = facet.map(|local| element.facet_nodes(local));
        let nodes = kept.as_deref();
        match element.as_table() {
            Some(table) => {
                let all: Vec<usize> = (0..element.nodes()).collect();
                let mut monomials = Monomials::new(table, nodes.unwrap_or(&all));
                if let Some(coefficients) = facet.and_then(|local| element.dual_on_facet(local)) {
                    monomials.combine(&coefficients);
                }
                let monomials = Some(monomials);
                LaneElement { monomials, ..Self::without_functions() }
            }
            None => Self::lagrange(element.as_lagrange().as_ref(), nodes),
        }
    }

    /// No function, as of a space on facets inside of a cell.
    pub(crate) fn without_functions() -> Self {
        LaneElement { degree: 0, simplex: false, steps: vec![], monomials: None }
    }

    /// Functions of some nodes, those to which dual functions are dual in the place of these.
    pub(crate) fn before_duality(element: &Element, nodes: &[usize]) -> Self {
        let monomials = element.as_table().map(|table| Monomials::new(table, nodes));
        LaneElement { monomials, ..Self::without_functions() }
    }

    fn lagrange(element: Option<&Lagrange>, nodes: Option<&[usize]>) -> Self {
        let Some(element) = element else {
            return Self::without_functions();
        };
        let simplex = element.shape.is_simplex();
        let steps_of = |node: &[u8; 3]| {
            let first = if simplex { element.degree as u8 - node.iter().sum::<u8>() } else { 0 };
            [first, node[0], node[1], node[2]]
        };
        let steps = match (element.degree, nodes) {
            (0, _) => vec![[0; 4]],
            (degree, None) => lattice(element.shape, degree).iter().map(steps_of).collect(),
            (degree, Some(nodes)) => {
                let all = lattice(element.shape, degree);
                nodes.iter().map(|node| steps_of(&all[*node])).collect()
            }
        };
        LaneElement { degree: element.degree, simplex, steps, monomials: None }
    }

    /// Derivatives at a point up to `ORDER`, two at most.
    #[inline(always)]
    pub(crate) fn evaluate<L: Lane, const ORDER: usize, const D: usize>(
        &self,
        point: &[L; D],
        basis: &mut LaneBasis<L, D>,
    ) {
        if let Some(monomials) = &self.monomials {
            return monomials.evaluate::<L, ORDER, D>(point, basis);
        }
        let (zero, one) = (L::splat(0.0), L::splat(1.0));
        let mut factors = [[[one, zero, zero]; MAXIMUM_DEGREE + 1]; 4];
        if self.simplex {
            let mut rest = one;
            for k in 0..D {
                rest = rest - point[k];
                self.ascending::<L, ORDER>(point[k], &mut factors[k + 1]);
            }
            self.ascending::<L, ORDER>(rest, &mut factors[0]);
        } else {
            for k in 0..D {
                self.segment::<L, ORDER>(point[k], &mut factors[k + 1]);
            }
        }
        let count = self.steps.len();
        basis.value.resize(count, zero);
        basis.gradient.resize(if ORDER > 0 { count } else { 0 }, [zero; D]);
        basis.hessian.resize(if ORDER > 1 { count } else { 0 }, [[zero; D]; D]);
        for node in 0..count {
            let steps = &self.steps[node];
            let mut own = [[zero; 3]; 4];
            for axis in 0..=D {
                let factor = &factors[axis][steps[axis] as usize];
                for order in 0..=ORDER {
                    own[axis][order] = factor[order];
                }
            }
            let mut value = own[0][0];
            for axis in 1..=D {
                value = value * own[axis][0];
            }
            basis.value[node] = value;
            if ORDER == 0 {
                continue;
            }
            let mut slopes = [zero; 4];
            for axis in 0..=D {
                slopes[axis] = first::<L, D>(&own, axis);
            }
            for k in 0..D {
                // Each ∂/∂ξ is ∂/∂λ of its own coordinate less ∂/∂λ₀, whose factor is 1 on quadrilaterals and hexahedra.
                basis.gradient[node][k] = slopes[k + 1] - slopes[0];
            }
            if ORDER > 1 {
                let common = second::<L, D>(&own, 0, 0);
                for k in 0..D {
                    for l in 0..D {
                        let mixed = second::<L, D>(&own, 0, k + 1) + second::<L, D>(&own, 0, l + 1);
                        basis.hessian[node][k][l] = second::<L, D>(&own, k + 1, l + 1) - mixed + common;
                    }
                }
            }
        }
    }

    /// p_n(λ) = Π_{m < n} (kλ − m)/(m + 1): 1 at λ = n/k, zero at the multiples of 1/k below.
    #[inline(always)]
    fn ascending<L: Lane, const ORDER: usize>(&self, lambda: L, factors: &mut Factors<L>) {
        let k = L::splat(self.degree as f64);
        factors[0] = [L::splat(1.0), L::splat(0.0), L::splat(0.0)];
        for n in 0..self.degree {
            let (scale, root) = (L::splat(1.0 / (n as f64 + 1.0)), k * lambda - L::splat(n as f64));
            let [p, dp, ddp] = factors[n];
            factors[n + 1][0] = scale * (p * root);
            if ORDER > 0 {
                factors[n + 1][1] = scale * (dp * root + k * p);
            }
            if ORDER > 1 {
                factors[n + 1][2] = scale * (ddp * root + (k * dp + k * dp));
            }
        }
    }

    /// The basis on the segment, the simplex of one dimension, where two factors make one.
    #[inline(always)]
    fn segment<L: Lane, const ORDER: usize>(&self, x: L, factors: &mut Factors<L>) {
        let mut left = *factors;
        let mut right = *factors;
        self.ascending::<L, ORDER>(L::splat(1.0) - x, &mut left);
        self.ascending::<L, ORDER>(x, &mut right);
        for steps in 0..=self.degree {
            let ([a, da, dda], [b, db, ddb]) = (left[self.degree - steps], right[steps]);
            let mixed = da * db + da * db;
            factors[steps] = [a * b, a * db - da * b, dda * b - mixed + a * ddb];
        }
    }
}

/// The product of the coordinates' factors, differentiated along one.
#[inline(always)]
fn first<L: Lane, const D: usize>(own: &[[L; 3]; 4], along: usize) -> L {
    let mut product = own[along][1];
    for axis in 0..=D {
        if axis != along {
            product = product * own[axis][0];
        }
    }
    product
}

/// The same, differentiated along two.
#[inline(always)]
fn second<L: Lane, const D: usize>(own: &[[L; 3]; 4], a: usize, b: usize) -> L {
    let mut product = if a == b { own[a][2] } else { own[a][1] * own[b][1] };
    for axis in 0..=D {
        if axis != a && axis != b {
            product = product * own[axis][0];
        }
    }
    product
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::CellShape;

    fn agrees<const D: usize>(shape: CellShape, point: [f64; D]) {
        for degree in 0..=MAXIMUM_DEGREE {
            let element = Lagrange { shape, degree };
            let tables = element.tabulate_with_hessians(&[point]);
            let (lanes, mut basis) =
                (LaneElement::new(&Element::Lagrange(element), None), LaneBasis::default());
            lanes.evaluate::<f64, 2, D>(&point, &mut basis);
            assert_eq!(basis.value.len(), element.nodes());
            let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{shape:?} {degree}: {a} is not {b}");
            for node in 0..element.nodes() {
                close(basis.value[node], tables.value[node]);
                for k in 0..D {
                    close(basis.gradient[node][k], tables.gradient[node][k]);
                    for l in 0..D {
                        close(basis.hessian[node][k][l], tables.hessian[node][k][l]);
                    }
                }
            }
            if degree > 0 {
                let facet = element.facet_nodes(1);
                let on_facet = LaneElement::new(&Element::Lagrange(element), Some(1));
                on_facet.evaluate::<f64, 1, D>(&point, &mut basis);
                assert!(basis.hessian.is_empty());
                for (place, node) in facet.iter().enumerate() {
                    close(basis.value[place], tables.value[*node]);
                    for k in 0..D {
                        close(basis.gradient[place][k], tables.gradient[*node][k]);
                    }
                }
                on_facet.evaluate::<f64, 0, D>(&point, &mut basis);
                assert!(basis.gradient.is_empty());
                for (value, node) in basis.value.iter().zip(&facet) {
                    close(*value, tables.value[*node]);
                }
            }
        }
    }

    #[test]
    fn lanes_and_tables_agree() {
        for shape in CellShape::ALL {
            match shape.dimension() {
                2 => agrees(shape, [0.3, 0.45]),
                _ => agrees(shape, [0.3, 0.15, 0.4]),
            }
        }
    }
}

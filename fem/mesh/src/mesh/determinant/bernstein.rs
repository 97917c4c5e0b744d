//! Polynomials on a reference cell in Bernstein form: coefficients, products, halves.

use std::collections::HashMap;

use crate::element::CellShape;

/// Exponents of a Bernstein polynomial: one per vertex of a simplex; on quadrilaterals and hexahedra one per axis, of the
/// factor that is 1 at its upper end. What is not used is zero.
pub(super) type Exponents = [u8; 4];

/// The Bernstein polynomials of one degree on a reference cell.
#[derive(Clone, Debug)]
pub(super) struct Bernstein {
    shape: CellShape,
    /// Along each axis; on simplices the first one is the total degree.
    degrees: [u8; 3],
    pub(super) exponents: Vec<Exponents>,
}

/// A cut through a reference cell: between two vertices of a simplex, or across an axis.
#[derive(Clone, Copy, Debug)]
pub(super) enum Cut {
    Edge(usize, usize),
    Axis(usize),
}

/// Coefficients of a half as sums over those of the whole.
pub(super) type Half = Vec<Vec<(usize, f64)>>;

impl Bernstein {
    /// The polynomials of a degree along each axis; on simplices the first one is the total degree.
    pub(super) fn new(shape: CellShape, degrees: [u8; 3]) -> Self {
        let (count, most) = match shape.is_simplex() {
            true => (shape.dimension() + 1, [degrees[0]; 4]),
            false => (shape.dimension(), [degrees[0], degrees[1], degrees[2], 0]),
        };
        let mut exponents: Vec<Exponents> = vec![[0; 4]];
        for place in 0..count {
            let with = |exponent: u8, mut other: Exponents| {
                other[place] = exponent;
                other
            };
            exponents = (0..=most[place])
                .flat_map(|exponent| exponents.iter().map(move |other| with(exponent, *other)))
                .collect();
        }
        if shape.is_simplex() {
            exponents.retain(|exponents| exponents.iter().sum::<u8>() == degrees[0]);
        }
        Bernstein { shape, degrees, exponents }
    }

    /// The degree along an axis; on simplices the first one is the total degree.
    pub(super) fn degree(&self, axis: usize) -> u8 {
        self.degrees.get(axis).copied().unwrap_or(0)
    }

    /// B_a B_b = (m_a m_b / m_{a + b}) B_{a + b}: the factor m of a polynomial.
    pub(super) fn multiplicity(&self, exponents: &Exponents) -> f64 {
        if self.shape.is_simplex() {
            let below: f64 = exponents.iter().map(|&exponent| factorial(exponent)).product();
            return factorial(self.degrees[0]) / below;
        }
        self.degrees.iter().zip(exponents).map(|(&degree, &exponent)| binomial(degree, exponent)).product()
    }

    /// The place of each polynomial.
    pub(super) fn places(&self) -> HashMap<Exponents, usize> {
        self.exponents.iter().enumerate().map(|(place, exponents)| (*exponents, place)).collect()
    }

    /// The coefficients that are values at the cell's vertices, each with its vertex: on simplices as the vertex's number, otherwise as lower or
    /// upper end of each axis.
    pub(super) fn corners(&self) -> Vec<(usize, Exponents)> {
        let simplex = self.shape.is_simplex();
        let at_end = |exponents: &Exponents| match simplex {
            true => exponents.contains(&self.degrees[0]),
            false => self.degrees.iter().zip(exponents).all(|(degree, e)| *e == 0 || e == degree),
        };
        let ends = |exponents: &Exponents| exponents.map(|exponent| u8::from(exponent > 0));
        let corners = self.exponents.iter().enumerate().filter(|(_, exponents)| at_end(exponents));
        corners.map(|(place, exponents)| (place, ends(exponents))).collect()
    }

    /// The two halves of a cell. Of a simplex the first one has the middle of the edge in place of its second end.
    pub(super) fn halves(&self, cut: Cut) -> [Half; 2] {
        let places = self.places();
        // The exponents at the end that stays and at the end that moves.
        let ends = |exponents: &Exponents, moved: usize| match cut {
            Cut::Edge(a, b) => {
                let [kept, moved] = if moved == 1 { [a, b] } else { [b, a] };
                (exponents[kept], exponents[moved])
            }
            Cut::Axis(axis) => {
                let [lower, upper] = [self.degrees[axis] - exponents[axis], exponents[axis]];
                if moved == 1 { (lower, upper) } else { (upper, lower) }
            }
        };
        let with = |exponents: &Exponents, moved: usize, count: u8| {
            let mut changed = *exponents;
            let (kept_count, moved_count) = ends(exponents, moved);
            match cut {
                Cut::Edge(a, b) => {
                    let [kept, moved] = if moved == 1 { [a, b] } else { [b, a] };
                    changed[kept] = kept_count + moved_count - count;
                    changed[moved] = count;
                }
                Cut::Axis(axis) => {
                    changed[axis] = if moved == 1 { count } else { self.degrees[axis] - count };
                }
            }
            places[&changed]
        };
        // De Casteljau's algorithm at one half: the moved end counts in all ways as either end.
        [1, 0].map(|moved| {
            let of_half = |exponents: &Exponents| {
                let (_, count) = ends(exponents, moved);
                let weight = |part: u8| binomial(count, part) * 0.5_f64.powi(i32::from(count));
                (0..=count).map(|part| (with(exponents, moved, part), weight(part))).collect()
            };
            self.exponents.iter().map(of_half).collect()
        })
    }
}

fn factorial(n: u8) -> f64 {
    (1..=n).map(f64::from).product()
}

fn binomial(n: u8, k: u8) -> f64 {
    factorial(n) / (factorial(k) * factorial(n - k))
}

//! Proof that the Jacobian determinant of a cell is positive everywhere in it, or a point where it is not.
//!
//! A polynomial lies between the least and the largest of its Bernstein coefficients, and those at the vertices are its
//! values there (G. Farin, Curves and Surfaces for CAGD; for cells A. Johnen, J.-F. Remacle, C. Geuzaine, Geometrical
//! validity of curvilinear finite elements, 2013). If all are positive, so is the determinant; if one at a vertex is
//! not, the cell is folded; else the cell is halved, and each half is asked.

mod bernstein;
#[cfg(test)]
mod tests;

use std::sync::OnceLock;

use self::bernstein::{Bernstein, Cut, Exponents, Half};
use super::small_matrices::{determinant, inverse};
use crate::element::{CellShape, Lagrange};

/// Halves of a cell that are asked before the question is given up. A determinant that comes near zero in a point needs
/// about a hundred; more than these only one that nearly vanishes along a surface.
const MOST_HALVES: usize = 4096;

/// A determinant this small relative to the product of the lengths of the Jacobian's columns is round-off of zero.
pub(super) const ROUND_OFF: f64 = 1e-14;

/// Below this a determinant has no reciprocal to calculate with: cells with an edge as short as the least numbers are
/// degenerate.
pub(super) const SMALLEST: f64 = 1e-300;

/// Relative deviation of the Jacobian from its mean, below which the determinant needs no second look.
const NEARLY_AFFINE: f64 = 0.9;

/// The sign of a cell's Jacobian determinant, as far as it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sign<const D: usize> {
    /// Positive everywhere.
    Positive,
    /// Not positive at this reference point, up to round-off.
    Folded { reference: [f64; D], determinant: f64 },
    /// After many subdivisions a part around this reference point still has only a lower bound.
    Undecided { reference: [f64; D], bound: f64 },
}

/// The determinant as a function of a cell's nodes.
pub struct JacobianDeterminant<const D: usize> {
    shape: CellShape,
    /// For each reference coordinate the polynomials in which ∂x/∂ξ is written.
    derivatives: [Bernstein; D],
    /// Coefficient after coefficient of each ∂x/∂ξ: nodes and their weights.
    controls: [Vec<Vec<(usize, f64)>>; D],
    expansion: OnceLock<Expansion<D>>,
}

/// The determinant's own Bernstein form: needed where cells are strongly distorted.
struct Expansion<const D: usize> {
    length: usize,
    corners: Vec<(usize, Exponents)>,
    /// The determinant of one coefficient of each derivative, times the number, adds to a coefficient.
    terms: Vec<([u16; D], u16, f64)>,
    /// By edge of a simplex, or axis.
    halves: Vec<(Cut, [Half; 2])>,
}

/// A part of a cell: the coefficients there, and its vertices, or lower and upper corner.
struct Part<const D: usize> {
    coefficients: Vec<f64>,
    vertices: Vec<[f64; D]>,
    /// Number of halvings.
    depth: usize,
}

impl<const D: usize> JacobianDeterminant<D> {
    /// For the cells of a geometry element.
    pub fn new(element: &Lagrange) -> Self {
        let (shape, degree) = (element.shape, element.degree as u8);
        let derivatives = std::array::from_fn(|axis| {
            let mut degrees = if D == 2 { [degree, degree, 0] } else { [degree; 3] };
            degrees[if shape.is_simplex() { 0 } else { axis }] -= 1;
            Bernstein::new(shape, degrees)
        });
        let of_axis = |axis: usize| -> Vec<Vec<(usize, f64)>> {
            let form: &Bernstein = &derivatives[axis];
            form.exponents.iter().map(|exponents| control::<D>(element, form, exponents, axis)).collect()
        };
        let controls = std::array::from_fn(of_axis);
        JacobianDeterminant { shape, derivatives, controls, expansion: OnceLock::new() }
    }

    /// The sign on the cell whose nodes are at the given positions \[length\].
    pub fn sign(&self, nodes: &[u32], positions: &[[f64; D]]) -> Sign<D> {
        let columns: [Vec<[f64; D]>; D] = std::array::from_fn(|axis| {
            let combined = |terms: &Vec<(usize, f64)>| {
                let mut sum = [0.0; D];
                for &(node, weight) in terms {
                    let x = &positions[nodes[node] as usize];
                    for i in 0..D {
                        sum[i] += weight * x[i];
                    }
                }
                sum
            };
            self.controls[axis].iter().map(combined).collect()
        });
        if is_nearly_affine(&columns) { Sign::Positive } else { self.decide(&columns) }
    }

    #[cold]
    fn decide(&self, columns: &[Vec<[f64; D]>; D]) -> Sign<D> {
        let expansion = self.expansion.get_or_init(|| self.expand());
        let mut coefficients = vec![0.0; expansion.length];
        for (factors, place, weight) in &expansion.terms {
            let jacobian: [[f64; D]; D] =
                std::array::from_fn(|i| std::array::from_fn(|j| columns[j][usize::from(factors[j])][i]));
            coefficients[usize::from(*place)] += weight * determinant(&jacobian);
        }
        let longest = |column: &Vec<[f64; D]>| column.iter().map(length).fold(0.0, f64::max);
        let least = (ROUND_OFF * columns.iter().map(longest).product::<f64>()).max(SMALLEST);
        let vertices = match self.shape.is_simplex() {
            true => self.shape.vertex_points().iter().map(|x| std::array::from_fn(|k| x[k])).collect(),
            false => vec![[0.0; D], [1.0; D]],
        };
        let mut parts = vec![Part { coefficients, vertices, depth: 0 }];
        let mut asked = 0;
        while let Some(part) = parts.pop() {
            for (place, ends) in &expansion.corners {
                let value = part.coefficients[*place];
                // NaN is not positive.
                if value.is_nan() || value <= least {
                    return Sign::Folded { reference: part.corner(ends), determinant: value };
                }
            }
            let bound = part.bound();
            if bound > least {
                continue;
            }
            asked += 1;
            if asked > MOST_HALVES {
                return Sign::Undecided { reference: part.centre(), bound };
            }
            let [first, second] = part.halves(expansion);
            // The worse one is asked first.
            parts.extend(if first.bound() < second.bound() { [second, first] } else { [first, second] });
        }
        Sign::Positive
    }

    fn expand(&self) -> Expansion<D> {
        let shape = self.shape;
        let own = |axis: usize| self.derivatives.each_ref().map(|form| form.degree(axis)).iter().sum::<u8>();
        let whole = Bernstein::new(shape, [0, 1, 2].map(own));
        let places = whole.places();
        let mut products: Vec<([u16; D], Exponents, f64)> = vec![([0; D], [0; 4], 1.0)];
        for (axis, form) in self.derivatives.iter().enumerate() {
            let with = |(factors, exponents, weight): &([u16; D], Exponents, f64),
                        (place, own): (usize, &Exponents)| {
                let mut factors = *factors;
                factors[axis] = place as u16;
                let sum = std::array::from_fn(|k| exponents[k] + own[k]);
                (factors, sum, weight * form.multiplicity(own))
            };
            let all = products
                .iter()
                .flat_map(|product| form.exponents.iter().enumerate().map(move |own| with(product, own)));
            products = all.collect();
        }
        let term = |(factors, exponents, weight): ([u16; D], Exponents, f64)| {
            (factors, places[&exponents] as u16, weight / whole.multiplicity(&exponents))
        };
        let cuts: Vec<Cut> = match shape.is_simplex() {
            true => shape.edges().iter().map(|&[a, b]| Cut::Edge(a, b)).collect(),
            false => (0..D).map(Cut::Axis).collect(),
        };
        Expansion {
            length: whole.exponents.len(),
            corners: whole.corners(),
            terms: products.into_iter().map(term).collect(),
            halves: cuts.into_iter().map(|cut| (cut, whole.halves(cut))).collect(),
        }
    }
}

/// A coefficient of ∂x/∂ξ as a sum over nodes: along each axis the coefficients of degree 2 are f(0), 2 f(½) −
/// (f(0) + f(1))/2 and f(1); those of degree 1, and all on simplices, are values.
fn control<const D: usize>(
    element: &Lagrange,
    form: &Bernstein,
    exponents: &Exponents,
    axis: usize,
) -> Vec<(usize, f64)> {
    let mut points: Vec<([f64; D], f64)> = vec![([0.0; D], 1.0)];
    if element.shape.is_simplex() {
        let vertices = element.shape.vertex_points();
        let vertex = exponents.iter().position(|exponent| *exponent > 0).map_or([0.0; 3], |v| vertices[v]);
        points = vec![(std::array::from_fn(|k| vertex[k]), 1.0)];
    } else {
        for k in 0..D {
            let samples: &[(f64, f64)] = match (form.degree(k), exponents[k]) {
                (_, 0) => &[(0.0, 1.0)],
                (2, 1) => &[(0.0, -0.5), (0.5, 2.0), (1.0, -0.5)],
                _ => &[(1.0, 1.0)],
            };
            let with = |(mut point, weight): ([f64; D], f64), (t, own): (f64, f64)| {
                point[k] = t;
                (point, weight * own)
            };
            points = points.iter().flat_map(|point| samples.iter().map(|s| with(*point, *s))).collect();
        }
    }
    let places: Vec<[f64; D]> = points.iter().map(|(point, _)| *point).collect();
    let tables = element.tabulate(&places);
    let mut weights = vec![0.0; tables.nodes];
    for ((_, weight), slopes) in points.iter().zip(tables.gradient.chunks(tables.nodes)) {
        for (sum, slope) in weights.iter_mut().zip(slopes) {
            *sum += weight * slope[axis];
        }
    }
    weights.into_iter().enumerate().filter(|(_, weight)| *weight != 0.0).collect()
}

/// Whether J = A + E with the mean A and, for each column, ‖A⁻¹E‖₁ so small that all eigenvalues of A⁻¹J have positive
/// real parts: a bound that most cells meet, for a fraction of the work.
fn is_nearly_affine<const D: usize>(columns: &[Vec<[f64; D]>; D]) -> bool {
    let mut mean = [[0.0; D]; D];
    for (axis, column) in columns.iter().enumerate() {
        for x in column {
            for i in 0..D {
                mean[i][axis] += x[i];
            }
        }
        for row in &mut mean {
            row[axis] /= column.len() as f64;
        }
    }
    let scale: f64 = (0..D).map(|axis| length::<D>(&std::array::from_fn(|i| mean[i][axis]))).product();
    let whole = determinant(&mean);
    // At no point it is less than a thousandth of this.
    let Some(inverse) = inverse(&mean).filter(|_| whole > (ROUND_OFF * scale).max(1e3 * SMALLEST)) else {
        return false;
    };
    columns.iter().enumerate().all(|(axis, column)| {
        column.iter().all(|x| {
            let off = |i: usize| {
                let entry: f64 = (0..D).map(|j| inverse[i][j] * x[j]).sum();
                (entry - if i == axis { 1.0 } else { 0.0 }).abs()
            };
            (0..D).map(off).sum::<f64>() <= NEARLY_AFFINE
        })
    })
}

fn length<const D: usize>(x: &[f64; D]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

impl<const D: usize> Part<D> {
    fn bound(&self) -> f64 {
        self.coefficients.iter().copied().fold(f64::INFINITY, f64::min)
    }

    fn corner(&self, ends: &Exponents) -> [f64; D] {
        match ends.iter().position(|end| *end > 0) {
            Some(vertex) if self.vertices.len() > 2 => self.vertices[vertex],
            _ => std::array::from_fn(|k| self.vertices[usize::from(ends[k])][k]),
        }
    }

    fn centre(&self) -> [f64; D] {
        let count = self.vertices.len() as f64;
        std::array::from_fn(|k| self.vertices.iter().map(|vertex| vertex[k]).sum::<f64>() / count)
    }

    /// Of a simplex those across its longest edge; of a quadrilateral or hexahedron those with the best bounds.
    fn halves(&self, expansion: &Expansion<D>) -> [Part<D>; 2] {
        let cuts = &expansion.halves;
        let square = |cut: Cut| match cut {
            Cut::Edge(a, b) => {
                let (a, b) = (self.vertices[a], self.vertices[b]);
                (0..D).map(|k| (a[k] - b[k]) * (a[k] - b[k])).sum::<f64>()
            }
            Cut::Axis(_) => 0.0,
        };
        if let Cut::Edge(..) = cuts[0].0 {
            let longer = |a: usize, b: usize| if square(cuts[b].0) > square(cuts[a].0) { b } else { a };
            let (cut, halves) = &cuts[(0..cuts.len()).reduce(longer).unwrap_or(0)];
            return self.halved(*cut, halves);
        }
        // Where bounds are equal, the axes take turns.
        let in_turn = (0..D).map(|k| &cuts[(self.depth + k) % D]);
        let mut all = in_turn.map(|(cut, halves)| self.halved(*cut, halves));
        let bounds = |halves: &[Part<D>; 2]| halves[0].bound() + halves[1].bound();
        let better = |a: [Part<D>; 2], b: [Part<D>; 2]| if bounds(&b) > bounds(&a) { b } else { a };
        let first = all.next().unwrap_or_else(|| self.halved(cuts[0].0, &cuts[0].1));
        all.fold(first, better)
    }

    fn halved(&self, cut: Cut, halves: &[Half; 2]) -> [Part<D>; 2] {
        [0, 1].map(|number| {
            let sum = |terms: &Vec<(usize, f64)>| {
                terms.iter().map(|(place, weight)| weight * self.coefficients[*place]).sum()
            };
            let mut vertices = self.vertices.clone();
            match cut {
                Cut::Edge(a, b) => {
                    let middle = std::array::from_fn(|k| 0.5 * (vertices[a][k] + vertices[b][k]));
                    vertices[if number == 0 { b } else { a }] = middle;
                }
                Cut::Axis(axis) => {
                    vertices[1 - number][axis] = 0.5 * (vertices[0][axis] + vertices[1][axis]);
                }
            }
            let coefficients = halves[number].iter().map(sum).collect();
            Part { coefficients, vertices, depth: self.depth + 1 }
        })
    }
}

//! Elements of polynomials that are given by their nodes: the basis functions are 1 at one node and 0 at the others.

use super::CellShape;
use super::lagrange::{ElementError, Lagrange, MAXIMUM_NODES};
use super::layout::Layout;
use super::polynomial::Polynomial;

/// The highest exponent of a coordinate in a table's polynomials.
pub const MAXIMUM_EXPONENT: usize = 6;

/// Values below this, relative to 1, are rounding.
const ROUNDING: f64 = 1e-9;

/// An element of polynomials on a reference cell. Its functions are sums of monomials.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Name, for messages.
    pub(super) name: String,
    pub(super) layout: Layout,
    /// The degree that rules of quadrature count: that of the polynomials which the element holds completely, or more.
    pub(super) degree: usize,
    /// Exponents of the monomials.
    exponents: Vec<[u8; 3]>,
    /// The coefficient of monomial m in function i, at `i * monomials + m`.
    coefficients: Vec<f64>,
    /// Per facet, the functions that do not vanish on all of it.
    pub(super) seen: Vec<Vec<usize>>,
    /// The Lagrange element that has the same functions on facets.
    pub(super) traces: Option<Lagrange>,
    /// Whether the functions on a facet follow from the values at its nodes, and are the same from both sides however cells are turned.
    pub(super) conforms: bool,
    /// The meaning of the coefficients.
    pub(super) meaning: Meaning,
    /// Whether the functions are polynomials of the position and not of the reference coordinates.
    pub(super) in_space: bool,
}

/// The meaning of an element's coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Meaning {
    /// Values at nodes.
    Values,
    /// Those of Bernstein's polynomials of degree 2.
    Bernstein,
    /// Those of the functions on facets that are dual to the table's.
    Dual,
    /// The same of Bernstein's polynomials of degree 2.
    DualOfBernstein,
}

/// Value and first two derivatives of the powers of a coordinate.
type Powers = [[f64; 3]; MAXIMUM_EXPONENT + 1];

impl Table {
    /// The element that spans some polynomials, given by the values at its nodes.
    ///
    /// # Errors
    /// [`ElementError::NotUnisolvent`] where the values at the nodes do not determine the polynomial, [`ElementError::Table`] for
    /// too many nodes or too high exponents.
    pub(super) fn nodal(
        name: String,
        layout: Layout,
        degree: usize,
        span: &[Polynomial],
    ) -> Result<Self, ElementError> {
        if layout.nodes() != span.len() {
            return Err(ElementError::Table { name, reason: "it has as many functions as nodes" });
        }
        let shape = layout.shape;
        let values = layout.points.iter().map(|point| span.iter().map(|p| p.at(point)).collect()).collect();
        let Some(inverse) = inverse(values) else { return Err(ElementError::NotUnisolvent { name, shape }) };
        // Function i is Σ_j (V⁻¹)_ji p_j with V_ij = p_j(x_i).
        let function = |i: usize| {
            let terms = span.iter().zip(&inverse).flat_map(|(polynomial, row)| {
                polynomial.terms.iter().map(move |(exponents, factor)| (*exponents, row[i] * factor))
            });
            Polynomial { terms: terms.collect() }
        };
        let functions: Vec<Polynomial> = (0..span.len()).map(function).collect();
        Table::of_functions(name, layout, degree, &functions)
    }

    /// The element of some functions, one per node.
    ///
    /// # Errors
    /// [`ElementError::Table`] for too many nodes or too high exponents.
    pub(super) fn of_functions(
        name: String,
        layout: Layout,
        degree: usize,
        functions: &[Polynomial],
    ) -> Result<Self, ElementError> {
        let refused = |reason| Err(ElementError::Table { name: name.clone(), reason });
        if functions.len() > MAXIMUM_NODES {
            return refused("it has 125 nodes at most");
        }
        let mut exponents: Vec<[u8; 3]> =
            functions.iter().flat_map(|p| &p.terms).map(|term| term.0).collect();
        exponents.sort_unstable();
        exponents.dedup();
        if exponents.as_flattened().iter().any(|exponent| usize::from(*exponent) > MAXIMUM_EXPONENT) {
            return refused("its exponents are 6 at most");
        }
        let mut coefficients = vec![0.0; functions.len() * exponents.len()];
        for (row, polynomial) in coefficients.chunks_mut(exponents.len().max(1)).zip(functions) {
            for (term, factor) in &polynomial.terms {
                let place = exponents.iter().position(|known| known == term).unwrap_or(0);
                row[place] += factor;
            }
        }
        let mut table = Table {
            name,
            layout,
            degree,
            exponents,
            coefficients,
            seen: vec![],
            traces: None,
            conforms: false,
            meaning: Meaning::Values,
            in_space: false,
        };
        table.seen = table.seen_on_facets();
        table.traces = [1, 2]
            .into_iter()
            .map(|degree| Lagrange { shape: table.layout.shape, degree })
            .find(|known| table.has_traces_of(known));
        table.conforms = table.traces.is_some() || table.is_alike_from_both_sides();
        Ok(table)
    }

    /// The functions that are dual to these on facets.
    pub(super) fn dual(self) -> Self {
        Table { meaning: Meaning::Dual, traces: None, ..self }
    }

    /// The functions that are dual to these on facets, which are Bernstein's polynomials.
    pub(super) fn dual_of_bernstein(self) -> Self {
        Table { meaning: Meaning::DualOfBernstein, traces: None, ..self }
    }

    /// The same functions, which are Bernstein's polynomials.
    pub(super) fn of_bernstein(self) -> Self {
        Table { meaning: Meaning::Bernstein, ..self }
    }

    /// The same functions of the position.
    pub(super) fn in_space(self) -> Self {
        Table { in_space: true, ..self }
    }

    /// Exponents of the monomials.
    #[doc(hidden)]
    pub fn exponents(&self) -> &[[u8; 3]] {
        &self.exponents
    }

    /// The coefficients of a function's monomials.
    #[doc(hidden)]
    pub fn coefficients_of(&self, function: usize) -> &[f64] {
        let count = self.exponents.len();
        &self.coefficients[function * count..][..count]
    }

    /// Points on a facet, more than a polynomial that is not zero there has zeros.
    fn samples(&self, local: usize) -> Vec<[f64; 3]> {
        let steps = MAXIMUM_EXPONENT + 2;
        let place = |step: usize| (step as f64 + 0.5) / steps as f64;
        let across = if self.layout.shape.dimension() == 2 { 1 } else { steps };
        let all = (0..steps).flat_map(|s| (0..across).map(move |t| [s, t]));
        all.map(|[s, t]| self.layout.on_facet(local, [place(s), if across == 1 { 0.0 } else { place(t) }]))
            .collect()
    }

    /// Calls with the values of all functions at points of a facet.
    fn at_samples(&self, local: usize, call: &mut dyn FnMut(&[f64; 3], &[f64])) {
        let mut value = vec![0.0; self.layout.nodes()];
        for point in self.samples(local) {
            self.add_values(&point, &mut value);
            call(&point, &value);
        }
    }

    fn seen_on_facets(&self) -> Vec<Vec<usize>> {
        let of_facet = |local: usize| {
            let mut largest = vec![0.0_f64; self.layout.nodes()];
            self.at_samples(local, &mut |_, value| {
                for (largest, value) in largest.iter_mut().zip(value) {
                    *largest = largest.max(value.abs());
                }
            });
            (0..largest.len()).filter(|function| largest[*function] > ROUNDING).collect()
        };
        (0..self.layout.shape.facets()).map(of_facet).collect()
    }

    /// Whether its functions at the nodes of each facet are those of a Lagrange element there, and the others vanish.
    fn has_traces_of(&self, lagrange: &Lagrange) -> bool {
        let on_facet = |local: usize| {
            let nodes = self.layout.facet_nodes(local);
            let mut seen = nodes.clone();
            seen.sort_unstable();
            let mut same = seen == self.seen[local] && nodes == lagrange.facet_nodes(local);
            self.at_samples(local, &mut |point, value| {
                let mut other = [0.0; MAXIMUM_NODES];
                match self.layout.shape.dimension() {
                    2 => lagrange.evaluate_values(&[point[0], point[1]], &mut other),
                    _ => lagrange.evaluate_values(point, &mut other),
                }
                same &= nodes.iter().all(|node| (value[*node] - other[*node]).abs() < ROUNDING);
            });
            same
        };
        (0..self.layout.shape.facets()).all(on_facet)
    }

    /// Whether the nodes on each facet determine the functions there, and all facets have the same ones, whichever vertex comes first and
    /// in both directions around them.
    fn is_alike_from_both_sides(&self) -> bool {
        let shape = self.layout.shape;
        let sorted = |mut nodes: Vec<usize>| {
            nodes.sort_unstable();
            nodes
        };
        if (0..shape.facets()).any(|local| sorted(self.layout.facet_nodes(local)) != self.seen[local]) {
            return false;
        }
        let places = self.layout.facet_node_points();
        let (first, count) = (self.layout.facet_nodes(0), self.layout.nodes());
        let at = |local: usize, place: [f64; 2]| {
            let mut value = vec![0.0; count];
            self.add_values(&self.layout.on_facet(local, place), &mut value);
            value
        };
        let near = |a: [f64; 2], b: [f64; 2]| (0..2).all(|k| (a[k] - b[k]).abs() < ROUNDING);
        symmetries(shape).into_iter().all(|turned| {
            let images: Option<Vec<usize>> = places
                .iter()
                .map(|place| places.iter().position(|other| near(*other, turned(*place))))
                .collect();
            let Some(images) = images else { return false };
            (0..shape.facets()).all(|local| {
                let own = self.layout.facet_nodes(local);
                SAMPLES.iter().all(|[s, t]| {
                    let place = [*s, if shape.dimension() == 2 { 0.0 } else { *t }];
                    let (here, there) = (at(local, place), at(0, turned(place)));
                    let pairs = own.iter().zip(&images);
                    pairs
                        .into_iter()
                        .all(|(node, image)| (here[*node] - there[first[*image]]).abs() < ROUNDING)
                })
            })
        })
    }

    fn add_values(&self, point: &[f64; 3], value: &mut [f64]) {
        let powers = point.map(powers);
        let monomials: Vec<f64> = self.exponents.iter().map(|e| product(&powers, e, [0; 3])).collect();
        for (function, value) in value.iter_mut().enumerate() {
            let terms = self.coefficients_of(function).iter().zip(&monomials);
            *value = terms.map(|(coefficient, monomial)| coefficient * monomial).sum();
        }
    }

    pub(super) fn evaluate_values<const D: usize>(&self, point: &[f64; D], value: &mut [f64]) {
        self.add_values(&padded(point), &mut value[..self.layout.nodes()]);
    }

    pub(super) fn evaluate<const D: usize>(
        &self,
        point: &[f64; D],
        value: &mut [f64],
        gradient: &mut [[f64; D]],
    ) {
        self.evaluate_values(point, value);
        let powers = padded(point).map(powers);
        let slopes: Vec<[f64; D]> = self
            .exponents
            .iter()
            .map(|e| {
                std::array::from_fn(|k| product(&powers, e, std::array::from_fn(|l| usize::from(k == l))))
            })
            .collect();
        for (function, gradient) in gradient[..self.layout.nodes()].iter_mut().enumerate() {
            let coefficients = self.coefficients_of(function);
            *gradient =
                std::array::from_fn(|k| coefficients.iter().zip(&slopes).map(|(c, s)| c * s[k]).sum());
        }
    }

    pub(super) fn hessians<const D: usize>(&self, point: &[f64; D]) -> Vec<[[f64; D]; D]> {
        let powers = padded(point).map(powers);
        let second = |e: &[u8; 3], k: usize, l: usize| {
            product(&powers, e, std::array::from_fn(|axis| usize::from(axis == k) + usize::from(axis == l)))
        };
        let of_function = |function: usize| {
            let terms = || self.coefficients_of(function).iter().zip(&self.exponents);
            std::array::from_fn(|k| {
                std::array::from_fn(|l| terms().map(|(c, e)| c * second(e, k, l)).sum::<f64>())
            })
        };
        (0..self.layout.nodes()).map(of_function).collect()
    }
}

/// Points on a facet where functions are compared.
const SAMPLES: [[f64; 2]; 8] =
    [[0.1, 0.2], [0.3, 0.1], [0.15, 0.55], [0.45, 0.3], [0.7, 0.05], [0.05, 0.8], [0.35, 0.4], [0.6, 0.25]];

/// The maps of a facet's coordinates that permute its vertices.
fn symmetries(shape: CellShape) -> Vec<fn([f64; 2]) -> [f64; 2]> {
    match shape {
        CellShape::Triangle | CellShape::Quadrilateral => vec![|p| p, |[s, _]| [1.0 - s, 0.0]],
        CellShape::Tetrahedron => vec![
            |p| p,
            |[s, t]| [t, s],
            |[s, t]| [1.0 - s - t, t],
            |[s, t]| [s, 1.0 - s - t],
            |[s, t]| [1.0 - s - t, s],
            |[s, t]| [t, 1.0 - s - t],
        ],
        CellShape::Hexahedron => vec![
            |p| p,
            |[s, t]| [t, s],
            |[s, t]| [1.0 - s, t],
            |[s, t]| [s, 1.0 - t],
            |[s, t]| [1.0 - s, 1.0 - t],
            |[s, t]| [1.0 - t, s],
            |[s, t]| [t, 1.0 - s],
            |[s, t]| [1.0 - t, 1.0 - s],
        ],
    }
}

fn padded<const D: usize>(point: &[f64; D]) -> [f64; 3] {
    std::array::from_fn(|k| if k < D { point[k] } else { 0.0 })
}

fn powers(x: f64) -> Powers {
    let mut powers = [[1.0, 0.0, 0.0]; MAXIMUM_EXPONENT + 1];
    for n in 1..=MAXIMUM_EXPONENT {
        let [p, dp, ddp] = powers[n - 1];
        powers[n] = [p * x, dp * x + p, ddp * x + 2.0 * dp];
    }
    powers
}

fn product(powers: &[Powers; 3], exponents: &[u8; 3], orders: [usize; 3]) -> f64 {
    (0..3).map(|k| powers[k][usize::from(exponents[k])][orders[k]]).product()
}

/// The inverse of a small matrix, by elimination with the largest pivot of each column; none if it is singular.
pub(super) fn inverse(mut matrix: Vec<Vec<f64>>) -> Option<Vec<Vec<f64>>> {
    let count = matrix.len();
    for (index, row) in matrix.iter_mut().enumerate() {
        row.extend((0..count).map(|k| f64::from(u8::from(k == index))));
    }
    for column in 0..count {
        let size = |row: &usize| matrix[*row][column].abs();
        let pivot = (column..count).max_by(|a, b| size(a).total_cmp(&size(b)))?;
        let largest = matrix[pivot][column].abs();
        if largest.is_nan() || largest <= ROUNDING {
            return None;
        }
        matrix.swap(column, pivot);
        let scale = 1.0 / matrix[column][column];
        matrix[column].iter_mut().for_each(|entry| *entry *= scale);
        let pivot_row = matrix[column].clone();
        for (index, row) in matrix.iter_mut().enumerate() {
            let factor = row[column];
            if index != column && factor != 0.0 {
                row.iter_mut().zip(&pivot_row).for_each(|(entry, pivot)| *entry -= factor * pivot);
            }
        }
    }
    Some(matrix.into_iter().map(|row| row[count..].to_vec()).collect())
}

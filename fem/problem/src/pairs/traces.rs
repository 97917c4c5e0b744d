//! Traces of Lagrange elements on facets as polynomials of the facet's own coordinates.

use super::frame::dot;
use crate::element::CellShape;
use crate::element::lagrange::{Lagrange, MAXIMUM_NODES};

/// The coefficients of the position on a facet, a polynomial of degree two at most in each of its coordinates: those of sⁱtʲ in space, row after
/// row, and those of 1, s and s² in the plane, where they fill three of four places.
#[derive(Clone, Debug)]
pub(super) struct Coefficients<const D: usize>([[[f64; D]; D]; D]);

impl<const D: usize> Coefficients<D> {
    pub const ZERO: Self = Coefficients([[[0.0; D]; D]; D]);

    /// The coefficient of sⁱtʲ; j is zero in the plane.
    #[inline(always)]
    pub fn of(&self, i: usize, j: usize) -> &[f64; D] {
        let [row, column] = Self::place(i, j);
        &self.0[row][column]
    }

    /// The coefficient of sⁱtʲ, to be changed.
    #[inline(always)]
    pub fn of_mut(&mut self, i: usize, j: usize) -> &mut [f64; D] {
        let [row, column] = Self::place(i, j);
        &mut self.0[row][column]
    }

    #[inline(always)]
    fn place(i: usize, j: usize) -> [usize; 2] {
        if D == 2 { [i / 2, i % 2] } else { [i, j] }
    }
}

/// The nodes of an element that have a trace on one of its facets.
#[derive(Debug)]
struct Trace {
    key: (CellShape, usize, usize),
    nodes: Vec<NodeTrace>,
}

/// The trace of a node's basis function: the terms of its polynomial that do not vanish.
#[derive(Debug)]
pub(super) struct NodeTrace {
    pub node: usize,
    /// The coefficients of 1, s and s², which are all in the plane.
    in_plane: [f64; 3],
    terms: [(usize, usize, f64); 9],
    count: usize,
}

impl NodeTrace {
    fn of(node: usize, polynomial: &[[f64; 3]; 3]) -> Self {
        let in_plane = [0, 1, 2].map(|i: usize| polynomial[i][0]);
        let mut trace = NodeTrace { node, in_plane, terms: [(0, 0, 0.0); 9], count: 0 };
        for (i, row) in polynomial.iter().enumerate() {
            for (j, factor) in row.iter().enumerate().filter(|(_, factor)| **factor != 0.0) {
                trace.terms[trace.count] = (i, j, *factor);
                trace.count += 1;
            }
        }
        trace
    }

    /// The terms cᵢⱼ sⁱtʲ, as i, j and c.
    pub fn terms(&self) -> &[(usize, usize, f64)] {
        &self.terms[..self.count]
    }
}

/// Traces that were computed.
#[derive(Debug, Default)]
pub(super) struct Traces(Vec<Trace>);

impl Traces {
    /// The trace of an element of degree two at most on a local facet, whose coordinates are those of the cell from `origin` along
    /// `tangents`.
    pub fn of<const D: usize>(
        &mut self,
        element: Lagrange,
        local: usize,
        origin: &[f64; D],
        tangents: &[[f64; D]; 2],
    ) -> &[NodeTrace] {
        let key = (element.shape, local, element.degree);
        let place = match self.0.iter().position(|trace| trace.key == key) {
            Some(place) => place,
            None => {
                self.0.push(Trace::new(element, local, origin, tangents));
                self.0.len() - 1
            }
        };
        &self.0[place].nodes
    }
}

impl Trace {
    #[inline(never)]
    fn new<const D: usize>(
        element: Lagrange,
        local: usize,
        origin: &[f64; D],
        tangents: &[[f64; D]; 2],
    ) -> Self {
        let places = [0.0, 0.5, 1.0];
        // The values of all nodes at three places along each coordinate; in the plane the second one is zero.
        let values = places.map(|s| {
            places.map(|t| {
                let t = if D == 2 { 0.0 } else { t };
                let at = std::array::from_fn(|k| origin[k] + s * tangents[0][k] + t * tangents[1][k]);
                let (mut value, mut gradient) = ([0.0; MAXIMUM_NODES], [[0.0; D]; MAXIMUM_NODES]);
                element.evaluate(&at, &mut value, &mut gradient);
                value
            })
        });
        let of_node =
            |node: usize| NodeTrace::of(node, &polynomial(|i, j| values[i][j][node], element.degree));
        let nodes = (0..element.nodes()).map(of_node);
        let nodes = nodes.filter(|trace| trace.count > 0).collect();
        Trace { key: (element.shape, local, element.degree), nodes }
    }
}

/// The coefficients of a function of at most this degree, 2 or less, in each coordinate, from its values at 0, 1/2 and 1: of sⁱtʲ at `[i][j]`.
fn polynomial(at: impl Fn(usize, usize) -> f64, degree: usize) -> [[f64; 3]; 3] {
    // Of one that is linear its middle says nothing new.
    let through = |[first, middle, last]: [f64; 3]| match degree {
        0 | 1 => [first, last - first, 0.0],
        _ => [first, 4.0 * middle - 3.0 * first - last, 2.0 * (first + last) - 4.0 * middle],
    };
    // Of each place along s the polynomial of t, then these coefficients as polynomials of s.
    let rows = [0, 1, 2].map(|i| through([0, 1, 2].map(|j| at(i, j))));
    let columns = [0, 1, 2].map(|j| through([0, 1, 2].map(|i| rows[i][j])));
    std::array::from_fn(|i| std::array::from_fn(|j| columns[j][i]))
}

/// Adds what the nodes of an element make of the position; `value` is asked for by places in the trace.
#[inline(always)]
pub(super) fn add_trace<const D: usize>(
    sum: &mut Coefficients<D>,
    trace: &[NodeTrace],
    value: impl Fn(usize) -> [f64; D],
) {
    if D == 2 {
        let mut in_plane = [0, 1, 2].map(|i| *sum.of(i, 0));
        for (place, of_node) in trace.iter().enumerate() {
            let value = value(place);
            for (sum, factor) in in_plane.iter_mut().zip(of_node.in_plane) {
                for (sum, component) in sum.iter_mut().zip(value) {
                    *sum += factor * component;
                }
            }
        }
        for (i, found) in in_plane.into_iter().enumerate() {
            *sum.of_mut(i, 0) = found;
        }
        return;
    }
    for (place, of_node) in trace.iter().enumerate() {
        let value = value(place);
        for &(i, j, factor) in of_node.terms() {
            let sum = sum.of_mut(i, j);
            for k in 0..D {
                sum[k] += factor * value[k];
            }
        }
    }
}

/// The most that a polynomial facet is away, at the same coordinates, from the flat one with its first, second and last corner,
/// and from what the corners span: segment, triangle or bilinear quadrilateral.
pub(super) fn deviations<const D: usize>(polynomial: &Coefficients<D>, triangle: bool) -> [f64; 2] {
    let length = |a: &[f64; D]| dot(a, a).sqrt();
    // s − s² is a quarter at most, and so are the other terms less what they are at the corners.
    if D == 2 {
        return [0.25 * length(polynomial.of(2, 0)); 2];
    }
    let bent = [(2, 0), (0, 2), (2, 1), (1, 2), (2, 2)];
    let spanned = 0.25 * bent.iter().map(|&(i, j)| length(polynomial.of(i, j))).sum::<f64>();
    if triangle {
        return [spanned + 0.25 * length(polynomial.of(1, 1)); 2];
    }
    let terms = [(1, 1), (2, 1), (1, 2), (2, 2)];
    let twist = std::array::from_fn(|k| terms.iter().map(|&(i, j)| polynomial.of(i, j)[k]).sum());
    [spanned + length(&twist), spanned]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A trace is the element's own value on its facet.
    #[test]
    fn traces_are_values_on_facets() {
        for (shape, degree) in
            [(CellShape::Tetrahedron, 2), (CellShape::Hexahedron, 2), (CellShape::Hexahedron, 1)]
        {
            let element = Lagrange { shape, degree };
            for local in 0..shape.facets() {
                let vertices = shape.facet_vertices(local);
                let corner =
                    |k: usize| -> [f64; 3] { shape.vertex_points()[vertices[k]][..3].try_into().expect("3") };
                let origin = corner(0);
                let along = |k: usize| std::array::from_fn(|i| corner(k)[i] - origin[i]);
                let tangents = [along(1), along(vertices.len() - 1)];
                let mut traces = Traces::default();
                let nodes = traces.of(element, local, &origin, &tangents);
                assert_eq!(nodes.len(), element.facet_nodes(local).len());
                let (s, t) = (0.3, 0.25);
                let at = std::array::from_fn(|k| origin[k] + s * tangents[0][k] + t * tangents[1][k]);
                let (mut value, mut gradient) = ([0.0; MAXIMUM_NODES], [[0.0; 3]; MAXIMUM_NODES]);
                element.evaluate(&at, &mut value, &mut gradient);
                for trace in nodes {
                    let terms = trace.terms().iter();
                    let found: f64 = terms.map(|&(i, j, c)| c * s.powi(i as i32) * t.powi(j as i32)).sum();
                    assert!((found - value[trace.node]).abs() < 1e-15, "{shape:?} {local} {}", trace.node);
                }
            }
        }
    }
}

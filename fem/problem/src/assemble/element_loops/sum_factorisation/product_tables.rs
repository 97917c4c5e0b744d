//! The factors of product basis functions at the coordinates of a grid of points.

use crate::element::Lagrange;

/// Coordinates closer than this, on a reference cell of size 1, are the same.
const SAME_COORDINATE: f64 = 1e-13;

/// An element whose basis functions are products, at points that form a grid: the same coordinates along each axis.
///
/// Nodes and points have places on their grids: of indices (i₀, …, i_{D−1}) along the axes the last runs fastest.
#[derive(Clone, Debug)]
pub(in crate::assemble) struct ProductTables {
    /// Nodes along an axis, n.
    pub nodes: usize,
    /// Points along an axis, m.
    pub points: usize,
    /// f_a(t_q), and its derivative, at `q * nodes + a`.
    pub to_points: [Vec<f64>; 2],
    /// The same at `a * points + q`.
    pub to_nodes: [Vec<f64>; 2],
    /// f_a(t_q) f_b(t_q) at `(a * nodes + b) * points + q`, each factor as it is or differentiated.
    pub pairs: [[Vec<f64>; 2]; 2],
    /// The same for a ≤ b only.
    pub ordered_pairs: [[Vec<f64>; 2]; 2],
    /// The node at each place of the grid of nodes.
    pub node_at: Vec<u32>,
    /// The place of each point of the rule on the grid of points.
    pub place_of: Vec<u32>,
    /// The distance of the outer points from the middle of an axis, in halves of the axis, where two or three points lie symmetrically
    /// and the basis functions have as many equidistant nodes.
    pub reach: Option<f64>,
}

impl ProductTables {
    /// The tables, if the basis functions are products and the points a grid.
    pub fn new<const D: usize>(element: &Lagrange, points: &[[f64; D]]) -> Option<Self> {
        let steps = element.grid_steps::<D>()?;
        let (coordinates, place_of) = grid(points)?;
        let (n, m) = (element.degree + 1, coordinates.len());
        let factors: Vec<_> = coordinates.iter().map(|t| element.axis_factors(*t)).collect();
        let table = |order: usize, node: usize, q: usize| factors[q][node][order];
        let by_point = |order| {
            (0..m).flat_map(|q| (0..n).map(move |a| (q, a))).map(|(q, a)| table(order, a, q)).collect()
        };
        let by_node = |order| {
            (0..n).flat_map(|a| (0..m).map(move |q| (q, a))).map(|(q, a)| table(order, a, q)).collect()
        };
        let by_pair = |first: usize, second: usize, ordered: bool| {
            let pairs = (0..n).flat_map(|a| (0..n).map(move |b| (a, b))).filter(|(a, b)| !ordered || a <= b);
            pairs
                .flat_map(|(a, b)| (0..m).map(move |q| (a, b, q)))
                .map(|(a, b, q)| table(first, a, q) * table(second, b, q))
                .collect()
        };
        let all_pairs = |ordered| [0, 1].map(|first| [0, 1].map(|second| by_pair(first, second, ordered)));
        let mut node_at = vec![0; steps.len()];
        for (node, steps) in steps.iter().enumerate() {
            node_at[steps.iter().fold(0, |place, step| place * n + step)] = node as u32;
        }
        Some(ProductTables {
            nodes: n,
            points: m,
            to_points: [by_point(0), by_point(1)],
            to_nodes: [by_node(0), by_node(1)],
            pairs: all_pairs(false),
            ordered_pairs: all_pairs(true),
            node_at,
            place_of,
            reach: reach(&coordinates, n),
        })
    }
}

/// [`ProductTables::reach`].
fn reach(coordinates: &[f64], nodes: usize) -> Option<f64> {
    let last = coordinates.len() - 1;
    let symmetric =
        (0..=last).all(|k| (coordinates[k] + coordinates[last - k] - 1.0).abs() < SAME_COORDINATE);
    let alike = nodes == coordinates.len() && (nodes == 2 || nodes == 3);
    (symmetric && alike).then(|| coordinates[last] - coordinates[0])
}

/// The coordinates along each axis of points that form a grid, and each point's place.
fn grid<const D: usize>(points: &[[f64; D]]) -> Option<(Vec<f64>, Vec<u32>)> {
    let mut coordinates: Vec<f64> = points.iter().map(|point| point[0]).collect();
    coordinates.sort_by(f64::total_cmp);
    coordinates.dedup_by(|next, before| *next - *before < SAME_COORDINATE);
    if coordinates.len().pow(D as u32) != points.len() {
        return None;
    }
    let index = |x: f64| coordinates.iter().position(|t| (x - t).abs() < SAME_COORDINATE);
    let mut taken = vec![false; points.len()];
    let mut places = Vec::with_capacity(points.len());
    for point in points {
        let mut place = 0;
        for x in point {
            place = place * coordinates.len() + index(*x)?;
        }
        if std::mem::replace(&mut taken[place], true) {
            return None;
        }
        places.push(place as u32);
    }
    Some((coordinates, places))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::CellShape;
    use crate::quadrature::cell_rule;

    #[test]
    fn products_of_the_factors_are_the_basis() {
        for degree in 1..=4 {
            let element = Lagrange::new(CellShape::Hexahedron, degree).unwrap();
            let rule = cell_rule::<3>(CellShape::Hexahedron, 2 * degree + 1).unwrap();
            let product = ProductTables::new(&element, &rule.points).unwrap();
            let table = element.tabulate(&rule.points);
            let (n, m) = (product.nodes, product.points);
            for q in 0..rule.points.len() {
                let point = product.place_of[q] as usize;
                for place in 0..n * n * n {
                    let along = |axis: u32, order: usize| {
                        let (q, a) = (point / m.pow(2 - axis) % m, place / n.pow(2 - axis) % n);
                        assert_eq!(product.to_nodes[order][a * m + q], product.to_points[order][q * n + a]);
                        product.to_points[order][q * n + a]
                    };
                    let node = product.node_at[place] as usize;
                    let value = along(0, 0) * along(1, 0) * along(2, 0);
                    assert!((value - table.value[q * table.nodes + node]).abs() < 1e-14);
                    let slope = along(0, 0) * along(1, 1) * along(2, 0);
                    assert!((slope - table.gradient[q * table.nodes + node][1]).abs() < 1e-13);
                }
            }
        }
    }

    #[test]
    fn other_points_are_no_grid() {
        let element = Lagrange::new(CellShape::Quadrilateral, 1).unwrap();
        let grid = [[0.2, 0.1], [0.1, 0.2], [0.1, 0.1], [0.2, 0.2]];
        assert!(ProductTables::new(&element, &grid).is_some());
        for (point, moved) in [(0, [0.2, 0.3]), (1, [0.2, 0.1]), (3, [0.3, 0.2])] {
            let mut points = grid;
            points[point] = moved;
            assert!(ProductTables::new(&element, &points).is_none());
        }
        assert!(ProductTables::new(&element, &grid[..3]).is_none());
        let triangle = Lagrange::new(CellShape::Triangle, 1).unwrap();
        assert!(ProductTables::new(&triangle, &grid).is_none());
    }
}

//! The conventions of basix, FFCx's element library: node order, facet numbers, quadrature rules.

use std::sync::OnceLock;

use forms_fem::element::{CellShape, Lagrange};
use forms_fem::quadrature::{Quadrature, QuadratureError, QuadratureRule, cell_rule, facet_reference_rule};
use serde::Deserialize;
use thiserror::Error;

/// The entities that a kernel integrates over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entities {
    /// Cells.
    Cells,
    /// Exterior facets.
    Facets,
}

/// Which of basix's two node orders an element has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NodeOrder {
    /// Vertices, edges, faces, interior: `basix.create_element`.
    Entities,
    /// The nodes (0, 1, ½) of each direction, the last direction fastest: `basix.create_tp_element`, which
    /// FFCx's sum factorisation takes.
    TensorProduct,
}

// Coordinates in units of one half. Degree 1 has the first nodes of each list.
const TRIANGLE: [[u8; 3]; 6] = [[0, 0, 0], [2, 0, 0], [0, 2, 0], [1, 1, 0], [0, 1, 0], [1, 0, 0]];
const QUADRILATERAL: [[u8; 3]; 9] =
    [[0, 0, 0], [2, 0, 0], [0, 2, 0], [2, 2, 0], [1, 0, 0], [0, 1, 0], [2, 1, 0], [1, 2, 0], [1, 1, 0]];
const TETRAHEDRON: [[u8; 3]; 10] = [
    [0, 0, 0],
    [2, 0, 0],
    [0, 2, 0],
    [0, 0, 2],
    [0, 1, 1],
    [1, 0, 1],
    [1, 1, 0],
    [0, 0, 1],
    [0, 1, 0],
    [1, 0, 0],
];
const HEXAHEDRON: [[u8; 3]; 27] = [
    [0, 0, 0],
    [2, 0, 0],
    [0, 2, 0],
    [2, 2, 0],
    [0, 0, 2],
    [2, 0, 2],
    [0, 2, 2],
    [2, 2, 2],
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
    [2, 1, 0],
    [2, 0, 1],
    [1, 2, 0],
    [0, 2, 1],
    [2, 2, 1],
    [1, 0, 2],
    [0, 1, 2],
    [2, 1, 2],
    [1, 2, 2],
    [1, 1, 0],
    [1, 0, 1],
    [0, 1, 1],
    [2, 1, 1],
    [1, 2, 1],
    [1, 1, 2],
    [1, 1, 1],
];

/// Number of nodes of the Lagrange element of degree 1 or 2 on a shape.
pub const fn node_count(shape: CellShape, degree: usize) -> usize {
    match (shape, degree) {
        (CellShape::Triangle, 1) => 3,
        (CellShape::Triangle, _) => 6,
        (CellShape::Quadrilateral, 1) => 4,
        (CellShape::Quadrilateral, _) => 9,
        (CellShape::Tetrahedron, 1) => 4,
        (CellShape::Tetrahedron, _) => 10,
        (CellShape::Hexahedron, 1) => 8,
        (CellShape::Hexahedron, _) => 27,
    }
}

// Number of points of basix's rules on simplices, by degree; see `data/basix.json`.
const TRIANGLE_POINTS: [usize; 13] = [1, 1, 3, 6, 6, 7, 12, 15, 16, 19, 25, 28, 33];
const TETRAHEDRON_POINTS: [usize; 13] = [1, 1, 4, 5, 14, 15, 24, 31, 45, 57, 74, 95, 122];

/// Number of points of basix's rule of a degree on a shape or on its facets; degrees up to 12 on simplices.
///
/// # Panics
/// For higher degrees on simplices; as a constant that is a compile error.
pub const fn point_count(shape: CellShape, degree: usize, entities: Entities) -> usize {
    let line = degree / 2 + 1;
    match (shape, entities) {
        (CellShape::Triangle, Entities::Cells) | (CellShape::Tetrahedron, Entities::Facets) => {
            TRIANGLE_POINTS[degree]
        }
        (CellShape::Tetrahedron, Entities::Cells) => TETRAHEDRON_POINTS[degree],
        (CellShape::Triangle | CellShape::Quadrilateral, Entities::Facets) => line,
        (CellShape::Quadrilateral, Entities::Cells) | (CellShape::Hexahedron, Entities::Facets) => {
            line * line
        }
        (CellShape::Hexahedron, Entities::Cells) => line * line * line,
    }
}

/// Number of reference coordinates of a shape.
pub const fn dimension(shape: CellShape) -> usize {
    match shape {
        CellShape::Triangle | CellShape::Quadrilateral => 2,
        CellShape::Tetrahedron | CellShape::Hexahedron => 3,
    }
}

// Our nodes in half steps.
fn ours(shape: CellShape, degree: usize) -> Vec<[u8; 3]> {
    fn half_steps<const D: usize>(element: Lagrange) -> Vec<[u8; 3]> {
        let mut nodes = vec![[0; 3]; element.nodes()];
        for (node, point) in nodes.iter_mut().zip(element.node_points::<D>()) {
            for (half, coordinate) in node.iter_mut().zip(point) {
                *half = (2.0 * coordinate).round() as u8;
            }
        }
        nodes
    }
    let element = Lagrange { shape, degree };
    if dimension(shape) == 2 { half_steps::<2>(element) } else { half_steps::<3>(element) }
}

// Node `index` of basix's element, in half steps.
fn basix_node(shape: CellShape, degree: usize, order: NodeOrder, index: usize) -> [u8; 3] {
    match (shape, order) {
        (CellShape::Quadrilateral | CellShape::Hexahedron, NodeOrder::TensorProduct) => {
            let line = [0, 2, 1];
            let (count, dimension) = (degree + 1, dimension(shape));
            let (mut node, mut rest, mut axis) = ([0; 3], index, dimension);
            while axis > 0 {
                axis -= 1;
                node[axis] = line[rest % count];
                rest /= count;
            }
            node
        }
        (CellShape::Triangle, _) => TRIANGLE[index],
        (CellShape::Quadrilateral, _) => QUADRILATERAL[index],
        (CellShape::Tetrahedron, _) => TETRAHEDRON[index],
        (CellShape::Hexahedron, _) => HEXAHEDRON[index],
    }
}

/// Reference coordinates of basix's nodes; the third is zero in two dimensions.
pub fn node_points(shape: CellShape, degree: usize, order: NodeOrder) -> Vec<[f64; 3]> {
    let node = |index| basix_node(shape, degree, order, index).map(|half| 0.5 * f64::from(half));
    (0..node_count(shape, degree)).map(node).collect()
}

/// For each node of basix's element, in its order, our number of that node.
pub fn our_node_numbers(shape: CellShape, degree: usize, order: NodeOrder) -> Vec<usize> {
    let ours = ours(shape, degree);
    let number = |node: [u8; 3]| ours.iter().position(|own| *own == node).unwrap_or(usize::MAX);
    (0..node_count(shape, degree)).map(|index| number(basix_node(shape, degree, order, index))).collect()
}

/// Our numbers of basix's local facets, zero after the last.
pub const fn our_facets(shape: CellShape) -> [usize; 6] {
    match shape {
        CellShape::Triangle => [1, 2, 0, 0, 0, 0],
        CellShape::Quadrilateral => [0, 3, 1, 2, 0, 0],
        CellShape::Tetrahedron => [0, 1, 2, 3, 0, 0],
        CellShape::Hexahedron => [0, 2, 5, 3, 4, 1],
    }
}

/// Errors of rules.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum RuleError {
    /// The list of basix's rules does not read.
    #[error("basix's rules do not read: {0}")]
    Data(String),
    /// Above the highest degree that was written down.
    #[error("basix's rule of degree {degree} on the {shape} was not written down; see write_basix.py")]
    Degree {
        /// The shape.
        shape: &'static str,
        /// The degree asked for.
        degree: usize,
    },
    /// Of our rules.
    #[error(transparent)]
    Ours(#[from] QuadratureError),
}

#[derive(Deserialize)]
struct Written {
    rules: WrittenRules,
}

#[derive(Deserialize)]
struct WrittenRules {
    triangle: Vec<WrittenRule>,
    tetrahedron: Vec<WrittenRule>,
}

#[derive(Deserialize)]
struct WrittenRule {
    points: Vec<Vec<f64>>,
    weights: Vec<f64>,
}

fn written() -> Result<&'static WrittenRules, RuleError> {
    static RULES: OnceLock<Result<WrittenRules, String>> = OnceLock::new();
    let read = || {
        let data: Result<Written, _> = serde_json::from_str(include_str!("../data/basix.json"));
        data.map(|data| data.rules).map_err(|error| error.to_string())
    };
    RULES.get_or_init(read).as_ref().map_err(|error| RuleError::Data(error.clone()))
}

fn simplex_rule<const D: usize>(shape: CellShape, degree: usize) -> Result<QuadratureRule<D>, RuleError> {
    let rules = written()?;
    let rules = if shape == CellShape::Triangle { &rules.triangle } else { &rules.tetrahedron };
    let rule = rules.get(degree).ok_or(RuleError::Degree { shape: shape.name(), degree })?;
    let points = rule.points.iter().map(|point| std::array::from_fn(|k| point[k])).collect();
    Ok(QuadratureRule { points, weights: rule.weights.clone() })
}

/// Basix's default rules of a degree on a shape and on its facets. On segments, quadrilaterals and hexahedra they
/// are ours, products of Gauss points; on simplices ours have other points in some degrees. Rules on facets
/// have the facet's symmetry, so that it does not matter in which order its vertices are counted.
///
/// # Errors
/// A [`RuleError`], for degrees beyond those written down.
pub fn quadrature<const D: usize>(shape: CellShape, degree: usize) -> Result<Quadrature<D>, RuleError> {
    let cell = match shape {
        CellShape::Triangle | CellShape::Tetrahedron => simplex_rule(shape, degree)?,
        CellShape::Quadrilateral | CellShape::Hexahedron => cell_rule(shape, degree)?,
    };
    let facet = match shape {
        CellShape::Tetrahedron => simplex_rule(CellShape::Triangle, degree)?,
        _ => facet_reference_rule(shape, degree)?,
    };
    Ok(Quadrature::Explicit { cell, facet })
}

//! VTK's types of cells, and the order in which they list their points.

use crate::element::CellShape;
use crate::mesh::imported::{Kind, cell, kind};

const KINDS: [Kind; 20] = [
    kind(1, "vertex", 0, 1, 1, None),
    kind(3, "line", 1, 2, 2, None),
    kind(21, "quadratic edge", 1, 3, 2, None),
    kind(5, "triangle", 2, 3, 3, cell(CellShape::Triangle, 1, &[0, 1, 2])),
    kind(22, "quadratic triangle", 2, 6, 3, cell(CellShape::Triangle, 2, &[0, 1, 2, 3, 4, 5])),
    kind(34, "biquadratic triangle", 2, 7, 3, None),
    kind(9, "quadrilateral", 2, 4, 4, cell(CellShape::Quadrilateral, 1, &[0, 1, 2, 3])),
    kind(
        23,
        "quadratic quadrilateral of 8 points",
        2,
        8,
        4,
        cell(CellShape::Quadrilateral, 2, &[0, 1, 2, 3, 4, 5, 6, 7]),
    ),
    kind(
        28,
        "biquadratic quadrilateral",
        2,
        9,
        4,
        cell(CellShape::Quadrilateral, 2, &[0, 1, 2, 3, 4, 5, 6, 7, 8]),
    ),
    kind(10, "tetrahedron", 3, 4, 4, cell(CellShape::Tetrahedron, 1, &[0, 1, 2, 3])),
    kind(
        24,
        "quadratic tetrahedron",
        3,
        10,
        4,
        cell(CellShape::Tetrahedron, 2, &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9]),
    ),
    kind(12, "hexahedron", 3, 8, 8, cell(CellShape::Hexahedron, 1, &[0, 1, 2, 3, 4, 5, 6, 7])),
    kind(
        25,
        "quadratic hexahedron of 20 points",
        3,
        20,
        8,
        cell(
            CellShape::Hexahedron,
            2,
            &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19],
        ),
    ),
    kind(33, "quadratic hexahedron of 24 points", 3, 24, 8, None),
    // VTK's faces are x = 0, x = 1, y = 0, y = 1, z = 0, z = 1 and ours z = 0, z = 1, y = 0, x = 1, y = 1, x = 0.
    kind(
        29,
        "triquadratic hexahedron",
        3,
        27,
        8,
        cell(
            CellShape::Hexahedron,
            2,
            &[
                0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 24, 25, 22, 21, 23, 20,
                26,
            ],
        ),
    ),
    kind(13, "wedge", 3, 6, 6, None),
    kind(26, "quadratic wedge", 3, 15, 6, None),
    kind(32, "biquadratic wedge", 3, 18, 6, None),
    kind(14, "pyramid", 3, 5, 5, None),
    kind(27, "quadratic pyramid", 3, 13, 5, None),
];

/// Help where a cell is not supported.
pub(super) fn advice(kind: &Kind) -> &'static str {
    match kind.code {
        26 | 27 | 32..=34 => {
            "second-order cells are QUADRATIC_TRIANGLE, QUADRATIC_QUAD, BIQUADRATIC_QUAD, QUADRATIC_TETRA, QUADRATIC_HEXAHEDRON or \
             TRIQUADRATIC_HEXAHEDRON"
        }
        _ => "a mesh consists of triangles, quadrilaterals, tetrahedra or hexahedra",
    }
}

/// The types that are read, where a type is not known.
pub(super) const KNOWN: &str = "vertices, lines, triangles, quadrilaterals, tetrahedra, hexahedra, wedges and pyramids of \
     first and second order, with all their points, are known";

fn of_code(code: u8) -> Option<&'static Kind> {
    KINDS.iter().find(|kind| kind.code == code)
}

/// For each point of a type of cell, which is to be written, the number of our node.
#[doc(hidden)]
pub fn nodes_in_order(code: u8) -> Vec<usize> {
    let places = of_code(code).and_then(|kind| kind.cell.as_ref()).map_or(&[][..], |cell| cell.order);
    let mut order = vec![0; places.len()];
    for (node, &place) in places.iter().enumerate() {
        order[usize::from(place)] = node;
    }
    order
}

/// The kind of a cell by its code and number of points, and for each of the kind's points its place in the cell's list,
/// if that differs. Pixels, voxels and Lagrange cells of first and second order are cells of the usual kinds, and so
/// are polygons of three and four points and lines of two.
pub(super) fn resolve(
    code: i64,
    points: usize,
    before_9: bool,
) -> Option<(&'static Kind, Option<&'static [u8]>)> {
    // VTK changed two edges of the Lagrange hexahedron in version 9.
    const BEFORE_9: [u8; 27] =
        [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 19, 18, 20, 21, 22, 23, 24, 25, 26];
    let (code, order): (u8, Option<&'static [u8]>) = match (code, points) {
        (2, 1) => (1, None),
        (4 | 68, 2) => (3, None),
        (68, 3) => (21, None),
        (7 | 69, 3) => (5, None),
        (69, 6) => (22, None),
        (7 | 70, 4) => (9, None),
        (8, 4) => (9, Some(&[0, 1, 3, 2])),
        (70, 9) => (28, None),
        (71, 4) => (10, None),
        (71, 10) => (24, None),
        (11, 8) => (12, Some(&[0, 1, 3, 2, 4, 5, 7, 6])),
        (72, 8) => (12, None),
        (72, 27) if before_9 => (29, Some(&BEFORE_9)),
        (72, 27) => (29, None),
        _ => (u8::try_from(code).ok()?, None),
    };
    of_code(code).filter(|kind| kind.nodes == points).map(|kind| (kind, order))
}

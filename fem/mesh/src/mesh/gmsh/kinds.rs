//! Gmsh's element types, and the order in which they list their nodes.

use crate::element::CellShape;
use crate::mesh::imported::{Kind, cell, kind};

const KINDS: [Kind; 19] = [
    kind(15, "point", 0, 1, 1, None),
    kind(1, "line of 2 nodes", 1, 2, 2, None),
    kind(8, "line of 3 nodes", 1, 3, 2, None),
    kind(2, "triangle of 3 nodes", 2, 3, 3, cell(CellShape::Triangle, 1, &[0, 1, 2])),
    kind(9, "triangle of 6 nodes", 2, 6, 3, cell(CellShape::Triangle, 2, &[0, 1, 2, 3, 4, 5])),
    kind(3, "quadrilateral of 4 nodes", 2, 4, 4, cell(CellShape::Quadrilateral, 1, &[0, 1, 2, 3])),
    kind(
        16,
        "quadrilateral of 8 nodes",
        2,
        8,
        4,
        cell(CellShape::Quadrilateral, 2, &[0, 1, 2, 3, 4, 5, 6, 7]),
    ),
    kind(
        10,
        "quadrilateral of 9 nodes",
        2,
        9,
        4,
        cell(CellShape::Quadrilateral, 2, &[0, 1, 2, 3, 4, 5, 6, 7, 8]),
    ),
    kind(4, "tetrahedron of 4 nodes", 3, 4, 4, cell(CellShape::Tetrahedron, 1, &[0, 1, 2, 3])),
    // Gmsh's edges: 01 12 20 03 23 13.
    kind(
        11,
        "tetrahedron of 10 nodes",
        3,
        10,
        4,
        cell(CellShape::Tetrahedron, 2, &[0, 1, 2, 3, 4, 5, 6, 7, 9, 8]),
    ),
    kind(5, "hexahedron of 8 nodes", 3, 8, 8, cell(CellShape::Hexahedron, 1, &[0, 1, 2, 3, 4, 5, 6, 7])),
    kind(
        17,
        "hexahedron of 20 nodes",
        3,
        20,
        8,
        cell(
            CellShape::Hexahedron,
            2,
            &[0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15],
        ),
    ),
    // Gmsh's edges: 01 03 04 12 15 23 26 37 45 47 56 67. Its faces: bottom, front, left, right, back, top.
    kind(
        12,
        "hexahedron of 27 nodes",
        3,
        27,
        8,
        cell(
            CellShape::Hexahedron,
            2,
            &[
                0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15, 20, 25, 21, 23, 24, 22,
                26,
            ],
        ),
    ),
    kind(6, "prism of 6 nodes", 3, 6, 6, None),
    kind(18, "prism of 15 nodes", 3, 15, 6, None),
    kind(13, "prism of 18 nodes", 3, 18, 6, None),
    kind(7, "pyramid of 5 nodes", 3, 5, 5, None),
    kind(19, "pyramid of 13 nodes", 3, 13, 5, None),
    kind(14, "pyramid of 14 nodes", 3, 14, 5, None),
];

/// The type with a code, if it is of first or second order.
pub(super) fn of(code: i64) -> Option<&'static Kind> {
    KINDS.iter().find(|kind| i64::from(kind.code) == code)
}

/// Help where a cell is not supported.
pub(super) fn advice(_: &Kind) -> &'static str {
    "a mesh consists of triangles, quadrilaterals, tetrahedra or hexahedra"
}

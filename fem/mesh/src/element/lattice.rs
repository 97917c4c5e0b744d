//! Places of the nodes of Lagrange elements on their reference cells: equispaced, entity after entity.

use std::sync::LazyLock;

use super::CellShape;

/// The highest degree.
pub const MAXIMUM_DEGREE: usize = 4;

/// Reference coordinates of a node in steps of 1/degree; the third is zero in two dimensions.
pub(super) type Steps = [u8; 3];

/// The nodes of each shape and degree, made at the first use.
static LATTICES: LazyLock<Vec<Vec<Vec<Steps>>>> = LazyLock::new(|| {
    let of_shape = |shape| (0..=MAXIMUM_DEGREE).map(|degree| nodes(shape, degree)).collect();
    CellShape::ALL.into_iter().map(of_shape).collect()
});

/// The nodes of the element of a degree from 1 on: vertices, insides of edges, of faces, of the cell.
#[doc(hidden)]
pub fn lattice(shape: CellShape, degree: usize) -> &'static [Steps] {
    &LATTICES[shape as usize][degree]
}

/// Points strictly inside the triangle with corners 0, 1 and 2, as steps from corner 0 towards 1 and 2; the first
/// runs fastest.
#[doc(hidden)]
pub fn inside_triangle(degree: usize) -> impl Iterator<Item = [usize; 2]> {
    (1..degree).flat_map(move |second| (1..degree - second).map(move |first| [first, second]))
}

/// Points strictly inside the quadrilateral with corners 0 to 3: steps towards 1 and 3.
#[doc(hidden)]
pub fn inside_quadrilateral(degree: usize) -> impl Iterator<Item = [usize; 2]> {
    (1..degree).flat_map(move |second| (1..degree).map(move |first| [first, second]))
}

/// Points on a facet's own reference cell, as steps from its first corner towards the second and the last: corners,
/// insides of the edges between successive corners, inside.
pub(super) fn facet_lattice(shape: CellShape, degree: usize) -> Vec<[usize; 2]> {
    let of = |shape| lattice(shape, degree).iter().map(|node| [node[0].into(), node[1].into()]).collect();
    match shape {
        CellShape::Triangle | CellShape::Quadrilateral => {
            [0, degree].into_iter().chain(1..degree).map(|step| [step, 0]).collect()
        }
        CellShape::Tetrahedron => of(CellShape::Triangle),
        CellShape::Hexahedron => of(CellShape::Quadrilateral),
    }
}

/// The node of the cell at a point of a facet, in steps as [`facet_lattice`] gives them.
pub(super) fn on_facet(shape: CellShape, degree: usize, facet: &[usize], [s, t]: [usize; 2]) -> Steps {
    let corner = |place: usize| shape.vertex_points()[facet[place]];
    let (first, second, last) = (corner(0), corner(1), corner(facet.len() - 1));
    std::array::from_fn(|k| {
        let (s, t) = (s as f64, t as f64);
        (first[k] * degree as f64 + s * (second[k] - first[k]) + t * (last[k] - first[k])) as u8
    })
}

fn nodes(shape: CellShape, degree: usize) -> Vec<Steps> {
    let vertices = shape.vertex_points();
    let mut nodes: Vec<Steps> = vertices.iter().map(|x| x.map(|x| x as u8 * degree as u8)).collect();
    for edge in shape.edges() {
        nodes.extend((1..degree).map(|step| on_facet(shape, degree, edge, [step, 0])));
    }
    if shape.dimension() == 3 {
        for local in 0..shape.facets() {
            let facet = shape.facet_vertices(local);
            let inside: Vec<_> = match shape.is_simplex() {
                true => inside_triangle(degree).collect(),
                false => inside_quadrilateral(degree).collect(),
            };
            nodes.extend(inside.into_iter().map(|point| on_facet(shape, degree, facet, point)));
        }
    }
    let line = |count: usize| 1..count as u8;
    match shape {
        CellShape::Triangle => {
            nodes.extend(inside_triangle(degree).map(|[x, y]| [x as u8, y as u8, 0]));
        }
        CellShape::Quadrilateral => {
            nodes.extend(inside_quadrilateral(degree).map(|[x, y]| [x as u8, y as u8, 0]));
        }
        CellShape::Tetrahedron => {
            for z in line(degree) {
                let below = degree - usize::from(z);
                nodes.extend(inside_triangle(below).map(|[x, y]| [x as u8, y as u8, z]));
            }
        }
        CellShape::Hexahedron => {
            for z in line(degree) {
                nodes.extend(inside_quadrilateral(degree).map(|[x, y]| [x as u8, y as u8, z]));
            }
        }
    }
    nodes
}

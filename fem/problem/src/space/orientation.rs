//! In which order the cells around an edge or a face count the nodes inside it: by the numbers of its vertices in the
//! mesh, which are the same for all of them.

use crate::element::{inside_quadrilateral, inside_triangle};

/// The places of the nodes inside an edge, given the numbers of its two vertices: the first is next to the lower one.
pub(super) fn along_edge(degree: usize, around: &[u32; 4]) -> Vec<usize> {
    let forward = 0..degree - 1;
    if around[0] < around[1] { forward.collect() } else { forward.rev().collect() }
}

/// The places of the nodes inside a triangle, given the numbers of its three vertices: as
/// [`inside_triangle`] counts from the lowest of them to the middle and to the highest one.
pub(super) fn in_triangle(degree: usize, around: &[u32; 4]) -> Vec<usize> {
    let mut ascending = [0, 1, 2];
    ascending.sort_unstable_by_key(|&corner| around[corner]);
    let place = |[first, second]: [usize; 2]| {
        // Steps away from the opposite edges.
        let weights = [degree - first - second, first, second];
        let turned = [weights[ascending[1]], weights[ascending[2]]];
        inside_triangle(degree).position(|other| other == turned).unwrap_or(0)
    };
    inside_triangle(degree).map(place).collect()
}

/// The places of the nodes inside a quadrilateral, given the numbers of its vertices, which run around it: as
/// [`inside_quadrilateral`] counts from the vertex of the lowest number to the lower of its neighbours.
pub(super) fn in_quadrilateral(degree: usize, around: &[u32; 4]) -> Vec<usize> {
    let origin = (0..4).min_by_key(|&corner| around[corner]).unwrap_or(0);
    let swapped = around[(origin + 1) % 4] > around[(origin + 3) % 4];
    let place = |[first, second]: [usize; 2]| {
        // Steps from the origin to the next vertex around, and to the one before.
        let (next, before) = match origin {
            0 => (first, second),
            1 => (second, degree - first),
            2 => (degree - first, degree - second),
            _ => (degree - second, first),
        };
        let (along, across) = if swapped { (before, next) } else { (next, before) };
        (along - 1) + (across - 1) * (degree - 1)
    };
    inside_quadrilateral(degree).map(place).collect()
}

//! The point of a facet that lies nearest to a given one.

use super::boundary_edges::BoundaryEdges;
use super::surface::{SurfaceFacet, SurfacePoint, dot, minus};
use super::tolerances::{INSIDE, STEPS};
use crate::mesh::small_matrices::inverse;

/// A point of an opposite facet.
#[derive(Clone, Copy, Debug)]
pub(super) struct ClosestPoint<const D: usize> {
    /// Coordinates on the facet.
    pub s: [f64; 2],
    pub position: [f64; D],
    /// The facet's outward unit normal there.
    pub normal: [f64; D],
    /// Whether it is an end of the surface, beyond which another point would be nearer.
    pub at_rim: bool,
}

/// The point of a facet with given coordinates.
pub(super) fn hit<const D: usize>(facet: &SurfaceFacet<D>, s: [f64; 2], at_rim: bool) -> ClosestPoint<D> {
    let point = facet.at(&s);
    ClosestPoint { s, position: point.position, normal: point.normal(), at_rim }
}

/// The point of a facet's surface at which the distance from x is stationary along some directions of its coordinates;
/// the surface goes on beyond the facet.
fn stationary<const D: usize>(
    facet: &SurfaceFacet<D>,
    x: &[f64; D],
    start: [f64; 2],
    directions: &[[f64; 2]],
) -> Option<[f64; 2]> {
    let mut s = start;
    let mut previous = f64::INFINITY;
    for _ in 0..STEPS {
        let SurfacePoint { position, tangents } = facet.at(&s);
        let second = facet.second(&s);
        let off = minus(&position, x);
        let combined = |d: &[f64; 2]| -> [f64; D] {
            std::array::from_fn(|k| d[0] * tangents[0][k] + d[1] * tangents[1][k])
        };
        let slopes: Vec<f64> = directions.iter().map(|d| dot(&combined(d), &off)).collect();
        let metric = |a: &[f64; 2], b: &[f64; 2]| dot(&combined(a), &combined(b));
        let bent = |a: &[f64; 2], b: &[f64; 2]| -> f64 {
            (0..2).map(|i| (0..2).map(|j| a[i] * b[j] * dot(&second[i][j], &off)).sum::<f64>()).sum()
        };
        let step = match directions {
            [d] => {
                let newton = metric(d, d) + bent(d, d);
                let slope = if newton > 0.1 * metric(d, d) { newton } else { metric(d, d) };
                let length = -slopes[0] / slope;
                [length * d[0], length * d[1]]
            }
            [d, e] => {
                let matrix = |bend: f64| {
                    let entry = |a, b| metric(a, b) + bend * bent(a, b);
                    [[entry(d, d), entry(d, e)], [entry(e, d), entry(e, e)]]
                };
                let determinant = |m: &[[f64; 2]; 2]| m[0][0] * m[1][1] - m[0][1] * m[1][0];
                let (newton, plain) = (matrix(1.0), matrix(0.0));
                let positive = newton[0][0] > 0.0 && determinant(&newton) > 0.01 * determinant(&plain);
                let inverse = inverse(if positive { &newton } else { &plain })?;
                let lengths = inverse.map(|row| -(row[0] * slopes[0] + row[1] * slopes[1]));
                [0, 1].map(|k| lengths[0] * d[k] + lengths[1] * e[k])
            }
            _ => return Some(s),
        };
        let length = step[0].abs().max(step[1].abs());
        if !length.is_finite() {
            return None;
        }
        let factor = 1.0 / length.max(1.0);
        s = [s[0] + factor * step[0], s[1] + factor * step[1]];
        if length < 1e-13 || (length < 1e-8 && length >= 0.5 * previous) {
            return Some(s);
        }
        previous = length;
    }
    None
}

/// The nearest point of a facet, its edges and corners included.
pub(super) fn nearest<const D: usize>(
    facet: &SurfaceFacet<D>,
    rim: &BoundaryEdges,
    x: &[f64; D],
) -> Option<ClosestPoint<D>> {
    const AXES: [[f64; 2]; 2] = [[1.0, 0.0], [0.0, 1.0]];
    if let Some(s) = stationary(facet, x, facet.middle(), &AXES[..D - 1])
        && facet.contains(&s, INSIDE)
    {
        return Some(hit(facet, s, false));
    }
    let (corners, vertices) = (facet.parameters(), facet.vertices().collect::<Vec<_>>());
    let mut found: Option<(f64, ClosestPoint<D>)> = None;
    let mut keep = |hit: ClosestPoint<D>| {
        let off = minus(&hit.position, x);
        let distance = dot(&off, &off);
        if found.is_none_or(|(known, _)| distance < known) {
            found = Some((distance, hit));
        }
    };
    for k in 0..corners.len() {
        keep(hit(facet, corners[k], rim.at_vertex(vertices[k])));
        if D == 3 {
            let next = (k + 1) % corners.len();
            let direction = [0, 1].map(|i| corners[next][i] - corners[k][i]);
            let middle = [0, 1].map(|i| 0.5 * (corners[next][i] + corners[k][i]));
            if let Some(s) = stationary(facet, x, middle, &[direction])
                && facet.contains(&s, INSIDE)
            {
                keep(hit(facet, s, rim.at_edge(vertices[k], vertices[next])));
            }
        }
    }
    found.map(|(_, hit)| hit)
}

//! The pieces of a facet in space: an opposite facet, projected to the plane of the own one, and clipped by its outline.

use super::search::Search;
use super::surface::{SurfaceFacet, dot, minus, unit};
use crate::quadrature::{Piece, QuadratureRule};

/// Pieces smaller than this part of their facet hold nothing.
const SMALLEST: f64 = 1e-14;

type Point = [f64; 2];

/// The plane through the middle of a facet, across its normal there, with the outline of the facet in it.
pub(super) struct FacetPlane<const D: usize> {
    origin: [f64; D],
    axes: [[f64; D]; 2],
    normal: [f64; D],
    /// Corners, counter-clockwise.
    outline: Vec<Point>,
}

impl<const D: usize> FacetPlane<D> {
    pub fn new(own: &SurfaceFacet<D>) -> Self {
        let middle = own.at(&own.middle());
        let (normal, first) = (middle.normal(), unit(&middle.tangents[0]));
        let second = std::array::from_fn(|i| {
            let (j, k) = ((i + 1) % D, (i + 2) % D);
            normal[j] * first[k] - normal[k] * first[j]
        });
        let mut plane =
            FacetPlane { origin: middle.position, axes: [first, second], normal, outline: vec![] };
        let corners = own.parameters().iter().map(|s| own.at(s).position);
        plane.outline = corners.map(|corner| plane.project(&corner, &normal)).collect();
        plane
    }

    /// Intersection of the plane with a line from a point along a direction.
    fn project(&self, point: &[f64; D], direction: &[f64; D]) -> Point {
        let off = minus(point, &self.origin);
        let across = dot(&self.normal, direction);
        // A line nearly along the plane meets it nowhere near.
        let (direction, across) = if across.abs() < 0.1 { (&self.normal, 1.0) } else { (direction, across) };
        let distance = dot(&self.normal, &off) / across;
        let foot: [f64; D] = std::array::from_fn(|k| off[k] - distance * direction[k]);
        self.axes.each_ref().map(|axis| dot(axis, &foot))
    }

    /// The part of the outline that faces an opposite facet, as triangles.
    pub fn facing(&self, search: &Search<D>, facet: usize) -> Vec<Piece> {
        let opposite = &search.opposite[facet];
        if dot(&opposite.at(&opposite.middle()).normal(), &self.normal) >= 0.0 {
            return vec![];
        }
        let corners = opposite.vertices().zip(opposite.parameters());
        let mut projected: Vec<Point> = corners
            .map(|(vertex, s)| {
                self.project(&opposite.at(s).position, &search.direction_at(vertex, &self.normal))
            })
            .collect();
        if area(&projected) < 0.0 {
            projected.reverse();
        }
        let polygon = clip(projected, &self.outline);
        let whole = area(&self.outline);
        let mut triangles = Vec::new();
        // All corners of a convex polygon see each other: triangles from the first are as exact as those from the centroid, and
        // two fewer.
        for k in 1..polygon.len().max(2) - 1 {
            let triangle = [polygon[0], polygon[k], polygon[k + 1]];
            if area(&triangle) > SMALLEST * whole {
                triangles.push(triangle);
            }
        }
        triangles
    }

    /// A rule in the plane as one on the facet's own reference cell, by the map that takes its corners to those of the
    /// outline: the outline covers the whole facet, also of one that is curved.
    pub fn on_reference_cell(&self, rule: QuadratureRule<2>) -> QuadratureRule<2> {
        let mut mapped = QuadratureRule { points: vec![], weights: vec![] };
        for (point, weight) in rule.points.iter().zip(&rule.weights) {
            let (s, determinant) = self.invert(point);
            mapped.points.push(s);
            mapped.weights.push(weight / determinant);
        }
        mapped
    }

    /// The reference point of a point of the outline, and the determinant of the map there.
    fn invert(&self, point: &Point) -> (Point, f64) {
        let corner = &self.outline;
        let last = corner[corner.len() - 1];
        let edge = |to: &Point| [to[0] - corner[0][0], to[1] - corner[0][1]];
        let (along, across) = (edge(&corner[1]), edge(&last));
        // Of a parallelogram the opposite corner is the sum of the two edges; what is left bends the map.
        let bend = match corner.len() {
            4 => [0, 1].map(|k| edge(&corner[2])[k] - along[k] - across[k]),
            _ => [0.0; 2],
        };
        let wanted = edge(point);
        let mut s = [0.5; 2];
        for _ in 0..20 {
            let first = [0, 1].map(|k| along[k] + s[1] * bend[k]);
            let second = [0, 1].map(|k| across[k] + s[0] * bend[k]);
            let determinant = first[0] * second[1] - first[1] * second[0];
            let rest = [0, 1].map(|k| wanted[k] - s[0] * along[k] - s[1] * across[k] - s[0] * s[1] * bend[k]);
            let step = [
                (rest[0] * second[1] - rest[1] * second[0]) / determinant,
                (first[0] * rest[1] - first[1] * rest[0]) / determinant,
            ];
            s = [s[0] + step[0], s[1] + step[1]];
            if step[0].abs().max(step[1].abs()) < 1e-14 {
                break;
            }
        }
        let first = [0, 1].map(|k| along[k] + s[1] * bend[k]);
        let second = [0, 1].map(|k| across[k] + s[0] * bend[k]);
        (s, first[0] * second[1] - first[1] * second[0])
    }
}

/// The part of a convex polygon inside another one, which is counter-clockwise (Sutherland and Hodgman 1974).
fn clip(subject: Vec<Point>, window: &[Point]) -> Vec<Point> {
    let mut polygon = subject;
    for k in 0..window.len() {
        let (start, end) = (window[k], window[(k + 1) % window.len()]);
        // Positive on the left, where the window is.
        let side =
            |p: &Point| (end[0] - start[0]) * (p[1] - start[1]) - (end[1] - start[1]) * (p[0] - start[0]);
        let mut kept = Vec::with_capacity(polygon.len() + 1);
        for (index, point) in polygon.iter().enumerate() {
            let next = &polygon[(index + 1) % polygon.len()];
            let (here, there) = (side(point), side(next));
            if here >= 0.0 {
                kept.push(*point);
            }
            if (here > 0.0 && there < 0.0) || (here < 0.0 && there > 0.0) {
                let t = here / (here - there);
                kept.push([0, 1].map(|k| point[k] + t * (next[k] - point[k])));
            }
        }
        polygon = kept;
    }
    polygon
}

/// The area of a polygon, positive where it is counter-clockwise.
fn area(polygon: &[Point]) -> f64 {
    let edge = |k: usize| (polygon[k], polygon[(k + 1) % polygon.len()]);
    0.5 * (0..polygon.len()).map(edge).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [Point; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

    #[test]
    fn areas_of_clipped_polygons() {
        let shifted = |x: f64, y: f64| SQUARE.map(|p| [p[0] + x, p[1] + y]).to_vec();
        assert!((area(&clip(shifted(0.25, -0.5), &SQUARE)) - 0.375).abs() < 1e-15);
        assert!(area(&clip(shifted(1.0, 0.0), &SQUARE)).abs() < 1e-15);
        assert!(clip(shifted(3.0, 0.0), &SQUARE).is_empty());
        // A square on its corner, of area 9/8, whose four corners are cut off.
        let turned = vec![[0.5, -0.25], [1.25, 0.5], [0.5, 1.25], [-0.25, 0.5]];
        assert!((area(&clip(turned, &SQUARE)) - (1.125 - 4.0 * 0.0625)).abs() < 1e-15);
        let triangle = vec![[-1.0, -1.0], [3.0, -1.0], [-1.0, 3.0]];
        assert!((area(&clip(triangle, &SQUARE)) - 1.0).abs() < 1e-15);
    }
}

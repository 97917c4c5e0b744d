//! A polygon in an own facet's coordinates whose corners move with the feet of opposite nodes.

use super::segment_motion::FEET;

/// A foot that is nearer to the outline lies on it, in coordinates of the own facet.
pub(super) const ON_OUTLINE: f64 = 1e-12;

/// An edge whose ends differ by less in their distance from a line has no point of intersection that moves along it.
const PARALLEL: f64 = 1e-11;

/// The part of a polygon that negative triangles may have, and what counts as the size of smaller ones: twice an area, in coordinates of the own facet.
const FOLDED: f64 = 0.05;
const SMALL: f64 = 0.2;

pub(super) type Point = [f64; 2];

/// A line c + g·s = 0 in the own facet's coordinates, positive on the own facet's side.
pub(super) type Line = (f64, Point);

/// A corner of a polygon with its derivatives by the feet, of the k-th one along β \[k]\[β].
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub s: Point,
    pub by: [[Point; 2]; FEET],
    /// Whether it is the foot of a middle node.
    pub is_middle: bool,
}

pub(super) fn cross(a: &Point, b: &Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

pub(super) fn apart(a: &Point, b: &Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

/// Twice the area.
pub(super) fn area(corners: &[Corner]) -> f64 {
    let triangle =
        |k: usize| cross(&apart(&corners[k].s, &corners[0].s), &apart(&corners[k + 1].s, &corners[0].s));
    (1..corners.len().max(2) - 1).map(triangle).sum()
}

pub(super) fn middle(corners: &[Corner]) -> Point {
    [0, 1].map(|k| corners.iter().map(|corner| corner.s[k]).sum::<f64>() / corners.len() as f64)
}

/// The triangles of a polygon, from a middle node where it has one.
pub(super) fn triangles(corners: &[Corner]) -> impl Iterator<Item = [&Corner; 3]> {
    let (count, first) = (corners.len(), corners.iter().position(|corner| corner.is_middle).unwrap_or(0));
    let at = move |k: usize| &corners[(first + k) % count];
    (1..count.max(2) - 1).map(move |k| [at(0), at(k), at(k + 1)])
}

/// The part of a polygon on the positive side of a line (Sutherland and Hodgman 1974).
pub(super) fn clip(polygon: &[Corner], (constant, slope): &Line, clipped: &mut Vec<Corner>) {
    let value = |s: &Point| constant + slope[0] * s[0] + slope[1] * s[1];
    clipped.clear();
    for (k, last) in polygon.iter().enumerate() {
        let first = &polygon[(k + polygon.len() - 1) % polygon.len()];
        let [a, b] = [value(&first.s), value(&last.s)];
        if (a > ON_OUTLINE) != (b > ON_OUTLINE) {
            let difference = a - b;
            let t = (a / difference).clamp(0.0, 1.0);
            let along = apart(&last.s, &first.s);
            let between = |x: &Point, y: &Point| [0, 1].map(|k| (1.0 - t) * x[k] + t * y[k]);
            let s = between(&first.s, &last.s);
            let mut corner = Corner { s, by: Default::default(), is_middle: false };
            if difference.abs() > PARALLEL {
                for (by, (x, y)) in corner
                    .by
                    .as_flattened_mut()
                    .iter_mut()
                    .zip(first.by.as_flattened().iter().zip(last.by.as_flattened()))
                {
                    let moved = between(x, y);
                    let back = (slope[0] * moved[0] + slope[1] * moved[1]) / difference;
                    *by = [0, 1].map(|k| moved[k] + back * along[k]);
                }
            }
            clipped.push(corner);
        }
        if b > ON_OUTLINE {
            clipped.push(*last);
        }
    }
}

/// Whether triangles of a polygon lie upon each other, by more than edges that bend inwards make them.
pub(super) fn is_folded(polygon: &[Corner]) -> bool {
    let sizes = triangles(polygon).map(|[a, b, c]| cross(&apart(&b.s, &a.s), &apart(&c.s, &a.s)));
    sizes.map(|size| (-size).max(0.0)).sum::<f64>() > FOLDED * area(polygon).max(SMALL)
}

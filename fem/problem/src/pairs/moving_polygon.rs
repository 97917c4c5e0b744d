//! A polygon in an own facet's coordinates whose corners move with the feet of opposite nodes.
//!
//! A corner is a foot, the point at which the chord between two feet meets the own outline, or a corner of the own facet. So it is known at the end by
//! which feet it moves, however often the polygon was clipped.

use super::segment_motion::FEET;

/// A foot that is nearer to the outline lies on it, in coordinates of the own facet.
pub(super) const ON_OUTLINE: f64 = 1e-12;

/// A chord whose ends differ by less in their distance from a line has no point of intersection that moves along it.
const PARALLEL: f64 = 1e-11;

/// The part of a polygon that negative triangles may have, and what counts as the size of smaller ones: twice an area, in coordinates of the own facet.
const FOLDED: f64 = 0.05;
const SMALL: f64 = 0.2;

pub(super) type Point = [f64; 2];

/// A line c + g·s = 0 in the own facet's coordinates, positive on the own facet's side.
pub(super) type Line = (f64, Point);

/// The derivatives of a corner by the feet, of the k-th one along β \[k]\[β].
pub(super) type CornerRates = [[Point; 2]; FEET];

/// The source of a corner of a polygon.
#[derive(Clone, Copy, Debug)]
enum Origin {
    Foot(u8),
    /// The chord that ends at a foot, and the line of the own outline that it meets.
    Crossing {
        chord: u8,
        line: u8,
    },
    OwnCorner,
}

/// An edge of a polygon.
#[derive(Clone, Copy, Debug)]
enum Edge {
    /// The chord that ends at a foot.
    Chord(u8),
    Outline,
}

/// A corner of a polygon.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub s: Point,
    origin: Origin,
    /// The edge that ends here.
    edge: Edge,
    /// Whether it is the foot of a middle node.
    is_middle: bool,
}

impl Corner {
    /// A corner of the own facet.
    pub fn of_own_facet(s: &Point) -> Self {
        Corner { s: *s, origin: Origin::OwnCorner, edge: Edge::Outline, is_middle: false }
    }

    /// The corners of the polygon of an opposite facet's feet, where every second one may be that of a middle node. Surfaces that face each other turn
    /// opposite ways: the last foot is the first corner.
    pub fn of_feet(feet: &[Point], has_middles: bool) -> impl Iterator<Item = Self> {
        feet.iter().enumerate().rev().map(move |(k, s)| Corner {
            s: *s,
            origin: Origin::Foot(k as u8),
            edge: Edge::Chord(k as u8),
            is_middle: has_middles && k % 2 == 1,
        })
    }

    /// The derivatives of the corner by the feet, where lines of the own outline have clipped the polygon.
    pub fn rates(&self, feet: &[Point], lines: &[Line]) -> CornerRates {
        let mut by = CornerRates::default();
        match self.origin {
            Origin::OwnCorner => {}
            Origin::Foot(k) => by[usize::from(k)] = [[1.0, 0.0], [0.0, 1.0]],
            Origin::Crossing { chord, line } => {
                let last = usize::from(chord);
                let first = (last + 1) % feet.len();
                let (line, along) = (&lines[usize::from(line)], apart(&feet[last], &feet[first]));
                let [a, b] = [first, last].map(|foot| value(line, &feet[foot]));
                let difference = a - b;
                if difference.abs() > PARALLEL {
                    let t = (a / difference).clamp(0.0, 1.0);
                    for (foot, part) in [(first, 1.0 - t), (last, t)] {
                        for (axis, by) in by[foot].iter_mut().enumerate() {
                            let back = line.1[axis] * part / difference;
                            *by = along.map(|component| back * component);
                            by[axis] += part;
                        }
                    }
                }
            }
        }
        by
    }
}

/// The value of a line's function at a point.
pub(super) fn value((constant, slope): &Line, s: &Point) -> f64 {
    constant + slope[0] * s[0] + slope[1] * s[1]
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

/// The least and the largest of the corners' coordinates.
pub(super) fn extent(corners: &[Corner]) -> [[f64; 2]; 2] {
    let none = [f64::INFINITY, -f64::INFINITY];
    let wider = |[low, high]: [f64; 2], s: f64| [low.min(s), high.max(s)];
    [0, 1].map(|axis| corners.iter().map(|corner| corner.s[axis]).fold(none, wider))
}

/// The triangles of a polygon by the places of their corners, from a middle node where it has one.
pub(super) fn triangles(corners: &[Corner]) -> impl Iterator<Item = [usize; 3]> {
    let (count, first) = (corners.len(), corners.iter().position(|corner| corner.is_middle).unwrap_or(0));
    let at = move |k: usize| if first + k < count { first + k } else { first + k - count };
    (1..count.max(2) - 1).map(move |k| [at(0), at(k), at(k + 1)])
}

/// The part of a polygon on the positive side of a line with a number (Sutherland and Hodgman 1974).
pub(super) fn clip(polygon: &[Corner], (number, line): (u8, &Line), clipped: &mut Vec<Corner>) {
    clipped.clear();
    let Some(mut first) = polygon.last() else { return };
    let mut a = value(line, &first.s);
    for last in polygon {
        let b = value(line, &last.s);
        let is_inside = b > ON_OUTLINE;
        if (a > ON_OUTLINE) != is_inside {
            let t = (a / (a - b)).clamp(0.0, 1.0);
            let s = [0, 1].map(|k| (1.0 - t) * first.s[k] + t * last.s[k]);
            let origin = match last.edge {
                Edge::Chord(chord) => Origin::Crossing { chord, line: number },
                // Two lines of the outline meet.
                Edge::Outline => Origin::OwnCorner,
            };
            let edge = if is_inside { Edge::Outline } else { last.edge };
            clipped.push(Corner { s, origin, edge, is_middle: false });
        }
        if is_inside {
            clipped.push(*last);
        }
        (first, a) = (last, b);
    }
}

/// Whether triangles of a polygon lie upon each other, by more than edges that bend inwards make them.
pub(super) fn is_folded(polygon: &[Corner]) -> bool {
    let sizes = triangles(polygon).map(|triangle| {
        let [a, b, c] = triangle.map(|k| &polygon[k].s);
        cross(&apart(b, a), &apart(c, a))
    });
    sizes.map(|size| (-size).max(0.0)).sum::<f64>() > FOLDED * area(polygon).max(SMALL)
}

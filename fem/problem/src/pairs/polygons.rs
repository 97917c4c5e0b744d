//! Moving segments in space: the feet of an opposite facet's corners are a polygon in the own facet's coordinates, which is clipped by the own
//! facet's outline and divided into triangles from a corner.
//!
//! Each corner of what is left carries its derivatives by the feet. A foot on the outline counts as outside, for both own facets of an edge.

use super::PairError;
use super::found::Found;
use super::parts::{PartPoint, continued_by};
use super::rays::Rays;
use super::search::{FACING, Search};
use super::segment_motion::{FEET, Shares, foot, foot_matrix};
use super::surface::{SurfaceFacet, dot, minus};
use crate::lanes::SimdLane;
use crate::quadrature::QuadratureRule;

/// A foot that is nearer to the outline lies on it, in coordinates of the own facet.
const ON_OUTLINE: f64 = 1e-12;

/// An edge whose ends differ by less in their distance from a line has no point of intersection that moves along it.
const PARALLEL: f64 = 1e-11;

/// Polygons, and overlaps of them, that are smaller hold nothing: twice their areas, in coordinates of the own facet.
const SMALLEST: f64 = 1e-14;
const OVERLAP: f64 = 1e-9;

/// Twice the area of a triangle whose corners lie on a line.
const LEAST: f64 = 1e-15;

/// Steps of Newton's method for a foot.
const STEPS: usize = 20;

type Point = [f64; 2];

/// A line c + g·s = 0 in the own facet's coordinates, positive on the own facet's side.
type Line = (f64, Point);

const TRIANGLE: [Line; 3] = [(0.0, [0.0, 1.0]), (1.0, [-1.0, -1.0]), (0.0, [1.0, 0.0])];

const SQUARE: [Line; 4] = [(0.0, [0.0, 1.0]), (1.0, [-1.0, 0.0]), (1.0, [0.0, -1.0]), (0.0, [1.0, 0.0])];

/// A corner of a polygon with its derivatives by the feet, of the k-th one along β \[k]\[β].
#[derive(Clone, Copy, Debug)]
struct Corner {
    s: Point,
    by: [[Point; 2]; FEET],
}

/// A part of an own facet that sees an opposite one.
#[derive(Clone, Debug)]
struct Part {
    facet: usize,
    corners: Vec<Corner>,
    feet: [Point; FEET],
    gap: f64,
}

/// Room for the polygons of one own facet.
#[derive(Default)]
pub(super) struct Polygons {
    polygon: Vec<Corner>,
    clipped: Vec<Corner>,
    parts: Vec<Part>,
}

fn cross(a: &Point, b: &Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn apart(a: &Point, b: &Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

/// Twice the area.
fn area(corners: &[Corner]) -> f64 {
    let triangle =
        |k: usize| cross(&apart(&corners[k].s, &corners[0].s), &apart(&corners[k + 1].s, &corners[0].s));
    (1..corners.len().max(2) - 1).map(triangle).sum()
}

fn middle(corners: &[Corner]) -> Point {
    [0, 1].map(|k| corners.iter().map(|corner| corner.s[k]).sum::<f64>() / corners.len() as f64)
}

fn is_convex(corners: &[Corner]) -> bool {
    let at = |k: usize| &corners[k % corners.len()].s;
    (0..corners.len()).all(|k| cross(&apart(at(k + 1), at(k)), &apart(at(k + 2), at(k + 1))) >= 0.0)
}

/// The part of a polygon on the positive side of a line (Sutherland and Hodgman 1974).
fn clip(polygon: &[Corner], (constant, slope): &Line, clipped: &mut Vec<Corner>) {
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
            let mut corner = Corner { s: between(&first.s, &last.s), by: Default::default() };
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

/// The coordinates of a node's foot, on the own facet continued beyond its outline.
fn foot_of<const D: usize>(own: &SurfaceFacet<D>, y: &[f64; D]) -> Option<Point> {
    let mut s = own.middle();
    for _ in 0..STEPS {
        let here = own.at(&s);
        let off = minus(y, &here.position);
        let along = here.tangents.each_ref().map(|tangent| dot(tangent, &off));
        let step = match own.affine {
            true => here.frame().dual.each_ref().map(|dual| dot(dual, &off)),
            false => foot_matrix(own, &s, &off).map(|row| row[0] * along[0] + row[1] * along[1]),
        };
        s = [s[0] + step[0], s[1] + step[1]];
        let length = step[0].abs().max(step[1].abs());
        if own.affine || length < 1e-14 * (1.0 + s[0].abs().max(s[1].abs())) {
            return (s[0] + s[1]).is_finite().then_some(s);
        }
    }
    None
}

/// The points of a rule on the triangles of a polygon.
fn add_points(corners: &[Corner], rule: &QuadratureRule<2>, points: &mut Vec<PartPoint>) {
    let first = &corners[0];
    for pair in corners[1..].windows(2) {
        let triangle = [first, &pair[0], &pair[1]];
        let [a, b] = [1, 2].map(|k| apart(&triangle[k].s, &first.s));
        // Ends of two edges that meet the outline at one point part with it: a triangle without an area has the rate of one.
        let determinant = cross(&a, &b).max(LEAST);
        // Of each foot along each coordinate, the rate of the determinant as a part of it.
        let mut stretch = [[0.0; 2]; FEET];
        for (k, stretch) in stretch.as_flattened_mut().iter_mut().enumerate() {
            let [by_a, by_b] =
                [1, 2].map(|at| apart(&triangle[at].by.as_flattened()[k], &first.by.as_flattened()[k]));
            *stretch = (cross(&by_a, &b) + cross(&a, &by_b)) / determinant;
        }
        if determinant == LEAST && stretch == [[0.0; 2]; FEET] {
            continue;
        }
        for ([s, t], weight) in rule.points.iter().zip(&rule.weights) {
            let parts = [1.0 - s - t, *s, *t];
            let mean = |of: [f64; 3]| parts[0] * of[0] + parts[1] * of[1] + parts[2] * of[2];
            let mut shares = Shares::default();
            for (k, share) in shares.as_flattened_mut().iter_mut().enumerate() {
                let by = triangle.map(|corner| corner.by.as_flattened()[k]);
                let [x, y] = [0, 1].map(|axis| mean(by.map(|by| by[axis])));
                *share = [x, y, stretch.as_flattened()[k]];
            }
            let s = [0, 1].map(|axis| mean(triangle.map(|corner| corner.s[axis])));
            points.push(PartPoint { s, weight: weight * determinant, shares });
        }
    }
}

impl<const D: usize> Search<'_, '_, D> {
    /// The points of an own facet in space, whose candidates are known.
    ///
    /// # Errors
    /// [`PairError::SegmentsFolded`], [`PairError::SegmentsHidden`].
    #[inline(always)]
    pub fn add_polygons_of<L: SimdLane>(
        &self,
        (own, candidates): (&SurfaceFacet<D>, &[usize]),
        rule: &QuadratureRule<2>,
        found: &mut Found<D>,
        (points, polygons): (&mut Vec<PartPoint>, &mut Polygons),
    ) -> Result<(), PairError> {
        let outline = own.parameters().iter().map(|s| Corner { s: *s, by: Default::default() });
        points.clear();
        add_points(&outline.collect::<Vec<_>>(), rule, points);
        found.counts().measure = points.iter().map(|point| point.weight * own.at(&point.s).element()).sum();
        self.find_parts(own, candidates, found, polygons)?;
        self.drop_hidden(own, found, polygons)?;
        found.counts().segments += polygons.parts.len();
        for part in &polygons.parts {
            points.clear();
            add_points(&part.corners, rule, points);
            let opposite = &self.opposite[part.facet];
            let corners = 0..opposite.parameters().len();
            let feet = corners.map(|k| Some(foot((own, &part.feet[k]), (opposite, k))));
            self.add_part::<L>((own, part.facet), self.reach(own), points, feet, found);
        }
        Ok(())
    }

    /// The parts that see the candidates, each without the others.
    fn find_parts(
        &self,
        own: &SurfaceFacet<D>,
        candidates: &[usize],
        found: &mut Found<D>,
        polygons: &mut Polygons,
    ) -> Result<(), PairError> {
        let Polygons { polygon, clipped, parts } = polygons;
        parts.clear();
        let normal = own.at(&own.middle()).normal();
        let lines = if own.parameters().len() == 3 { &TRIANGLE[..] } else { &SQUARE[..] };
        for &facet in candidates {
            let opposite = &self.opposite[facet];
            // Facets that the own one sees from the side may fold; no ray counts that meets them.
            if dot(&normal, &opposite.at(&opposite.middle()).normal()) >= FACING {
                continue;
            }
            let folded = || PairError::SegmentsFolded { position: own.centre.to_vec() };
            let mut feet = [[0.0; 2]; FEET];
            polygon.clear();
            for (k, at) in opposite.parameters().iter().enumerate() {
                let s = foot_of(own, &opposite.at(at).position).ok_or_else(folded)?;
                feet[k] = s;
                let mut by = <[[Point; 2]; FEET]>::default();
                by[k] = [[1.0, 0.0], [0.0, 1.0]];
                polygon.push(Corner { s, by });
            }
            // Surfaces that face each other turn opposite ways.
            polygon.reverse();
            let beside = |(constant, slope): &Line| {
                let value = |corner: &Corner| constant + slope[0] * corner.s[0] + slope[1] * corner.s[1];
                polygon.iter().all(|corner| value(corner) <= ON_OUTLINE)
            };
            if area(polygon) <= SMALLEST || lines.iter().any(beside) {
                continue;
            }
            if polygon.len() > 3 && !is_convex(polygon) {
                return Err(folded());
            }
            for line in lines {
                clip(polygon, line, clipped);
                std::mem::swap(polygon, clipped);
            }
            if polygon.len() < 3 || area(polygon) <= SMALLEST {
                continue;
            }
            match self.seen_from(own, &middle(polygon), facet) {
                Some(gap) => parts.push(Part { facet, corners: polygon.clone(), feet, gap }),
                None => found.counts().dropped += 1,
            }
        }
        Ok(())
    }

    /// The gap to a facet on the ray from a point, where the point sees it.
    fn seen_from(&self, own: &SurfaceFacet<D>, s: &Point, facet: usize) -> Option<f64> {
        let point = own.at(s);
        let rays = Rays { x: point.position, n: point.normal() };
        let nearest = self.nearest_on_rays(own, s, &rays, &[facet], self.reach(own), continued_by(own));
        nearest.found.then_some(nearest.gap)
    }

    /// Drops what nearer facets hide. Facets with a common corner hide nothing of each other.
    fn drop_hidden(
        &self,
        own: &SurfaceFacet<D>,
        found: &mut Found<D>,
        polygons: &mut Polygons,
    ) -> Result<(), PairError> {
        let Polygons { polygon, clipped, parts } = polygons;
        let mut common = |a: &Part, b: &Part| {
            let extent = |part: &Part, axis: usize| {
                let values = part.corners.iter().map(|corner| corner.s[axis]);
                values.fold([f64::INFINITY, -f64::INFINITY], |[low, high], s| [low.min(s), high.max(s)])
            };
            let separate = |axis: usize| {
                let ([a, b], [c, d]) = (extent(a, axis), extent(b, axis));
                b.min(d) - a.max(c) <= 0.0
            };
            let [first, second] = [a, b].map(|part| &self.opposite[part.facet]);
            if separate(0) || separate(1) || first.vertices().any(|own| second.vertices().any(|of| of == own))
            {
                return 0.0;
            }
            polygon.clone_from(&a.corners);
            for (k, corner) in b.corners.iter().enumerate() {
                let along = apart(&b.corners[(k + 1) % b.corners.len()].s, &corner.s);
                let slope = [-along[1], along[0]];
                clip(polygon, &(-slope[0] * corner.s[0] - slope[1] * corner.s[1], slope), clipped);
                std::mem::swap(polygon, clipped);
            }
            area(polygon)
        };
        let pairs = (0..parts.len()).flat_map(|k| (0..k).map(move |other| (k, other)));
        if pairs.into_iter().all(|(k, other)| common(&parts[k], &parts[other]) <= OVERLAP) {
            return Ok(());
        }
        // Nearest first: what they leave of those behind is seen.
        parts.sort_by(|a, b| a.gap.abs().total_cmp(&b.gap.abs()));
        let mut kept: Vec<Part> = Vec::with_capacity(parts.len());
        for part in parts.drain(..) {
            let hidden: f64 = kept.iter().map(|nearer| common(&part, nearer)).sum();
            if hidden <= OVERLAP {
                kept.push(part);
            } else if area(&part.corners) - hidden <= OVERLAP {
                found.counts().dropped += 1;
            } else {
                return Err(PairError::SegmentsHidden {
                    position: own.at(&middle(&part.corners)).position.to_vec(),
                });
            }
        }
        kept.sort_by_key(|part| part.facet);
        *parts = kept;
        Ok(())
    }
}

//! Moving segments in space: the feet of an opposite facet's nodes are a polygon in the own facet's coordinates, which is clipped by the own
//! facet's outline and divided into triangles from a corner.
//!
//! Each corner of what is left carries its derivatives by the feet. A foot on the outline counts as outside, for both own facets of an edge.
//! Of facets of degree two the triangles begin at a middle node: where its edge is straight, no triangle is without area. Where edges bend inwards some
//! of them may be negative. Their sum has the area of the polygon, and its integrals of polynomials.

use super::PairError;
use super::feet::{foot_of, is_positive};
use super::found::Found;
use super::moving_polygon::{
    Corner, Line, ON_OUTLINE, Point, apart, area, clip, cross, is_folded, middle, triangles,
};
use super::parts::{PartPoint, continued_by};
use super::rays::Rays;
use super::search::{FACING, Search};
use super::segment_motion::{FEET, Shares, foot, foot_matrix};
use super::surface::{SurfaceFacet, dot};
use super::tolerances::INSIDE;
use crate::lanes::SimdLane;
use crate::quadrature::QuadratureRule;

/// Polygons, and overlaps of them, that are smaller hold nothing: twice their areas, in coordinates of the own facet.
const SMALLEST: f64 = 1e-14;
const OVERLAP: f64 = 1e-9;

/// Twice the area of a triangle whose corners lie on a line.
const LEAST: f64 = 1e-15;

const TRIANGLE: [Line; 3] = [(0.0, [0.0, 1.0]), (1.0, [-1.0, -1.0]), (0.0, [1.0, 0.0])];

const SQUARE: [Line; 4] = [(0.0, [0.0, 1.0]), (1.0, [-1.0, 0.0]), (1.0, [0.0, -1.0]), (0.0, [1.0, 0.0])];

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

/// The points of a rule on the triangles of a polygon.
fn add_points(corners: &[Corner], rule: &QuadratureRule<2>, points: &mut Vec<PartPoint>) {
    for triangle in triangles(corners) {
        let first = triangle[0];
        let [a, b] = [1, 2].map(|k| apart(&triangle[k].s, &first.s));
        // Ends of two edges that meet the outline at one point part with it: a triangle without an area has the rate of one.
        let determinant = Some(cross(&a, &b)).filter(|size| size.abs() > LEAST).unwrap_or(LEAST);
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

/// The polygon of an opposite facet's feet, in the order of the own outline, and the feet in that of its nodes; none where a node has no foot.
fn find_feet<const D: usize>(
    own: &SurfaceFacet<D>,
    opposite: &SurfaceFacet<D>,
    polygon: &mut Vec<Corner>,
) -> Option<[Point; FEET]> {
    let mut feet = [[0.0; 2]; FEET];
    polygon.clear();
    let (nodes, corners) = (opposite.outline(), opposite.parameters().len());
    for (k, at) in nodes.iter().enumerate() {
        let s = foot_of(own, &opposite.at(at).position)?;
        feet[k] = s;
        let mut by = <[[Point; 2]; FEET]>::default();
        by[k] = [[1.0, 0.0], [0.0, 1.0]];
        polygon.push(Corner { s, by, is_middle: nodes.len() > corners && k % 2 == 1 });
    }
    // Surfaces that face each other turn opposite ways.
    polygon.reverse();
    Some(feet)
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
        let corner = |s: &Point| Corner { s: *s, by: Default::default(), is_middle: false };
        let outline = own.parameters().iter().map(corner);
        points.clear();
        add_points(&outline.collect::<Vec<_>>(), rule, points);
        found.counts().measure = points.iter().map(|point| point.weight * own.at(&point.s).element()).sum();
        self.find_parts((own, candidates), points, found, polygons)?;
        self.drop_hidden(own, found, polygons)?;
        found.counts().segments += polygons.parts.len();
        for part in &polygons.parts {
            points.clear();
            add_points(&part.corners, rule, points);
            let opposite = &self.opposite[part.facet];
            let nodes = 0..opposite.outline().len();
            let feet = nodes.map(|k| Some(foot((own, &part.feet[k]), (opposite, k))));
            self.add_part::<L>((own, part.facet), self.reach(own), points, feet, found);
        }
        Ok(())
    }

    /// The parts that see the candidates, each without the others. `points` are some of the own facet.
    fn find_parts(
        &self,
        (own, candidates): (&SurfaceFacet<D>, &[usize]),
        points: &[PartPoint],
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
            let Some(feet) = find_feet(own, opposite, polygon) else {
                self.leave_out((own, facet), points, found)?;
                continue;
            };
            let beside = |(constant, slope): &Line| {
                let value = |corner: &Corner| constant + slope[0] * corner.s[0] + slope[1] * corner.s[1];
                polygon.iter().all(|corner| value(corner) <= ON_OUTLINE)
            };
            if lines.iter().any(beside) {
                continue;
            }
            // Far from the own facet a polygon may fold; what is inside of the outline counts.
            for line in lines {
                clip(polygon, line, clipped);
                std::mem::swap(polygon, clipped);
            }
            if polygon.len() < 3 || area(polygon) <= SMALLEST {
                continue;
            }
            if is_folded(polygon) {
                self.leave_out((own, facet), points, found)?;
                continue;
            }
            match self.seen_from(own, &middle(polygon), facet, continued_by(own, opposite)) {
                Some(gap) => parts.push(Part { facet, corners: polygon.clone(), feet, gap }),
                None => found.counts().dropped += 1,
            }
        }
        Ok(())
    }

    /// A facet that cannot be cut. It is left out where the own facet's rays have met each other before they meet it, or will soon: at the gap g its
    /// centres of curvature must be farther away than 2 g.
    ///
    /// # Errors
    /// [`PairError::SegmentsFolded`] where it is nearer.
    #[cold]
    fn leave_out(
        &self,
        (own, facet): (&SurfaceFacet<D>, usize),
        points: &[PartPoint],
        found: &mut Found<D>,
    ) -> Result<(), PairError> {
        let middle = own.middle();
        let places = points.iter().map(|point| &point.s).chain(own.outline()).chain([&middle]);
        let mut is_met = false;
        for s in places {
            let Some(gap) = self.seen_from(own, s, facet, INSIDE) else { continue };
            is_met = true;
            let off = own.at(s).normal().map(|component| 2.0 * gap * component);
            if is_positive(&foot_matrix(own, s, &off)) {
                return Err(PairError::SegmentsFolded { position: own.centre.to_vec() });
            }
        }
        found.counts().dropped += usize::from(is_met);
        Ok(())
    }

    /// The gap to a facet on the ray from a point, where the point sees it, continued by a tolerance.
    fn seen_from(&self, own: &SurfaceFacet<D>, s: &Point, facet: usize, continued: f64) -> Option<f64> {
        let point = own.at(s);
        let rays = Rays { x: point.position, n: point.normal() };
        let nearest = self.nearest_on_rays(own, s, &rays, &[facet], self.reach(own), continued);
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
            let mut sum = 0.0;
            for [first, second, third] in
                triangles(&b.corners).map(|triangle| triangle.map(|corner| &corner.s))
            {
                let sign = cross(&apart(second, first), &apart(third, first)).signum();
                polygon.clone_from(&a.corners);
                for (from, to) in [(first, second), (second, third), (third, first)] {
                    let along = apart(to, from);
                    let slope = [-sign * along[1], sign * along[0]];
                    clip(polygon, &(-slope[0] * from[0] - slope[1] * from[1], slope), clipped);
                    std::mem::swap(polygon, clipped);
                }
                sum += sign * area(polygon);
            }
            sum
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

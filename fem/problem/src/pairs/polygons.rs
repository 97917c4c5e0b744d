//! Moving segments in space: the feet of an opposite facet's nodes are a polygon in the own facet's coordinates, which is clipped by the own
//! facet's outline and divided into triangles from a corner.
//!
//! Each corner of what is left has derivatives by the feet. A foot on the outline counts as outside, for both own facets of an edge.
//! Of facets of degree two the triangles begin at a middle node: where its edge is straight, no triangle is without area. Where edges bend inwards some
//! of them may be negative. Their sum has the area of the polygon, and its integrals of polynomials.

use std::ops::Range;

use super::PairError;
use super::feet::{MiddleOfFacet, feet_of, is_positive};
use super::found::Found;
use super::moving_polygon::{
    Corner, CornerRates, Line, ON_OUTLINE, Point, apart, area, clip, cross, extent, is_folded, middle,
    triangles, value,
};
use super::parts::{PartPoint, PartPoints, continued_by};
use super::rays::Rays;
use super::search::{FACING, Search};
use super::segment_motion::{FEET, add_feet, foot_matrix};
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
    /// Its corners among those of all parts.
    corners: Range<usize>,
    extent: [[f64; 2]; 2],
    feet: [Point; FEET],
    gap: f64,
}

/// Room for the polygons of one own facet.
#[derive(Default)]
pub(super) struct Polygons {
    polygon: Vec<Corner>,
    clipped: Vec<Corner>,
    corners: Vec<Corner>,
    /// Of the corners of one part.
    rates: Vec<CornerRates>,
    parts: Vec<Part>,
}

/// The lines of an own facet's outline.
fn lines_of<const D: usize>(own: &SurfaceFacet<D>) -> &'static [Line] {
    if own.parameters().len() == 3 { &TRIANGLE } else { &SQUARE }
}

/// Whether a facet faces an own one with this unit normal.
fn faces<const D: usize>(normal: &[f64; D], opposite: &SurfaceFacet<D>) -> bool {
    let across = match opposite.flat() {
        Some(flat) if opposite.affine => flat.frame.normal,
        _ => opposite.at(&opposite.middle()).long_normal(),
    };
    let product = dot(normal, &across);
    product < 0.0 && FACING * FACING * dot(&across, &across) < product * product
}

/// The points of a rule on the triangles of a polygon, whose corners have derivatives by a number of feet.
fn add_points(
    corners: &[Corner],
    (rates, feet): (&[CornerRates], usize),
    rule: &QuadratureRule<2>,
    PartPoints { points, shares }: &mut PartPoints,
) {
    for triangle in triangles(corners) {
        let at = triangle.map(|k| &corners[k].s);
        let [a, b] = [1, 2].map(|k| apart(at[k], at[0]));
        // Ends of two edges that meet the outline at one point part with it: a triangle without an area has the rate of one.
        let determinant = Some(cross(&a, &b)).filter(|size| size.abs() > LEAST).unwrap_or(LEAST);
        let by = triangle.map(|k| rates.get(k).map_or(&[][..], |by| &by.as_flattened()[..2 * feet]));
        // Of each foot along each coordinate, the rate of the determinant as a part of it.
        let mut stretch = [0.0; 2 * FEET];
        for k in 0..2 * feet {
            let [by_a, by_b] = [1, 2].map(|of| apart(&by[of][k], &by[0][k]));
            stretch[k] = (cross(&by_a, &b) + cross(&a, &by_b)) / determinant;
        }
        if determinant == LEAST && stretch == [0.0; 2 * FEET] {
            continue;
        }
        for ([s, t], weight) in rule.points.iter().zip(&rule.weights) {
            let parts = [1.0 - s - t, *s, *t];
            let mean = |of: [&Point; 3]| {
                [0, 1].map(|axis| parts[0] * of[0][axis] + parts[1] * of[1][axis] + parts[2] * of[2][axis])
            };
            for k in 0..2 * feet {
                let [x, y] = mean([&by[0][k], &by[1][k], &by[2][k]]);
                shares.extend_from_slice(&[x, y, stretch[k]]);
            }
            points.push(PartPoint { s: mean(at), weight: weight * determinant });
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
        (points, polygons): (&mut PartPoints, &mut Polygons),
    ) -> Result<(), PairError> {
        points.clear();
        polygons.polygon.clear();
        polygons.polygon.extend(own.parameters().iter().map(Corner::of_own_facet));
        add_points(&polygons.polygon, (&[], 0), rule, points);
        let measures = points.points.iter().map(|point| point.weight * own.at(&point.s).element());
        found.counts().measure = measures.sum();
        self.find_parts::<L>((own, candidates), &points.points, found, polygons)?;
        self.drop_hidden(own, found, polygons)?;
        let Polygons { parts, corners, rates, .. } = polygons;
        found.counts().segments += parts.len();
        for part in parts.iter() {
            let (corners, opposite) = (&corners[part.corners.clone()], &self.opposite[part.facet]);
            let nodes = opposite.outline().len();
            rates.clear();
            rates.extend(corners.iter().map(|corner| corner.rates(&part.feet[..nodes], lines_of(own))));
            points.clear();
            add_points(corners, (rates, nodes), rule, points);
            let first_foot = found.feet.len();
            add_feet::<L, D>(own, &part.feet[..nodes], opposite, &mut found.feet);
            self.add_part::<L>((own, part.facet), self.reach(own), points, first_foot, found);
        }
        Ok(())
    }

    /// The parts that see the candidates, each without the others. `points` are some of the own facet.
    #[inline(always)]
    fn find_parts<L: SimdLane>(
        &self,
        (own, candidates): (&SurfaceFacet<D>, &[usize]),
        points: &[PartPoint],
        found: &mut Found<D>,
        polygons: &mut Polygons,
    ) -> Result<(), PairError> {
        let Polygons { polygon, clipped, corners, parts, .. } = polygons;
        parts.clear();
        corners.clear();
        let (from, lines) = (MiddleOfFacet::of(own), lines_of(own));
        for &facet in candidates {
            let opposite = &self.opposite[facet];
            // Facets that the own one sees from the side may fold; no ray counts that meets them.
            if !faces(&from.normal, opposite) {
                continue;
            }
            let Some(feet) = feet_of::<L, D>(own, &from, opposite) else {
                self.leave_out((own, facet), points, found)?;
                continue;
            };
            let nodes = &feet[..opposite.outline().len()];
            if lines.iter().any(|line| nodes.iter().all(|s| value(line, s) <= ON_OUTLINE)) {
                continue;
            }
            polygon.clear();
            polygon.extend(Corner::of_feet(nodes, nodes.len() > opposite.parameters().len()));
            // Far from the own facet a polygon may fold; what is inside of the outline counts.
            for (number, line) in (0..).zip(lines) {
                clip(polygon, (number, line), clipped);
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
                Some(gap) => {
                    let first = corners.len();
                    corners.extend_from_slice(polygon);
                    let (corners, extent) = (first..corners.len(), extent(polygon));
                    parts.push(Part { facet, corners, extent, feet, gap });
                }
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
            if is_positive(&foot_matrix(&own.at(s).tangents, &own.second(s), &off)) {
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
        let Polygons { polygon, clipped, corners, parts, .. } = polygons;
        let mut common = |a: &Part, b: &Part| {
            let separate = |axis: usize| {
                let ([a, b], [c, d]) = (a.extent[axis], b.extent[axis]);
                b.min(d) - a.max(c) <= 0.0
            };
            let [first, second] = [a, b].map(|part| &self.opposite[part.facet]);
            if separate(0) || separate(1) || first.vertices().any(|own| second.vertices().any(|of| of == own))
            {
                return 0.0;
            }
            let (mut sum, of_second) = (0.0, &corners[b.corners.clone()]);
            for triangle in triangles(of_second) {
                let [first, second, third] = triangle.map(|k| &of_second[k].s);
                let sign = cross(&apart(second, first), &apart(third, first)).signum();
                polygon.clear();
                polygon.extend_from_slice(&corners[a.corners.clone()]);
                for (from, to) in [(first, second), (second, third), (third, first)] {
                    let along = apart(to, from);
                    let slope = [-sign * along[1], sign * along[0]];
                    clip(polygon, (0, &(-slope[0] * from[0] - slope[1] * from[1], slope)), clipped);
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
            } else if area(&corners[part.corners.clone()]) - hidden <= OVERLAP {
                found.counts().dropped += 1;
            } else {
                return Err(PairError::SegmentsHidden {
                    position: own.at(&middle(&corners[part.corners.clone()])).position.to_vec(),
                });
            }
        }
        kept.sort_by_key(|part| part.facet);
        *parts = kept;
        Ok(())
    }
}

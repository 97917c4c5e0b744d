//! Moving segments: an own facet is cut where opposite nodes come to lie on its rays, and each part that sees an opposite facet has a quadrature
//! rule of its own. Here facets in the plane are cut, in `polygons.rs` those in space.
//!
//! The middle of a part decides which facet it sees. Parts that see none are dropped; neighbours that see the same one are one segment.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lanes are plain.
#![allow(clippy::needless_range_loop)]

use super::PairError;
use super::candidates::RayBundle;
use super::cuts::normals_through;
use super::found::Found;
use super::parts::{PartPoint, PartPoints};
use super::polygons::Polygons;
use super::rays::Rays;
use super::search::Search;
use super::segment_motion::foot;
use super::surface::SurfaceFacet;
use super::tolerances::INSIDE;
use crate::lanes::{SimdLane, WIDEST};

/// Parts shorter than this part of their facet hold nothing.
const SHORTEST: f64 = 1e-14;

/// An end of a segment.
#[derive(Clone, Copy, Debug)]
struct SegmentEnd {
    s: f64,
    /// The opposite node whose ray cuts here, as a facet and its corner; none at an end of the own facet.
    node: Option<[u32; 2]>,
}

/// A part of an own facet and the index of the opposite facet that it sees.
#[derive(Clone, Copy, Debug)]
struct Segment {
    facet: usize,
    ends: [SegmentEnd; 2],
}

/// Room for the segments of one own facet.
#[derive(Default)]
pub(super) struct SegmentRoom {
    candidates: Vec<usize>,
    /// The nodes that were taken to the facet.
    nodes: Vec<u32>,
    ends: Vec<SegmentEnd>,
    segments: Vec<Segment>,
    points: PartPoints,
    polygons: Polygons,
}

impl<const D: usize> Search<'_, '_, D> {
    /// The points of the segments of an own facet, added.
    ///
    /// # Errors
    /// As [`Search::add_polygons_of`].
    #[inline(always)]
    pub fn add_segments_of<L: SimdLane>(
        &self,
        index: usize,
        found: &mut Found<D>,
        room: &mut SegmentRoom,
    ) -> Result<(), PairError> {
        let own = &self.own[index];
        let shape = self.mesh.cell_shape(own.facet.cell as usize);
        let Some((_, rule)) = self.rules.iter().find(|(known, _)| *known == shape) else { return Ok(()) };
        let reach = self.reach(own);
        let beam = RayBundle::of_facet(own, reach);
        let may_face = |facet| self.may_face(own, facet);
        let made = self.candidates.of(index, &beam, own.diameter, may_face, &mut room.candidates);
        found.remade.extend(made.map(|list| (index, list)));
        if D == 3 {
            let SegmentRoom { candidates, points, polygons, .. } = room;
            return self.add_polygons_of::<L>((own, candidates), rule, found, (points, polygons));
        }
        for (s, weight) in rule.points.iter().zip(&rule.weights) {
            found.counts().measure += weight * own.at(s).element();
        }
        self.cut(own, room);
        self.find_segments::<L>(own, reach, rule.points.len(), found, room);
        let SegmentRoom { segments, points, .. } = room;
        for Segment { facet, ends } in segments.iter() {
            let [first, last] = ends.map(|end| end.s);
            let length = last - first;
            points.clear();
            for ([part, _], weight) in rule.points.iter().zip(&rule.weights) {
                points.shares.extend_from_slice(&[1.0 - part, -1.0 / length, *part, 1.0 / length]);
                let s = [first * (1.0 - part) + last * part, 0.0];
                points.points.push(PartPoint { s, weight: weight * length });
            }
            let feet = ends.map(|end| {
                let [holder, corner] = end.node?.map(|number| number as usize);
                let (seen, vertex) = (&self.opposite[*facet], self.opposite[holder].vertices().nth(corner));
                // Facets share their ends: the one that is seen couples nothing new.
                let opposite = match seen.vertices().position(|known| Some(known) == vertex) {
                    Some(place) => (seen, place),
                    None => (&self.opposite[holder], corner),
                };
                Some(foot((own, &[end.s, 0.0]), opposite))
            });
            let first_foot = found.feet.len();
            found.feet.extend(feet);
            self.add_part::<L>((own, *facet), reach, points, first_foot, found);
        }
        Ok(())
    }

    /// The ends of the parts of an own facet, ascending.
    fn cut(&self, own: &SurfaceFacet<D>, room: &mut SegmentRoom) {
        let SegmentRoom { candidates, nodes, ends, .. } = room;
        nodes.clear();
        ends.clear();
        ends.extend([0.0, 1.0].map(|s| SegmentEnd { s, node: None }));
        let Some(curve) = own.parabola() else { return };
        for &index in candidates.iter() {
            let opposite = &self.opposite[index];
            for (corner, (vertex, s)) in opposite.vertices().zip(opposite.parameters()).enumerate() {
                // Facets share their ends.
                if nodes.contains(&vertex) {
                    continue;
                }
                nodes.push(vertex);
                let (found, count) = normals_through(&curve, &opposite.at(s).position);
                let node = Some([index as u32, corner as u32]);
                ends.extend(found[..count].iter().map(|s| SegmentEnd { s: *s, node }));
            }
        }
        ends.sort_unstable_by(|a, b| a.s.total_cmp(&b.s));
    }

    /// The segments between the ends.
    #[inline(always)]
    fn find_segments<L: SimdLane>(
        &self,
        own: &SurfaceFacet<D>,
        reach: f64,
        points: usize,
        found: &mut Found<D>,
        room: &mut SegmentRoom,
    ) {
        let SegmentRoom { candidates, ends, segments, .. } = room;
        segments.clear();
        // What is too short is no part: its ends are one.
        let mut kept = 1;
        for k in 1..ends.len() {
            if ends[k].s - ends[kept - 1].s > SHORTEST {
                ends[kept] = ends[k];
                kept += 1;
            } else if ends[k].node.is_none() {
                // The end of the own facet stays.
                ends[kept - 1] = ends[k];
            }
        }
        ends.truncate(kept);
        for batch in (0..kept - 1).step_by(L::WIDTH) {
            let filled = L::WIDTH.min(kept - 1 - batch);
            let mut middles = [0.0; WIDEST];
            for lane in 0..L::WIDTH {
                let part = batch + lane.min(filled - 1);
                middles[lane] = 0.5 * (ends[part].s + ends[part + 1].s);
            }
            let s = [L::load(&middles), L::splat(0.0)];
            let point = own.at(&s);
            let rays = Rays { x: point.position, n: point.normal() };
            let nearest = self.nearest_on_rays(own, &s, &rays, candidates, reach, INSIDE);
            let [mut seen, mut rejected, mut facets] = [[0.0; WIDEST]; 3];
            let (one, zero) = (L::splat(1.0), L::splat(0.0));
            L::select(nearest.found, one, zero).store(&mut seen);
            L::select(nearest.rejected, one, zero).store(&mut rejected);
            nearest.facet.store(&mut facets);
            for lane in 0..filled {
                let between = [ends[batch + lane], ends[batch + lane + 1]];
                if seen[lane] == 0.0 {
                    let counts = found.counts();
                    counts.dropped += 1;
                    if rejected[lane] != 0.0 {
                        counts.open += points;
                        counts.rejected += points;
                    }
                    continue;
                }
                let facet = facets[lane] as usize;
                match segments.last_mut() {
                    // The end of a facet that is hidden behind another one ends nothing.
                    Some(last) if last.facet == facet && last.ends[1].s == between[0].s => {
                        last.ends[1] = between[1];
                    }
                    _ => segments.push(Segment { facet, ends: between }),
                }
            }
        }
        found.counts().segments += segments.len();
    }
}

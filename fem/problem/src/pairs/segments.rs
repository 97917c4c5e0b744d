//! Moving segments: an own facet in the plane is cut where opposite nodes come to lie on its rays, and each part that sees an opposite facet
//! has a quadrature rule of its own.
//!
//! The middle of a part decides which facet it sees. Parts that see none are dropped; neighbours that see the same one are one segment.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lanes are plain.
#![allow(clippy::needless_range_loop)]

use super::PairGroup;
use super::candidates::RayBundle;
use super::cuts::normals_through;
use super::found::{Found, PairPoint, Unit};
use super::rays::Rays;
use super::search::Search;
use super::segment_motion::{SegmentEnd, moving_end, slopes_of_point};
use super::surface::SurfaceFacet;
use crate::lanes::{SimdLane, WIDEST};

/// Parts shorter than this part of their facet hold nothing.
const SHORTEST: f64 = 1e-14;

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
}

impl<const D: usize> Search<'_, '_, D> {
    /// The points of the segments of an own facet, added.
    #[inline(always)]
    pub fn add_segments_of<L: SimdLane>(&self, index: usize, found: &mut Found<D>, room: &mut SegmentRoom) {
        let own = &self.own[index];
        let shape = self.mesh.cell_shape(own.facet.cell as usize);
        let Some((_, rule)) = self.rules.iter().find(|(known, _)| *known == shape) else { return };
        let reach = self.reach(own);
        let beam = RayBundle::of_segment(own, reach);
        let may_face = |facet| self.may_face(own, facet);
        let made = self.candidates.of(index, &beam, own.diameter, may_face, &mut room.candidates);
        found.remade.extend(made.map(|list| (index, list)));
        for (s, weight) in rule.points.iter().zip(&rule.weights) {
            found.counts().measure += weight * own.at(s).element();
        }
        self.cut(own, room);
        self.find_segments::<L>(own, reach, rule.points.len(), found, room);
        let SegmentRoom { segments, .. } = room;
        let place = self.mesh.walk_of_facet(&[own.facet]);
        for segment in segments.iter() {
            let [first, last] = segment.ends.map(|end| end.s);
            let opposite = &self.opposite[segment.facet];
            let (mut count, start) = (0, found.next_point());
            for batch in (0..rule.points.len()).step_by(L::WIDTH) {
                let filled = L::WIDTH.min(rule.points.len() - batch);
                let mut places = [0.0; WIDEST];
                for lane in 0..L::WIDTH {
                    let [along, _] = rule.points[batch + lane.min(filled - 1)];
                    places[lane] = first * (1.0 - along) + last * along;
                }
                let s = [L::load(&places), L::splat(0.0)];
                let point = own.at(&s);
                let rays = Rays { x: point.position, n: point.normal() };
                let nearest = self.nearest_on_rays(own, &s, &rays, &[segment.facet], reach);
                let [mut seen, mut rejected, mut gaps, mut met] = [[0.0; WIDEST]; 4];
                let (one, zero) = (L::splat(1.0), L::splat(0.0));
                L::select(nearest.found, one, zero).store(&mut seen);
                L::select(nearest.rejected, one, zero).store(&mut rejected);
                nearest.gap.store(&mut gaps);
                nearest.s[0].store(&mut met);
                let [mut x, mut n] = [[[0.0; WIDEST]; D]; 2];
                for k in 0..D {
                    rays.x[k].store(&mut x[k]);
                    rays.n[k].store(&mut n[k]);
                }
                for lane in 0..filled {
                    let counts = found.counts();
                    if seen[lane] == 0.0 {
                        counts.open += 1;
                        counts.rejected += usize::from(rejected[lane] != 0.0);
                        continue;
                    }
                    let mut position = [0.0; D];
                    let mut toward = [0.0; D];
                    for k in 0..D {
                        position[k] = x[k][lane];
                        toward[k] = n[k][lane];
                    }
                    let own_place = [places[lane], 0.0];
                    let weight = rule.weights[batch + lane] * (last - first);
                    let gap = gaps[lane];
                    counts.add_point(&position, gap, weight * own.at(&own_place).element());
                    found.add_point(&PairPoint {
                        reference: [own.reference(&own_place), opposite.reference(&[met[lane], 0.0])],
                        weight,
                        gap,
                        toward,
                        rigid_normal: opposite.rigid_normal,
                    });
                    found.slopes.extend_from_slice(
                        &slopes_of_point(own, places[lane], opposite, met[lane], gap)
                            [..PairGroup::<D>::STRIDE],
                    );
                    found.fractions.push(rule.points[batch + lane][0]);
                    count += 1;
                }
            }
            if count > 0 {
                let facets = [own.facet, opposite.facet];
                let number = Some(found.ends.len());
                found.ends.push(segment.ends.map(|end| moving_end(own, &end, self.opposite, segment.facet)));
                found.units.push(Unit { place, facets, count, start, segment: number });
            }
        }
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
            let nearest = self.nearest_on_rays(own, &s, &rays, candidates, reach);
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

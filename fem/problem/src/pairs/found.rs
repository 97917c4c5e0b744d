//! Results of a search: points with their opposite points, facet by facet, and their numbers.

use std::ops::Range;

use super::PairGroup;
use super::candidates::KeptList;
use super::segment_motion::Foot;
use super::surface::SurfaceFacet;
use crate::mesh::{Facet, Mesh};

/// A quadrature point with its opposite point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PairPoint<const D: usize> {
    /// Reference coordinates in the own cell and in the opposite one.
    pub reference: [[f64; D]; 2],
    /// Weight on the own facet's reference cell.
    pub weight: f64,
    pub gap: f64,
    pub toward: [f64; D],
    /// The opposite surface's outward unit normal before it moves, where it is rigid.
    pub rigid_normal: Option<[f64; D]>,
}

/// The points of an own facet that lie opposite to one facet.
#[derive(Clone, Debug)]
pub(super) struct Unit {
    /// The place of the own facet in the walk.
    pub place: u32,
    /// The own facet and the opposite one.
    pub facets: [Facet; 2],
    /// How many points it has, and where they begin.
    pub count: usize,
    pub start: FirstPoint,
    pub segment: Option<MovingUnit>,
}

/// The places of a moving segment's numbers among those that were found.
#[derive(Clone, Debug)]
pub(super) struct MovingUnit {
    pub feet: Range<usize>,
    /// The first of its points.
    pub shares: usize,
}

/// Where a unit's points begin among numbers and normals of those that were found.
#[derive(Clone, Copy, Debug)]
pub(super) struct FirstPoint {
    pub numbers: usize,
    pub rigid_normals: usize,
}

/// Numbers of a search, added up over facets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Counts<const D: usize> {
    pub points: usize,
    pub open: usize,
    pub rejected: usize,
    pub deepest: f64,
    pub deepest_at: Option<[f64; D]>,
    pub largest: f64,
    pub paired: f64,
    pub measure: f64,
    /// Segments, and parts between cuts that see nothing.
    pub segments: usize,
    pub dropped: usize,
}

impl<const D: usize> Default for Counts<D> {
    fn default() -> Self {
        let (points, open, rejected) = (0, 0, 0);
        let (deepest, largest, paired, measure) = (0.0, 0.0, 0.0, 0.0);
        let (segments, dropped) = (0, 0);
        Counts {
            points,
            open,
            rejected,
            deepest,
            deepest_at: None,
            largest,
            paired,
            measure,
            segments,
            dropped,
        }
    }
}

impl<const D: usize> Counts<D> {
    pub fn add(&mut self, other: &Counts<D>) {
        self.points += other.points;
        self.open += other.open;
        self.rejected += other.rejected;
        if other.deepest > self.deepest {
            (self.deepest, self.deepest_at) = (other.deepest, other.deepest_at);
        }
        self.largest = self.largest.max(other.largest);
        self.paired += other.paired;
        self.measure += other.measure;
        self.segments += other.segments;
        self.dropped += other.dropped;
    }

    pub fn add_point(&mut self, position: &[f64; D], gap: f64, measure: f64) {
        self.points += 1;
        if -gap > self.deepest {
            (self.deepest, self.deepest_at) = (-gap, Some(*position));
        }
        self.largest = self.largest.max(gap);
        self.paired += measure;
    }
}

/// The pairs of some own facets.
#[derive(Debug, Default)]
pub(super) struct Found<const D: usize> {
    pub units: Vec<Unit>,
    /// The numbers of each point as [`PairGroup::points`] has them.
    pub points: Vec<f64>,
    /// Of each point that faces a rigid surface.
    pub rigid_normals: Vec<[f64; D]>,
    /// Of each point of a whole facet with rays: its place among the points of the rule.
    pub rule_points: Vec<u16>,
    /// Of the points of moving segments, as [`GroupMotion`](super::GroupMotion) has them.
    pub slopes: [Vec<f64>; 2],
    pub bends: Vec<f64>,
    pub shares: Vec<f64>,
    pub feet: Vec<Option<Foot<D>>>,
    /// Of each own facet.
    pub counts: Vec<Counts<D>>,
    /// Lists of candidates that were made for some own facets.
    pub remade: Vec<(usize, KeptList<D>)>,
}

/// The index of the opposite facet of a pair that has its unit.
const TAKEN: usize = usize::MAX;

/// Own facets after which room is made for the next ones, and the largest factor by which a list grows then.
const FIRST_GUESS: usize = 32;
const GROWTH: usize = 8;

/// Room in a list for a multiple of its length and an eighth, unless it has room for twice its length.
fn grow<T>(list: &mut Vec<T>, times: usize) {
    if list.capacity() < 2 * list.len() {
        list.reserve_exact(list.len() * times.max(1) - list.len() + list.len() / 8);
    }
}

/// Room for what is computed of one own facet.
#[derive(Debug, Default)]
pub(super) struct Room<const D: usize> {
    /// The pairs with the opposite facets' indices.
    pub pairs: Vec<(usize, PairPoint<D>)>,
}

impl<const D: usize> Found<D> {
    /// With room for some own facets with the given number of points each.
    pub fn with_room(facets: usize, points: usize) -> Self {
        Found {
            units: Vec::with_capacity(2 * facets),
            points: Vec::with_capacity(facets * points * PairGroup::<D>::STRIDE),
            rigid_normals: vec![],
            rule_points: Vec::with_capacity(facets * points),
            slopes: [vec![], vec![]],
            bends: vec![],
            shares: vec![],
            feet: vec![],
            counts: Vec::with_capacity(facets),
            remade: vec![],
        }
    }

    /// Room for what the next own facets may have as those did that are done: lists that grow by doubling would be copied once more.
    pub fn make_room(&mut self, done: usize, facets: usize) {
        if done < FIRST_GUESS || !done.is_power_of_two() {
            return;
        }
        let times = (facets / done).min(GROWTH);
        let [slopes, further] = &mut self.slopes;
        for list in [&mut self.points, slopes, further, &mut self.bends, &mut self.shares] {
            grow(list, times);
        }
        grow(&mut self.feet, times);
        grow(&mut self.units, times);
    }

    /// Beginning of one more own facet.
    pub fn begin(&mut self) {
        self.counts.push(Counts::default());
    }

    /// The numbers of the last own facet.
    pub fn counts(&mut self) -> &mut Counts<D> {
        let last = self.counts.len() - 1;
        &mut self.counts[last]
    }

    /// The place where the next point begins.
    pub fn next_point(&self) -> FirstPoint {
        FirstPoint { numbers: self.points.len(), rigid_normals: self.rigid_normals.len() }
    }

    /// One more point, its numbers as in [`PairGroup::points`] and straight into place: what is put together first is read before it has
    /// come to the cache.
    #[inline(always)]
    pub fn add_point(&mut self, point: &PairPoint<D>) {
        let first = self.points.len();
        self.points.extend_from_slice(&[0.0; PairGroup::<3>::STRIDE][..PairGroup::<D>::STRIDE]);
        let numbers = &mut self.points[first..][..PairGroup::<D>::STRIDE];
        for k in 0..D {
            numbers[k] = point.reference[0][k];
            numbers[D + k] = point.reference[1][k];
            numbers[2 * D + 2 + k] = point.toward[k];
        }
        (numbers[2 * D], numbers[2 * D + 1]) = (point.weight, point.gap);
        self.rigid_normals.extend(point.rigid_normal);
    }

    /// End of an own facet: its pairs are sorted by opposite facets, in the order of its points. All facets of a rigid surface move with one
    /// cell, and count as one.
    pub fn end(
        &mut self,
        mesh: &Mesh<D>,
        own: &SurfaceFacet<D>,
        opposite: &[SurfaceFacet<D>],
        room: &mut Room<D>,
    ) {
        let place = mesh.walk_of_facet(&[own.facet]);
        for first in 0..room.pairs.len() {
            let index = room.pairs[first].0;
            if index == TAKEN {
                continue;
            }
            let start = self.next_point();
            let (mut count, facet) = (0, opposite[index].facet);
            for (other, point) in &mut room.pairs[first..] {
                if *other == index || (*other != TAKEN && opposite[*other].facet == facet) {
                    *other = TAKEN;
                    count += 1;
                    self.add_point(point);
                }
            }
            let facets = [own.facet, facet];
            self.units.push(Unit { place, facets, count, start, segment: None });
        }
        room.pairs.clear();
    }
}

//! Contact pairs: each quadrature point of a surface with the point opposite to it, on the undeformed mesh or on displaced
//! surfaces, where points slide. `search.rs` finds the opposite point: `Search::opposite_to` for the nearest point or a single ray,
//! `nearest_on_rays.rs` for the rays of a facet together.
//!
//! ```text
//! displacement   the fields that displace surfaces
//! traces    elements on facets, as polynomials
//! rest      facets before they are displaced
//! surface, frame   facets as parametrised surfaces, their points and normals
//! surfaces, rigid   the surfaces of a pairing by name; those that are rigid
//! rim       where a surface ends
//! rays, nearest_on_rays   the point of one facet on a ray, and the nearest of some facets; many rays side by side
//! parabola  where a line meets a quadratic curve of the plane
//! opposite  the point of one facet nearest to a point
//! candidates     the facets that rays may meet, kept while motions are small
//! search, points, ray_points, found   the opposite points of an own facet's points
//! pieces, clip   an own facet in parts that face one opposite facet, in the plane and in space
//! segments, cuts   the same on displaced surfaces, where cuts move with the surfaces, in the plane
//! polygons, moving_polygon, feet   the same in space
//! parts      the points of what sees one opposite facet
//! segment_motion   derivatives of their cuts and points
//! report    the numbers of a pairing's points
//! known, surface_values   searches that were done, and the values that identify them
//! jumping_data   functions of position that do not know on which body they are
//! first_touch    a rigid approach until surfaces meet
//! tunnelling     points that would pass through the opposite body between two displacements
//! ```
//!
//! Pairs of the undeformed mesh are searched for once, and kept by [`Assembler`](crate::assemble::Assembler); those of displaced
//! surfaces are kept for the last displacements, and lists of candidates from one displacement to the next. Pairs are a function of
//! mesh and displacement alone, whatever was found before.

mod boundary_edges;
mod candidates;
mod clip;
mod curvature;
mod cuts;
mod displacement;
mod error;
mod feet;
mod first_touch;
mod found;
mod frame;
mod jumping_data;
mod known;
mod moving_polygon;
mod nearest_on_rays;
mod newest;
mod opposite;
mod parabola;
mod parts;
mod pieces;
mod points;
mod polygons;
mod ray_points;
mod rays;
mod report;
mod rest;
mod rigid;
mod search;
mod search_key;
mod segment_motion;
mod segments;
mod surface;
mod surface_values;
mod surfaces;
mod tolerances;
mod traces;
mod tunnelling;

use std::ops::Range;
use std::sync::Arc;

use forms_core::contract::Pairing;

use self::candidates::KeptCandidates;
pub(crate) use self::curvature::{FootCurve, NodeOfFoot};
pub(crate) use self::displacement::{Displacement, DisplacementField};
pub use self::error::PairError;
pub use self::first_touch::{Approach, FirstTouch};
use self::found::{Counts, Found, MovingUnit, Unit};
pub(crate) use self::jumping_data::ReadFunction;
pub(crate) use self::known::KnownPairs;
use self::points::OfFacets;
pub use self::report::PairReport;
use self::rest::SurfacesAtRest;
pub(crate) use self::rigid::coupled_facets;
use self::search::Search;
pub(crate) use self::segment_motion::{Foot, GroupMotion};
use self::surfaces::Surfaces;
pub use self::tunnelling::FollowedMotion;
pub(crate) use self::tunnelling::Follower;
use crate::element::CellShape;
use crate::lanes::InstructionSet;
use crate::mesh::{Facet, Mesh};
use crate::quadrature::Quadrature;
use crate::threads::Threads;

/// Facets that see each other at the same number of points, from cells of the same shapes.
#[derive(Clone, Debug)]
pub(crate) struct PairGroup<const D: usize> {
    /// The shapes of the own and the opposite cells, and the facets' local numbers in them.
    pub sides: [(CellShape, u8); 2],
    /// The own facet and the opposite one of each unit.
    pub facets: Vec<[Facet; 2]>,
    /// Points of each unit.
    pub count: usize,
    /// Of each unit and point: reference coordinates in the own cell, in the opposite one, the weight on the own facet's
    /// reference cell, the gap, the direction toward the opposite point.
    pub points: Vec<f64>,
    /// Of each unit and point where the opposite surface is rigid, so that its facets are none of cells: their outward unit normal
    /// before they move. Empty elsewhere.
    pub rigid_normals: Vec<f64>,
    /// Of each unit and point of whole facets: its place among the points of the rule. Empty elsewhere.
    pub rule_points: Vec<u16>,
    /// The motion of the points of moving segments. Empty elsewhere.
    pub motion: GroupMotion<D>,
}

impl<const D: usize> PairGroup<D> {
    /// Numbers per point.
    pub const STRIDE: usize = 3 * D + 2;

    /// The units whose own cell is wanted.
    pub fn filtered(&self, wanted: impl Fn(u32) -> bool) -> Self {
        let of_units = |numbers: &[f64], stride: usize, kept: &[usize]| -> Vec<f64> {
            let length = self.count * stride;
            let known = kept.iter().filter(|_| !numbers.is_empty());
            known.flat_map(|unit| &numbers[unit * length..][..length]).copied().collect()
        };
        let kept: Vec<usize> =
            (0..self.facets.len()).filter(|unit| wanted(self.facets[*unit][0].cell)).collect();
        let units = self.facets.len();
        let coordinates = self.motion.coordinates(units);
        PairGroup {
            sides: self.sides,
            facets: kept.iter().map(|unit| self.facets[*unit]).collect(),
            count: self.count,
            points: of_units(&self.points, Self::STRIDE, &kept),
            rigid_normals: of_units(&self.rigid_normals, D, &kept),
            rule_points: kept
                .iter()
                .flat_map(|unit| self.rule_points.iter().skip(unit * self.count).take(self.count))
                .copied()
                .collect(),
            motion: GroupMotion {
                slopes: self.motion.slopes.each_ref().map(|slopes| of_units(slopes, Self::STRIDE, &kept)),
                bends: of_units(&self.motion.bends, Self::STRIDE, &kept),
                shares: of_units(&self.motion.shares, coordinates * D, &kept),
                feet: kept.iter().flat_map(|unit| self.motion.feet_of(*unit, units)).cloned().collect(),
            },
        }
    }
}

/// Common properties of the units of a group: the sides, the number of points, and whether the opposite surface is rigid.
type GroupKey = ([(CellShape, u8); 2], usize, bool);

/// The pairs of a mesh for a pairing and a rule.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub struct Pairs<const D: usize> {
    /// In an order that follows from the mesh alone; in each group units are in the order of the walk.
    pub(crate) groups: Vec<Arc<PairGroup<D>>>,
    pub report: PairReport<D>,
    /// The places in the pairing of surfaces whose points have no opposite one.
    pub unpaired: Vec<usize>,
}

/// Own facets that a thread searches for at a time.
const CHUNK: usize = 64;

impl<const D: usize> Pairs<D> {
    /// The pairs whose own facets belong to the cells of bodies, and not to copies of other processes' cells.
    pub(crate) fn of_cells(pairs: Arc<Self>, mesh: &Mesh<D>) -> Arc<Self> {
        if mesh.ghost_cells().is_empty() {
            return pairs;
        }
        let own = mesh.body_cells();
        let of_group = |group: &Arc<PairGroup<D>>| group.filtered(|cell| own.contains(&(cell as usize)));
        let groups = pairs.groups.iter().map(of_group).filter(|group| !group.facets.is_empty());
        Arc::new(Pairs { groups: groups.map(Arc::new).collect(), ..(*pairs).clone() })
    }

    /// Searches with the candidates of an earlier search for the same pairing and rule, and leaves those of this one.
    fn find(
        mesh: &Mesh<D>,
        pairing: &Pairing,
        rule: (&Quadrature<D>, usize),
        displacement: Option<&Displacement<D>>,
        at_rest: &SurfacesAtRest<D>,
        threads: Threads,
        earlier: &[KeptCandidates<D>],
    ) -> Result<(Self, Vec<KeptCandidates<D>>), PairError> {
        if pairing.surfaces.is_empty() {
            return Err(PairError::NoSurfaces);
        }
        if let Some(reach) = pairing.reach
            && !(reach > 0.0 && reach.is_finite())
        {
            return Err(PairError::Reach { reach });
        }
        let surfaces = Surfaces::new(mesh, pairing, at_rest, displacement, threads)?;
        let (mut all, mut kept, mut unpaired) = (Vec::new(), Vec::new(), Vec::new());
        let mut counts = Counts::default();
        for (number, facing) in pairing.surfaces.iter().enumerate() {
            let search = Search::new(mesh, pairing, facing, rule, &surfaces, earlier.get(number))?;
            let facets = search.own.len();
            let parts = threads.count().min(facets.div_ceil(CHUNK)).max(1);
            let parts = (0..parts).map(|part| part * facets / parts..(part + 1) * facets / parts).collect();
            let instructions = InstructionSet::best().checked();
            let found = threads.run(parts, |facets: Range<usize>| {
                instructions.run_without_kernel(OfFacets { search: &search, facets })
            });
            let mut own = Counts::default();
            let mut remade = Vec::new();
            for part in found {
                let mut part = part?;
                part.counts.iter().for_each(|counted| own.add(counted));
                remade.append(&mut part.remade);
                all.push(part);
            }
            // Displaced surfaces may part.
            if own.points == 0 && displacement.is_none() {
                let (own_name, opposite) = (facing.own.clone(), facing.opposite.clone());
                return Err(PairError::NoPartners { own: own_name, opposite, met: own.rejected });
            }
            if own.points == 0 {
                unpaired.push(number);
            }
            counts.add(&own);
            kept.push(search.candidates.keep(remade));
        }
        Ok((Pairs { groups: grouped(mesh, &all), report: PairReport::of(&counts), unpaired }, kept))
    }

    /// The own and opposite facets of all units, each pair of them once; with those whose nodes end a segment without being seen from it.
    pub fn facets(&self) -> Vec<[Facet; 2]> {
        let mut facets: Vec<_> = self.groups.iter().flat_map(|group| &group.facets).copied().collect();
        for group in &self.groups {
            for (unit, sides) in group.facets.iter().enumerate() {
                let feet = group.motion.feet_of(unit, group.facets.len()).iter().flatten();
                let hidden = feet.map(|foot| foot.facet).filter(|facet| *facet != sides[1]);
                facets.extend(hidden.clone().flat_map(|third| sides.map(|side| [side, third])));
                // The second derivatives of energies couple all nodes that move a unit.
                let between = hidden.clone().flat_map(|one| hidden.clone().map(move |other| [one, other]));
                facets.extend(between.filter(|[one, other]| one < other));
            }
        }
        facets.sort_unstable();
        facets.dedup();
        facets
    }

    /// Numbers that tell which facets face each other at how many points, rigid ones by their normals. Where they change, a point has
    /// crossed an edge of the opposite surface, or lost or found it: what is assembled has a kink there.
    pub fn contact_topology(&self) -> Vec<u32> {
        let mut numbers = vec![];
        for group in &self.groups {
            let facets = group.facets.iter().flatten();
            numbers.push(group.count as u32);
            numbers.extend(facets.flat_map(|facet| [facet.cell, u32::from(facet.local)]));
            let bits = group.rigid_normals.iter().map(|normal| normal.to_bits());
            numbers.extend(bits.flat_map(|bits| [bits as u32, (bits >> 32) as u32]));
        }
        numbers
    }
}

/// Units with like sides and numbers of points together, in the order of the walk.
fn grouped<const D: usize>(mesh: &Mesh<D>, found: &[Found<D>]) -> Vec<Arc<PairGroup<D>>> {
    let units = found.iter().flat_map(|part| part.units.iter().map(move |unit| (unit, part)));
    let units: Vec<(&Unit, &Found<D>)> = units.collect();
    // Units of an own facet follow each other.
    let begins = |k: &usize| *k == 0 || units[*k].0.facets[0] != units[*k - 1].0.facets[0];
    // Place and number as one: they are sorted in half the time.
    let key = |k: usize| u64::from(units[k].0.place) << 32 | k as u64;
    let mut own: Vec<u64> = (0..units.len()).filter(begins).map(key).collect();
    own.sort_unstable();
    let mut order: Vec<usize> = Vec::with_capacity(units.len());
    for key in own {
        let first = (key & u64::from(u32::MAX)) as usize;
        order.push(first);
        order.extend((first + 1..units.len()).take_while(|k| !begins(k)));
    }
    let mut kinds: Vec<(GroupKey, usize, usize)> = Vec::new();
    let mut last = 0;
    let mut kind_of = |unit: &Unit| {
        let side = |facet: Facet| (mesh.cell_shape(facet.cell as usize), facet.local);
        let key = (unit.facets.map(side), unit.count, mesh.carries(unit.facets[1].cell));
        // Units of a kind follow each other more often than not.
        if kinds.get(last).is_none_or(|(known, ..)| *known != key) {
            last = kinds.iter().position(|(known, ..)| *known == key).unwrap_or(kinds.len());
        }
        if last == kinds.len() {
            kinds.push((key, 0, unit.segment.as_ref().map_or(0, |segment| segment.feet.len())));
        }
        kinds[last].1 += 1;
        last
    };
    let kind_of_each: Vec<usize> = order.iter().map(|number| kind_of(units[*number].0)).collect();
    let with_room = |(key, units, feet): &(GroupKey, usize, usize)| {
        let (sides, count, rigid) = *key;
        let points = Vec::with_capacity(units * count * PairGroup::<D>::STRIDE);
        let rigid_normals = Vec::with_capacity(if rigid { units * count * D } else { 0 });
        let (facets, motion) =
            (Vec::with_capacity(*units), GroupMotion::with_room(units * feet, *units, count));
        let rule_points = Vec::with_capacity(units * count);
        (*key, PairGroup { sides, facets, count, points, rigid_normals, rule_points, motion })
    };
    let mut groups: Vec<(GroupKey, PairGroup<D>)> = kinds.iter().map(with_room).collect();
    for (number, kind) in order.into_iter().zip(kind_of_each) {
        let (Unit { facets, count, start, segment, .. }, part) = units[number];
        let ((.., rigid), group) = &mut groups[kind];
        group.facets.push(*facets);
        // Point by point: of a length that is known nothing is called.
        for point in part.points[start.numbers..].chunks_exact(PairGroup::<D>::STRIDE).take(*count) {
            group.points.extend_from_slice(point);
        }
        if let Some(MovingUnit { feet, shares }) = segment {
            for (slopes, found) in group.motion.slopes.iter_mut().zip(&part.slopes).take(D - 1) {
                slopes.extend(&found[start.numbers..][..count * PairGroup::<D>::STRIDE]);
            }
            if D == 2 {
                let bends = &part.bends[start.numbers..][..count * PairGroup::<D>::STRIDE];
                group.motion.bends.extend(bends);
            }
            group.motion.shares.extend(&part.shares[*shares..][..count * feet.len() * (D - 1) * D]);
            group.motion.feet.extend_from_slice(&part.feet[feet.clone()]);
        }
        let places = part.rule_points.iter().skip(start.numbers / PairGroup::<D>::STRIDE);
        group.rule_points.extend(places.take(*count));
        if *rigid {
            let normals = &part.rigid_normals[start.rigid_normals..][..*count];
            group.rigid_normals.extend_from_slice(normals.as_flattened());
        }
    }
    groups.sort_unstable_by_key(|(key, _)| *key);
    groups.into_iter().map(|(_, group)| Arc::new(group)).collect()
}

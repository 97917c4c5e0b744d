//! Tunnelling: points that leave the opposite body at its far side between two displacements, so that contact never sees them.
//!
//! The surfaces go straight from one displacement to the other, and pairs are searched for at places on the way that are so close
//! to each other that no point gets through unseen (the conservative sampling of discrete collision detection, as in Ericson,
//! Real-Time Collision Detection, 2005, section 5.5).

use std::collections::HashMap;

use forms_core::contract::Pairing;

use super::rays::along_ray;
use super::rest::{FacetAtRest, SurfaceAtRest};
use super::surface::{SurfaceFacet, dot, minus};
use super::surfaces::Surfaces;
use super::{Displacement, DisplacementField, KnownPairs, PairError, PairGroup, Pairs};
use crate::locate::BoxGrid;
use crate::mesh::{Facet, Mesh};
use crate::quadrature::Quadrature;
use crate::space::Space;
use crate::threads::Threads;

/// A point may be behind the opposite surface by this part of what contact can see. Further on its side would be ambiguous.
const ALLOWED: f64 = 0.5;

/// From one place to the next surfaces move by at most this part of what contact can see. Where normals are 60° apart a gap
/// changes by twice as much, and a point on its way through is still found twice beyond what is allowed.
const SPACING: f64 = 0.125;

/// Bodies that are thinner than this part of an opposite facet, as at the tip of a wedge, count as that thick.
const THINNEST: f64 = 0.25;

/// Places on one way, at most.
const PLACES: usize = 256;

/// The motion of a pairing's surfaces from one displacement to another, on which no point passed through the opposite body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FollowedMotion<const D: usize> {
    /// A bound of how far points of the surfaces moved relative to those opposite to them \[length\].
    pub relative_motion: f64,
    /// The smallest of reaches and thicknesses of opposite bodies: what contact can see behind a surface \[length\].
    pub visible_depth: f64,
    /// The number of places at which pairs were searched for.
    pub places: usize,
    /// The deepest overlap on the way, at its end, too \[length\].
    pub deepest_overlap: f64,
}

/// The thickness of a body behind some of its facets, in the direction of their inward normals, before it is displaced; none where
/// it is above the depth asked for.
fn thicknesses<const D: usize>(
    mesh: &Mesh<D>,
    facets: &[SurfaceFacet<D>],
    depth: f64,
) -> HashMap<Facet, f64> {
    if mesh.boundary_facets().is_empty() {
        // Of a piece of a mesh.
        return HashMap::new();
    }
    let at_rest = FacetAtRest::all(mesh, mesh.boundary_facets());
    let at_rest = SurfaceAtRest { facets: at_rest.into(), nodes: vec![] };
    let boundary = SurfaceFacet::all(mesh, &at_rest, 0..at_rest.facets.len(), None);
    let grid = BoxGrid::new(boundary.iter().map(|facet| facet.corners()).collect());
    let mut found = HashMap::new();
    for facet in facets.iter().filter(|facet| facet.rigid_normal.is_none()) {
        let (start, outward) = facet.undisplaced(&facet.middle());
        let inward = outward.map(|component| -component);
        let end: [f64; D] = std::array::from_fn(|k| start[k] + depth * inward[k]);
        let along =
            (std::array::from_fn(|k| start[k].min(end[k])), std::array::from_fn(|k| start[k].max(end[k])));
        let exit = |candidate: usize| {
            let other = &boundary[candidate];
            // Of two points of a curved facet on the line that which the body is left at: it faces a ray the other way.
            let hit = along_ray(other, &start, &outward).filter(|_| other.facet != facet.facet)?;
            let distance = dot(&inward, &minus(&hit.position, &start));
            (dot(&hit.normal, &inward) > 0.0 && distance > 0.0 && distance <= depth).then_some(distance)
        };
        if let Some(thickness) = grid.meeting(&along).into_iter().filter_map(exit).min_by(f64::total_cmp) {
            found.insert(facet.facet, thickness.max(THINNEST * facet.diameter));
        }
    }
    found
}

/// The motions of a surface's corners and middles.
fn motions<const D: usize>(before: &[SurfaceFacet<D>], after: &[SurfaceFacet<D>]) -> Vec<[f64; D]> {
    let moved = |(before, after): (&SurfaceFacet<D>, &SurfaceFacet<D>)| -> Vec<[f64; D]> {
        let points = before.parameters().iter().copied().chain([before.middle()]);
        points.map(|s| minus(&after.at(&s).position, &before.at(&s).position)).collect()
    };
    before.iter().zip(after).flat_map(moved).collect()
}

/// The larger of two numbers; NaN where one of them is.
fn larger(one: f64, other: f64) -> f64 {
    if one.is_nan() || one > other { one } else { other }
}

/// A bound of the difference of any two motions, one of each list; NaN where one of them is no motion.
fn relative<const D: usize>(own: &[[f64; D]], opposite: &[[f64; D]]) -> f64 {
    let count = opposite.len().max(1) as f64;
    let mean: [f64; D] =
        std::array::from_fn(|k| opposite.iter().map(|motion| motion[k]).sum::<f64>() / count);
    let furthest = |motions: &[[f64; D]]| {
        let squares = motions.iter().map(|motion| minus(motion, &mean)).map(|off| dot(&off, &off));
        squares.fold(0.0, larger).sqrt()
    };
    furthest(own) + furthest(opposite)
}

/// Depth to which contact can see behind the surfaces of a pairing.
struct Visible {
    /// The reach of each own facet.
    reaches: HashMap<Facet, f64>,
    /// The thickness behind opposite facets, where it is less than the largest reach.
    thicknesses: HashMap<Facet, f64>,
}

impl Visible {
    fn of<const D: usize>(mesh: &Mesh<D>, pairing: &Pairing, surfaces: &Surfaces<D>) -> Self {
        let own = pairing.surfaces.iter().flat_map(|facing| surfaces.of(&facing.own));
        let reach = |facet: &SurfaceFacet<D>| pairing.reach.unwrap_or(2.0 * facet.diameter);
        let reaches: HashMap<Facet, f64> = own.map(|facet| (facet.facet, reach(facet))).collect();
        let largest = reaches.values().copied().fold(0.0, f64::max);
        let mut found = HashMap::new();
        let mut seen: Vec<&str> = Vec::new();
        for facing in &pairing.surfaces {
            if !seen.contains(&facing.opposite.as_str()) {
                seen.push(&facing.opposite);
                found.extend(thicknesses(mesh, surfaces.of(&facing.opposite), largest));
            }
        }
        Visible { reaches, thicknesses: found }
    }

    /// That of an own facet and an opposite one.
    fn between(&self, [own, opposite]: &[Facet; 2]) -> f64 {
        let [reach, thickness] = [self.reaches.get(own), self.thicknesses.get(opposite)]
            .map(|known| known.copied().unwrap_or(f64::INFINITY));
        reach.min(thickness)
    }

    fn least(&self) -> f64 {
        self.reaches.values().chain(self.thicknesses.values()).copied().fold(f64::INFINITY, f64::min)
    }
}

/// The first point that lies deeper behind the opposite surface than is allowed: its facets, depth and reference coordinates.
fn too_deep<const D: usize>(pairs: &Pairs<D>, visible: &Visible) -> Option<([Facet; 2], f64, [f64; D])> {
    for group in &pairs.groups {
        let units = group.points.chunks_exact(group.count * PairGroup::<D>::STRIDE);
        for (facets, points) in group.facets.iter().zip(units) {
            let allowed = ALLOWED * visible.between(facets);
            for point in points.chunks_exact(PairGroup::<D>::STRIDE) {
                let depth = -point[2 * D + 1];
                if depth > allowed {
                    return Some((*facets, depth, std::array::from_fn(|k| point[k])));
                }
            }
        }
    }
    None
}

fn displacement<'a, const D: usize>(space: &'a Space<D>, values: &'a [f64]) -> Displacement<'a, D> {
    Displacement { fields: vec![DisplacementField { space, values }] }
}

/// The searches that follow a motion.
pub(crate) struct Follower<'a, const D: usize> {
    pub mesh: &'a Mesh<D>,
    pub pairing: &'a Pairing,
    pub quadrature: &'a Quadrature<D>,
    pub degree: usize,
    pub known: &'a KnownPairs<D>,
    pub threads: Threads,
}

impl<const D: usize> Follower<'_, D> {
    /// The motion from one displacement of a space to another one, followed; both are given by their coefficients.
    ///
    /// # Errors
    /// [`PairError`]: surfaces that are missing or do not fit, a reach that is no length.
    pub fn follow(&self, space: &Space<D>, ends: [&[f64]; 2]) -> Result<FollowedMotion<D>, PairError> {
        let Follower { mesh, pairing, quadrature, degree, known, threads } = *self;
        if pairing.surfaces.is_empty() {
            return Err(PairError::NoSurfaces);
        }
        if let Some(reach) = pairing.reach.filter(|reach| !(*reach > 0.0 && reach.is_finite())) {
            return Err(PairError::Reach { reach });
        }
        let [before, after] = ends;
        let surfaces = ends.map(|values| {
            Surfaces::new(mesh, pairing, &known.at_rest, Some(&displacement(space, values)), threads)
        });
        let [first, last] = surfaces;
        let (first, last) = (first?, last?);
        let visible = Visible::of(mesh, pairing, &first);
        let mut motion = 0.0_f64;
        for facing in &pairing.surfaces {
            let [own, opposite] =
                [&facing.own, &facing.opposite].map(|name| motions(first.of(name), last.of(name)));
            motion = larger(motion, relative(&own, &opposite));
        }
        let depth = visible.least();
        let places = (motion / (SPACING * depth)).ceil();
        if places.is_nan() || places > PLACES as f64 {
            return Err(PairError::TooFar { motion, allowed: PLACES as f64 * SPACING * depth });
        }
        let places = (places as usize).max(1);
        let mut deepest_overlap = 0.0_f64;
        for place in 1..=places {
            let part = place as f64 / places as f64;
            let between = |(before, after): (&f64, &f64)| before + part * (after - before);
            let values: Vec<f64> = match place == places {
                true => after.to_vec(),
                false => before.iter().zip(after).map(between).collect(),
            };
            let found = |values: &[f64]| {
                known.find(mesh, pairing, quadrature, degree, Some(&displacement(space, values)), threads)
            };
            let place = |facets: &[Facet; 2], reference: &[f64; D]| {
                (mesh.map(facets[0].cell as usize, reference).0.to_vec(), visible.between(facets))
            };
            let pairs = found(&values)?;
            if let Some((facets, depth, reference)) = too_deep(&pairs, &visible) {
                if let Some((facets, depth, reference)) = too_deep(&*found(before)?, &visible) {
                    let (position, visible) = place(&facets, &reference);
                    return Err(PairError::Inside { position, depth, visible });
                }
                let (position, visible) = place(&facets, &reference);
                return Err(PairError::Tunnelling { position, depth, visible, part });
            }
            deepest_overlap = deepest_overlap.max(pairs.report.deepest_overlap);
        }
        Ok(FollowedMotion { relative_motion: motion, visible_depth: depth, places, deepest_overlap })
    }
}

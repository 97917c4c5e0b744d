//! Contact pairs: each quadrature point of a surface with the point opposite to it, on the undeformed mesh or on displaced
//! surfaces.
//!
//! ```text
//! displacement   the fields that displace surfaces
//! surface   facets as parametrised surfaces, and where a surface ends
//! opposite  the point of one facet on a ray, or nearest to a point
//! search    the opposite points of an own facet, among candidates from a grid of boxes
//! pieces, clip   an own facet in parts that face one opposite facet, in the plane and in space
//! ```
//!
//! Pairs of the undeformed mesh are searched for once, and kept by [`Assembler`](crate::assemble::Assembler); those of displaced
//! surfaces are kept for the last displacements. They are a function of mesh and displacement alone, whatever was found before.

mod clip;
mod displacement;
mod error;
mod opposite;
mod pieces;
mod search;
mod surface;

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use forms_core::contract::Pairing;

pub(crate) use self::displacement::{Displacement, DisplacementField};
pub use self::error::PairError;
use self::search::{Counts, Search, Unit};
use crate::element::CellShape;
use crate::mesh::{Facet, Mesh};
use crate::quadrature::Quadrature;
use crate::threads::Threads;

/// Numbers of a pairing's points: `assembler.pairs(&pairing, degree)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairReport {
    /// Quadrature points with an opposite point.
    pub points: usize,
    /// Quadrature points without one. Parts of facets that face nothing get no points with
    /// [`PairQuadrature::Pieces`](forms_core::contract::PairQuadrature::Pieces); compare `paired_measure` with `measure`.
    pub open: usize,
    /// Those of them for which a facet was found, but from behind or further away than the reach.
    pub rejected: usize,
    /// The largest −g, zero where nothing overlaps \[length\].
    pub deepest_overlap: f64,
    /// The largest g, zero where there is none \[length\].
    pub largest_gap: f64,
    /// The measure of what has opposite points \[length^(D−1)\].
    pub paired_measure: f64,
    /// The measure of the surfaces that are integrated over \[length^(D−1)\].
    pub measure: f64,
}

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
}

impl<const D: usize> PairGroup<D> {
    /// Numbers per point.
    pub const STRIDE: usize = 3 * D + 2;

    /// The units whose own cell is wanted.
    pub fn filtered(&self, wanted: impl Fn(u32) -> bool) -> Self {
        let length = self.count * Self::STRIDE;
        let kept: Vec<usize> =
            (0..self.facets.len()).filter(|unit| wanted(self.facets[*unit][0].cell)).collect();
        PairGroup {
            sides: self.sides,
            facets: kept.iter().map(|unit| self.facets[*unit]).collect(),
            count: self.count,
            points: kept.iter().flat_map(|unit| &self.points[unit * length..][..length]).copied().collect(),
        }
    }
}

/// The pairs of a mesh for a pairing and a rule.
#[derive(Clone, Debug)]
pub(crate) struct Pairs<const D: usize> {
    /// In an order that follows from the mesh alone; in each group units stand in the order of the walk.
    pub groups: Vec<Arc<PairGroup<D>>>,
    pub report: PairReport,
}

/// Own facets that a thread searches for at a time.
const CHUNK: usize = 64;

impl<const D: usize> Pairs<D> {
    fn find(
        mesh: &Mesh<D>,
        pairing: &Pairing,
        quadrature: &Quadrature<D>,
        degree: usize,
        displacement: Option<&Displacement<D>>,
        threads: Threads,
    ) -> Result<Self, PairError> {
        if pairing.surfaces.is_empty() {
            return Err(PairError::NoSurfaces);
        }
        let mut all: Vec<(u32, Unit<D>)> = Vec::new();
        let mut counts = Counts::default();
        for facing in &pairing.surfaces {
            let search = Search::new(mesh, pairing, facing, quadrature, degree, displacement)?;
            let facets = search.own.len();
            let parts = threads.count().min(facets.div_ceil(CHUNK)).max(1);
            let parts = (0..parts).map(|part| part * facets / parts..(part + 1) * facets / parts).collect();
            let found = threads.run(parts, |part: Range<usize>| {
                part.map(|facet| search.pairs_of(facet)).collect::<Result<Vec<_>, PairError>>()
            });
            let mut own = Counts::default();
            for part in found {
                for (units, counted) in part? {
                    own.add(&counted);
                    all.extend(units.into_iter().map(|unit| (mesh.walk_of_facet(&unit.facets[..1]), unit)));
                }
            }
            // Displaced surfaces may part.
            if own.points == 0 && displacement.is_none() {
                let (own_name, opposite) = (facing.own.clone(), facing.opposite.clone());
                return Err(PairError::NoPartners { own: own_name, opposite, met: own.rejected });
            }
            counts.add(&own);
        }
        all.sort_by_key(|(place, _)| *place);
        let mut groups: BTreeMap<_, PairGroup<D>> = BTreeMap::new();
        for (_, unit) in all {
            let side = |facet: Facet| (mesh.cell_shape(facet.cell as usize), facet.local);
            let (sides, count) = (unit.facets.map(side), unit.points.len());
            let group = groups.entry((sides, count)).or_insert_with(|| PairGroup {
                sides,
                facets: vec![],
                count,
                points: vec![],
            });
            group.facets.push(unit.facets);
            for point in &unit.points {
                group.points.extend(point.reference.as_flattened());
                group.points.extend([point.weight, point.gap]);
                group.points.extend(point.toward);
            }
        }
        Ok(Pairs {
            groups: groups.into_values().map(Arc::new).collect(),
            report: PairReport {
                points: counts.points,
                open: counts.open,
                rejected: counts.rejected,
                deepest_overlap: counts.deepest,
                largest_gap: counts.largest,
                paired_measure: counts.paired,
                measure: counts.measure,
            },
        })
    }

    /// The own and opposite facets of all units, each pair of them once.
    pub fn facets(&self) -> Vec<[Facet; 2]> {
        let mut facets: Vec<_> = self.groups.iter().flat_map(|group| &group.facets).copied().collect();
        facets.sort_unstable();
        facets.dedup();
        facets
    }
}

/// Pairs that were searched for on one mesh, so that each search is done once.
#[derive(Debug, Default)]
pub(crate) struct KnownPairs<const D: usize> {
    known: Mutex<Vec<Known<D>>>,
}

#[derive(Debug)]
struct Known<const D: usize> {
    pairing: Pairing,
    quadrature: Quadrature<D>,
    degree: usize,
    /// Degree and coefficients of the fields that displace the surfaces.
    displacement: Option<Vec<(usize, Vec<f64>)>>,
    pairs: Arc<Pairs<D>>,
}

impl<const D: usize> Known<D> {
    fn is_displaced_by(&self, displacement: Option<&Displacement<D>>) -> bool {
        match (&self.displacement, displacement) {
            (None, None) => true,
            (Some(own), Some(other)) => {
                own.len() == other.fields.len()
                    && own.iter().zip(&other.fields).all(|((degree, values), field)| {
                        *degree == field.space.degree && values[..] == *field.values
                    })
            }
            _ => false,
        }
    }
}

/// Searches that are kept, of the undeformed mesh and of displaced surfaces; the oldest go.
const KEPT: usize = 8;

impl<const D: usize> KnownPairs<D> {
    /// The pairs of the mesh, always the same one, with the rules of a choice of quadrature; `estimated` is the degree
    /// where the choice is the compiler's estimate.
    pub fn find(
        &self,
        mesh: &Mesh<D>,
        pairing: &Pairing,
        quadrature: &Quadrature<D>,
        estimated: usize,
        displacement: Option<&Displacement<D>>,
        threads: Threads,
    ) -> Result<Arc<Pairs<D>>, PairError> {
        // Where facets are split elsewhere, pairs keep pieces of their own.
        let mut choice = quadrature;
        while let Quadrature::Split { whole, .. } = choice {
            choice = whole;
        }
        let degree = if choice.follows_estimates() { estimated } else { 0 };
        let is_known = |known: &&Known<D>| {
            known.degree == degree
                && known.pairing == *pairing
                && known.quadrature == *choice
                && known.is_displaced_by(displacement)
        };
        let lock = || self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = lock().iter().find(is_known) {
            return Ok(Arc::clone(&known.pairs));
        }
        // Not under the lock: a search runs on several threads.
        let pairs = Arc::new(Pairs::find(mesh, pairing, choice, degree, displacement, threads)?);
        let mut known = lock();
        let of_this_kind = |one: &Known<D>| one.displacement.is_some() == displacement.is_some();
        if known.iter().filter(|one| of_this_kind(one)).count() == KEPT
            && let Some(oldest) = known.iter().position(of_this_kind)
        {
            known.remove(oldest);
        }
        let (pairing, quadrature) = (pairing.clone(), choice.clone());
        let displacement = displacement.map(|displacement| {
            displacement.fields.iter().map(|field| (field.space.degree, field.values.to_vec())).collect()
        });
        known.push(Known { pairing, quadrature, degree, displacement, pairs: Arc::clone(&pairs) });
        Ok(pairs)
    }
}

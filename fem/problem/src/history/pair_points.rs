//! Histories at the points of contact pairs: values that belong to one pairing of fixed points and one rule.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::{Arc, RwLock};

use forms_core::contract::{Entity, PairQuadrature, Pairing, Requirements, Side};

use super::{HistoryMismatch, PointStorage, Snapshot, State};
use crate::assemble::Assembler;
use crate::mesh::Facet;
use crate::pairs::{PairError, PairGroup, Pairs};

/// The kind of a pairing's points, for histories that are read there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PointsOfPairs {
    /// Pairs of the undeformed mesh.
    Fixed,
    /// Own points of whole facets, whose opposite points slide.
    Sliding,
    /// Points of moving segments.
    Segments,
}

impl PointsOfPairs {
    /// The points of an integral over a pairing, whose surfaces may be displaced.
    pub fn of(pairing: &Pairing, displaced: bool) -> Self {
        match (displaced, pairing.quadrature) {
            (false, _) => PointsOfPairs::Fixed,
            (true, Some(PairQuadrature::Pieces)) => PointsOfPairs::Segments,
            (true, _) => PointsOfPairs::Sliding,
        }
    }
}

/// The places of the values of a pairing's points.
pub(super) struct PairPoints {
    pub pairing: Pairing,
    /// By own and opposite facet: the numbers of the points, in the order in which pairs are evaluated.
    ranges: HashMap<[Facet; 2], Range<usize>>,
}

impl<const D: usize> PointStorage<D> {
    #[inline(never)]
    pub(super) fn on_pairs(
        assembler: &Assembler<D>,
        pairing: &Pairing,
        degree: usize,
        initial: &[f64],
    ) -> Result<Self, PairError> {
        let pairs = Pairs::of_cells(assembler.pairs_of(pairing, degree)?, assembler.mesh());
        let (mut ranges, mut count) = (HashMap::new(), 0);
        for group in &pairs.groups {
            for facets in &group.facets {
                let range = count..count + group.count;
                count = range.end;
                if ranges.insert(*facets, range).is_some() {
                    return Err(PairError::Twice);
                }
            }
        }
        let committed = Arc::new(initial.repeat(count));
        Ok(PointStorage {
            mesh: assembler.mesh().clone(),
            entity: Entity::Pairs,
            region: pairing.to_string(),
            regions: vec![],
            degree,
            quadrature: assembler.quadrature().clone(),
            components: initial.len(),
            initial: initial.to_vec(),
            entities: vec![],
            starts: vec![0],
            pairs: Some(PairPoints { pairing: pairing.clone(), ranges }),
            state: RwLock::new(State { committed, written: None, commits: 0 }),
        })
    }

    /// Whether its values can be read at the points of a pairing, from the side of a slot.
    fn check_pairing(
        &self,
        pairing: &Pairing,
        points: PointsOfPairs,
        side: Side,
    ) -> Result<(), HistoryMismatch> {
        let (made_for, read_on) = (self.region.clone(), pairing.to_string());
        let is_own = match points {
            PointsOfPairs::Segments => return Err(HistoryMismatch::Segments { read_on }),
            PointsOfPairs::Fixed => self.pairs.as_ref().is_some_and(|own| own.pairing == *pairing),
            PointsOfPairs::Sliding => self.entity == Entity::Facets,
        };
        match (is_own, points) {
            (true, _) if side == Side::Other => Err(HistoryMismatch::Opposite),
            (true, _) => Ok(()),
            (false, PointsOfPairs::Fixed) => Err(HistoryMismatch::Pairs { made_for, read_on }),
            (false, _) => Err(HistoryMismatch::Sliding { made_for, read_on }),
        }
    }
}

impl<const D: usize> Snapshot<'_, D> {
    /// Whether a kernel may read the field `number` on a pairing.
    pub(crate) fn check_on_pairs(
        &self,
        requirements: &Requirements,
        number: usize,
        pairing: &Pairing,
        points: PointsOfPairs,
    ) -> Result<(), HistoryMismatch> {
        let mut slots = requirements.fields.iter().filter(|slot| slot.field == number);
        slots.try_for_each(|slot| self.storage.check_pairing(pairing, points, slot.side))
    }

    /// The components at the q-th point of a unit of a group: an own facet that faces an opposite one.
    pub(crate) fn at_pair(
        &self,
        group: &PairGroup<D>,
        unit: usize,
        q: usize,
    ) -> Result<&[f64], HistoryMismatch> {
        let (storage, facets) = (self.storage, group.facets[unit]);
        if storage.pairs.is_none()
            && let Some(place) = group.rule_points.get(unit * group.count + q)
        {
            return self.at(facets[0].cell, Some(facets[0].local), usize::from(*place));
        }
        let range = storage.pairs.as_ref().and_then(|pairs| pairs.ranges.get(&facets));
        let point =
            range.map(|range| range.start + q).filter(|point| range.is_some_and(|r| r.contains(point)));
        let Some(point) = point else {
            let Facet { cell, local } = facets[0];
            let what = format!("facet {local} of cell {cell}");
            return Err(HistoryMismatch::Region {
                entity: "the pairs",
                region: storage.region.clone(),
                what,
            });
        };
        let start = point * storage.components;
        Ok(&self.values[start..start + storage.components])
    }
}

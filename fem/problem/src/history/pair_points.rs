//! Histories at the points of contact pairs: values that belong to one pairing of fixed points and one rule.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::{Arc, RwLock};

use forms_core::contract::{Entity, Pairing, Requirements, Side};

use super::{HistoryMismatch, PointStorage, Snapshot, State};
use crate::assemble::Assembler;
use crate::mesh::Facet;
use crate::pairs::PairError;

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
        let pairs = assembler.pairs_of(pairing, degree)?;
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
            degree,
            quadrature: assembler.quadrature().clone(),
            components: initial.len(),
            entities: vec![],
            starts: vec![0],
            pairs: Some(PairPoints { pairing: pairing.clone(), ranges }),
            state: RwLock::new(State { committed, written: None, commits: 0 }),
        })
    }

    /// Whether its values can be read at the points of a pairing, from the side of a slot.
    fn check_pairing(&self, pairing: &Pairing, side: Side) -> Result<(), HistoryMismatch> {
        match &self.pairs {
            Some(own) if own.pairing != *pairing => Err(self.elsewhere(pairing)),
            None => Err(self.elsewhere(pairing)),
            Some(_) if side == Side::Other => Err(HistoryMismatch::Opposite),
            Some(_) => Ok(()),
        }
    }

    fn elsewhere(&self, pairing: &Pairing) -> HistoryMismatch {
        HistoryMismatch::Pairs { made_for: self.region.clone(), read_on: pairing.to_string() }
    }
}

impl<const D: usize> Snapshot<'_, D> {
    /// Whether a kernel may read the field `number` on a pairing.
    pub(crate) fn check_on_pairs(
        &self,
        requirements: &Requirements,
        number: usize,
        pairing: &Pairing,
    ) -> Result<(), HistoryMismatch> {
        let mut slots = requirements.fields.iter().filter(|slot| slot.field == number);
        slots.try_for_each(|slot| self.storage.check_pairing(pairing, slot.side))
    }

    /// The components at the q-th point of an own facet that face an opposite one.
    pub(crate) fn at_pair(&self, facets: [Facet; 2], q: usize) -> Result<&[f64], HistoryMismatch> {
        let storage = self.storage;
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

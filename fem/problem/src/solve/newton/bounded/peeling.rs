//! Sets that shrink slowly: whole steps free one layer of nodes at a time, since reactions that draw off are at the edge of the set. After
//! some layers the next steps free 2, 4, 8, ... of them. Unknowns that were freed too early are beyond their bounds in the next iterate, which holds
//! them again, all at once.

use std::sync::Arc;

use super::{ActiveSet, Way};
use crate::linear_algebra::{CsrMatrix, SparsityPattern};
use crate::solve::newton::FreeEquations;

/// Steps in a row that free unknowns, before more layers are freed.
const STEPS: usize = 3;

/// A step frees unknowns where it holds at most one for as many that it frees.
const FREED_PER_HELD: usize = 2;

/// The largest number of layers is 2 to this power.
const LARGEST: usize = 20;

/// One step frees one of this many held unknowns at most.
const LARGEST_PART: usize = 4;

/// The course of the set's size.
#[derive(Debug, Default)]
pub(super) struct Peeling {
    pattern: Option<Arc<SparsityPattern>>,
    /// Steps in a row that freed unknowns.
    shrinking: usize,
    /// Whether the last step did.
    shrinks: bool,
    /// Whether unknowns are held again that were freed with layers.
    grows_back: bool,
    /// The size of the set before its layers were freed, if the last step did so.
    before: Option<usize>,
    /// The layers that were freed last.
    layers: usize,
    /// The most layers, if as many came back whole.
    most: Option<usize>,
}

impl Peeling {
    // By its pattern unknowns are neighbours.
    pub fn keep_pattern(&mut self, matrix: &CsrMatrix) {
        if !self.pattern.as_ref().is_some_and(|known| Arc::ptr_eq(known, matrix.pattern())) {
            self.pattern = Some(matrix.pattern().clone());
        }
    }

    /// Entry of a step that freed and held some unknowns, with the number that is held now. True if freed layers came back whole.
    pub fn enter(&mut self, freed: usize, held: usize, count: usize) -> bool {
        let shrinks = freed > 0 && FREED_PER_HELD * held <= freed;
        let peeled = self.before.take();
        let came_back = peeled.is_some_and(|before| held > 0 && count >= before);
        if came_back {
            self.most = Some(self.layers / 4);
        }
        self.grows_back = !shrinks && (peeled.is_some() || self.grows_back);
        self.shrinking = match shrinks {
            true => self.shrinking + 1,
            // Some layers were too many: fewer of them once the set shrinks again.
            false if self.grows_back => self.shrinking.saturating_sub(2).clamp(1, STEPS - 1),
            false => 0,
        };
        self.shrinks = shrinks;
        came_back
    }

    /// The layers to be freed; fewer than two are left to the steps themselves.
    fn layers(&self) -> usize {
        if !self.shrinks || self.shrinking < STEPS {
            return 0;
        }
        let layers = 1 << (self.shrinking + 1 - STEPS).min(LARGEST);
        let layers = self.most.map_or(layers, |most| layers.min(most));
        if layers < 2 { 0 } else { layers }
    }
}

impl FreeEquations<'_> {
    /// Frees layers of unknowns next to those that the last iterate freed, where the set shrinks slowly.
    pub(in crate::solve::newton) fn peel(&mut self) {
        let Some(set) = &mut self.bounds else { return };
        let freed = set.free_layers();
        for place in &freed {
            self.residuals.reduced[*place] = set.reactions[*place];
        }
        if !freed.is_empty() {
            self.iterates.replace_last_residual(&self.elimination, &self.residuals.reduced);
        }
    }
}

impl ActiveSet {
    /// Frees layers, and gives the places of their unknowns.
    fn free_layers(&mut self) -> Vec<usize> {
        let layers = self.peeling.layers();
        let Some(pattern) = self.peeling.pattern.clone().filter(|_| layers > 0 && self.way == Way::Whole)
        else {
            return vec![];
        };
        let (count, mut all) = (self.count(), vec![]);
        let mut index = vec![usize::MAX; pattern.rows()];
        self.unknowns.iter().enumerate().for_each(|(number, one)| index[one.place] = number);
        let is_restless = |unknown: &usize| self.restless.binary_search(unknown).is_ok();
        let edge = self.unknowns.iter().filter(|one| is_restless(&one.unknown) && one.held.is_none());
        let mut edge: Vec<usize> = edge.map(|one| one.place).collect();
        self.peeling.layers = 0;
        for _ in 0..layers {
            let mut next = vec![];
            for place in &edge {
                for neighbour in &pattern.column_indices()
                    [pattern.row_pointers()[*place]..pattern.row_pointers()[place + 1]]
                {
                    let Some(one) = self.unknowns.get(index[*neighbour as usize]) else { continue };
                    if one.held.is_some() && one.lower < one.upper {
                        next.push(one.place);
                    }
                }
            }
            next.sort_unstable();
            next.dedup();
            if next.is_empty() || LARGEST_PART * (all.len() + next.len()) > count {
                break;
            }
            next.iter().for_each(|place| self.unknowns[index[*place]].held = None);
            all.extend_from_slice(&next);
            edge = next;
            self.peeling.layers += 1;
        }
        if !all.is_empty() {
            self.peeling.before = Some(count);
            let set = self.fingerprint();
            if let Some(last) = self.visits.last_mut() {
                last.set = set;
            }
        }
        all
    }
}

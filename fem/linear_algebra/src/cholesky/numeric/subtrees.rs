//! Parts of the elimination tree that do not depend on each other, side by side on threads.
//!
//! A part is a range of supernodes that have no earlier ones outside of it. What is in no part comes after all of them, in order.

use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use super::pivots::Pivots;
use super::wide::share;
use super::{Numeric, Scratch};
use crate::threads::Threads;

/// Largest load of a thread relative to the mean of all.
const UNEVEN: f64 = 1.1;
/// Most times that a part is cut.
const CUTS: usize = 100;
/// Cost of a product of rows relative to that of its entries \[multiplications\].
const OVERHEAD: f64 = 500.0;
/// Cost of an entry of a product relative to its multiplications \[multiplications\].
const MOVED: f64 = 8.0;

/// A range of supernodes with the cost of their factorisation.
#[derive(Clone, Debug, PartialEq)]
struct Part {
    range: Range<usize>,
    cost: f64,
}

/// Ranges of supernodes whose dependences lie within them.
struct Tree {
    /// The first supernode that each depends on, over others too.
    first: Vec<u32>,
    /// Cost of each and all before it.
    cost: Vec<f64>,
}

impl Tree {
    fn part(&self, range: Range<usize>) -> Part {
        let cost = self.cost[range.end] - self.cost[range.start];
        Part { range, cost }
    }

    /// The parts that are left of one without its last supernode. Neighbours of little cost stay together.
    fn cut(&self, part: &Part, little: f64) -> Vec<Part> {
        let mut found: Vec<Part> = vec![];
        let mut end = part.range.end - 1;
        while end > part.range.start {
            let mut at = end - 1;
            let mut first = self.first[at] as usize;
            while at > first {
                at -= 1;
                first = first.min(self.first[at] as usize);
            }
            match found.last_mut() {
                Some(later) if later.cost < little => *later = self.part(first..later.range.end),
                _ => found.push(self.part(first..end)),
            }
            end = first;
        }
        found
    }

    /// Parts for n threads to share, the most costly first: the most costly is cut until the shares are nearly even (Geist and
    /// Ng 1989).
    fn parts(&self, threads: usize) -> Vec<Part> {
        let mut parts = vec![self.part(0..self.first.len())];
        let little = parts[0].cost / (32 * threads) as f64;
        for _ in 0..CUTS {
            let mut loads = vec![0.0_f64; threads];
            for part in &parts {
                if let Some(least) = loads.iter_mut().min_by(|a, b| a.total_cmp(b)) {
                    *least += part.cost;
                }
            }
            let most = loads.iter().copied().fold(0.0, f64::max);
            if most * threads as f64 <= UNEVEN * loads.iter().sum::<f64>() || parts[0].cost < little {
                break;
            }
            let heaviest = parts.swap_remove(0);
            parts.extend(self.cut(&heaviest, little));
            parts.sort_by(|a, b| b.cost.total_cmp(&a.cost).then(a.range.start.cmp(&b.range.start)));
            if parts.is_empty() {
                break;
            }
        }
        parts
    }
}

impl<P: Pivots> Numeric<'_, P> {
    /// Factors into the values; an error is the place in the elimination order of the first pivot that is not taken.
    pub(in crate::cholesky) fn factorise(&self, threads: Threads, values: &mut [f64]) -> Result<(), usize> {
        let count = self.symbolic.n_supernodes();
        let mut scratch = Scratch::default();
        let parts = match threads == Threads::ONE || count == 0 {
            true => vec![],
            false => self.tree().parts(threads.count()),
        };
        self.factor_parts(threads, &parts, values, &mut scratch)?;
        scratch.handed_over = 0;
        let mut ranges: Vec<Range<usize>> = parts.into_iter().map(|part| part.range).collect();
        ranges.sort_unstable_by_key(|range| range.start);
        let mut ranges = ranges.into_iter().peekable();
        let mut supernode = 0;
        while supernode < count {
            if let Some(range) = ranges.next_if(|range| range.start == supernode) {
                supernode = range.end;
                continue;
            }
            let place = self.values(supernode..supernode + 1);
            let (known, later) = values.split_at_mut(place.start);
            scratch.prefault(place.start, place.len(), later);
            self.supernode(supernode, threads, (0, known), &mut later[..place.len()], &mut scratch)?;
            supernode += 1;
        }
        Ok(())
    }

    /// Factors parts side by side, each on one thread. What fails is the first pivot that fails in any.
    fn factor_parts(
        &self,
        threads: Threads,
        parts: &[Part],
        values: &mut [f64],
        scratch: &mut Scratch,
    ) -> Result<(), usize> {
        let mut by_place: Vec<usize> = (0..parts.len()).collect();
        by_place.sort_unstable_by_key(|part| parts[*part].range.start);
        let mut blocks = vec![];
        let (mut rest, mut start) = (values, 0);
        for part in by_place {
            let place = self.values(parts[part].range.clone());
            let (block, others) = rest[place.start - start..].split_at_mut(place.len());
            blocks.push((part, block));
            (rest, start) = (others, place.end);
        }
        blocks.sort_unstable_by_key(|(part, _)| *part);
        let failed: Mutex<Option<usize>> = Mutex::new(None);
        share(threads, blocks, scratch, |(part, block), scratch| {
            let range = parts[part].range.clone();
            let start = self.values(range.clone()).start;
            scratch.handed_over = start;
            for supernode in range {
                let place = self.values(supernode..supernode + 1);
                let (known, later) = block.split_at_mut(place.start - start);
                scratch.prefault(place.start, place.len(), later);
                let own = &mut later[..place.len()];
                if let Err(column) = self.supernode(supernode, Threads::ONE, (start, known), own, scratch) {
                    let mut failed = failed.lock().unwrap_or_else(PoisonError::into_inner);
                    *failed = Some(failed.map_or(column, |other| other.min(column)));
                    return;
                }
            }
        });
        failed.into_inner().unwrap_or_else(PoisonError::into_inner).map_or(Ok(()), Err)
    }

    /// Dependencies of supernodes, and their costs.
    fn tree(&self) -> Tree {
        let count = self.symbolic.n_supernodes();
        let (mut first, mut cost) = (Vec::with_capacity(count), vec![0.0]);
        let mut sum = 0.0;
        for s in 0..count {
            let width = self.columns(s).len() as f64;
            let below = self.symbolic.supernode(s).pattern().len() as f64;
            sum += OVERHEAD + 0.5 * width * width * (width / 3.0 + below);
            let mut earliest = s as u32;
            for update in self.updates.of(s) {
                let earlier = update.supernode as usize;
                earliest = earliest.min(first[earlier]);
                let rows = self.symbolic.supernode(earlier).pattern().len() as f64 - f64::from(update.first);
                let moved = f64::from(update.count) * (rows - 0.5 * f64::from(update.count));
                sum += OVERHEAD + moved * (MOVED + self.columns(earlier).len() as f64);
            }
            first.push(earliest);
            cost.push(sum);
        }
        Tree { first, cost }
    }
}

//! The multifrontal method: the numeric part of LLᵀ, on threads.
//!
//! The front of a supernode has the rows of its own columns and those that they reach. Into it go the entries of the
//! matrix and, in the order of the supernodes' numbers, the updates of its children in the elimination tree; its columns
//! are eliminated, and what that changes below them is the update for the parent (Duff and Reid 1983, Liu 1992).
//! Subtrees run beside each other, and the large fronts above them are cut into tiles. No sum depends on either, so that the factor
//! is the same for each number of threads, to the last bit.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use faer::MatMut;

use super::dense_front::{Room, each, eliminate};
use super::elimination_tree::EliminationTree;
use crate::analysis::Analysis;
use crate::large_pages;
use crate::threads::Threads;

/// A thread is given subtrees of at most this part of its share of the work.
const PART: f64 = 0.25;

/// Why there is no factor.
#[derive(Debug)]
pub(super) enum NoFactor {
    /// The first place of the elimination order whose pivot is not positive.
    NotPositive { place: usize },
    /// Memory is too small.
    NoMemory,
}

/// The lower triangle of a front's rows below its columns, by columns.
type Update = Vec<f64>;

struct Fronts<'a> {
    analysis: &'a Analysis,
    tree: EliminationTree,
    /// Values of the reordered lower triangle.
    lower: &'a [f64],
    /// The columns of each supernode.
    columns: Vec<Mutex<&'a mut [f64]>>,
    updates: Vec<Mutex<Update>>,
    /// The first place whose pivot is not positive, as far as is known: what comes after it is not needed.
    failed: AtomicUsize,
    out_of_memory: AtomicBool,
}

/// What a thread needs besides.
struct Worker {
    /// The row in the current front of each row that it has.
    local: Vec<u32>,
    room: Room,
}

impl Worker {
    fn new(size: usize) -> Worker {
        Worker { local: vec![0; size], room: Room::new() }
    }
}

/// Fills `values`, which are zero, with the factor of the matrix whose reordered lower triangle has the values `lower`.
pub(super) fn factor(
    analysis: &Analysis,
    lower: &[f64],
    values: &mut [f64],
    threads: Threads,
) -> Result<(), NoFactor> {
    let supernodes = &analysis.supernodes;
    let count = supernodes.n_supernodes();
    let mut columns = Vec::with_capacity(count);
    let mut rest = values;
    for pair in supernodes.col_ptr_for_val().windows(2).take(count) {
        let (own, further) = std::mem::take(&mut rest).split_at_mut((pair[1] - pair[0]) as usize);
        columns.push(Mutex::new(own));
        rest = further;
    }
    let fronts = Fronts {
        analysis,
        tree: EliminationTree::new(supernodes),
        lower,
        columns,
        updates: (0..count).map(|_| Mutex::new(Update::new())).collect(),
        failed: AtomicUsize::new(usize::MAX),
        out_of_memory: AtomicBool::new(false),
    };
    let mut own = Worker::new(analysis.size());
    if threads == Threads::ONE {
        fronts.tree.order().iter().for_each(|&s| fronts.eliminate(s as usize, &mut own, threads));
    } else {
        let (subtrees, above) = fronts.tree.parts(PART / threads.count() as f64);
        let idle: Mutex<Vec<Worker>> = Mutex::new(Vec::new());
        each(threads, subtrees, |run| {
            let known = locked(&idle).pop();
            let mut worker = known.unwrap_or_else(|| Worker::new(analysis.size()));
            fronts.tree.order()[run].iter().for_each(|&s| {
                fronts.eliminate(s as usize, &mut worker, Threads::ONE);
            });
            locked(&idle).push(worker);
        });
        above.iter().for_each(|&s| fronts.eliminate(s as usize, &mut own, threads));
    }
    if fronts.out_of_memory.into_inner() {
        return Err(NoFactor::NoMemory);
    }
    match fronts.failed.into_inner() {
        usize::MAX => Ok(()),
        place => Err(NoFactor::NotPositive { place }),
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Fronts<'_> {
    /// Eliminates the columns of a supernode whose children have been eliminated.
    fn eliminate(&self, s: usize, worker: &mut Worker, threads: Threads) {
        let supernodes = &self.analysis.supernodes;
        let node = supernodes.supernode(s);
        let (start, pattern) = (node.start(), node.pattern());
        // A subtree that has failed has no update for what is above it.
        if self.failed.load(Ordering::Relaxed) <= start {
            return;
        }
        let count = supernodes.supernode_end()[s] as usize - start;
        let (rows, below) = (count + pattern.len(), pattern.len());
        let mut columns = locked(&self.columns[s]);
        let Some(mut update) = large_pages::zeros_within_memory(below * below) else {
            self.out_of_memory.store(true, Ordering::Relaxed);
            self.failed.store(0, Ordering::Relaxed);
            return;
        };
        for (row, local) in worker.local[start..start + count].iter_mut().enumerate() {
            *local = row as u32;
        }
        for (row, &place) in pattern.iter().enumerate() {
            worker.local[place as usize] = (count + row) as u32;
        }
        for (column, place) in columns.chunks_exact_mut(rows).zip(start..) {
            let entries = self.analysis.lower_pointers[place] as usize
                ..self.analysis.lower_pointers[place + 1] as usize;
            for (&row, &value) in self.analysis.lower_rows[entries.clone()].iter().zip(&self.lower[entries]) {
                column[worker.local[row as usize] as usize] += value;
            }
        }
        let mut places: Vec<u32> = Vec::new();
        for &child in self.tree.children(s) {
            let child_update = std::mem::take(&mut *locked(&self.updates[child as usize]));
            places.clear();
            let pattern = supernodes.supernode(child as usize).pattern();
            places.extend(pattern.iter().map(|&row| worker.local[row as usize]));
            for (j, from) in child_update.chunks_exact(places.len().max(1)).enumerate() {
                let column = places[j] as usize;
                let target = match column < count {
                    true => &mut columns[column * rows..(column + 1) * rows],
                    false => &mut update[(column - count) * below..(column + 1 - count) * below],
                };
                let shift = if column < count { 0 } else { count as u32 };
                for (&place, value) in places[j..].iter().zip(&from[j..]) {
                    target[(place - shift) as usize] += value;
                }
            }
        }
        let result = eliminate(
            MatMut::from_column_major_slice_mut(&mut columns[..], rows, count),
            MatMut::from_column_major_slice_mut(&mut update[..], below, below),
            &mut worker.room,
            threads,
        );
        match result {
            Ok(()) => *locked(&self.updates[s]) = update,
            Err(column) => {
                self.failed.fetch_min(start + column, Ordering::Relaxed);
            }
        }
    }
}

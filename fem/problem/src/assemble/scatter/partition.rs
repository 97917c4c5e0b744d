//! Partition of the entities of a group, and of the rows that they touch, among threads.
//!
//! Each thread takes a run of entities. A row belongs to the first thread that touches it, which adds to it at once;
//! the others keep their contributions, and these are added afterwards, thread by thread. So each entry receives its
//! contributions in the order of the entities, as on one thread. Because nodes are numbered in the order of their first
//! use along the walk, the rows of a thread follow each other, and few rows are touched by two threads.

use std::ops::Range;

use crate::threads::Threads;

/// Runs of entities begin at multiples of this, so that lanes fill alike for every number of threads.
const ALIGNMENT: usize = 64;

/// Fewer entities are not worth a thread.
const SMALLEST: usize = 256;

/// The entities and the rows of each thread.
pub(in crate::assemble) struct Partition {
    pub entities: Vec<Range<usize>>,
    /// Ascending, without gaps: no thread before the k-th touches a row of `rows[k]`.
    pub rows: Vec<Range<usize>>,
}

impl Partition {
    /// A division of `count` entities whose rows `rows_of` tells, of `row_count` rows in all.
    pub fn new<'n>(
        count: usize,
        threads: Threads,
        row_count: usize,
        rows_of: impl Fn(usize) -> &'n [u32] + Sync,
    ) -> Self {
        let entities = runs(count, threads.count());
        let mut rows = Vec::with_capacity(entities.len());
        let mut start = 0;
        for end in ends(&entities, threads, rows_of) {
            let end = start.max(end);
            rows.push(start..end);
            start = end;
        }
        rows.push(start..row_count);
        Partition { entities, rows }
    }
}

/// The row after the last one that each run but the last touches. All threads look, each through its part of the entities.
fn ends<'n>(
    runs: &[Range<usize>],
    threads: Threads,
    rows_of: impl Fn(usize) -> &'n [u32] + Sync,
) -> Vec<usize> {
    let (runs, count) = (&runs[..runs.len() - 1], runs[runs.len() - 1].start);
    let parts = threads.for_work(count);
    let parts = (0..parts).map(|part| part * count / parts..(part + 1) * count / parts).collect();
    let found = threads.run(parts, |part: Range<usize>| {
        let end = |run: &Range<usize>| {
            let mut end = 0;
            for entity in run.start.max(part.start)..run.end.min(part.end) {
                for row in rows_of(entity) {
                    end = end.max(row + 1);
                }
            }
            end as usize
        };
        runs.iter().map(end).collect::<Vec<_>>()
    });
    (0..runs.len()).map(|run| found.iter().map(|ends| ends[run]).max().unwrap_or(0)).collect()
}

/// Runs of entities for at most the given number of threads; at least one.
pub(in crate::assemble) fn runs(count: usize, threads: usize) -> Vec<Range<usize>> {
    let parts = threads.min(count / SMALLEST).max(1);
    let start = |part: usize| match part == parts {
        true => count,
        false => part * count / parts / ALIGNMENT * ALIGNMENT,
    };
    (0..parts).map(|part| start(part)..start(part + 1)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_aligned_and_cover_everything() {
        for (count, threads) in [(0, 3), (1, 2), (255, 4), (1000, 3), (4096, 5)] {
            let runs = runs(count, threads);
            assert!(!runs.is_empty() && runs.len() <= threads);
            assert_eq!((runs[0].start, runs[runs.len() - 1].end), (0, count));
            for pair in runs.windows(2) {
                assert_eq!(pair[0].end, pair[1].start);
                assert_eq!(pair[0].end % ALIGNMENT, 0);
            }
        }
        assert_eq!(runs(4096, 5).len(), 5);
    }

    #[test]
    fn no_earlier_thread_touches_the_rows_of_a_later_one() {
        // A chain: entity k touches the rows k and k + 1; entity 700 also the last row.
        let rows: Vec<Vec<u32>> =
            (0..1024).map(|k| if k == 700 { vec![k, k + 1, 1030] } else { vec![k, k + 1] }).collect();
        let partition = Partition::new(1024, Threads::new(4), 1031, |entity| &rows[entity][..]);
        assert_eq!(partition.entities, [0..256, 256..512, 512..768, 768..1024]);
        assert_eq!(partition.rows, [0..257, 257..513, 513..1031, 1031..1031]);
    }

    #[test]
    fn threads_that_look_together_find_the_same_rows() {
        // Enough entities that the look is shared; parts and runs end at different places.
        let rows: Vec<[u32; 2]> =
            (0..100_000).map(|k| [k, k + if k % 7919 == 0 { 60_000 } else { 1 }]).collect();
        let partition = Partition::new(100_000, Threads::new(3), 200_000, |entity| &rows[entity][..]);
        let last =
            |run: &Range<usize>| rows[run.clone()].iter().flatten().max().map_or(0, |row| *row as usize + 1);
        let mut start = 0;
        for (run, rows) in partition.entities.iter().zip(&partition.rows).take(2) {
            let end = start.max(last(run));
            assert_eq!(*rows, start..end);
            start = end;
        }
        assert_eq!(partition.rows[2], start..200_000);
    }
}

//! Rows that few columns meet, which are sorted with their repetitions: two cells around a node of an edge, some triangles around a
//! vertex.
//!
//! The place of a column in a row is the number of different columns that are smaller. Comparing all with all finds the number with
//! repetitions, sixteen and more at a time, since distances from the row's own node fit in 16 bits nearly everywhere; equal columns get
//! equal numbers, and what the repetitions are is read off from the numbers that nobody gets.

// Closures and iterator adaptors do not inherit a caller's target features: loops that are to be vectorised are plain.
#![allow(clippy::needless_range_loop)]

use super::sparsity::Cliques;

/// The most columns, with repetitions.
pub(super) const LONGEST: usize = 64;

/// Columns of the cliques around a node, clique after clique.
pub(super) struct ShortRow {
    columns: [u32; LONGEST],
    /// The same less the row's node.
    distances: [i16; LONGEST],
}

impl Default for ShortRow {
    fn default() -> Self {
        ShortRow { columns: [0; LONGEST], distances: [0; LONGEST] }
    }
}

impl ShortRow {
    /// Collects the columns of the cliques around a node, and gives their number; none if they are too many, or too far from the node.
    #[inline(always)]
    pub fn gather(&mut self, cliques: &Cliques, around: &[(u32, u32)], node: u32) -> Option<usize> {
        const HALF: u32 = 1 << 15;
        let (mut count, mut far) = (0, 0);
        for &(clique, _) in around {
            let columns = cliques.columns[clique as usize];
            let end = count + columns.len();
            let (own, distances) = (self.columns.get_mut(count..end)?, self.distances.get_mut(count..end)?);
            for k in 0..columns.len() {
                let distance = columns[k].wrapping_sub(node);
                own[k] = columns[k];
                distances[k] = distance as i16;
                far |= distance.wrapping_add(HALF);
            }
            count = end;
        }
        (far < 2 * HALF).then_some(count)
    }

    /// Sorts so many columns, and gives the number of different ones. What stands behind them in `sorted` means nothing. `ranks` gets
    /// the place of each column that was collected.
    #[inline(always)]
    pub fn sort(&self, count: usize, sorted: &mut [u32; LONGEST], ranks: &mut [u32]) -> usize {
        match count {
            0..=16 => self.count_smaller::<16>(count, sorted, ranks),
            17..=32 => self.count_smaller::<32>(count, sorted, ranks),
            33..=48 => self.count_smaller::<48>(count, sorted, ranks),
            _ => self.count_smaller::<LONGEST>(count, sorted, ranks),
        }
    }

    #[inline(always)]
    fn count_smaller<const LENGTH: usize>(
        &self,
        count: usize,
        sorted: &mut [u32; LONGEST],
        ranks: &mut [u32],
    ) -> usize {
        let mut own = [0_i16; LENGTH];
        own.copy_from_slice(&self.distances[..LENGTH]);
        let mut smaller = [0_u16; LENGTH];
        for k in 0..count {
            let column = own[k];
            // What stands behind the columns gets a number, too, which nothing reads.
            for other in 0..LENGTH {
                smaller[other] += u16::from(column < own[other]);
            }
        }
        let mut taken = [0_u8; LENGTH];
        for k in 0..count {
            taken[usize::from(smaller[k])] = 1;
        }
        // Of each number how many below it are taken: eight sums in one product.
        const EACH: u64 = 0x0101_0101_0101_0101;
        let (mut below, mut before) = ([0_u8; LENGTH], 0);
        for (taken, below) in taken.as_chunks::<8>().0.iter().zip(below.as_chunks_mut::<8>().0) {
            let taken = u64::from_le_bytes(*taken);
            let up_to = taken.wrapping_mul(EACH);
            *below = (up_to - taken + before).to_le_bytes();
            before += (up_to >> 56).wrapping_mul(EACH);
        }
        let ranks = &mut ranks[..count];
        for k in 0..count {
            let rank = u32::from(below[usize::from(smaller[k])]);
            ranks[k] = rank;
            sorted[rank as usize] = self.columns[k];
        }
        (before >> 56) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repeated_columns_are_sorted_once() {
        for length in 1..=LONGEST {
            for different in [1, 2, 9, 40, 64] {
                let node = 100_000;
                let columns: Vec<u32> =
                    (0..length as u32).map(|k| node - 30_000 + (k % different) * 7_919 % 60_013).collect();
                let mut expected = columns.clone();
                expected.sort_unstable();
                expected.dedup();
                let sets: Vec<&[u32]> = columns.chunks(7).collect();
                let around: Vec<(u32, u32)> = (0..sets.len() as u32).map(|clique| (clique, 0)).collect();
                let cliques = Cliques { rows: sets.clone(), columns: sets };
                let mut row = ShortRow::default();
                assert_eq!(row.gather(&cliques, &around, node), Some(length));
                let (mut sorted, mut ranks) = ([0; LONGEST], vec![0; length]);
                let count = row.sort(length, &mut sorted, &mut ranks);
                assert_eq!(sorted[..count], expected);
                for (column, rank) in columns.iter().zip(ranks) {
                    assert_eq!(sorted[rank as usize], *column);
                }
            }
        }
    }

    #[test]
    fn columns_that_are_far_or_many_are_refused() {
        let node = 100_000;
        for (column, near) in [
            (67_232, true),
            (67_231, false),
            (132_767, true),
            (132_768, false),
            (0, false),
            (u32::MAX, false),
        ] {
            let set = [node, column];
            let cliques = Cliques { rows: vec![&set], columns: vec![&set] };
            assert_eq!(ShortRow::default().gather(&cliques, &[(0, 0)], node), near.then_some(2), "{column}");
        }
        let many: Vec<u32> = (0..=LONGEST as u32).collect();
        let cliques = Cliques { rows: vec![&many], columns: vec![&many] };
        assert_eq!(ShortRow::default().gather(&cliques, &[(0, 0)], 0), None);
    }
}

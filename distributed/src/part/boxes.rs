//! Division of a grid into boxes of about as many blocks, one for each process.

use std::ops::Range;

/// A box of blocks.
pub(super) type Box<const D: usize> = [Range<usize>; D];

/// Boxes of a grid with the given numbers of blocks: halves of halves, across the longest side. None where there are too few blocks.
pub(super) fn boxes<const D: usize>(divisions: [usize; D], count: usize) -> Option<Vec<Box<D>>> {
    let mut found = Vec::with_capacity(count);
    halve(divisions.map(|blocks| 0..blocks), count, &mut found)?;
    Some(found)
}

fn halve<const D: usize>(whole: Box<D>, count: usize, found: &mut Vec<Box<D>>) -> Option<()> {
    if count == 1 {
        found.push(whole);
        return Some(());
    }
    let axis = (0..D).rev().max_by_key(|axis| whole[*axis].len())?;
    let (length, first) = (whole[axis].len(), count / 2);
    if length < 2 {
        return None;
    }
    let lower = ((length * first + count / 2) / count).clamp(1, length - 1);
    let across: usize = whole.iter().map(Range::len).product::<usize>() / length;
    // Each half has processes for its blocks, also if there are few.
    let first = first.max(count.saturating_sub(across * (length - lower))).min(across * lower);
    let cut = whole[axis].start + lower;
    let (mut low, mut high) = (whole.clone(), whole);
    low[axis].end = cut;
    high[axis].start = cut;
    halve(low, first, found)?;
    halve(high, count - first, found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_are_a_partition_of_about_equal_sizes() {
        for (divisions, count) in
            [([8, 8, 8], 1), ([8, 8, 8], 7), ([80, 80, 80], 16), ([3, 1, 2], 6), ([3, 3, 3], 16)]
        {
            let found = boxes(divisions, count).unwrap();
            let size = |one: &Box<3>| one.iter().map(Range::len).product::<usize>();
            let sizes: Vec<usize> = found.iter().map(size).collect();
            assert_eq!((found.len(), sizes.iter().sum::<usize>()), (count, divisions.iter().product()));
            let [least, most] = [sizes.iter().min().unwrap(), sizes.iter().max().unwrap()];
            // Few blocks cannot be shared evenly.
            assert!(*most <= 2 * least + 2, "{sizes:?}");
            for (k, one) in found.iter().enumerate() {
                let meets =
                    |other: &Box<3>| one.iter().zip(other).all(|(a, b)| a.start < b.end && b.start < a.end);
                assert!(!found[..k].iter().any(meets));
            }
        }
        assert_eq!(boxes([2, 1], 3), None);
    }
}

//! Elimination of groups against LU of the whole matrix.

use super::*;
use crate::spectrum::irregular_from;
use crate::vector::norm;
use crate::{LuFactor, SparsityPattern};

/// A chain of n nodes with two unknowns each, and groups of `inside` unknowns between neighbours, numbered in between; with other numbers
/// everywhere, and not symmetric. `diagonal` is that of the last unknown of each group.
fn chain(n: usize, inside: usize, diagonal: f64) -> (CsrMatrix, Groups) {
    let stride = 2 + inside;
    let size = n * 2 + (n - 1) * inside;
    let mut numbers = irregular_from(17, 100 * size);
    let mut number = || numbers.next().unwrap();
    let mut triplets = vec![];
    let mut groups = Groups::default();
    for node in 0..n {
        let own = [node * stride, node * stride + 1];
        triplets.extend(own.map(|k| (k, k, 20.0)));
        if node + 1 == n {
            break;
        }
        let next = [(node + 1) * stride, (node + 1) * stride + 1];
        let group: Vec<usize> = (node * stride + 2..(node + 1) * stride).collect();
        groups.add(0, group.iter().map(|k| *k as u32));
        let all = [&own[..], &next, &group].concat();
        for &i in &all {
            for &j in &all {
                let is_last = i == j && group.last() == Some(&i);
                // The first unknown of a group is not coupled with the first node.
                if group.first() == Some(&j) && own.contains(&i) {
                    continue;
                }
                triplets.push((i, j, if is_last { diagonal } else { number() }));
                if i == j && !is_last && group.contains(&i) {
                    triplets.push((i, j, 5.0));
                }
            }
        }
    }
    (CsrMatrix::from_triplets(size, size, &triplets).unwrap(), groups)
}

fn solve(matrix: &CsrMatrix, b: &[f64], transpose: Transpose) -> Vec<f64> {
    let factor = LuFactor::new(matrix, None).unwrap();
    let mut x = b.to_vec();
    factor.solve_in_place(&mut x, transpose).unwrap();
    x
}

fn relative(a: &[f64], b: &[f64]) -> f64 {
    norm(&a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<_>>()) / norm(b)
}

#[test]
fn groups_are_eliminated_and_recovered_exactly_both_ways() {
    for (n, inside, diagonal) in [(2, 1, 3.0), (9, 3, 6.0), (40, 5, 0.0), (7, 2, -4.0)] {
        let (matrix, groups) = chain(n, inside, diagonal);
        let (elimination, counts) = BlockElimination::new(matrix.pattern(), &groups).unwrap();
        let elimination = elimination.unwrap();
        assert_eq!(counts, Counts { eliminated: (n - 1) * inside, coupled: 0, by_pivots: 0 });
        assert_eq!(elimination.rest().len(), 2 * n);
        let (left, blocks) = elimination.eliminate(Threads::ONE, &matrix).unwrap().unwrap();
        let b: Vec<f64> = irregular_from(5, matrix.rows()).collect();
        for transpose in [Transpose::No, Transpose::Yes] {
            let reduced = elimination.reduce(&blocks, &b, transpose).unwrap();
            let rest = solve(&left, &reduced, transpose);
            let found = elimination.recover(&blocks, &b, &rest, transpose).unwrap();
            let expected = solve(&matrix, &b, transpose);
            assert!(relative(&found, &expected) < 1e-12, "{n} {inside}: {:e}", relative(&found, &expected));
        }
    }
}

#[test]
fn what_is_left_has_the_same_bits_on_any_number_of_threads() {
    let (matrix, groups) = chain(6000, 3, 6.0);
    let elimination = BlockElimination::new(matrix.pattern(), &groups).unwrap().0.unwrap();
    let bits = |threads| {
        let (left, _) = elimination.eliminate(Threads::new(threads), &matrix).unwrap().unwrap();
        left.values().iter().map(|value| value.to_bits()).collect::<Vec<_>>()
    };
    let one = bits(1);
    for threads in [2, 3, 7, 16] {
        assert!(bits(threads) == one, "{threads}");
    }
}

#[test]
fn what_couples_groups_or_has_no_pivot_stays() {
    // Groups {2}, {3} are coupled, {4} is eliminated, {5} has no pivot, and rank 1 gives way to rank 0.
    let entries = [
        (0, 0, 4.0),
        (1, 1, 4.0),
        (0, 1, 1.0),
        (1, 0, 1.0),
        (2, 2, 3.0),
        (3, 3, 3.0),
        (2, 3, 1.0),
        (3, 2, 1.0),
        (0, 2, 1.0),
        (2, 0, 1.0),
        (4, 4, 2.0),
        (0, 4, 1.0),
        (4, 0, 1.0),
        (4, 1, 1.0),
        (1, 4, 1.0),
        (5, 5, 1e-12),
        (5, 1, 1.0),
        (1, 5, 1.0),
        (6, 6, 3.0),
        (6, 4, 1.0),
        (4, 6, 1.0),
    ];
    let matrix = CsrMatrix::from_triplets(7, 7, &entries).unwrap();
    let mut groups = Groups::default();
    groups.add(1, [6]);
    (2..6).for_each(|unknown| groups.add(0, [unknown]));
    let (elimination, counts) = BlockElimination::new(matrix.pattern(), &groups).unwrap();
    assert_eq!(counts, Counts { eliminated: 2, coupled: 3, by_pivots: 0 });
    let Err((next, counts)) = elimination.unwrap().eliminate(Threads::ONE, &matrix).unwrap() else {
        panic!("a pivot of 1e-12");
    };
    assert_eq!(counts, Counts { eliminated: 1, coupled: 3, by_pivots: 1 });
    let next = next.unwrap();
    assert_eq!(next.rest(), [0, 1, 2, 3, 5, 6]);
    let (left, _) = next.eliminate(Threads::ONE, &matrix).unwrap().unwrap();
    // A coupling that the elimination makes: 6 with 0 and 1.
    assert_eq!((left.get(5, 0), left.get(5, 1), left.get(0, 0)), (-0.5, -0.5, 3.5));
}

#[test]
fn parts_of_a_group_that_are_not_coupled_are_judged_separately() {
    let entries = [(0, 0, 1.0), (1, 1, 2.0), (0, 1, 1.0), (1, 0, 1.0), (0, 2, 1.0), (2, 0, 1.0), (2, 2, 0.0)];
    let matrix = CsrMatrix::from_triplets(3, 3, &entries).unwrap();
    let mut groups = Groups::default();
    groups.add(0, [1, 2, 1]);
    let elimination = BlockElimination::new(matrix.pattern(), &groups).unwrap().0.unwrap();
    let Err((Some(next), counts)) = elimination.eliminate(Threads::ONE, &matrix).unwrap() else {
        panic!("a pivot of zero");
    };
    assert_eq!((next.rest(), counts.eliminated, counts.by_pivots), (&[0, 2][..], 1, 1));
}

#[test]
fn nothing_is_eliminated_where_nothing_would_be_left() {
    let matrix = CsrMatrix::from_triplets(2, 2, &[(0, 0, 1.0), (1, 1, 1.0)]).unwrap();
    let mut groups = Groups::default();
    [0, 1, 9].iter().for_each(|unknown| groups.add(0, [*unknown]));
    let (elimination, counts) = BlockElimination::new(matrix.pattern(), &groups).unwrap();
    assert!(elimination.is_none() && counts == Counts::default());
    let other = SparsityPattern::new(2, 3, vec![0, 0, 0], vec![]).unwrap();
    assert!(BlockElimination::new(&Arc::new(other), &groups).is_err());
}

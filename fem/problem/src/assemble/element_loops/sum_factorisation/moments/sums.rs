//! The sums of all pairs of nodes by moments, for some cells at once: code that knows neither kernel nor element but the number of nodes
//! along an axis.

// Closures and iterator adaptors do not inherit a caller's target features, and copies of slices may become calls:
// loops over lane values are plain.
#![allow(clippy::needless_range_loop, clippy::manual_memcpy)]

use super::{MOST_MADE, Made, Moments, Squares, first_pairs, in_order, power};
use crate::lanes::{SharedWork, SimdLane};

/// Numbers for two powers of u along two axes each, or two nodes.
type Square<L, const N: usize> = [[L; N]; N];

/// The arguments of [`Moments::sum`].
pub(super) struct Sums<'a, L, const D: usize> {
    pub moments: &'a Moments,
    pub numbers: &'a [L],
    pub room: &'a mut Vec<L>,
    pub sums: &'a mut [L],
}

impl<L: SimdLane, const D: usize> SharedWork<L> for Sums<'_, L, D> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Moments { nodes, values, .. } = *self.moments;
        // In space there is always something to be done along the first axis alone.
        match (nodes, values || D == 3) {
            (2, true) => self.planes::<2, true>(),
            (2, false) => self.planes::<2, false>(),
            (_, true) => self.planes::<3, true>(),
            (_, false) => self.planes::<3, false>(),
        }
    }
}

impl<L: SimdLane, const D: usize> Sums<'_, L, D> {
    /// `VALUES`: there are squares of functions that are not differentiated along the last two axes.
    #[inline(always)]
    fn planes<const N: usize, const VALUES: bool>(self) {
        let Sums { moments, numbers, room, sums } = self;
        let Moments { factors, planes, squares, mirrored, .. } = moments;
        let (of_pair, inner) = (N.pow(D as u32 - 2), N.pow(2 * (D as u32 - 1)));
        let factors = &[L::splat(factors[0]), L::splat(factors[1])];
        let (numbers, _) = numbers.as_chunks::<N>();
        let (numbers, _) = numbers.as_chunks::<N>();
        for plane in planes {
            let zeros = plane.sources.len() * of_pair;
            let length = (zeros + 1 + MOST_MADE) * N * N;
            if room.len() != length {
                room.clear();
                room.resize(length, L::splat(0.0));
            }
            let (room, _) = room.as_chunks_mut::<N>();
            let (room, _) = room.as_chunks_mut::<N>();
            for pair in 0..plane.sources.len() {
                if let Some(source) = plane.sources[pair] {
                    let source = &numbers[source * of_pair..][..of_pair];
                    moments_of(source, &mut room[pair * of_pair..][..of_pair]);
                }
            }
            let squares = &squares[usize::from(plane.symmetric)];
            let sums = &mut sums[plane.start..];
            if D == 2 {
                let squares = &squares[0].of::<L, N>(room);
                if plane.symmetric {
                    last_axes::<L, N, VALUES, true>(
                        squares,
                        factors,
                        &mut sums[..first_pairs(N, true) * inner],
                    );
                } else {
                    last_axes::<L, N, VALUES, false>(
                        squares,
                        factors,
                        &mut sums[..first_pairs(N, false) * inner],
                    );
                }
            } else {
                let count = first_pairs(N, plane.symmetric);
                for (own, sums) in squares[..count].iter().zip(sums.chunks_exact_mut(inner)) {
                    own.make(room);
                    last_axes::<L, N, VALUES, false>(&own.of::<L, N>(room), factors, sums);
                    for k in 0..N * N {
                        along_first::<L, N>(sums, N * N, k, factors);
                    }
                }
            }
            if plane.symmetric {
                let sums = &mut sums[..first_pairs(N, true) * inner];
                for [own, image] in mirrored {
                    along_first_mirrored::<L, N>(sums, inner, [*own as usize, *image as usize], factors);
                }
            } else {
                let sums = &mut sums[..first_pairs(N, false) * inner];
                for k in 0..inner {
                    along_first::<L, N>(sums, inner, k, factors);
                }
            }
        }
    }
}

impl Squares {
    #[inline(always)]
    fn of<'a, L, const N: usize>(&self, room: &'a [Square<L, N>]) -> [&'a Square<L, N>; 9] {
        let mut squares = [&room[0]; 9];
        for k in 0..9 {
            squares[k] = &room[self.places[k]];
        }
        squares
    }

    /// Makes those that are sums or multiples.
    #[inline(always)]
    fn make<L: SimdLane, const N: usize>(&self, room: &mut [Square<L, N>]) {
        for Made { place, terms } in &self.made {
            let mut sum = [[L::splat(0.0); N]; N];
            for (source, factor) in terms {
                let (source, factor) = (&room[*source], L::splat(*factor));
                for m in 0..N {
                    for n in 0..N {
                        sum[m][n] = source[m][n].multiply_add(factor, sum[m][n]);
                    }
                }
            }
            room[*place] = sum;
        }
    }
}

/// The entries for basis functions along the last axis and powers of u along the one before it, pair after pair of these powers.
#[inline(always)]
fn last_axes<L: SimdLane, const N: usize, const VALUES: bool, const ORDERED: bool>(
    squares: &[&Square<L, N>; 9],
    factors: &[L; 2],
    sums: &mut [L],
) {
    let mut sums = sums.chunks_exact_mut(N * N);
    // Written out: what there is for a pair of powers is known when this is compiled.
    macro_rules! pairs {
        ($($m:literal $n:literal),*) => {
            $(if usize::max($m, $n) < N && ($m <= $n || !ORDERED) && let Some(sums) = sums.next() {
                last_axis::<L, N, VALUES, $m, $n>(squares, factors, sums);
            })*
        };
    }
    pairs!(0 0, 0 1, 0 2, 1 0, 1 1, 1 2, 2 0, 2 1, 2 2);
}

/// The entries for basis functions along the last axis and the powers M and K of u along the one before it.
#[inline(always)]
fn last_axis<L: SimdLane, const N: usize, const VALUES: bool, const M: usize, const K: usize>(
    squares: &[&Square<L, N>; 9],
    factors: &[L; 2],
    sums: &mut [L],
) {
    // By what is done along the last axis: nothing, the derivative of the test function, of the trial function, of both.
    let mut rows = [[L::splat(0.0); N]; 4];
    macro_rules! add {
        ($($last:literal: $test:literal $trial:literal),*) => {
            $(if (M > 0 || $test != 1) && (K > 0 || $trial != 1) && (VALUES || $test * $trial > 0) {
                let (of_test, of_trial) = ($test == 1, $trial == 1);
                let factor = if of_test { M } else { 1 } * if of_trial { K } else { 1 };
                let row = power(M + K - of_test as usize - of_trial as usize, N);
                let square = &squares[3 * $test + $trial][row];
                // Without values there is one for each.
                let first = !VALUES || !(of_test || of_trial);
                for e in 0..N {
                    rows[$last][e] = if first { times(square[e], factor) } else { plus(rows[$last][e], square[e], factor) };
                }
            })*
        };
    }
    add!(0: 0 0, 0: 1 0, 0: 0 1, 0: 1 1, 1: 2 0, 1: 2 1, 2: 0 2, 2: 1 2, 3: 2 2);
    let mut powers = [[L::splat(0.0); N]; N];
    for m in 0..N {
        for n in 0..N {
            let mut entry = rows[0][power(m + n, N)];
            if m > 0 {
                entry = plus(entry, rows[1][power(m + n - 1, N)], m);
            }
            if n > 0 {
                entry = plus(entry, rows[2][power(m + n - 1, N)], n);
            }
            if m > 0 && n > 0 {
                entry = plus(entry, rows[3][power(m + n - 2, N)], m * n);
            }
            powers[m][n] = entry;
        }
    }
    let basis = both_ways(powers, factors);
    let sums = &mut sums[..N * N];
    for m in 0..N {
        for n in 0..N {
            sums[m * N + n] = basis[m][n];
        }
    }
}

/// A small multiple of a number.
#[inline(always)]
fn times<L: SimdLane>(number: L, factor: usize) -> L {
    if factor == 1 { number } else { number * L::splat(factor as f64) }
}

/// A sum and a small multiple of a number.
#[inline(always)]
fn plus<L: SimdLane>(sum: L, number: L, factor: usize) -> L {
    if factor == 1 { sum + number } else { number.multiply_add(L::splat(factor as f64), sum) }
}

/// The k-th numbers of lists of `inner` numbers, one for each pair of indices along an axis, from powers of u to basis functions.
#[inline(always)]
fn along_first<L: SimdLane, const N: usize>(lists: &mut [L], inner: usize, k: usize, factors: &[L; 2]) {
    let mut powers = [[L::splat(0.0); N]; N];
    for m in 0..N {
        for n in 0..N {
            powers[m][n] = lists[(m * N + n) * inner + k];
        }
    }
    let basis = both_ways(powers, factors);
    for m in 0..N {
        for n in 0..N {
            lists[(m * N + n) * inner + k] = basis[m][n];
        }
    }
}

/// The same of a symmetric matrix, where only the lists of pairs in order exist: for a place in a list, and the place with indices
/// exchanged, where the numbers of the other pairs are.
#[inline(always)]
fn along_first_mirrored<L: SimdLane, const N: usize>(
    lists: &mut [L],
    inner: usize,
    [own, image]: [usize; 2],
    factors: &[L; 2],
) {
    assert!(own < inner && image < inner && lists.len() == first_pairs(N, true) * inner);
    let place = |m: usize, n: usize| match m <= n {
        true => in_order(N, m, n) * inner + own,
        false => in_order(N, n, m) * inner + image,
    };
    let mut powers = [[L::splat(0.0); N]; N];
    for m in 0..N {
        for n in 0..N {
            powers[m][n] = lists[place(m, n)];
        }
    }
    let basis = both_ways(powers, factors);
    for m in 0..N {
        for n in 0..N {
            lists[place(m, n)] = basis[m][n];
        }
    }
}

/// Moments of the numbers at a grid of points, at the same places by powers along the axes.
#[inline(always)]
fn moments_of<L: SimdLane, const N: usize>(source: &[Square<L, N>], target: &mut [Square<L, N>]) {
    for k in 0..source.len() {
        let mut square = source[k];
        for m in 0..N {
            square[m] = sums_of_powers(square[m]);
        }
        for n in 0..N {
            let mut column = square[0];
            for m in 0..N {
                column[m] = square[m][n];
            }
            let column = sums_of_powers(column);
            for m in 0..N {
                square[m][n] = column[m];
            }
        }
        target[k] = square;
    }
    if let Some(target) = target.first_chunk_mut::<N>() {
        for m in 0..N {
            for n in 0..N {
                let mut column = target[0][0];
                for k in 0..N {
                    column[k] = target[k][m][n];
                }
                let column = sums_of_powers(column);
                for k in 0..N {
                    target[k][m][n] = column[k];
                }
            }
        }
    }
}

/// Σ of number × u^k over the points of an axis.
#[inline(always)]
fn sums_of_powers<L: SimdLane, const N: usize>(numbers: [L; N]) -> [L; N] {
    let mut sums = numbers;
    let both = numbers[0] + numbers[N - 1];
    sums[1] = numbers[N - 1] - numbers[0];
    if N == 2 {
        sums[0] = both;
    } else {
        (sums[0], sums[2]) = (both + numbers[1], both);
    }
    sums
}

/// A matrix of powers of u along rows and columns as that of the basis functions.
#[inline(always)]
fn both_ways<L: SimdLane, const N: usize>(mut matrix: Square<L, N>, factors: &[L; 2]) -> Square<L, N> {
    for m in 0..N {
        matrix[m] = to_nodes(matrix[m], factors);
    }
    for n in 0..N {
        let mut column = [L::splat(0.0); N];
        for m in 0..N {
            column[m] = matrix[m][n];
        }
        let column = to_nodes(column, factors);
        for m in 0..N {
            matrix[m][n] = column[m];
        }
    }
    matrix
}

/// Numbers linear in a function, given of powers of u, as those of the basis functions along an axis.
#[inline(always)]
fn to_nodes<L: SimdLane, const N: usize>(powers: [L; N], [even, odd]: &[L; 2]) -> [L; N] {
    let mut basis = powers;
    let half = powers[if N == 2 { 0 } else { 2 }] * *even;
    basis[0] = powers[1].multiply_add(-*odd, half);
    basis[N - 1] = powers[1].multiply_add(*odd, half);
    if N == 3 {
        basis[1] = half.multiply_add(L::splat(-2.0), powers[0]);
    }
    basis
}

//! Lane types against plain numbers.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lanes are plain.
#![allow(clippy::needless_range_loop)]

use super::instruction_set::InLanes;
use super::*;

/// The sets of this machine, those that kernels are not compiled for in this profile included.
fn of_machine() -> Vec<InstructionSet> {
    InstructionSet::ALL.into_iter().filter(|set| set.is_of_machine()).collect()
}

/// Some work in the lanes of a set of this machine.
fn run_in<W: LaneWork>(set: InstructionSet, work: W) -> W::Output {
    match set {
        #[cfg(target_arch = "x86_64")]
        InstructionSet::Avx512 if set.is_of_machine() => x86::Avx512::call(InLanes(work)),
        #[cfg(target_arch = "x86_64")]
        InstructionSet::Avx2 if set.is_of_machine() => x86::Avx2::call(InLanes(work)),
        set => set.checked().run_without_kernel(work),
    }
}

/// Each operation on 64 numbers, in a set's lanes.
struct Operations<'a> {
    a: &'a [f64],
    b: &'a [f64],
}

impl LaneWork for Operations<'_> {
    type Output = Vec<Vec<f64>>;

    #[inline(always)]
    fn run<L: SimdLane>(self) -> Self::Output {
        let mut results = vec![vec![0.0; self.a.len()]; 16];
        for start in (0..self.a.len()).step_by(L::WIDTH) {
            let (a, b) = (L::load(&self.a[start..]), L::load(&self.b[start..]));
            let less = a.less(b);
            let values = [
                a + b,
                a - b,
                a * b,
                a / b,
                -a,
                a.abs(),
                a.abs().sqrt(),
                a.powi(3),
                b.powi(-2),
                a.minimum(b),
                a.maximum(b),
                L::select(less, a, b),
                L::select(L::not(L::or(less, a.equal(b))), a, b),
                L::select(L::and(a.less_equal(b), b.less_equal(a)), a, b),
                a.exp(),
                a.abs().powf(b),
            ];
            for (value, result) in values.iter().zip(&mut results) {
                value.store(&mut result[start..]);
            }
        }
        results
    }
}

fn numbers(seed: u64) -> Vec<f64> {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    let mut numbers: Vec<f64> = (0..60).map(|_| 3.0 * next()).collect();
    numbers.extend([0.0, -0.0, f64::NAN, f64::INFINITY]);
    numbers
}

#[test]
fn all_sets_compute_what_plain_numbers_do() {
    let (a, mut b) = (numbers(1), numbers(2));
    b[7] = a[7];
    let expected = run_in(InstructionSet::Plain, Operations { a: &a, b: &b });
    for set in of_machine() {
        let found = run_in(set, Operations { a: &a, b: &b });
        for (operation, (found, expected)) in found.iter().zip(&expected).enumerate() {
            for (k, (x, y)) in found.iter().zip(expected).enumerate() {
                let close = (x - y).abs() <= 4.0 * f64::EPSILON * y.abs();
                assert!(
                    x == y || close || (x.is_nan() && y.is_nan()),
                    "{set}, operation {operation}, entry {k}: {x}, not {y}"
                );
            }
        }
    }
}

struct Logarithms<'a>(&'a [f64]);

impl LaneWork for Logarithms<'_> {
    type Output = Vec<f64>;

    #[inline(always)]
    fn run<L: SimdLane>(self) -> Vec<f64> {
        let mut result = vec![0.0; self.0.len()];
        for start in (0..self.0.len()).step_by(L::WIDTH) {
            L::load(&self.0[start..]).ln().store(&mut result[start..]);
        }
        result
    }
}

#[test]
fn logarithms_are_right_to_two_units_in_the_last_place() {
    let mut numbers =
        vec![1.0, 2.0, 0.5, std::f64::consts::SQRT_2, 1.0 + f64::EPSILON, 1.0 - f64::EPSILON, 1e300, 1e-300];
    for k in 0..80_000 {
        let t = f64::from(k) / 8e4;
        numbers.push(0.3 + 2.0 * t);
        numbers.push((1200.0 * (t - 0.5)).exp2().min(1e308));
    }
    // Lanes without a logarithm are next to ordinary ones.
    numbers.extend([0.0, -1.0, f64::INFINITY, f64::NAN, 5e-324, 3.0, -0.0, 7.0]);
    for set in of_machine() {
        for (x, found) in numbers.iter().zip(run_in(set, Logarithms(&numbers))) {
            let expected = x.ln();
            let close = (found - expected).abs() <= 2.0 * f64::EPSILON * expected.abs();
            assert!(
                found == expected || close || (found.is_nan() && expected.is_nan()),
                "{set}: ln {x} = {found}, not {expected}"
            );
        }
    }
}

struct Transposition {
    count: usize,
    filled: usize,
}

impl LaneWork for Transposition {
    type Output = (usize, Vec<f64>);

    #[inline(always)]
    fn run<L: SimdLane>(self) -> Self::Output {
        let mut entries = Vec::new();
        for k in 0..self.count {
            let mut lanes = [0.0; WIDEST];
            for lane in 0..L::WIDTH {
                lanes[lane] = (100 * lane + k) as f64;
            }
            entries.push(L::load(&lanes));
        }
        let filled = self.filled.min(L::WIDTH);
        let mut target = vec![-1.0; filled * (self.count + 3)];
        L::store_transposed::<false>(&entries[..], filled, &mut target, self.count + 3);
        // Adding the same once more doubles it.
        L::store_transposed::<true>(&entries[..], filled, &mut target, self.count + 3);
        (filled, target)
    }
}

#[test]
fn transposed_lanes_stand_one_after_the_other() {
    for set in of_machine() {
        for count in [1, 2, 3, 4, 6, 9, 13, 36] {
            for filled in [1, 3, 8] {
                let (filled, found) = run_in(set, Transposition { count, filled });
                for (index, value) in found.iter().enumerate() {
                    let (lane, k) = (index / (count + 3), index % (count + 3));
                    let expected = if k < count { 2.0 * (100 * lane + k) as f64 } else { -1.0 };
                    assert!(lane < filled && *value == expected, "{set}: lane {lane}, entry {k}: {value}");
                }
            }
        }
    }
}

/// Entries in another order, of all lanes.
struct Reordered<'a>(&'a [u32]);

impl LaneWork for Reordered<'_> {
    type Output = (usize, Vec<f64>);

    #[inline(always)]
    fn run<L: SimdLane>(self) -> Self::Output {
        let mut entries = Vec::new();
        for k in 0..self.0.len() {
            let mut lanes = [0.0; WIDEST];
            for lane in 0..L::WIDTH {
                lanes[lane] = (100 * lane + k) as f64;
            }
            entries.push(L::load(&lanes));
        }
        let order = Order::new(self.0.to_vec(), L::WIDTH);
        let mut target = vec![-1.0; L::WIDTH * self.0.len()];
        let source = Ordered::new(&entries, &order, self.0.len());
        L::store_transposed::<false>(source, L::WIDTH, &mut target, self.0.len());
        (L::WIDTH, target)
    }
}

#[test]
fn entries_come_out_in_their_order() {
    for count in [1, 3, 4, 7, 9, 16, 37] {
        // All places, each once: 5 is no divisor of a count.
        let places: Vec<u32> = (0..count).map(|k| (5 * k + 2) % count).collect();
        for set in of_machine() {
            let (lanes, found) = run_in(set, Reordered(&places));
            for (index, value) in found.iter().enumerate() {
                let (lane, k) = (index / places.len(), index % places.len());
                let expected = (100 * lane) as f64 + f64::from(places[k]);
                assert!(lane < lanes && *value == expected, "{set}: lane {lane}, entry {k}: {value}");
            }
        }
    }
}

/// COUNT entries of all lanes, compared with what is there.
struct Few<const COUNT: usize>;

impl<const COUNT: usize> LaneWork for Few<COUNT> {
    type Output = Vec<f64>;

    #[inline(always)]
    fn run<L: SimdLane>(self) -> Self::Output {
        let mut entries = [L::splat(0.0); COUNT];
        for k in 0..COUNT {
            let mut lanes = [0.0; WIDEST];
            for lane in 0..L::WIDTH {
                lanes[lane] = (100 * lane + k) as f64;
            }
            entries[k] = L::load(&lanes);
        }
        // No room beyond the last.
        let mut target = vec![-1.0; (L::WIDTH - 1) * 9 + 2 + COUNT];
        L::store_few(entries, &mut target, 2, 9);
        target
    }
}

fn few<const COUNT: usize>() {
    for set in of_machine() {
        for (index, value) in run_in(set, Few::<COUNT>).iter().enumerate() {
            let (lane, k) = (index / 9, index % 9);
            let inside = (2..2 + COUNT).contains(&k);
            let expected = if inside { (100 * lane + k - 2) as f64 } else { -1.0 };
            assert!(*value == expected, "{set}: {COUNT} entries, lane {lane}, place {k}: {value}");
        }
    }
}

#[test]
fn a_few_entries_stand_side_by_side() {
    few::<1>();
    few::<2>();
    few::<3>();
    few::<4>();
    few::<7>();
}

/// COUNT entries from each lane's place, and from the starts of lists of seven.
struct Gathered<'a, const COUNT: usize> {
    values: &'a [f64],
    places: &'a [usize; WIDEST],
    filled: usize,
}

impl<const COUNT: usize> LaneWork for Gathered<'_, COUNT> {
    type Output = (usize, Vec<Vec<f64>>);

    #[inline(always)]
    fn run<L: SimdLane>(self) -> Self::Output {
        let filled = self.filled.min(L::WIDTH);
        let starts = Starts::new::<L>(2, filled, 7);
        let (listed, from) =
            (L::gather::<COUNT>(self.values, self.places), L::gather_from(self.values, &starts, 3));
        let mut found = Vec::new();
        for entries in [listed, from] {
            let mut lanes = [0.0; WIDEST];
            for k in 0..COUNT {
                entries[k].store(&mut lanes);
                found.push(lanes[..L::WIDTH].to_vec());
            }
        }
        (filled, found)
    }
}

fn gathers<const COUNT: usize>() {
    let values: Vec<f64> = (0..69 + COUNT).map(|k| k as f64).collect();
    let places = [3, 0, 69, 11, 12, 12, 40, 5];
    for set in of_machine() {
        for filled in [1, 3, 8] {
            let (filled, found) = run_in(set, Gathered::<COUNT> { values: &values, places: &places, filled });
            for (index, lanes) in found.iter().enumerate() {
                for (lane, value) in lanes.iter().enumerate() {
                    // Lanes that are not filled repeat the last cell.
                    let start = 7 * (2 + lane.min(filled - 1)) + 3;
                    let place = if index < COUNT { places[lane] } else { start };
                    assert_eq!(
                        *value,
                        (place + index % COUNT) as f64,
                        "{set}, entry {index} of {COUNT}, lane {lane}"
                    );
                }
            }
        }
    }
}

#[test]
fn gathered_entries_stand_in_their_lanes() {
    gathers::<1>();
    gathers::<2>();
    gathers::<3>();
    gathers::<4>();
}

#[test]
fn the_best_set_is_one_that_was_compiled() {
    assert!(InstructionSet::best().is_available());
    assert_eq!(InstructionSet::available().last(), Some(&InstructionSet::best()));
    assert!(InstructionSet::available().iter().all(|set| InstructionSet::compiled().contains(set)));
}

//! Instruction sets: how many cells a kernel computes at once, chosen when the program starts.
//!
//! Kernels are generic over [`Lane`]. `with_lanes!` chooses the lane type of a set, and `SimdLane::call` enters a function that was
//! compiled for the set; everything below that function is inlined into it, so that the compiler may use
//! the set's instructions. What is not inlined would still be right, only slow.

#![allow(unsafe_code)]
// Closures and iterator adaptors do not inherit a caller's target features: loops over lanes are plain.
#![allow(clippy::needless_range_loop)]

mod instruction_set;
#[cfg(target_arch = "x86_64")]
mod logarithm;
mod moving;
#[cfg(target_arch = "aarch64")]
mod neon;
mod ordered;
mod placed;
mod slope;
#[cfg(target_arch = "x86_64")]
mod x86;

use forms_core::contract::Lane;

pub use self::instruction_set::InstructionSet;
pub(crate) use self::instruction_set::{Checked, with_lanes};
pub(crate) use self::moving::Moving;
#[cfg(target_arch = "aarch64")]
pub(crate) use self::neon::Neon;
pub(crate) use self::ordered::{Order, Ordered};
pub(crate) use self::placed::{PairPlaces, PlacedBlocks};
pub(crate) use self::slope::{Both, SimdSlope};
#[cfg(all(target_arch = "x86_64", not(without_avx2)))]
pub(crate) use self::x86::Avx2;
#[cfg(all(target_arch = "x86_64", not(without_avx512)))]
pub(crate) use self::x86::Avx512;

/// No lane type of any instruction set has more lanes.
pub(crate) const WIDEST: usize = 8;

/// Work that can be run with any lane type.
pub(crate) trait LaneWork {
    /// The result.
    type Output;
    /// Does the work. Implementations are `#[inline(always)]`, and so is all that they do per lane.
    fn run<L: SimdLane>(self) -> Self::Output;
}

/// Work with one lane type in a function of its own, which many callers use.
pub(crate) trait SharedWork<L> {
    /// The result.
    type Output;
    /// Does the work; `#[inline(always)]`, as in [`LaneWork`].
    fn run(self) -> Self::Output;
}

/// A lane type with gather, scatter and transposition between memory and lanes.
pub(crate) trait SimdLane: Lane {
    /// Number of values that the processor's registers hold.
    const REGISTERS: usize;

    /// Whether a few entries at a time go to memory by [`SimdLane::store_few`] from the registers where they were made: quicker than all of
    /// them at the end where few shuffles part the lanes.
    const STORES_FEW: bool = false;

    /// Whether a mask holds in some lane.
    #[inline(always)]
    fn any(mask: Self::Mask) -> bool {
        let mut lanes = [0.0; WIDEST];
        Self::select(mask, Self::splat(1.0), Self::splat(0.0)).store(&mut lanes);
        let mut any = false;
        for lane in 0..Self::WIDTH {
            any |= lanes[lane] != 0.0;
        }
        any
    }

    /// Runs some work in a function compiled for the lane type's instructions that is not inlined: what does
    /// not depend on the kernel is compiled once for all kernels.
    fn call<W: SharedWork<Self>>(work: W) -> W::Output;

    /// `COUNT` successive entries of `values` from `places[lane]` on, lane by lane; the first [`Lane::WIDTH`]
    /// places are read.
    ///
    /// # Panics
    /// When a place is out of range.
    #[inline(always)]
    fn gather<const COUNT: usize>(values: &[f64], places: &[usize; WIDEST]) -> [Self; COUNT] {
        let mut entries = [Self::splat(0.0); COUNT];
        let mut lanes = [0.0; WIDEST];
        for k in 0..COUNT {
            for lane in 0..Self::WIDTH {
                lanes[lane] = values[places[lane] + k];
            }
            entries[k] = Self::load(&lanes);
        }
        entries
    }

    /// [`SimdLane::gather`] at the same distance from a start in each lane.
    ///
    /// # Panics
    /// When a place is out of range.
    #[inline(always)]
    fn gather_from<const COUNT: usize>(values: &[f64], starts: &Starts, offset: usize) -> [Self; COUNT] {
        assert!(starts.largest < values.len() && offset + COUNT <= values.len() - starts.largest);
        let mut places = starts.places;
        for lane in 0..Self::WIDTH {
            places[lane] += offset;
        }
        Self::gather(values, &places)
    }

    /// The number of directions along which values carry derivatives by a motion of points.
    const DIRECTIONS: usize = 0;

    /// `self * factor + addend` with a factor that has no derivative where values carry one.
    #[inline(always)]
    fn multiply_add_constant(self, factor: Self, addend: Self) -> Self {
        self.multiply_add(factor, addend)
    }

    /// [`SimdLane::gather`] with the first and second derivatives of the entries, or those along two directions, where values carry any.
    ///
    /// # Panics
    /// When a place is out of range.
    #[inline(always)]
    fn gather_with_slopes<const COUNT: usize>(
        values: &[f64],
        _slopes: [&[f64]; 2],
        places: &[usize; WIDEST],
    ) -> [Self; COUNT] {
        Self::gather(values, places)
    }

    /// Whether a value is zero, with its derivatives.
    #[inline(always)]
    fn vanishes(self) -> Self::Mask {
        self.equal(Self::splat(0.0))
    }

    /// The same value with another derivative, where values carry one.
    #[inline(always)]
    fn with_slope(self, _slope: Self) -> Self {
        self
    }

    /// The same value with the derivatives of a function of position that has a gradient, where values carry any.
    #[inline(always)]
    fn moved_by<const D: usize>(self, _gradient: &[Self; D], _position: &[Self; D]) -> Self {
        self
    }

    /// Asks for the cache line of an entry that will be wanted soon. Nothing happens beyond the end, or on processors without such an
    /// instruction in stable Rust.
    #[inline(always)]
    fn prefetch<T>(_values: &[T], _place: usize) {}

    /// Writes the entries of each of the first `filled` lanes to `target[lane * stride..]`; adds them to what is there
    /// if `ADD`.
    ///
    /// # Panics
    /// When `target` is too short.
    #[inline(always)]
    fn store_transposed<const ADD: bool>(
        source: impl Entries<Self>,
        filled: usize,
        target: &mut [f64],
        stride: usize,
    ) {
        store_entries::<ADD, _>(source, 0..source.count(), filled, target, stride);
    }

    /// Writes COUNT entries of all lanes side by side to `target[lane * stride + place..]`.
    ///
    /// # Panics
    /// When `target` is too short.
    #[inline(always)]
    fn store_few<const COUNT: usize>(
        entries: [Self; COUNT],
        target: &mut [f64],
        place: usize,
        stride: usize,
    ) {
        let length = (Self::WIDTH - 1) * stride + COUNT;
        assert!(length <= target.len() && place <= target.len() - length);
        // SAFETY: no lane's place is beyond the length that was checked.
        unsafe { Self::store_few_from(entries, target.as_mut_ptr().add(place), stride) }
    }

    /// The same from a row of the first lane's on.
    ///
    /// # Safety
    /// COUNT numbers can be written there, and as far as the lane's number times `stride` behind, for each lane.
    #[inline(always)]
    unsafe fn store_few_from<const COUNT: usize>(entries: [Self; COUNT], row: *mut f64, stride: usize) {
        let mut lanes = [0.0; WIDEST];
        for k in 0..COUNT {
            entries[k].store(&mut lanes);
            for lane in 0..Self::WIDTH {
                // SAFETY: the caller's contract.
                unsafe { row.add(lane * stride + k).write(lanes[lane]) };
            }
        }
    }
}

/// Starts of the lists of a batch's cells, one per lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Starts {
    places: [usize; WIDEST],
    /// Of the places in the lanes of the type that they were made for.
    largest: usize,
}

impl Starts {
    /// Any places.
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    fn at<L: Lane>(places: &[usize; WIDEST]) -> Self {
        let mut largest = places[0];
        for lane in 1..L::WIDTH {
            largest = if places[lane] > largest { places[lane] } else { largest };
        }
        Starts { places: *places, largest }
    }

    /// Lists of one length, one after the other: those of `filled` cells from `first` on, in the lanes of a type; other
    /// lanes repeat the last.
    #[inline(always)]
    pub(crate) fn new<L: Lane>(first: usize, filled: usize, length: usize) -> Self {
        let (mut places, mut place) = ([first * length; WIDEST], first * length);
        if filled == L::WIDTH {
            for lane in 1..L::WIDTH {
                place += length;
                places[lane] = place;
            }
        } else {
            for lane in 1..L::WIDTH {
                place += if lane < filled { length } else { 0 };
                places[lane] = place;
            }
        }
        Starts { places, largest: place }
    }
}

/// Entries of lane values by number. A trait and not a closure: closures do not inherit target features. Handed over by value, so that
/// the compiler sees that what is written does not change where the entries are.
pub(crate) trait Entries<L>: Copy {
    /// Their number.
    fn count(&self) -> usize;
    /// The k-th entry.
    fn entry(&self, k: usize) -> &L;
    /// The k-th entry and its three successors.
    #[inline(always)]
    fn four(&self, k: usize) -> [&L; 4] {
        [self.entry(k), self.entry(k + 1), self.entry(k + 2), self.entry(k + 3)]
    }
}

/// [`SimdLane::store_transposed`] as work of its own, without adding.
pub(crate) struct Transposition<'a, E> {
    /// The entries.
    pub source: E,
    /// Number of lanes that are written.
    pub filled: usize,
    /// The destination.
    pub target: &'a mut [f64],
    /// From one lane to the next.
    pub stride: usize,
}

impl<L: SimdLane, E: Entries<L>> SharedWork<L> for Transposition<'_, E> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        L::store_transposed::<false>(self.source, self.filled, self.target, self.stride);
    }
}

/// Entries in the order of memory.
impl<L> Entries<L> for &[L] {
    #[inline(always)]
    fn count(&self) -> usize {
        self.len()
    }
    #[inline(always)]
    fn entry(&self, k: usize) -> &L {
        &self[k]
    }
}

/// [`SimdLane::store_transposed`], one number at a time.
#[inline(always)]
fn store_entries<const ADD: bool, L: Lane>(
    source: impl Entries<L>,
    range: std::ops::Range<usize>,
    filled: usize,
    target: &mut [f64],
    stride: usize,
) {
    let mut lanes = [0.0; WIDEST];
    for k in range {
        source.entry(k).store(&mut lanes);
        for (lane, value) in lanes[..filled].iter().enumerate() {
            let target = &mut target[lane * stride + k];
            *target = if ADD { *target + *value } else { *value };
        }
    }
}

/// An integer power, by repeated multiplication.
#[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
#[inline(always)]
fn power<L: Lane>(base: L, exponent: i32) -> L {
    let (mut rest, mut square, mut power) = (exponent.unsigned_abs(), base, L::splat(1.0));
    while rest > 0 {
        if rest % 2 == 1 {
            power = power * square;
        }
        square = square * square;
        rest /= 2;
    }
    if exponent < 0 { L::splat(1.0) / power } else { power }
}

impl SimdLane for f64 {
    const REGISTERS: usize = 16;

    #[inline(never)]
    fn call<W: SharedWork<Self>>(work: W) -> W::Output {
        work.run()
    }
}

#[cfg(test)]
mod tests;

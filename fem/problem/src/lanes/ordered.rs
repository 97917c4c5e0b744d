//! Lane values in an order that is not that of memory.

use super::{Entries, WIDEST};

/// Which of some values stands where: entry k is the `places[k]`-th value.
#[derive(Clone, Debug, Default)]
pub(crate) struct Order {
    /// Places times [`WIDEST`]: times the number of lanes these are the values' distances in bytes, a factor that addresses of all
    /// lane types have room for.
    scaled: Vec<u32>,
    /// More than the largest place.
    values: usize,
}

impl Order {
    pub fn new(places: Vec<u32>) -> Self {
        let values = places.iter().max().map_or(0, |largest| *largest as usize + 1);
        assert!(values * WIDEST <= u32::MAX as usize, "an element matrix of so many entries does not exist");
        Order { scaled: places.into_iter().map(|place| place * WIDEST as u32).collect(), values }
    }

    /// Which value each entry is.
    pub fn places(&self) -> impl Iterator<Item = u32> {
        self.scaled.iter().map(|scaled| scaled / WIDEST as u32)
    }
}

/// Values in an order.
pub(crate) struct Ordered<'a, L> {
    values: &'a [L],
    scaled: &'a [u32],
}

impl<L> Clone for Ordered<'_, L> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}
impl<L> Copy for Ordered<'_, L> {}

impl<'a, L> Ordered<'a, L> {
    /// The first `count` entries of an order.
    ///
    /// # Panics
    /// When there are fewer entries, or fewer values than the order has places for.
    #[inline(always)]
    pub fn new(values: &'a [L], order: &'a Order, count: usize) -> Self {
        assert!(order.values <= values.len());
        const { assert!(size_of::<L>().is_multiple_of(WIDEST)) }
        Ordered { values, scaled: &order.scaled[..count] }
    }
}

impl<L> Entries<L> for Ordered<'_, L> {
    #[inline(always)]
    fn count(&self) -> usize {
        self.scaled.len()
    }
    #[inline(always)]
    fn entry(&self, k: usize) -> &L {
        let distance = self.scaled[k] as usize * (size_of::<L>() / WIDEST);
        // SAFETY: a distance in bytes is a place times the size of a value, and no place is beyond the values: `Ordered::new`. To
        // check that again for each entry would take a third of the time of the passage from lanes to memory.
        unsafe { &*self.values.as_ptr().byte_add(distance) }
    }
    /// Places are read two at a time: on their way from lanes to memory four entries take as many accesses to memory as the processor
    /// makes in a given time.
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    fn four(&self, k: usize) -> [&L; 4] {
        let pairs = self.scaled[k..k + 4].as_ptr().cast::<u64>();
        // SAFETY: four numbers of 32 bits are two of 64 bits; places as in `entry`.
        unsafe {
            let (first, second) = (pairs.read_unaligned(), pairs.add(1).read_unaligned());
            let value = |scaled: u64| {
                let distance = scaled as usize * (size_of::<L>() / WIDEST);
                &*self.values.as_ptr().byte_add(distance)
            };
            const LOW: u64 = u32::MAX as u64;
            [value(first & LOW), value(first >> 32), value(second & LOW), value(second >> 32)]
        }
    }
}

//! Lane values in an order that is not that of memory.

use super::Entries;

/// The position of each value: entry k is the `places[k]`-th value.
#[derive(Clone, Debug, Default)]
pub(crate) struct Order {
    /// Distances from the first value in bytes: an address is a sum then, whatever the lanes.
    distances: Vec<u32>,
    /// Of a value.
    bytes: usize,
    /// More than the largest place.
    values: usize,
}

impl Order {
    /// An order of values with the given number of lanes.
    ///
    /// # Panics
    /// When there are more than four gigabytes of values.
    pub fn new(places: Vec<u32>, lanes: usize) -> Self {
        let (bytes, values) =
            (lanes * size_of::<f64>(), places.iter().max().map_or(0, |largest| *largest as usize + 1));
        assert!(values * bytes <= u32::MAX as usize, "an element matrix of so many entries does not exist");
        let distances = places.into_iter().map(|place| place * bytes as u32).collect();
        Order { distances, bytes, values }
    }

    /// The value that each entry is.
    pub fn places(&self) -> impl Iterator<Item = u32> {
        self.distances.iter().map(|distance| distance / self.bytes as u32)
    }
}

/// Values in an order.
pub(crate) struct Ordered<'a, L> {
    values: &'a [L],
    distances: &'a [u32],
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
    /// When there are fewer entries, or fewer values than the order has places for, or values of another size.
    #[inline(always)]
    pub fn new(values: &'a [L], order: &'a Order, count: usize) -> Self {
        assert!(order.values <= values.len() && order.bytes == size_of::<L>());
        Ordered { values, distances: &order.distances[..count] }
    }
}

impl<L> Entries<L> for Ordered<'_, L> {
    #[inline(always)]
    fn count(&self) -> usize {
        self.distances.len()
    }
    #[inline(always)]
    fn entry(&self, k: usize) -> &L {
        let distance = self.distances[k] as usize;
        // SAFETY: a distance in bytes is a place times the size of a value, and no place is beyond the values: `Ordered::new`. To
        // check that again for each entry would take a third of the time of the passage from lanes to memory.
        unsafe { &*self.values.as_ptr().byte_add(distance) }
    }
    /// Places are read two at a time: on their way from lanes to memory four entries take as many accesses to memory as the processor
    /// makes in a given time.
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    fn four(&self, k: usize) -> [&L; 4] {
        let pairs = self.distances[k..k + 4].as_ptr().cast::<u64>();
        // SAFETY: four numbers of 32 bits are two of 64 bits; places as in `entry`.
        unsafe {
            let (first, second) = (pairs.read_unaligned(), pairs.add(1).read_unaligned());
            let value = |distance: u64| &*self.values.as_ptr().byte_add(distance as usize);
            const LOW: u64 = u32::MAX as u64;
            [value(first & LOW), value(first >> 32), value(second & LOW), value(second >> 32)]
        }
    }
}

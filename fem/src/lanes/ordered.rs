//! Lane values in an order that is not that of memory.

use super::Entries;

/// Which of some values stands where: entry k is the `places[k]`-th value.
#[derive(Clone, Debug, Default)]
pub(crate) struct Order {
    places: Vec<u32>,
    /// More than the largest place.
    values: usize,
}

impl Order {
    pub fn new(places: Vec<u32>) -> Self {
        let values = places.iter().max().map_or(0, |largest| *largest as usize + 1);
        Order { places, values }
    }

    /// Which value each entry is.
    pub fn places(&self) -> impl Iterator<Item = u32> {
        self.places.iter().copied()
    }
}

/// Values in an order.
pub(crate) struct Ordered<'a, L> {
    values: &'a [L],
    places: &'a [u32],
}

impl<'a, L> Ordered<'a, L> {
    /// The first `count` entries of an order.
    ///
    /// # Panics
    /// When there are fewer entries, or fewer values than the order has places for.
    #[inline(always)]
    pub fn new(values: &'a [L], order: &'a Order, count: usize) -> Self {
        assert!(order.values <= values.len());
        Ordered { values, places: &order.places[..count] }
    }
}

impl<L> Entries<L> for Ordered<'_, L> {
    #[inline(always)]
    fn count(&self) -> usize {
        self.places.len()
    }
    #[inline(always)]
    fn entry(&self, k: usize) -> &L {
        // SAFETY: no place is beyond the values: `Ordered::new`. To check that again for each entry would take a third
        // of the time of the passage from lanes to memory.
        unsafe { self.values.get_unchecked(self.places[k] as usize) }
    }
}

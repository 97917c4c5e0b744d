//! Maps and sets that keep their keys in order in a list.
//!
//! The compiler has thirty types of them, most with a few entries. A search tree of the standard library is compiled again for each type
//! (docs/decisions/build_times.md); here a type costs a binary search and an insertion.

use std::borrow::Borrow;
use std::mem::replace;
use std::ops::Index;
use std::{slice, vec};

/// A map with its keys in order.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SortedMap<K, V> {
    entries: Vec<(K, V)>,
}

impl<K, V> Default for SortedMap<K, V> {
    fn default() -> Self {
        SortedMap { entries: vec![] }
    }
}

impl<K: Ord, V> SortedMap<K, V> {
    pub fn new() -> Self {
        SortedMap::default()
    }

    /// Place of a key, or the place that it would have.
    fn place<Q: Ord + ?Sized>(&self, key: &Q) -> Result<usize, usize>
    where
        K: Borrow<Q>,
    {
        // Most lists are made in their order.
        if self.entries.last().is_none_or(|(last, _)| last.borrow() < key) {
            return Err(self.entries.len());
        }
        self.entries.binary_search_by(|(own, _)| own.borrow().cmp(key))
    }

    pub fn len(&self) -> usize {
        self.entries.len()
    }

    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    pub fn get<Q: Ord + ?Sized>(&self, key: &Q) -> Option<&V>
    where
        K: Borrow<Q>,
    {
        self.place(key).ok().map(|place| &self.entries[place].1)
    }

    pub fn get_mut<Q: Ord + ?Sized>(&mut self, key: &Q) -> Option<&mut V>
    where
        K: Borrow<Q>,
    {
        self.place(key).ok().map(|place| &mut self.entries[place].1)
    }

    pub fn contains_key<Q: Ord + ?Sized>(&self, key: &Q) -> bool
    where
        K: Borrow<Q>,
    {
        self.place(key).is_ok()
    }

    /// The value that the key had before.
    pub fn insert(&mut self, key: K, value: V) -> Option<V> {
        match self.place(&key) {
            Ok(place) => Some(replace(&mut self.entries[place].1, value)),
            Err(place) => {
                self.entries.insert(place, (key, value));
                None
            }
        }
    }

    pub fn remove<Q: Ord + ?Sized>(&mut self, key: &Q) -> Option<V>
    where
        K: Borrow<Q>,
    {
        self.place(key).ok().map(|place| self.entries.remove(place).1)
    }

    /// The value of a key, made first where there is none.
    pub fn get_or_insert_with(&mut self, key: K, make: impl FnOnce() -> V) -> &mut V {
        let place = match self.place(&key) {
            Ok(place) => place,
            Err(place) => {
                self.entries.insert(place, (key, make()));
                place
            }
        };
        &mut self.entries[place].1
    }

    /// The value of a key, the type's default where there is none yet.
    pub fn get_or_default(&mut self, key: K) -> &mut V
    where
        V: Default,
    {
        self.get_or_insert_with(key, V::default)
    }

    pub fn iter(&self) -> slice::Iter<'_, (K, V)> {
        self.entries.iter()
    }

    pub fn iter_mut(&mut self) -> impl Iterator<Item = (&K, &mut V)> {
        self.entries.iter_mut().map(|(key, value)| (&*key, value))
    }

    pub fn keys(&self) -> impl DoubleEndedIterator<Item = &K> + ExactSizeIterator + Clone {
        self.entries.iter().map(|(key, _)| key)
    }

    pub fn values(&self) -> impl DoubleEndedIterator<Item = &V> + ExactSizeIterator + Clone {
        self.entries.iter().map(|(_, value)| value)
    }

    pub fn into_values(self) -> impl Iterator<Item = V> {
        self.entries.into_iter().map(|(_, value)| value)
    }

    /// Keeps the entries that satisfy the condition.
    pub fn retain(&mut self, mut condition: impl FnMut(&K, &mut V) -> bool) {
        self.entries.retain_mut(|(key, value)| condition(key, value));
    }
}

impl<K: Ord + Borrow<Q>, Q: Ord + ?Sized, V> Index<&Q> for SortedMap<K, V> {
    type Output = V;

    fn index(&self, key: &Q) -> &V {
        self.get(key).expect("a key of the map")
    }
}

impl<K: Ord, V> FromIterator<(K, V)> for SortedMap<K, V> {
    fn from_iter<I: IntoIterator<Item = (K, V)>>(entries: I) -> Self {
        let mut map = SortedMap::new();
        map.extend(entries);
        map
    }
}

impl<K: Ord, V, const N: usize> From<[(K, V); N]> for SortedMap<K, V> {
    fn from(entries: [(K, V); N]) -> Self {
        entries.into_iter().collect()
    }
}

impl<K: Ord, V> Extend<(K, V)> for SortedMap<K, V> {
    fn extend<I: IntoIterator<Item = (K, V)>>(&mut self, entries: I) {
        for (key, value) in entries {
            self.insert(key, value);
        }
    }
}

impl<K, V> IntoIterator for SortedMap<K, V> {
    type Item = (K, V);
    type IntoIter = vec::IntoIter<(K, V)>;

    fn into_iter(self) -> Self::IntoIter {
        self.entries.into_iter()
    }
}

impl<'a, K, V> IntoIterator for &'a SortedMap<K, V> {
    type Item = &'a (K, V);
    type IntoIter = slice::Iter<'a, (K, V)>;

    fn into_iter(self) -> Self::IntoIter {
        self.entries.iter()
    }
}

/// A set in order.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SortedSet<T> {
    elements: Vec<T>,
}

impl<T> Default for SortedSet<T> {
    fn default() -> Self {
        SortedSet { elements: vec![] }
    }
}

impl<T: Ord> SortedSet<T> {
    pub fn new() -> Self {
        SortedSet::default()
    }

    pub fn len(&self) -> usize {
        self.elements.len()
    }

    pub fn is_empty(&self) -> bool {
        self.elements.is_empty()
    }

    pub fn contains<Q: Ord + ?Sized>(&self, element: &Q) -> bool
    where
        T: Borrow<Q>,
    {
        self.elements.binary_search_by(|own| own.borrow().cmp(element)).is_ok()
    }

    /// Whether the element was not there before.
    pub fn insert(&mut self, element: T) -> bool {
        let place = match self.elements.last().is_none_or(|last| *last < element) {
            true => Err(self.elements.len()),
            false => self.elements.binary_search(&element),
        };
        if let Err(place) = place {
            self.elements.insert(place, element);
        }
        place.is_err()
    }

    /// The last element that is less than a given one.
    pub fn last_before(&self, limit: &T) -> Option<&T> {
        self.elements[..self.elements.partition_point(|element| element < limit)].last()
    }

    pub fn iter(&self) -> slice::Iter<'_, T> {
        self.elements.iter()
    }
}

impl<T: Ord> FromIterator<T> for SortedSet<T> {
    fn from_iter<I: IntoIterator<Item = T>>(elements: I) -> Self {
        let mut elements: Vec<T> = elements.into_iter().collect();
        elements.sort_unstable();
        elements.dedup();
        SortedSet { elements }
    }
}

impl<T: Ord, const N: usize> From<[T; N]> for SortedSet<T> {
    fn from(elements: [T; N]) -> Self {
        elements.into_iter().collect()
    }
}

impl<T: Ord> Extend<T> for SortedSet<T> {
    fn extend<I: IntoIterator<Item = T>>(&mut self, elements: I) {
        for element in elements {
            self.insert(element);
        }
    }
}

impl<T> IntoIterator for SortedSet<T> {
    type Item = T;
    type IntoIter = vec::IntoIter<T>;

    fn into_iter(self) -> Self::IntoIter {
        self.elements.into_iter()
    }
}

impl<'a, T> IntoIterator for &'a SortedSet<T> {
    type Item = &'a T;
    type IntoIter = slice::Iter<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.elements.iter()
    }
}

#[cfg(test)]
mod tests {
    use std::collections::{BTreeMap, BTreeSet};

    use super::*;

    /// Numbers below 40 in no order, many of them more than once.
    fn numbers() -> impl Iterator<Item = u32> {
        (0..200_u32).map(|k| k.wrapping_mul(2_654_435_761) >> 16).map(|number| number % 40)
    }

    #[test]
    fn maps_are_those_of_the_standard_library() {
        let (mut own, mut expected) = (SortedMap::new(), BTreeMap::new());
        for (k, key) in numbers().enumerate() {
            match k % 4 {
                0 => assert_eq!(own.remove(&key), expected.remove(&key)),
                1 => {
                    *own.get_or_default(key) += k;
                    *expected.entry(key).or_default() += k;
                }
                _ => assert_eq!(own.insert(key, k), expected.insert(key, k)),
            }
            assert_eq!(own.get(&key), expected.get(&key));
            assert!(own.iter().map(|(key, value)| (key, value)).eq(&expected), "step {k}");
        }
        own.retain(|key, _| key % 3 > 0);
        expected.retain(|key, _| key % 3 > 0);
        assert!(own.keys().eq(expected.keys()) && own.values().eq(expected.values()));
        // Of two entries with one key the later one counts.
        let twice: SortedMap<_, _> = [(2, 'a'), (1, 'b'), (2, 'c')].into();
        assert_eq!(Vec::from_iter(twice), [(1, 'b'), (2, 'c')]);
    }

    #[test]
    fn sets_are_those_of_the_standard_library() {
        let (mut own, mut expected) = (SortedSet::new(), BTreeSet::new());
        for number in numbers() {
            assert_eq!(own.insert(number), expected.insert(number));
            assert!(own.iter().eq(&expected) && own.contains(&number));
        }
        for limit in 0..41 {
            assert_eq!(own.last_before(&limit), expected.range(..limit).next_back());
        }
        assert_eq!(own, numbers().collect());
    }
}

//! Disjoint sets of numbers that are joined pair by pair, as the cells or nodes of bodies.

/// Disjoint sets of the numbers from 0 on, each by one of its numbers.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub struct DisjointSets(Vec<u32>);

impl DisjointSets {
    /// Each number by itself.
    pub fn new(count: usize) -> Self {
        DisjointSets((0..count as u32).collect())
    }

    /// The number that represents the set of another one.
    pub fn root(&mut self, mut number: u32) -> u32 {
        while self.0[number as usize] != number {
            let above = self.0[self.0[number as usize] as usize];
            self.0[number as usize] = above;
            number = above;
        }
        number
    }

    /// The union of the sets of two numbers, made in place. The least number of a set represents it.
    pub fn join(&mut self, one: u32, other: u32) {
        let (one, other) = (self.root(one), self.root(other));
        self.0[one.max(other) as usize] = one.min(other);
    }
}

#[cfg(test)]
mod tests {
    use super::DisjointSets;

    #[test]
    fn sets_are_represented_by_their_least_number() {
        let mut sets = DisjointSets::new(7);
        for (one, other) in [(5, 6), (3, 5), (0, 1), (6, 3)] {
            sets.join(one, other);
        }
        assert_eq!((0..7).map(|number| sets.root(number)).collect::<Vec<_>>(), [0, 0, 2, 3, 4, 3, 3]);
    }
}

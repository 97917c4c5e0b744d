//! Random markings of cells, for tests of refinement.

/// Random numbers below a bound: SplitMix64 (Steele, Lea, Flood 2014).
pub(super) struct Random(pub(super) u64);

impl Random {
    pub(super) fn below(&mut self, bound: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ z >> 31) % bound as u64) as usize
    }

    /// Some cells, most of them near each other.
    pub(super) fn marking(&mut self, count: usize) -> Vec<u32> {
        let (first, number) = (self.below(count), 1 + self.below(4));
        let mut cells: Vec<u32> = (0..number).map(|_| ((first + self.below(6)) % count) as u32).collect();
        cells.extend((self.below(3) == 0).then_some((count - 1 - first) as u32));
        cells
    }
}

/// Number of markings: all with FORMS_SWEEPS.
pub(super) fn markings(in_sweeps: usize, as_a_rule: usize) -> usize {
    if std::env::var_os("FORMS_SWEEPS").is_some() { in_sweeps } else { as_a_rule }
}

//! Random numbers with a fixed seed (SplitMix64).

use super::Nodal;

pub struct Random(pub u64);

impl Random {
    /// Uniform in [−1, 1].
    pub fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        bits ^= bits >> 31;
        (bits >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// Nodal values in [centre − spread, centre + spread].
    pub fn field(&mut self, nodes: usize, components: usize, centre: f64, spread: f64) -> Nodal {
        let values = (0..nodes * components).map(|_| centre + spread * self.number()).collect();
        Nodal { components, values }
    }
}

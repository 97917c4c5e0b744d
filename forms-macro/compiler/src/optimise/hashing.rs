//! A hash for nodes and their numbers: multiplication and rotation. The standard one, which withstands chosen keys, took a
//! third of the compiler's time where that is built without optimisation, as release profiles build macros.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// A map by node, by scalar or by instruction. Nothing may depend on its order.
pub type Map<K, V> = HashMap<K, V, BuildHasherDefault<Multiplicative>>;

/// The state of the hash.
#[derive(Default)]
pub struct Multiplicative(u64);

/// 2⁶⁴ over the golden ratio, made odd.
const FACTOR: u64 = 0x9e37_79b9_7f4a_7c15;

impl Hasher for Multiplicative {
    fn finish(&self) -> u64 {
        // The map reads the lowest and the highest bits.
        self.0 ^ (self.0 >> 32)
    }
    fn write(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.write_u64(u64::from(*byte));
        }
    }
    fn write_u8(&mut self, value: u8) {
        self.write_u64(u64::from(value));
    }
    fn write_u32(&mut self, value: u32) {
        self.write_u64(u64::from(value));
    }
    fn write_u64(&mut self, value: u64) {
        self.0 = (self.0.rotate_left(5) ^ value).wrapping_mul(FACTOR);
    }
    fn write_usize(&mut self, value: usize) {
        self.write_u64(value as u64);
    }
    fn write_i32(&mut self, value: i32) {
        self.write_u64(u64::from(value as u32));
    }
    fn write_isize(&mut self, value: isize) {
        self.write_u64(value as u64);
    }
}

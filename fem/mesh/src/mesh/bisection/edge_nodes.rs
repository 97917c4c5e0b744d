//! Nodes in the middles of edges, by their edge.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// The nodes in the middle of edges, each found by the two ends of its edge.
#[derive(Default)]
pub(super) struct EdgeNodes(HashMap<u64, u32, BuildHasherDefault<EdgeHasher>>);

impl EdgeNodes {
    pub(super) fn get(&self, ends: [u32; 2]) -> Option<u32> {
        self.0.get(&key(ends)).copied()
    }

    pub(super) fn insert(&mut self, ends: [u32; 2], node: u32) {
        self.0.insert(key(ends), node);
    }
}

fn key([a, b]: [u32; 2]) -> u64 {
    u64::from(a.max(b)) << 32 | u64::from(a.min(b))
}

/// A hash of one number by a multiplication (D. E. Knuth, The Art of Computer Programming 3, section 6.4): edges come from a
/// mesh, and a table is asked some ten times per bisection.
#[derive(Default)]
struct EdgeHasher(u64);

impl Hasher for EdgeHasher {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.write_u64(u64::from(byte));
        }
    }

    fn write_u64(&mut self, value: u64) {
        let product = (self.0 ^ value).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        // Tables take the lowest and the highest bits; those of a product know the number's low ones best when high.
        self.0 = product ^ product >> 32;
    }
}

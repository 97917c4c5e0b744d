//! The calls of a kernel on the entities of a region, cells and facets alike: element matrices and vectors.

pub(super) mod block_sink;
mod node_pairs;
pub(super) mod reference_tensor;
pub(super) mod sink;
pub(super) mod sum_factorisation;

pub(super) mod matrices;
pub(super) mod vectors;

pub(super) use node_pairs::NodePairs;

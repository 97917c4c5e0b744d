//! The calls of a kernel on the entities of a region, cells and facets alike: element matrices and vectors.

mod bilinear_calls;
pub(super) mod block_sink;
mod linear_calls;
mod node_pairs;
pub(super) mod reference_tensor;
pub(super) mod sink;
pub(super) mod sum_factorisation;

pub(super) mod matrices;
pub(super) mod moving_points;
pub(super) mod piece_slopes;
pub(super) mod point_values;
pub(super) mod second_motion;
pub(super) mod vectors;

pub(super) use bilinear_calls::{BilinearCalls, Factors};
pub(super) use linear_calls::{LinearCalls, MovingCalls};
pub(super) use node_pairs::{NodePairs, no_products};

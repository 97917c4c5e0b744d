//! Laws of contact between bodies with means over own facets: tangents, balance, patch tests, adjoints, one point per facet, and the force of a
//! block that is drawn along a slab, in the plane and in space.

mod ball;
mod bodies;
mod fixed_pairs;
mod ironing;
mod penalty;
mod sliding;
mod wobble;

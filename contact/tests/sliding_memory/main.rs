//! Laws of sliding bodies whose own points remember: friction by springs with memory, wear, plastic surfaces; gradients through the memory.

mod bodies;
mod drag;
mod gradients;
mod plastic;
mod wear;

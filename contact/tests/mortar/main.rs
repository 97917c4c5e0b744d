//! Mortar methods: multipliers on own facets of bodies that slide. Patch tests with partial cover, friction in closed form in 2D and 3D, forces of a body that is
//! drawn along another one, rings by Lamé, and what is refused.

mod checks;
mod dual;
mod exact;
mod friction;
mod gradients;
mod known;
mod patch;
mod rings;
mod space;
mod stability;
mod wobble;

//! Newton's answers on problems whose equations differ by many orders of magnitude: listed ones, and random ones by the thousand.
//!
//! An answer is compared with a solution that is known, or with what further whole Newton steps by LU make of it. A refusal is
//! compared with such steps from the start.

mod kinds;
mod laws;
mod listed;
mod random;
mod reference;
mod solvers;

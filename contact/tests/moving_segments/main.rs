//! Sliding pairs on moving segments: patch tests while bodies slide, balance, covered lengths, the same bits on any number of threads.

mod balance;
mod covers;
mod energies;
mod errors;
mod histories;
mod loads;
mod patch;
mod rings;
mod shape;
mod space;
mod tangent;
mod wobble;

#![allow(dead_code, unused_imports)]
//! Sliding pairs on moving segments: patch tests while bodies slide, balance, covered lengths, the same bits on any number of threads.

mod balance;
mod errors;
mod patch;
mod shape;
mod space;
mod tangent;

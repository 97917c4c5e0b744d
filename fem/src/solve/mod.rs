//! Nonlinear solution: semismooth Newton.

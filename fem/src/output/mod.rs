//! Files and pictures.

pub mod atomic;
pub mod matrix_market;

pub use atomic::write_whole;
pub use matrix_market::write_matrix_market;

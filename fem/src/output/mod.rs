//! Files and pictures.

pub mod atomic;
#[cfg(feature = "pictures")]
pub mod picture;
pub mod vtu;

//! Files, written whole or not at all; bytes as text.

pub mod atomic;
#[doc(hidden)]
pub mod base64;

pub use atomic::{check_writable, write_whole};

//! Files, written whole or not at all; bytes as text.

pub mod atomic;
#[doc(hidden)]
pub mod base64;
mod checksum;

pub use atomic::{check_writable, write_whole};
#[doc(hidden)]
pub use checksum::checksum;

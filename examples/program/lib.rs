//! The frame of a program: its command line, and the memory that it takes.

pub mod command_line;
pub mod memory;

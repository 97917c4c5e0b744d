//! VTK files.

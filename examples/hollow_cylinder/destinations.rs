//! Destinations of the results, asked before the computation whether they can be written.

use std::fs;
use std::io;
use std::path::Path;

use forms_fem::output::check_writable;

/// Makes the directory where it does not exist, and writes and removes a file in it.
pub fn prepare_directory(directory: &Path) -> io::Result<()> {
    let named = |error: io::Error| {
        let text = format!("the output directory {} cannot be used: {error}", directory.display());
        io::Error::new(error.kind(), text)
    };
    fs::create_dir_all(directory).map_err(named)?;
    check_writable(directory.join("writable")).map_err(|error| named(io::Error::from(error.kind())))
}

/// Whether a file of this name can be written; what exists is left as it is.
pub fn check_file(path: &Path) -> io::Result<()> {
    check_writable(path)
        .map_err(|error| io::Error::new(error.kind(), format!("the file cannot be written: {error}")))
}

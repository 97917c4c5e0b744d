//! Whether results can be written, asked before the computation.

use std::fs;
use std::io;
use std::path::Path;

use forms_fem::output::write_whole;

/// Makes the directory where it does not exist, and writes and removes a file in it.
pub fn prepare_directory(directory: &Path) -> io::Result<()> {
    let named = |error: io::Error| {
        let text = format!("the output directory {} cannot be used: {error}", directory.display());
        io::Error::new(error.kind(), text)
    };
    fs::create_dir_all(directory).map_err(named)?;
    probe(&directory.join("writable")).map_err(named)
}

/// Whether a file of this name can be written; a file that exists is left as it is.
pub fn check_file(path: &Path) -> io::Result<()> {
    let named = |error: io::Error| {
        io::Error::new(error.kind(), format!("the file {} cannot be written: {error}", path.display()))
    };
    if path.is_dir() {
        return Err(named(io::Error::new(io::ErrorKind::IsADirectory, "it is a directory")));
    }
    if path.file_name().is_none() {
        return Err(named(io::Error::new(io::ErrorKind::InvalidInput, "it is not the name of a file")));
    }
    probe(path).map_err(named)
}

/// Writes and removes a file beside `path`.
fn probe(path: &Path) -> io::Result<()> {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.probe", std::process::id()));
    let probe = path.with_file_name(name);
    write_whole(&probe, |_| Ok(())).map_err(|error| io::Error::from(error.kind()))?;
    fs::remove_file(&probe)
}

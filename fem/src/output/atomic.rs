//! Writing a file whole or not at all.

use std::ffi::OsString;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Writes a file by way of a temporary one in the same directory, which is renamed when it is complete. A
/// reader sees the old file or the new one, never a part. On an error the old file stays and the temporary one
/// is removed.
///
/// # Errors
/// If the file cannot be created, written or renamed, or `write` fails; the message names the path.
pub fn write_whole(
    path: impl AsRef<Path>,
    write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> io::Result<()> {
    let path = path.as_ref();
    let name_path = |error: io::Error| io::Error::new(error.kind(), format!("{}: {error}", path.display()));
    let (temporary, file) = create_beside(path).map_err(name_path)?;
    let mut writer = BufWriter::new(file);
    let written = write(&mut writer)
        .and_then(|()| writer.into_inner().map_err(io::IntoInnerError::into_error))
        .and_then(|file| file.sync_all())
        .and_then(|()| fs::rename(&temporary, path));
    written.map_err(|error| {
        // The first error is the one to report, whether or not the remains can be removed.
        let _ = fs::remove_file(&temporary);
        name_path(error)
    })
}

/// Creates a new file with an unused name next to `path`.
fn create_beside(path: &Path) -> io::Result<(PathBuf, File)> {
    static COUNTER: AtomicU64 = AtomicU64::new(0);
    let Some(name) = path.file_name() else {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "not the name of a file"));
    };
    loop {
        let mut hidden = OsString::from(".");
        hidden.push(name);
        hidden.push(format!(".{}-{}.part", std::process::id(), COUNTER.fetch_add(1, Ordering::Relaxed)));
        let temporary = path.with_file_name(hidden);
        match OpenOptions::new().write(true).create_new(true).open(&temporary) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => continue,
            result => return result.map(|file| (temporary, file)),
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use std::io::Write;

    use super::*;

    /// A directory of its own for a test, removed at the end.
    pub(crate) struct TestDirectory(pub(crate) PathBuf);

    impl TestDirectory {
        pub(crate) fn new(name: &str) -> Self {
            let path = std::env::temp_dir().join(format!("forms-fem-{name}-{}", std::process::id()));
            fs::create_dir_all(&path).unwrap();
            Self(path)
        }
    }

    impl Drop for TestDirectory {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    #[test]
    fn a_file_is_replaced_whole_or_left_alone() {
        let directory = TestDirectory::new("atomic");
        let path = directory.0.join("result.txt");
        write_whole(&path, |writer| writer.write_all(b"first")).unwrap();
        write_whole(&path, |writer| writer.write_all(b"second")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"second");
        let error = write_whole(&path, |writer| {
            writer.write_all(b"third")?;
            Err(io::Error::other("the disk is on fire"))
        })
        .unwrap_err();
        assert!(error.to_string().contains("result.txt: the disk is on fire"));
        assert_eq!(fs::read(&path).unwrap(), b"second");
        assert_eq!(fs::read_dir(&directory.0).unwrap().count(), 1, "the temporary file was left behind");
    }

    #[test]
    fn a_missing_directory_is_named() {
        let directory = TestDirectory::new("atomic-missing");
        let error = write_whole(directory.0.join("nowhere").join("a.txt"), |_| Ok(())).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::NotFound);
        assert!(error.to_string().contains("a.txt"));
        assert!(write_whole(directory.0.join(".."), |_| Ok(())).is_err());
    }
}

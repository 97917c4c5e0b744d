//! Writing a file whole or not at all; devices and pipes are written through, links stay.

use std::ffi::OsString;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// A file written by way of a temporary one in the same directory, which is renamed when it is complete. A
/// reader sees the old file or the new one, never a part. On an error the old file stays and the temporary one
/// is removed. A file that was there passes its permissions on. Directories that are missing are made.
///
/// A symbolic link stays: the file that it leads to is written. What is no ordinary file, as a device or a named pipe,
/// stays too and is written through, and so is a file that is this process's standard output; there an error can leave a part.
///
/// # Errors
/// If the file cannot be created, written or renamed, or `write` fails; the message names the path.
pub fn write_whole(
    path: impl AsRef<Path>,
    write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> io::Result<()> {
    let path = path.as_ref();
    let written = Destination::of(path).and_then(|destination| match destination {
        Destination::Whole(path) => replace(&path, write),
        Destination::Through => {
            let mut writer = BufWriter::new(OpenOptions::new().write(true).open(path)?);
            write(&mut writer).and_then(|()| writer.flush())
        }
        Destination::StandardOutput(file) => {
            // What was printed earlier comes first.
            io::stdout().flush()?;
            let mut writer = BufWriter::new(file);
            write(&mut writer).and_then(|()| writer.flush())
        }
    });
    written.map_err(|error| named(path, &error))
}

/// Whether [`write_whole`] can write a file, to be asked before a long computation: a file of another name is written next to
/// it and removed, and the file itself is left as it is. A device is opened, a pipe is believed.
///
/// # Errors
/// The reason why a file cannot be written; the message names the path.
pub fn check_writable(path: impl AsRef<Path>) -> io::Result<()> {
    let path = path.as_ref();
    let checked = Destination::of(path).and_then(|destination| match destination {
        Destination::Whole(path) => {
            let (temporary, file) = create_beside(&path)?;
            drop(file);
            fs::remove_file(temporary)
        }
        // To open a pipe waits for a reader, and to close it again tells him that all has been said.
        Destination::Through if is_pipe(path) => Ok(()),
        Destination::Through => OpenOptions::new().write(true).open(path).map(drop),
        Destination::StandardOutput(_) => Ok(()),
    });
    checked.map_err(|error| named(path, &error))
}

/// The target of what is written under a path.
enum Destination {
    /// A file of this name is replaced or made.
    Whole(PathBuf),
    /// No ordinary file: it is opened and written to.
    Through,
    /// The standard output: what is printed before and after is not overwritten.
    StandardOutput(File),
}

impl Destination {
    fn of(path: &Path) -> io::Result<Destination> {
        match fs::metadata(path) {
            Ok(found) if found.is_dir() => {
                Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a directory"))
            }
            Ok(found) if !found.is_file() => Ok(Destination::Through),
            Ok(found) => match standard_output(&found) {
                Some(file) => Ok(Destination::StandardOutput(file)),
                None if fs::symlink_metadata(path)?.is_symlink() => {
                    fs::canonicalize(path).map(Destination::Whole)
                }
                None => Ok(Destination::Whole(path.to_owned())),
            },
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                end_of_links(path).map(Destination::Whole)
            }
            Err(error) => Err(error),
        }
    }
}

/// The name that symbolic links lead to, where there is no file yet.
fn end_of_links(path: &Path) -> io::Result<PathBuf> {
    const MOST_LINKS: usize = 40;
    let mut end = path.to_owned();
    for _ in 0..MOST_LINKS {
        match fs::read_link(&end) {
            // A relative link is relative to its own directory.
            Ok(next) => end = end.parent().unwrap_or(Path::new("")).join(next),
            Err(_) => return Ok(end),
        }
    }
    Err(io::Error::other("too many symbolic links"))
}

/// The standard output, if it goes into this very file.
#[cfg(unix)]
fn standard_output(found: &fs::Metadata) -> Option<File> {
    use std::os::fd::AsFd;
    use std::os::unix::fs::MetadataExt;
    // A copy of the descriptor goes on where the other writes, and moves it on.
    let file = File::from(io::stdout().as_fd().try_clone_to_owned().ok()?);
    let own = file.metadata().ok()?;
    ((own.dev(), own.ino()) == (found.dev(), found.ino())).then_some(file)
}

#[cfg(not(unix))]
fn standard_output(_: &fs::Metadata) -> Option<File> {
    None
}

#[cfg(unix)]
fn is_pipe(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt;
    fs::metadata(path).is_ok_and(|found| found.file_type().is_fifo())
}

#[cfg(not(unix))]
fn is_pipe(_: &Path) -> bool {
    false
}

fn named(path: &Path, error: &io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("{}: {error}", path.display()))
}

/// Puts a complete file in the place of an ordinary one, or of none.
fn replace(path: &Path, write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>) -> io::Result<()> {
    let (temporary, file) = create_beside(path)?;
    let mut writer = BufWriter::new(file);
    let written = write(&mut writer)
        .and_then(|()| writer.into_inner().map_err(io::IntoInnerError::into_error))
        .and_then(|file| match fs::metadata(path) {
            Ok(old) => file.set_permissions(old.permissions()).map(|()| file),
            Err(_) => Ok(file),
        })
        .and_then(|file| file.sync_all())
        .and_then(|()| fs::rename(&temporary, path));
    written.inspect_err(|_| {
        // The first error is the one to report, whether or not the remains can be removed.
        let _ = fs::remove_file(&temporary);
    })
}

/// Creates a new file with an unused name next to `path`.
fn create_beside(path: &Path) -> io::Result<(PathBuf, File)> {
    static COUNTER: AtomicU64 = AtomicU64::new(0);
    let Some(name) = path.file_name() else {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "not the name of a file"));
    };
    let mut made = false;
    loop {
        let mut hidden = OsString::from(".");
        hidden.push(name);
        hidden.push(format!(".{}-{}.part", std::process::id(), COUNTER.fetch_add(1, Ordering::Relaxed)));
        let temporary = path.with_file_name(hidden);
        match OpenOptions::new().write(true).create_new(true).open(&temporary) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => continue,
            Err(error) if error.kind() == io::ErrorKind::NotFound && !made => {
                // A path without a parent has a directory.
                path.parent().map_or(Ok(()), fs::create_dir_all)?;
                made = true;
            }
            result => return result.map(|file| (temporary, file)),
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
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

    #[cfg(unix)]
    #[test]
    fn links_stay_and_lead_to_the_file() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let directory = TestDirectory::new("atomic-links");
        let at = |name: &str| directory.0.join(name);
        fs::create_dir_all(at("below")).unwrap();
        fs::write(at("below/old.txt"), "old").unwrap();
        fs::set_permissions(at("below/old.txt"), fs::Permissions::from_mode(0o600)).unwrap();
        symlink("below/old.txt", at("to_old")).unwrap();
        symlink("to_new", at("to_to_new")).unwrap();
        symlink("below/new.txt", at("to_new")).unwrap();
        symlink("round", at("round")).unwrap();
        for (link, target) in [("to_old", "below/old.txt"), ("to_to_new", "below/new.txt")] {
            check_writable(at(link)).unwrap();
            write_whole(at(link), |writer| writer.write_all(b"written")).unwrap();
            assert!(fs::symlink_metadata(at(link)).unwrap().is_symlink(), "{link} was replaced");
            assert_eq!(fs::read(at(target)).unwrap(), b"written");
        }
        assert_eq!(fs::metadata(at("below/old.txt")).unwrap().permissions().mode() & 0o777, 0o600);
        assert!(check_writable(at("round")).is_err() && write_whole(at("round"), |_| Ok(())).is_err());
        assert_eq!(fs::read_dir(at("below")).unwrap().count(), 2);
        assert_eq!(fs::read_dir(&directory.0).unwrap().count(), 5);
    }

    /// A named pipe passes on what is written and stays; so does a link to a device, whose errors are reported.
    #[cfg(unix)]
    #[test]
    fn special_files_are_written_through() {
        use std::os::unix::fs::{FileTypeExt, symlink};
        let directory = TestDirectory::new("atomic-special");
        let pipe = directory.0.join("pipe");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status().unwrap();
        assert!(made.success());
        check_writable(&pipe).unwrap();
        let reader = {
            let pipe = pipe.clone();
            std::thread::spawn(move || fs::read(pipe).unwrap())
        };
        write_whole(&pipe, |writer| writer.write_all(b"through")).unwrap();
        assert!(fs::symlink_metadata(&pipe).unwrap().file_type().is_fifo(), "the pipe was replaced");
        assert_eq!(reader.join().unwrap(), b"through");
        let device = directory.0.join("device");
        symlink("/dev/null", &device).unwrap();
        check_writable(&device).unwrap();
        write_whole(&device, |writer| writer.write_all(b"nothing")).unwrap();
        assert!(fs::metadata("/dev/null").unwrap().file_type().is_char_device());
        assert!(fs::symlink_metadata(&device).unwrap().is_symlink());
        if Path::new("/dev/full").exists() {
            let full = directory.0.join("full");
            symlink("/dev/full", &full).unwrap();
            let error = write_whole(&full, |writer| writer.write_all(b"nothing")).unwrap_err();
            assert!(error.to_string().contains("full: "), "{error}");
        }
    }

    #[test]
    fn missing_directories_are_made() {
        let directory = TestDirectory::new("atomic-missing");
        write_whole(directory.0.join("new/below/a.txt"), |writer| writer.write_all(b"first")).unwrap();
        assert_eq!(fs::read(directory.0.join("new/below/a.txt")).unwrap(), b"first");
        let error = write_whole(directory.0.join("new/below/a.txt/b.txt"), |_| Ok(())).unwrap_err();
        assert!(error.to_string().contains("b.txt"), "{error}");
        fs::remove_dir_all(directory.0.join("new")).unwrap();
        assert!(write_whole(directory.0.join(".."), |_| Ok(())).is_err());
        assert!(check_writable(directory.0.join("..")).is_err());
        check_writable(directory.0.join("a.txt")).unwrap();
        assert_eq!(fs::read_dir(&directory.0).unwrap().count(), 0);
    }
}

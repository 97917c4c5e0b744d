//! Storage of the states to which a sweep comes back: in memory, or on disk except for the last one.

use std::convert::Infallible;
use std::io::{self, Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::output::write_whole;

/// A stack of states, each with the number of the step that follows it.
pub(super) trait CheckpointStore {
    /// Error of keeping or fetching a state.
    type Error;

    fn push(&mut self, step: usize, state: Vec<f64>) -> Result<(), Self::Error>;
    fn top(&self) -> Option<(usize, &[f64])>;
    fn pop(&mut self) -> Result<Option<Vec<f64>>, Self::Error>;
    fn count(&self) -> usize;
}

/// All in memory.
#[derive(Default)]
pub(super) struct InMemory(Vec<(usize, Vec<f64>)>);

impl CheckpointStore for InMemory {
    type Error = Infallible;

    fn push(&mut self, step: usize, state: Vec<f64>) -> Result<(), Infallible> {
        self.0.push((step, state));
        Ok(())
    }

    fn top(&self) -> Option<(usize, &[f64])> {
        self.0.last().map(|(step, state)| (*step, &state[..]))
    }

    fn pop(&mut self) -> Result<Option<Vec<f64>>, Infallible> {
        Ok(self.0.pop().map(|(_, state)| state))
    }

    fn count(&self) -> usize {
        self.0.len()
    }
}

/// A file per state, except for the last state, which is in memory; the files are gone when the sweep ends.
pub(super) struct OnDisk {
    directory: PathBuf,
    /// A number of its own in this process.
    sweep: usize,
    steps: Vec<usize>,
    top: Vec<f64>,
}

static SWEEPS: AtomicUsize = AtomicUsize::new(0);

impl OnDisk {
    pub fn new(directory: &Path) -> Self {
        let sweep = SWEEPS.fetch_add(1, Ordering::Relaxed);
        OnDisk { directory: directory.to_owned(), sweep, steps: vec![], top: vec![] }
    }

    fn path(&self, place: usize) -> PathBuf {
        self.directory.join(format!("state_{}_{}_{place}.bin", std::process::id(), self.sweep))
    }
}

impl CheckpointStore for OnDisk {
    type Error = io::Error;

    fn push(&mut self, step: usize, state: Vec<f64>) -> io::Result<()> {
        if let Some(place) = self.steps.len().checked_sub(1) {
            let bytes: Vec<u8> = self.top.iter().flat_map(|value| value.to_le_bytes()).collect();
            write_whole(self.path(place), |writer| writer.write_all(&bytes))?;
        }
        self.steps.push(step);
        self.top = state;
        Ok(())
    }

    fn top(&self) -> Option<(usize, &[f64])> {
        self.steps.last().map(|step| (*step, &self.top[..]))
    }

    fn pop(&mut self) -> io::Result<Option<Vec<f64>>> {
        if self.steps.pop().is_none() {
            return Ok(None);
        }
        let state = std::mem::take(&mut self.top);
        if let Some(place) = self.steps.len().checked_sub(1) {
            let path = self.path(place);
            let named =
                |error: io::Error| io::Error::new(error.kind(), format!("{}: {error}", path.display()));
            let mut bytes = Vec::with_capacity(8 * state.len());
            std::fs::File::open(&path).and_then(|mut file| file.read_to_end(&mut bytes)).map_err(named)?;
            if bytes.len() != 8 * state.len() {
                let found = format!("{} bytes in place of {}", bytes.len(), 8 * state.len());
                return Err(named(io::Error::new(io::ErrorKind::InvalidData, found)));
            }
            self.top = bytes.as_chunks().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
            std::fs::remove_file(&path).map_err(named)?;
        }
        Ok(Some(state))
    }

    fn count(&self) -> usize {
        self.steps.len()
    }
}

impl Drop for OnDisk {
    fn drop(&mut self) {
        for place in 0..self.steps.len().saturating_sub(1) {
            // Of a sweep that failed; a file that cannot be removed is not what failed.
            let _ = std::fs::remove_file(self.path(place));
        }
    }
}

/// Place and number of the states that a history keeps.
#[derive(Clone, Debug)]
pub(super) struct Storage {
    pub most: usize,
    pub directory: Option<PathBuf>,
}

impl Storage {
    /// All states in memory.
    pub const ALL: Storage = Storage { most: usize::MAX, directory: None };
}

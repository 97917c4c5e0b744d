//! States on disk, from which a run goes on with the same bits.

use std::fmt::Write as _;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;

use thiserror::Error;

use super::step::State;
use crate::field::{Field, FieldError};
use crate::instantiate::instantiate;
use crate::mesh::MeshError;
use crate::output::{checksum, write_whole};
use crate::solve::PerUnknown;
use crate::space::Space;

/// The states that a scheme reads, newest first, and the number of steps that led to them: what
/// [`TimeLoop::checkpoint`](super::TimeLoop::checkpoint) gives and [`TimeLoop::resumed`](super::TimeLoop::resumed) takes.
#[derive(Clone, Debug)]
pub struct Checkpoint<const D: usize> {
    /// Newest first, each with the states of all unknowns.
    pub states: Vec<Vec<State<D>>>,
    /// Steps taken.
    pub steps: usize,
}

/// Errors of a checkpoint.
#[derive(Debug, Error)]
#[allow(missing_docs)]
pub enum CheckpointError {
    /// The file cannot be read or written.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The file is no checkpoint, or a damaged one.
    #[error("{}, line {line}: {expected} was expected", path.display())]
    Content {
        path: PathBuf,
        /// Number of the line, from 1.
        line: usize,
        expected: &'static str,
    },
    /// It was written on another space.
    #[error("{} was written on another space: its nodes are not those of this one", path.display())]
    OtherSpace { path: PathBuf },
    /// One process's piece of a mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A number of a field is not finite.
    #[error("{}: {why}", path.display())]
    Field {
        path: PathBuf,
        /// The field's error.
        why: FieldError,
    },
}

/// The first line of the file.
const TITLE: &str = "states in time, version 1";

impl<const D: usize> Checkpoint<D> {
    /// The file, written whole or not at all, with decimal numbers that read back to the last bit.
    ///
    /// # Errors
    /// The system's error, with the name of the file.
    #[inline(never)]
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), CheckpointError> {
        self.states.iter().flatten().try_for_each(|state| no_piece(state.value.space()))?;
        let mut text = String::new();
        for state in self.states.iter().flatten() {
            let _ = writeln!(text, "{:e}", state.time);
            for field in [&state.value, &state.rate, &state.second_rate] {
                for value in field.values() {
                    let _ = writeln!(text, "{value:e}");
                }
            }
        }
        let spaces = self.states.iter().take(1).flatten().map(|state| state.value.space());
        let space = fingerprint(&spaces.collect::<Vec<_>>());
        let sum = checksum(text.bytes());
        let (steps, count) = (self.steps, self.states.len());
        Ok(write_whole(path, |file| write!(file, "{TITLE}\n{steps}\n{count}\n{space}\n{sum}\n{text}"))?)
    }

    /// The checkpoint in the file, on the space of the unknown, or on `[&first, &second]`, on which it was written; `None` if there is no
    /// file.
    ///
    /// # Errors
    /// [`CheckpointError`], with the name of the file.
    pub fn read<'s, const N: usize>(
        path: impl AsRef<Path>,
        spaces: impl PerUnknown<'s, Arc<Space<D>>, N>,
    ) -> Result<Option<Self>, CheckpointError> {
        Self::read_on(path.as_ref(), &spaces.per_unknown())
    }

    #[inline(never)]
    fn read_on(path: &Path, spaces: &[&Arc<Space<D>>]) -> Result<Option<Self>, CheckpointError> {
        spaces.iter().try_for_each(|space| no_piece(space))?;
        let text = match std::fs::read_to_string(path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => {
                return Err(io::Error::new(error.kind(), format!("{}: {error}", path.display())).into());
            }
            Ok(text) => text,
        };
        let mut lines = Lines { path, rest: &text, line: 0 };
        if lines.next("the title")? != TITLE {
            return Err(lines.unexpected("the title of a checkpoint"));
        }
        let steps = lines.number("the number of steps")?;
        let count: usize = lines.number("the number of states")?;
        if lines.number::<u64>("the number of the space")? != fingerprint(spaces) {
            return Err(CheckpointError::OtherSpace { path: path.to_owned() });
        }
        if lines.number::<u64>("the checksum")? != checksum(lines.rest.bytes()) {
            return Err(lines.unexpected("the checksum of what follows"));
        }
        let mut states = vec![];
        for _ in 0..count {
            let mut of_unknowns = vec![];
            for space in spaces {
                let time = lines.number("a time")?;
                let [value, rate, second_rate] =
                    [lines.field(space)?, lines.field(space)?, lines.field(space)?];
                of_unknowns.push(State { time, value, rate, second_rate });
            }
            states.push(of_unknowns);
        }
        Ok(Some(Checkpoint { states, steps }))
    }
}

/// Refuses the piece of a mesh that one process has, whose file would be that of all.
fn no_piece<const D: usize>(space: &Space<D>) -> Result<(), CheckpointError> {
    let instead = "take `PartCheckpoint`, a file of all processes";
    Ok(space.mesh().without_pieces("a checkpoint of one process", instead)?)
}

/// The lines of a file that are left.
struct Lines<'a> {
    path: &'a Path,
    rest: &'a str,
    line: usize,
}

impl<'a> Lines<'a> {
    fn unexpected(&self, expected: &'static str) -> CheckpointError {
        CheckpointError::Content { path: self.path.to_owned(), line: self.line, expected }
    }

    fn next(&mut self, expected: &'static str) -> Result<&'a str, CheckpointError> {
        self.line += 1;
        let (line, rest) = self.rest.split_once('\n').ok_or_else(|| self.unexpected(expected))?;
        self.rest = rest;
        Ok(line)
    }

    fn number<T: FromStr>(&mut self, expected: &'static str) -> Result<T, CheckpointError> {
        self.next(expected)?.parse().map_err(|_| self.unexpected(expected))
    }

    fn field<const D: usize>(&mut self, space: &Arc<Space<D>>) -> Result<Field<D>, CheckpointError> {
        let values: Result<Vec<f64>, _> =
            (0..space.unknowns()).map(|_| self.number("a value of a field")).collect();
        Field::from_values(space, values?)
            .map_err(|why| CheckpointError::Field { path: self.path.to_owned(), why })
    }
}

/// A number of the spaces' components and of the positions of their nodes.
fn fingerprint<const D: usize>(spaces: &[&Arc<Space<D>>]) -> u64 {
    checksum(spaces.iter().flat_map(|space| {
        let coordinates = space.positions().iter().flatten().flat_map(|x| x.to_bits().to_le_bytes());
        (space.components() as u64).to_le_bytes().into_iter().chain(coordinates)
    }))
}

instantiate!(checkpoint: fingerprint::<D>, Checkpoint::<D>::read_on);

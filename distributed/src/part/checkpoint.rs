//! Checkpoints of all processes: each writes what it has of fields and histories, by the vertices of nodes and cells in the whole mesh,
//! so that another number of processes can read them.
//!
//! The file that is named lists the others. It is written last, and names new files each time: a run that is interrupted leaves the checkpoint
//! before. It is text:
//!
//! ```text
//! forms checkpoint of a divided mesh, version 1
//! write 3
//! mesh 9b0f7c3e11d2a458
//! processes 2
//! number 5e-1 load
//! values temperature
//! on Nodes degree 2 []
//! piece 0 1874 5ab3d7c2690f1e48            for each process: first byte, length and checksum in its file
//! piece 0 1790 0d88e5f1c04b7a36
//! end 41c5…
//! ```
//!
//! The last line has the checksum of those before.
//!
//! A line of the others has a node or a cell in hexadecimal digits, and its values.

pub(super) mod entries;
mod index;

use std::collections::HashMap;
use std::ffi::OsStr;
use std::fmt::Write as _;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use forms_fem::contract::FieldValue;
use forms_fem::output::{checksum, write_whole};
use forms_fem::prelude::*;
use forms_fem::solve::DividedVectors;
use forms_fem::time::{Checkpoint, State};

use self::entries::{Entry, entries_of, entries_of_history, mesh_of};
use self::index::{Index, TITLE};
use super::MeshPart;
use super::shared_nodes::Key;
use crate::error::PetscError;

/// Numbers, fields and histories that all processes write together, to go on later on as many or as few processes.
///
/// ```no_run
/// # use forms_distributed::{PartCheckpoint, World};
/// # use forms_fem::prelude::*;
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let world = World::start()?;
/// # let part = world.rectangle([0.0; 2], [1.0; 2], [8; 2], CellShape::Triangle, 1)?;
/// # let space = Space::scalar(&part, 2)?;
/// # let mut u = Field::zero(&space);
/// if let Some(stored) = PartCheckpoint::read(&part, "out/run.checkpoint")? {
///     u = stored.field("temperature", &space)?;
/// }
/// // …
/// PartCheckpoint::new(&part).number("load", 0.5)?.field("temperature", &u)?.write("out/run.checkpoint")?;
/// # Ok(())
/// # }
/// ```
pub struct PartCheckpoint<'p, 'w, const D: usize> {
    part: &'p MeshPart<'w, D>,
    numbers: Vec<(String, f64)>,
    values: Vec<Values>,
}

/// Values of one name.
struct Values {
    name: String,
    /// The space, or the points.
    on: String,
    /// The lines of this process.
    text: String,
}

impl<'p, 'w, const D: usize> PartCheckpoint<'p, 'w, D> {
    /// An empty checkpoint on a part of a mesh.
    pub fn new(part: &'p MeshPart<'w, D>) -> Self {
        PartCheckpoint { part, numbers: vec![], values: vec![] }
    }

    /// A number that is the same on all processes, as that of a step.
    ///
    /// # Errors
    /// [`PetscError::Unfit`] of a name with a line break, or one that is there.
    pub fn number(mut self, name: &str, value: f64) -> Result<Self, PetscError> {
        self.check_name(name)?;
        self.numbers.push((name.to_owned(), value));
        Ok(self)
    }

    /// A field on the part.
    ///
    /// # Errors
    /// As [`PartCheckpoint::number`]; [`PetscError::Divided`] of spaces that parts do not have.
    pub fn field(self, name: &str, field: &Field<D>) -> Result<Self, PetscError> {
        let space = field.space();
        let vectors = self.part.vectors(&[space])?;
        let own = entries_of(&self.part.vertices, space).map(|mut entries| {
            entries.retain(|(_, first, _)| vectors.owns(*first));
            entries
        });
        let entries = self.part.world().agree(own)?;
        self.with(name, on_space(space), &entries, field.values())
    }

    /// The committed values of a history of cells or facets on the part.
    ///
    /// # Errors
    /// As [`PartCheckpoint::number`]; [`PetscError::Unfit`] of a history of another mesh.
    pub fn history<V: FieldValue>(
        self,
        name: &str,
        assembler: &Assembler<D>,
        history: &History<V, D>,
    ) -> Result<Self, PetscError> {
        let found = entries_of_history(self.part, assembler, history).and_then(|entries| {
            let values = assembler.history_values(history).map_err(unfit)?.concat();
            Ok((entries, values))
        });
        let (entries, values) = self.part.world().agree(found)?;
        self.with(name, ON_POINTS.to_owned(), &entries, &values)
    }

    /// The states of a motion with the number of its steps: [`TimeLoop::checkpoint`](forms_fem::time::TimeLoop::checkpoint).
    ///
    /// # Errors
    /// As [`PartCheckpoint::field`].
    pub fn motion(self, motion: &Checkpoint<D>) -> Result<Self, PetscError> {
        let sizes = [("steps", motion.steps), ("states", motion.states.len())];
        let mut all = self;
        for (name, size) in sizes {
            all = all.number(name, size as f64)?;
        }
        for (age, states) in motion.states.iter().enumerate() {
            for (unknown, state) in states.iter().enumerate() {
                let [time, fields @ ..] = names_of_state(age, unknown);
                all = all.number(&time, state.time)?;
                for (name, field) in fields.iter().zip([&state.value, &state.rate, &state.second_rate]) {
                    all = all.field(name, field)?;
                }
            }
        }
        Ok(all)
    }

    fn check_name(&self, name: &str) -> Result<(), PetscError> {
        let known = self.numbers.iter().map(|(name, _)| name).chain(self.values.iter().map(|one| &one.name));
        if name.contains(['\n', '\r']) || known.into_iter().any(|known| known == name) {
            return Err(unfit(format!("a checkpoint has \"{name}\" already, or its name has a line break")));
        }
        Ok(())
    }

    fn with(mut self, name: &str, on: String, entries: &[Entry], values: &[f64]) -> Result<Self, PetscError> {
        self.check_name(name)?;
        let mut text = String::new();
        for (key, first, count) in entries {
            key.iter().for_each(|number| _ = write!(text, "{number:x} "));
            text.push(':');
            values[*first..first + count].iter().for_each(|value| _ = write!(text, " {value:e}"));
            text.push('\n');
        }
        self.values.push(Values { name: name.to_owned(), on, text });
        Ok(self)
    }

    /// The files: `out/run.checkpoint` lists `run_w3_p0000.checkpoint` and so on, where 3 counts how often it was written. Each is written whole
    /// or not at all; those of the checkpoint before are removed last.
    ///
    /// # Errors
    /// [`PetscError::Unfit`] where a file cannot be written; the checkpoint before stays.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), PetscError> {
        let (path, world) = (path.as_ref(), self.part.world());
        let before = std::fs::read_to_string(path).ok();
        let before = before.as_deref().and_then(|text| Index::of(text).ok());
        let count = before.as_ref().map_or(0, |before| before.write).wrapping_add(1);
        let write = world.gather(count)?[0];
        let mut text = format!("{TITLE}\nwrite {write}\nmesh {:016x}\n", mesh_of(self.part)?);
        let _ = writeln!(text, "processes {}", world.size());
        self.numbers.iter().for_each(|(name, value)| _ = writeln!(text, "number {value:e} {name}"));
        let mut first = 0;
        for values in &self.values {
            let _ = writeln!(text, "values {}\non {}", values.name, values.on);
            let length = values.text.len() as u64;
            let own = [first, length, checksum(values.text.bytes())].map(|number| world.gather(number));
            let [starts, lengths, sums] = own;
            for ((start, length), sum) in starts?.iter().zip(lengths?).zip(sums?) {
                let _ = writeln!(text, "piece {start} {length} {sum:016x}");
            }
            first += length;
        }
        let sum = checksum(text.bytes());
        let _ = writeln!(text, "end {sum:016x}");
        let written = named(path, write, world.rank()).and_then(|own| {
            let all = |file: &mut dyn io::Write| {
                self.values.iter().try_for_each(|values| file.write_all(values.text.as_bytes()))
            };
            write_whole(own, |file| all(file)).map_err(unfit)
        });
        world.agree(written)?;
        let list = || write_whole(path, |file| file.write_all(text.as_bytes())).map_err(unfit);
        world.agree(if world.rank() == 0 { list() } else { Ok(()) })?;
        if let Some(before) = before.filter(|before| before.write != write) {
            for rank in (world.rank()..before.processes).step_by(world.size()) {
                // A file that cannot be removed is not what was asked for.
                let _ = named(path, before.write, rank).map(std::fs::remove_file);
            }
        }
        Ok(())
    }

    /// The checkpoint of a file, on another number of processes as well; `None` if there is no file.
    ///
    /// # Errors
    /// [`PetscError::Unfit`] of a file that is damaged, or belongs to another mesh.
    pub fn read(
        part: &'p MeshPart<'w, D>,
        path: impl AsRef<Path>,
    ) -> Result<Option<StoredCheckpoint<'p, 'w, D>>, PetscError> {
        let path = path.as_ref();
        let text = match std::fs::read_to_string(path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(unfit(format!("{}: {error}", path.display()))),
            Ok(text) => Ok(Some(text)),
        };
        let text = part.world().agree(text)?;
        let there = part.world().gather(u64::from(text.is_some()))?;
        let Some(text) = text.filter(|_| !there.contains(&0)) else {
            if there.contains(&1) {
                let message = format!("{} is there for some processes only", path.display());
                return Err(unfit(message));
            }
            return Ok(None);
        };
        let damaged = |why: String| unfit(format!("{}: {why}", path.display()));
        let index = part.world().agree(Index::of(&text).map_err(damaged))?;
        if index.mesh != mesh_of(part)? {
            return Err(unfit(format!("{} was written on another mesh", path.display())));
        }
        Ok(Some(StoredCheckpoint { part, path: path.to_owned(), index }))
    }
}

/// A checkpoint that was found.
pub struct StoredCheckpoint<'p, 'w, const D: usize> {
    part: &'p MeshPart<'w, D>,
    path: PathBuf,
    index: Index,
}

impl<const D: usize> StoredCheckpoint<'_, '_, D> {
    /// The number of a name.
    ///
    /// # Errors
    /// [`PetscError::Unfit`] where there is none.
    pub fn number(&self, name: &str) -> Result<f64, PetscError> {
        let found = self.index.numbers.iter().find(|(known, _)| known == name);
        let missing = || unfit(format!("{} has no number \"{name}\"", self.path.display()));
        found.map(|(_, value)| *value).ok_or_else(missing)
    }

    /// The field of a name, on a space of the part. All processes call it.
    ///
    /// # Errors
    /// [`PetscError::Unfit`] where there is none, where it was on another space, or where a file is missing or damaged.
    pub fn field(&self, name: &str, space: &Arc<Space<D>>) -> Result<Field<D>, PetscError> {
        let read = || {
            let values = self.values(
                name,
                &on_space(space),
                &entries_of(&self.part.vertices, space)?,
                space.unknowns(),
            )?;
            Field::from_values(space, values).map_err(unfit)
        };
        Ok(self.part.world().agree(read())?)
    }

    /// Commits the values of a name to a history on the part. All processes call it.
    ///
    /// # Errors
    /// As [`StoredCheckpoint::field`], for histories.
    pub fn history<V: FieldValue>(
        &self,
        name: &str,
        assembler: &Assembler<D>,
        history: &History<V, D>,
    ) -> Result<(), PetscError> {
        let read = || {
            let entries = entries_of_history(self.part, assembler, history)?;
            let count = entries.last().map_or(0, |(_, first, count)| first + count);
            let values = self.values(name, ON_POINTS, &entries, count)?;
            let values: Vec<Vec<f64>> = values.chunks(V::COMPONENTS).map(<[f64]>::to_vec).collect();
            assembler.set_history_values(history, &values).map_err(unfit)
        };
        Ok(self.part.world().agree(read())?)
    }

    /// The states of a motion, on the spaces of its unknowns: for [`TimeLoop::resumed`](forms_fem::time::TimeLoop::resumed).
    ///
    /// # Errors
    /// As [`StoredCheckpoint::field`].
    pub fn motion(&self, spaces: &[&Arc<Space<D>>]) -> Result<Checkpoint<D>, PetscError> {
        let [steps, count] = ["steps", "states"].map(|name| self.number(name));
        let mut states = vec![];
        for age in 0..count? as usize {
            let mut of_unknowns = vec![];
            for (unknown, space) in spaces.iter().enumerate() {
                let [time, value, rate, second_rate] = names_of_state(age, unknown);
                let [value, rate, second_rate] =
                    [value, rate, second_rate].map(|name| self.field(&name, space));
                let (value, rate, second_rate) = (value?, rate?, second_rate?);
                of_unknowns.push(State { time: self.number(&time)?, value, rate, second_rate });
            }
            states.push(of_unknowns);
        }
        Ok(Checkpoint { states, steps: steps? as usize })
    }

    /// The values of a name at these entries, from the files of all processes that wrote it.
    fn values(&self, name: &str, on: &str, entries: &[Entry], count: usize) -> Result<Vec<f64>, PetscError> {
        let path = self.path.display();
        let found = self.index.values.iter().find(|values| values.name == name);
        let found = found.ok_or_else(|| unfit(format!("{path} has no values \"{name}\"")))?;
        if found.on != on {
            return Err(unfit(format!(
                "{path}: \"{name}\" was written on {}, and is read on {on}",
                found.on
            )));
        }
        let wanted: HashMap<&Key, (usize, usize)> =
            entries.iter().map(|(key, first, count)| (key, (*first, *count))).collect();
        let (mut values, mut left) = (vec![0.0; count], wanted.len());
        for (rank, piece) in found.pieces.iter().enumerate() {
            let file = named(&self.path, self.index.write, rank)?;
            let damaged = |why: &dyn std::fmt::Display| unfit(format!("{}: {why}", file.display()));
            let text = piece.text(&file).map_err(|error| damaged(&error))?;
            if checksum(text.bytes()) != piece.checksum {
                return Err(damaged(&"its checksum is another one than that in the list"));
            }
            for line in text.lines() {
                let (key, own) = entry_of(line).ok_or_else(|| damaged(&"a line has no values"))?;
                let Some((first, count)) = wanted.get(&key) else { continue };
                if own.len() != *count {
                    return Err(damaged(&format!("{} values where {count} are wanted", own.len())));
                }
                values[*first..first + count].copy_from_slice(&own);
                left = left.saturating_sub(1);
            }
        }
        if left > 0 {
            return Err(unfit(format!("{path}: \"{name}\" has no values at {left} nodes or cells")));
        }
        Ok(values)
    }
}

/// The place of values at quadrature points.
const ON_POINTS: &str = "quadrature points";

fn on_space<const D: usize>(space: &Space<D>) -> String {
    format!("{} {} {:?}", space.elements(), space.scope(), space.shape())
}

fn names_of_state(age: usize, unknown: usize) -> [String; 4] {
    ["time", "value", "rate", "second rate"].map(|part| format!("{part} of unknown {unknown}, state {age}"))
}

/// The file of a process.
fn named(path: &Path, write: u64, rank: usize) -> Result<PathBuf, PetscError> {
    let stem = path.file_stem().and_then(OsStr::to_str);
    let stem = stem.ok_or_else(|| unfit(format!("{} names no file", path.display())))?;
    let own = path.with_file_name(format!("{stem}_w{write}_p{rank:04}"));
    Ok(path.extension().map_or(own.clone(), |extension| own.with_extension(extension)))
}

/// The key and the values of a line.
fn entry_of(line: &str) -> Option<(Key, Vec<f64>)> {
    let (key, values) = line.split_once(':')?;
    let key: Result<Key, _> = key.split_whitespace().map(|number| u64::from_str_radix(number, 16)).collect();
    let values: Result<Vec<f64>, _> = values.split_whitespace().map(str::parse).collect();
    Some((key.ok()?, values.ok()?))
}

fn unfit(why: impl ToString) -> PetscError {
    PetscError::Unfit { message: why.to_string() }
}

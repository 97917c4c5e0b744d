//! A descent on disk, from which it goes on after whatever stopped it.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use thiserror::Error;

use super::history::DescentState;
use crate::output::write_whole;

/// The state of a descent, and the settings that it belongs to. Numbers are written such that they read back as what they
/// were, to the last bit. The file also contains a checksum. A descent on a level set function has a state of its own type.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Checkpoint<S = DescentState> {
    /// Version of this package, whose later ones may take other steps.
    version: String,
    /// The program's settings, by name: all that the result depends on.
    pub settings: Value,
    /// Settings that a run which goes on may change, as the number of steps.
    pub changeable: Value,
    /// Steps whose shapes have been written.
    pub shapes: Vec<usize>,
    /// The state.
    pub state: S,
}

/// Errors of a checkpoint.
#[derive(Debug, Error)]
#[allow(missing_docs)]
pub enum CheckpointError {
    /// The file cannot be read or written.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The file is no checkpoint.
    #[error("{} is no checkpoint: {why}", path.display())]
    Content { path: PathBuf, why: String },
    /// The file's content is not what was written.
    #[error("{} is damaged: its checksum is {found}, not {expected}", path.display())]
    Damaged {
        path: PathBuf,
        /// The checksum that it states.
        expected: String,
        /// The checksum of what it holds.
        found: String,
    },
    /// It was made with other settings.
    #[error("the checkpoint was made with {name} = {was}, not {now}: remove it or use its settings")]
    OtherSettings {
        /// The first setting that differs.
        name: String,
        /// Its value in the checkpoint.
        was: String,
        /// Its value now.
        now: String,
    },
}

/// The content of the file.
#[derive(Serialize, Deserialize)]
struct Sealed {
    checksum: String,
    checkpoint: Value,
}

impl<S: Serialize + DeserializeOwned> Checkpoint<S> {
    /// A checkpoint of this version.
    pub fn new(settings: Value, changeable: Value, shapes: Vec<usize>, state: S) -> Self {
        Checkpoint { version: env!("CARGO_PKG_VERSION").to_owned(), settings, changeable, shapes, state }
    }

    /// The file, written whole or not at all. A program that is stopped while writing leaves the earlier file.
    ///
    /// # Errors
    /// The system's error, with the name of the file.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), CheckpointError> {
        let checkpoint = serde_json::to_value(self).map_err(io::Error::from)?;
        let sealed = Sealed { checksum: checksum(&checkpoint), checkpoint };
        let text = serde_json::to_string(&sealed).map_err(io::Error::from)?;
        Ok(write_whole(path, |file| writeln!(file, "{text}"))?)
    }

    /// The checkpoint in the file; `None` if there is no file.
    ///
    /// # Errors
    /// [`CheckpointError`], with the name of the file.
    pub fn read(path: impl AsRef<Path>) -> Result<Option<Self>, CheckpointError> {
        let path = path.as_ref();
        let text = match std::fs::read_to_string(path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => {
                return Err(io::Error::new(error.kind(), format!("{}: {error}", path.display())).into());
            }
            Ok(text) => text,
        };
        let content = |error: serde_json::Error| CheckpointError::Content {
            path: path.to_owned(),
            why: error.to_string(),
        };
        let Sealed { checksum: expected, checkpoint } = serde_json::from_str(&text).map_err(content)?;
        let found = checksum(&checkpoint);
        if found != expected {
            return Err(CheckpointError::Damaged { path: path.to_owned(), expected, found });
        }
        serde_json::from_value(checkpoint).map(Some).map_err(content)
    }

    /// The state, if the settings and the version are those of the checkpoint.
    ///
    /// # Errors
    /// [`CheckpointError::OtherSettings`] names the first that differs.
    pub fn state_for(self, settings: &Value) -> Result<S, CheckpointError> {
        let version = env!("CARGO_PKG_VERSION");
        if self.version != version {
            let name = format!("the version of {}", env!("CARGO_PKG_NAME"));
            return Err(CheckpointError::OtherSettings { name, was: self.version, now: version.to_owned() });
        }
        let nothing = serde_json::Map::new();
        let of = |value: &Value| value.as_object().cloned().unwrap_or_else(|| nothing.clone());
        let (was, now) = (of(&self.settings), of(settings));
        let differs = now.keys().chain(was.keys()).find(|name| was.get(*name) != now.get(*name));
        let text = |value: Option<&Value>| value.map_or_else(|| "nothing".to_owned(), Value::to_string);
        match differs {
            Some(name) => {
                let (was, now) = (text(was.get(name)), text(now.get(name)));
                Err(CheckpointError::OtherSettings { name: name.clone(), was, now })
            }
            None => Ok(self.state),
        }
    }
}

/// The checksum of what a checkpoint holds, over its text. A value that was read gives the text that was
/// written, whatever spaces stood between, for names are in alphabetical order and numbers come back to the last bit.
fn checksum(checkpoint: &Value) -> String {
    format!("{:016x}", crate::output::checksum(checkpoint.to_string().bytes()))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::super::history::{Row, Step, StopReason};
    use super::*;

    fn checkpoint() -> Checkpoint {
        // Numbers whose decimals are hard to read exactly.
        let nodes = vec![
            0.1 + 0.2,
            -0.0,
            f64::MIN_POSITIVE,
            5e-324,
            9007199254740993.0,
            1.0 / 3.0,
            2.225_073_858_507_201e-308,
        ];
        let step = Step { factor: 1e-17, trials: 2, longest_move: 0.7, multiplier: -1.1, gradient_norm: 3.3 };
        let row = Row {
            criterion: 0.3,
            constraint: None,
            quality: 0.9,
            smoothed: false,
            remeshed: None,
            step: Some(step),
        };
        let state = DescentState {
            nodes,
            mesh: None,
            step: Some(0.1),
            history: vec![row],
            finish: Some(StopReason::NoStep("why".into())),
        };
        let settings = json!({ "holes": 24, "radius": 2.5 });
        Checkpoint::new(settings, json!({ "steps": 7 }), vec![0, 1], state)
    }

    #[test]
    fn numbers_come_back_to_the_last_bit() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("checkpoint.json");
        assert!(Checkpoint::<DescentState>::read(&path).unwrap().is_none());
        let written = checkpoint();
        written.write(&path).unwrap();
        let read = Checkpoint::<DescentState>::read(&path).unwrap().unwrap();
        assert_eq!(read, written);
        let bits = |checkpoint: &Checkpoint| -> Vec<u64> {
            checkpoint.state.nodes.iter().map(|x| x.to_bits()).collect()
        };
        assert_eq!(bits(&read), bits(&written));
    }

    #[test]
    fn other_settings_are_named() {
        let settings = json!({ "holes": 12, "radius": 2.5 });
        let message = checkpoint().state_for(&settings).unwrap_err().to_string();
        assert!(message.starts_with("the checkpoint was made with holes = 24, not 12"), "{message}");
        let message = checkpoint().state_for(&json!({ "holes": 24 })).unwrap_err().to_string();
        assert!(message.starts_with("the checkpoint was made with radius = 2.5, not nothing"), "{message}");
        assert!(checkpoint().state_for(&json!({ "radius": 2.5, "holes": 24 })).is_ok());
    }

    #[test]
    fn another_version_is_named() {
        let older = Checkpoint { version: "0.0.1".into(), ..checkpoint() };
        let message = older.state_for(&checkpoint().settings).unwrap_err().to_string();
        let expected = "the checkpoint was made with the version of forms-fem = 0.0.1, not ";
        assert!(message.starts_with(expected), "{message}");
    }

    /// A digit that has changed leaves a number, and a file that can be read.
    #[test]
    fn a_damaged_checkpoint_is_refused() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("checkpoint.json");
        checkpoint().write(&path).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        for (sound, damaged) in [("0.30000000000000004", "0.30000000000000008"), ("[0,1]", "[0,3]")] {
            assert!(text.contains(sound), "{text}");
            std::fs::write(&path, text.replace(sound, damaged)).unwrap();
            let message = Checkpoint::<DescentState>::read(&path).unwrap_err().to_string();
            assert!(message.contains("checkpoint.json is damaged: its checksum is "), "{message}");
        }
        // Spaces and lines are no damage.
        let spaced = serde_json::to_string_pretty(&serde_json::from_str::<Value>(&text).unwrap()).unwrap();
        std::fs::write(&path, spaced).unwrap();
        assert_eq!(Checkpoint::<DescentState>::read(&path).unwrap().unwrap(), checkpoint());
    }

    #[test]
    fn a_file_that_is_no_checkpoint_is_named() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("checkpoint.json");
        std::fs::write(&path, "{ \"settings\": 1 }").unwrap();
        let message = Checkpoint::<DescentState>::read(&path).unwrap_err().to_string();
        assert!(message.contains("checkpoint.json is no checkpoint: "), "{message}");
    }
}

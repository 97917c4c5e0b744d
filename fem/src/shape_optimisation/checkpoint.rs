//! A descent on disk, from which it goes on after whatever stopped it.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::Value;
use thiserror::Error;

use super::history::DescentState;
use crate::output::write_whole;

/// The state of a descent, and the settings that it belongs to. Numbers are written such that they read back as what they
/// were, to the last bit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Checkpoint {
    /// The program's settings, by name: all that the result depends on.
    pub settings: Value,
    /// The state.
    pub state: DescentState,
}

/// Why a checkpoint cannot be used.
#[derive(Debug, Error)]
pub enum CheckpointError {
    /// The file cannot be read or written.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The file is no checkpoint.
    #[error("{} is no checkpoint: {why}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What is wrong in it.
        why: String,
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

impl Checkpoint {
    /// Writes the file whole or not at all: whoever is stopped while writing leaves the file before.
    ///
    /// # Errors
    /// What the system says, with the name of the file.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), CheckpointError> {
        let text = serde_json::to_string(self).map_err(io::Error::from)?;
        Ok(write_whole(path, |file| writeln!(file, "{text}"))?)
    }

    /// Reads the file; `None` if there is none.
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
        serde_json::from_str(&text)
            .map(Some)
            .map_err(|error| CheckpointError::Content { path: path.to_owned(), why: error.to_string() })
    }

    /// The state, if the settings are those of the checkpoint.
    ///
    /// # Errors
    /// [`CheckpointError::OtherSettings`] names the first that differs.
    pub fn state_for(self, settings: &Value) -> Result<DescentState, CheckpointError> {
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

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::super::history::{Finish, Row, Step};
    use super::*;
    use crate::output::atomic::tests::TestDirectory;

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
        let row = Row { criterion: 0.3, constraint: None, quality: 0.9, smoothed: false, step: Some(step) };
        let state = DescentState {
            nodes,
            step: Some(0.1),
            history: vec![row],
            finish: Some(Finish::NoStep("why".into())),
        };
        Checkpoint { settings: json!({ "holes": 24, "radius": 2.5 }), state }
    }

    #[test]
    fn numbers_come_back_to_the_last_bit() {
        let directory = TestDirectory::new("checkpoint");
        let path = directory.0.join("checkpoint.json");
        assert!(Checkpoint::read(&path).unwrap().is_none());
        let written = checkpoint();
        written.write(&path).unwrap();
        let read = Checkpoint::read(&path).unwrap().unwrap();
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
    fn a_file_that_is_no_checkpoint_is_named() {
        let directory = TestDirectory::new("no-checkpoint");
        let path = directory.0.join("checkpoint.json");
        std::fs::write(&path, "{ \"settings\": 1 }").unwrap();
        let message = Checkpoint::read(&path).unwrap_err().to_string();
        assert!(message.contains("checkpoint.json is no checkpoint: "), "{message}");
    }
}

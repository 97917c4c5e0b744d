//! The list of a checkpoint's files.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;
use std::str::Lines;

use forms_fem::output::checksum;

/// The first line.
pub(super) const TITLE: &str = "forms checkpoint of a divided mesh, version 1";

/// Contents of a list.
pub(super) struct Index {
    /// The number of times it was written.
    pub write: u64,
    pub mesh: u64,
    pub processes: usize,
    pub numbers: Vec<(String, f64)>,
    pub values: Vec<StoredValues>,
}

pub(super) struct StoredValues {
    pub name: String,
    pub on: String,
    /// Of each process.
    pub pieces: Vec<StoredPiece>,
}

/// Place of a process's lines in its file.
pub(super) struct StoredPiece {
    first: u64,
    length: usize,
    pub checksum: u64,
}

impl StoredPiece {
    pub fn text(&self, path: &Path) -> io::Result<String> {
        let mut file = File::open(path)?;
        file.seek(SeekFrom::Start(self.first))?;
        let mut text = String::new();
        file.take(self.length as u64).read_to_string(&mut text)?;
        Ok(text)
    }
}

impl Index {
    pub fn of(text: &str) -> Result<Self, String> {
        let Some(lines) = text.strip_prefix(TITLE) else {
            return Err("it is no checkpoint of a divided mesh".to_owned());
        };
        let (before, sum) = text.rsplit_once("end ").unwrap_or((text, ""));
        let is_whole = sum.strip_suffix('\n') == Some(&format!("{:016x}", checksum(before.bytes())));
        let found = is_whole.then(|| Self::after_title(&mut lines.trim_start().lines())).flatten();
        found.ok_or_else(|| "it is damaged".to_owned())
    }

    fn after_title(lines: &mut Lines<'_>) -> Option<Self> {
        let mut next = |word: &str| lines.next()?.strip_prefix(word)?.strip_prefix(' ');
        let write = next("write")?.parse().ok()?;
        let mesh = u64::from_str_radix(next("mesh")?, 16).ok()?;
        let processes = next("processes")?.parse().ok()?;
        let mut index = Index { write, mesh, processes, numbers: vec![], values: vec![] };
        loop {
            let line = lines.next()?;
            if line.starts_with("end ") {
                let whole = index.values.iter().all(|values| values.pieces.len() == processes);
                return whole.then_some(index);
            }
            let (word, rest) = line.split_once(' ')?;
            match word {
                "number" => {
                    let (value, name) = rest.split_once(' ')?;
                    index.numbers.push((name.to_owned(), value.parse().ok()?));
                }
                "values" => {
                    let on = lines.next()?.strip_prefix("on ")?.to_owned();
                    index.values.push(StoredValues { name: rest.to_owned(), on, pieces: vec![] });
                }
                "piece" => {
                    let mut words = rest.split(' ');
                    let (first, length) = (words.next()?.parse().ok()?, words.next()?.parse().ok()?);
                    let checksum = u64::from_str_radix(words.next()?, 16).ok()?;
                    index.values.last_mut()?.pieces.push(StoredPiece { first, length, checksum });
                }
                _ => return None,
            }
        }
    }
}

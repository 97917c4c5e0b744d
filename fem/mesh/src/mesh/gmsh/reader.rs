//! Numbers from the bytes of a file, written out or binary, and the position of each.

use super::error::{GmshError, GmshProblem};
use crate::mesh::imported::{FilePosition, shortened};

/// A file's way of writing numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

/// A place in a file, and how its numbers are read.
pub(super) struct Reader<'a> {
    pub(super) file: &'a str,
    bytes: &'a [u8],
    /// The next byte.
    pub(super) at: usize,
    pub(super) encoding: Encoding,
    /// Bytes of a binary `size_t`: 4 or 8.
    pub(super) word: usize,
    /// The section that is being read.
    pub(super) section: Option<String>,
}

/// The least size of an item of a list: bounds the number of items by the bytes left.
#[derive(Clone, Copy, Default)]
pub(super) struct Item {
    pub(super) integers: usize,
    pub(super) sizes: usize,
    pub(super) reals: usize,
}

type Result<T> = std::result::Result<T, GmshError>;

impl<'a> Reader<'a> {
    pub(super) fn new(file: &'a str, bytes: &'a [u8]) -> Self {
        Reader { file, bytes, at: 0, encoding: Encoding::Text, word: 8, section: None }
    }

    /// An error at an offset.
    pub(super) fn error_at(&self, at: usize, problem: GmshProblem) -> GmshError {
        let at = at.min(self.bytes.len());
        let position = if self.encoding == Encoding::Text {
            FilePosition::Line(1 + self.bytes[..at].iter().filter(|&&byte| byte == b'\n').count())
        } else {
            FilePosition::Byte(at)
        };
        let (file, section) = (self.file.to_owned(), self.section.clone());
        GmshError { file, position: Some(position), section, problem }
    }

    /// An error of the file as a whole.
    pub(super) fn error_of_file(&self, problem: GmshProblem) -> GmshError {
        GmshError { file: self.file.to_owned(), position: None, section: None, problem }
    }

    pub(super) fn truncated(&self, expected: &str) -> GmshError {
        self.error_at(self.bytes.len(), GmshProblem::Truncated { expected: expected.to_owned() })
    }

    pub(super) fn unexpected(&self, at: usize, expected: &str, found: &[u8]) -> GmshError {
        let (expected, found) = (expected.to_owned(), shortened(found));
        self.error_at(at, GmshProblem::Unexpected { expected, found })
    }

    /// The first characters of the file, for a message.
    pub(super) fn start(&self) -> String {
        shortened(self.bytes.split(|&byte| byte == b'\n').next().unwrap_or_default())
    }

    pub(super) fn skip_white(&mut self) {
        while self.bytes.get(self.at).is_some_and(u8::is_ascii_whitespace) {
            self.at += 1;
        }
    }

    /// The place of the next number: in text behind white space.
    pub(super) fn here(&mut self) -> usize {
        if self.encoding == Encoding::Text {
            self.skip_white();
        }
        self.at
    }

    pub(super) fn is_at_end(&self) -> bool {
        self.at >= self.bytes.len()
    }

    /// The rest of the line, without white space at its ends; the next byte is then the next line's first.
    pub(super) fn line(&mut self) -> &'a [u8] {
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|&byte| byte == b'\n').unwrap_or(rest.len());
        self.at = (self.at + length + 1).min(self.bytes.len());
        rest[..length].trim_ascii()
    }

    fn word_of_text(&mut self, expected: &str) -> Result<(usize, &'a [u8])> {
        self.skip_white();
        let rest = &self.bytes[self.at..];
        if rest.is_empty() {
            return Err(self.truncated(expected));
        }
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        let at = self.at;
        self.at += length;
        Ok((at, &rest[..length]))
    }

    /// A number that is written out, whatever the encoding of the rest.
    pub(super) fn text<T: std::str::FromStr>(&mut self, expected: &str) -> Result<T> {
        let (at, word) = self.word_of_text(expected)?;
        let number = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
        number.ok_or_else(|| self.unexpected(at, expected, word))
    }

    fn binary<const N: usize>(&mut self, expected: &str) -> Result<[u8; N]> {
        let Some(bytes) = self.bytes[self.at..].first_chunk::<N>() else {
            return Err(self.truncated(expected));
        };
        self.at += N;
        let mut bytes = *bytes;
        if self.encoding == Encoding::BigEndian {
            bytes.reverse();
        }
        Ok(bytes)
    }

    /// An `int`.
    pub(super) fn integer(&mut self, expected: &str) -> Result<i64> {
        match self.encoding {
            Encoding::Text => self.text(expected),
            _ => self.binary(expected).map(|bytes| i32::from_le_bytes(bytes).into()),
        }
    }

    /// A `size_t`.
    pub(super) fn size(&mut self, expected: &str) -> Result<u64> {
        match (self.encoding, self.word) {
            (Encoding::Text, _) => self.text(expected),
            (_, 4) => self.binary(expected).map(|bytes| u32::from_le_bytes(bytes).into()),
            _ => self.binary(expected).map(u64::from_le_bytes),
        }
    }

    /// A `double`.
    pub(super) fn real(&mut self, expected: &str) -> Result<f64> {
        match self.encoding {
            Encoding::Text => self.text(expected),
            _ => self.binary(expected).map(f64::from_le_bytes),
        }
    }

    /// A list's length as a `size_t`, no more than the rest of the file can hold.
    pub(super) fn count(&mut self, what: &'static str, item: Item) -> Result<usize> {
        let at = self.here();
        let count = self.size(&format!("the number of {what}"))?;
        self.check_count(at, what, count, item)
    }

    pub(super) fn check_count(&self, at: usize, what: &'static str, count: u64, item: Item) -> Result<usize> {
        let least = match self.encoding {
            // A digit and a separator.
            Encoding::Text => 2 * (item.integers + item.sizes + item.reals),
            _ => 4 * item.integers + self.word * item.sizes + 8 * item.reals,
        };
        let left = self.bytes.len() - self.at;
        match usize::try_from(count).ok().and_then(|count| Some((count, count.checked_mul(least)?))) {
            Some((count, bytes)) if bytes <= left + 1 => Ok(count),
            _ => Err(self.error_at(at, GmshProblem::Count { what, count, left })),
        }
    }

    /// The line that closes the section.
    pub(super) fn end_section(&mut self, name: &str) -> Result<()> {
        let expected = format!("$End{name}");
        let (at, word) = self.word_of_text(&expected)?;
        if word == expected.as_bytes() {
            return Ok(());
        }
        Err(self.unexpected(at, &expected, word))
    }

    /// Goes behind the line that closes the section.
    pub(super) fn skip_section(&mut self, name: &str) -> Result<()> {
        let mark = format!("$End{name}");
        let rest = &self.bytes[self.at..];
        match rest.windows(mark.len()).position(|window| window == mark.as_bytes()) {
            Some(position) => {
                self.at += position + mark.len();
                Ok(())
            }
            None => Err(self.truncated(&mark)),
        }
    }
}

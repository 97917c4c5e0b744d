//! Words, lines and numbers of a legacy file.

use super::array::{NumberType, Values};
use super::error::VtkProblem;
use crate::mesh::imported::{FilePosition, shortened};

type Result<T> = std::result::Result<T, VtkProblem>;

/// A place in a legacy file.
pub(super) struct Reader<'a> {
    bytes: &'a [u8],
    /// The next byte.
    pub(super) at: usize,
    /// Numbers are bytes, the first one of a number being the largest.
    pub(super) binary: bool,
}

impl<'a> Reader<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Reader { bytes, at: 0, binary: false }
    }

    /// An unexpected text at an offset.
    pub(super) fn unexpected(&self, at: usize, expected: &str) -> VtkProblem {
        let mut problem = super::markup::unexpected(self.bytes, at, expected);
        if let (VtkProblem::Unexpected { position, .. }, true) = (&mut problem, self.binary) {
            *position = FilePosition::Byte(at);
        }
        problem
    }

    fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    /// The rest of the line.
    pub(super) fn line(&mut self) -> &'a [u8] {
        let rest = self.rest();
        let length = rest.iter().position(|&byte| byte == b'\n').unwrap_or(rest.len());
        self.at = (self.at + length + 1).min(self.bytes.len());
        rest[..length].trim_ascii()
    }

    /// The words of the rest of the line.
    pub(super) fn words(&mut self) -> Vec<&'a str> {
        let line = std::str::from_utf8(self.line()).unwrap_or_default();
        line.split_ascii_whitespace().collect()
    }

    /// The next word; none at the end.
    pub(super) fn word(&mut self) -> Option<&'a str> {
        self.at += self.rest().iter().take_while(|byte| byte.is_ascii_whitespace()).count();
        let rest = self.rest();
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.at += length;
        // What is not UTF-8 is no word that anything expects.
        (length > 0).then(|| std::str::from_utf8(&rest[..length]).unwrap_or("\u{fffd}"))
    }

    /// The next word, if it is this one, in whatever case.
    pub(super) fn skip(&mut self, expected: &str) -> bool {
        let at = self.at;
        let there = self.word().is_some_and(|word| word.eq_ignore_ascii_case(expected));
        if !there {
            self.at = at;
        }
        there
    }

    /// The next word, which must be this one.
    pub(super) fn expect(&mut self, expected: &str) -> Result<()> {
        let at = self.at;
        if self.skip(expected) { Ok(()) } else { Err(self.unexpected(at, expected)) }
    }

    /// A count.
    pub(super) fn count(&mut self, what: &str) -> Result<usize> {
        let at = self.at;
        let count = self.word().and_then(|word| word.parse().ok());
        count.ok_or_else(|| self.unexpected(at, what))
    }

    /// A type of numbers.
    pub(super) fn number_type(&mut self) -> Result<NumberType> {
        let at = self.at;
        let found = self.word().and_then(NumberType::of);
        found.ok_or_else(|| self.unexpected(at, "a type of numbers"))
    }

    /// The given number of numbers, which begin on the next line where they are bytes.
    pub(super) fn numbers(&mut self, name: &str, number: NumberType, count: Option<usize>) -> Result<Values> {
        let cut =
            |count: &str| VtkProblem::array(name, format!("the file ends before its {count} numbers do"));
        let count = count.ok_or_else(|| cut("uncountable"))?;
        if self.binary {
            self.line();
            let bytes = count.checked_mul(number.size).and_then(|length| self.rest().get(..length));
            let bytes = bytes.ok_or_else(|| cut(&count.to_string()))?;
            self.at += bytes.len();
            return Ok(number.decode(bytes, false));
        }
        // A digit and a separator: a count that lies reserves nothing.
        if count > self.rest().len().div_ceil(2) {
            return Err(cut(&count.to_string()));
        }
        let mut words = Vec::with_capacity(count);
        for _ in 0..count {
            words.push(self.word().ok_or_else(|| cut(&count.to_string()))?);
        }
        let wrong = |word: &str| {
            VtkProblem::array(name, format!("{:?} is no such number", shortened(word.as_bytes())))
        };
        number.parse(words.into_iter()).map_err(wrong)
    }

    /// Goes behind the empty line that ends a block whose first word was read.
    pub(super) fn skip_block(&mut self) {
        self.line();
        while self.at < self.bytes.len() && !self.line().is_empty() {}
    }
}

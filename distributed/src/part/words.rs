//! Lists of numbers that go from process to process: lists in them come behind their lengths.

use forms_fem::mesh::Facet;

pub(super) fn word_of(facet: &Facet) -> u64 {
    u64::from(facet.cell) << 8 | u64::from(facet.local)
}

pub(super) fn facet_of(word: &u64) -> Facet {
    Facet { cell: (word >> 8) as u32, local: *word as u8 }
}

/// Adds a list behind its length.
pub(super) fn add(words: &mut Vec<u64>, list: impl Iterator<Item = u64>) {
    let at = words.len();
    words.push(0);
    words.extend(list);
    words[at] = (words.len() - at - 1) as u64;
}

/// The rest of a list.
pub(super) struct Words<'a>(pub &'a [u64]);

impl Words<'_> {
    pub fn number(&mut self) -> Option<usize> {
        let (first, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(*first as usize)
    }

    pub fn list<T>(&mut self, of: impl Fn(&u64) -> T) -> Option<Vec<T>> {
        let length = self.number()?;
        let (list, rest) = self.0.split_at_checked(length)?;
        self.0 = rest;
        Some(list.iter().map(of).collect())
    }

    pub fn text(&mut self) -> Option<String> {
        String::from_utf8(self.list(|byte| *byte as u8)?).ok()
    }
}

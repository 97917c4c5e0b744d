//! Lists of numbers that go from process to process: lists in them come behind their lengths.

use forms_fem::mesh::Facet;
use forms_fem::solve::communicator::Fingerprint;

use crate::error::PetscError;
use crate::world::World;

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

/// Sends a list to each of some processes, and receives one of any length from each: all these make a call of the same name, with a list for this
/// process.
pub(super) fn exchanged(
    world: &World,
    name: &str,
    lists: Vec<(usize, Vec<u64>)>,
) -> Result<Vec<(usize, Vec<u64>)>, PetscError> {
    let number = |what: &str| Fingerprint::default().text(what).text(name).finish();
    let ranks: Vec<usize> = lists.iter().map(|(rank, _)| *rank).collect();
    let lengths = lists.iter().map(|(rank, list)| (*rank, vec![list.len() as u64])).collect();
    let lengths = world.meetings().exchange(number("lengths"), lengths, &vec![1; ranks.len()])?;
    let lengths: Vec<usize> = lengths.iter().map(|length| length[0] as usize).collect();
    let found = world.meetings().exchange(number("lists"), lists, &lengths)?;
    Ok(ranks.into_iter().zip(found).collect())
}

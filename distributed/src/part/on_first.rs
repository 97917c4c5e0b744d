//! Fields of the whole mesh on the first process, and back: for what needs all of the mesh, as refinement does.

use std::collections::HashMap;

use forms_fem::prelude::*;
use forms_fem::solve::DividedVectors;
use forms_fem::solve::communicator::Fingerprint;

use super::MeshPart;
use super::checkpoint::entries::{Entry, entries_of, mesh_of, number_of};
use super::shared_nodes::{Key, Vertices};
use super::words::{Words, add};
use crate::error::PetscError;

/// The place of a key's first value, and their number.
type Places = HashMap<Key, (usize, usize)>;

impl<const D: usize> MeshPart<'_, D> {
    /// A field on the part as one of the whole mesh on the first process, whose space there is `whole`; nothing on the others. For a cycle of
    /// adaptivity: indicators of the cells go to the first process, which refines the mesh and scatters it again.
    ///
    /// # Errors
    /// [`PetscError::Unfit`] where the first process has no space, one of other elements, or one on another mesh.
    pub fn on_first(
        &self,
        field: &Field<D>,
        whole: Option<&Arc<Space<D>>>,
    ) -> Result<Option<Field<D>>, PetscError> {
        let (world, space) = (self.world(), field.space());
        let vectors = self.vectors(&[space])?;
        let whole = self.whole(space, whole)?;
        let own = world.agree(entries_of(&self.vertices, space))?;
        let mut words = vec![];
        for (key, first, count) in own.iter().filter(|(_, first, _)| vectors.owns(*first)) {
            add(&mut words, key.iter().copied());
            add(&mut words, field.values()[*first..first + count].iter().map(|value| value.to_bits()));
        }
        let lengths = world.gather(words.len() as u64)?;
        let number = Fingerprint::default().text("fields on the first process").finish();
        let (mut values, mut left) = (vec![], 0);
        let mut written = Ok(());
        let lists = match world.rank() {
            0 => (1..world.size()).map(|rank| (rank, vec![])).collect(),
            _ => vec![(0, words.clone())],
        };
        let expected = |(rank, _): &(usize, Vec<u64>)| if *rank == 0 { 0 } else { lengths[*rank] as usize };
        let expected: Vec<usize> = lists.iter().map(expected).collect();
        let found = world.meetings().exchange(number, lists, &expected)?;
        if let Some((whole, places)) = &whole {
            (values, left) = (vec![0.0; whole.unknowns()], places.len());
            written = [words].iter().chain(&found).try_for_each(|words| {
                left -= write(words, places, &mut values)?;
                Ok(())
            });
        }
        world.agree(written)?;
        world.agree(if left == 0 { Ok(()) } else { Err(unfit("a field has no values at some nodes")) })?;
        let field = whole.map(|(whole, _)| Field::from_values(&whole, values)).transpose();
        Ok(world.agree(field.map_err(|error| unfit(&error.to_string())))?)
    }

    /// A field on a space of the part with the values that the first process has of the whole mesh; other processes give nothing.
    ///
    /// # Errors
    /// As [`MeshPart::on_first`].
    pub fn from_first(
        &self,
        space: &Arc<Space<D>>,
        whole: Option<&Field<D>>,
    ) -> Result<Field<D>, PetscError> {
        let world = self.world();
        // That the space is on this part.
        self.vectors(&[space])?;
        let known = self.whole(space, whole.map(Field::space))?;
        let own = world.agree(entries_of(&self.vertices, space))?;
        let mut words = vec![];
        own.iter().for_each(|(key, ..)| add(&mut words, key.iter().copied()));
        let lengths = world.gather(words.len() as u64)?;
        let counts = world.gather(own.iter().map(|(_, _, count)| *count as u64).sum())?;
        let number = |what: &str| Fingerprint::default().text(what).finish();
        let is_first = world.rank() == 0;
        let others = || (1..world.size()).map(|rank| (rank, vec![]));
        let asked = if is_first { others().collect() } else { vec![(0, words.clone())] };
        let expected: Vec<usize> = match is_first {
            true => lengths[1..].iter().map(|length| *length as usize).collect(),
            false => vec![0],
        };
        let asked = world.meetings().exchange(number("nodes of a part"), asked, &expected)?;
        let read = |words: &[u64]| match (&known, whole) {
            (Some((_, places)), Some(field)) => values_of(words, places, field.values()),
            _ => Ok(vec![]),
        };
        let own_values = read(if is_first { &words } else { &[] });
        let answers: Result<Vec<Vec<u64>>, PetscError> = match is_first {
            true => asked.iter().map(|words| read(words)).collect(),
            false => Ok(vec![vec![]]),
        };
        let (own_values, answers) = (world.agree(own_values)?, world.agree(answers)?);
        let ranks = if is_first { 1..world.size() } else { 0..1 };
        let expected = if is_first { vec![0; ranks.len()] } else { vec![counts[world.rank()] as usize] };
        let lists = ranks.zip(answers).collect();
        let found = world.meetings().exchange(number("values of a part"), lists, &expected)?;
        let found = if is_first { &own_values } else { &found[0] };
        let (mut values, mut rest) = (vec![0.0; space.unknowns()], found.iter());
        for (_, first, count) in &own {
            let bits = rest.by_ref().take(*count);
            values[*first..first + count].iter_mut().zip(bits).for_each(|(value, bits)| {
                *value = f64::from_bits(*bits);
            });
        }
        Ok(world.agree(Field::from_values(space, values).map_err(|error| unfit(&error.to_string())))?)
    }

    /// The space of the first process with the places of its nodes.
    fn whole(
        &self,
        space: &Arc<Space<D>>,
        whole: Option<&Arc<Space<D>>>,
    ) -> Result<Option<(Arc<Space<D>>, Places)>, PetscError> {
        let (world, mesh) = (self.world(), mesh_of(self)?);
        let found = match whole.filter(|_| world.rank() == 0) {
            None if world.rank() == 0 => {
                Err(unfit("the first process has to give a space on the whole mesh"))
            }
            None => Ok(None),
            Some(whole) => {
                let numbers = (0..whole.mesh().node_count() as u64).collect();
                let vertices = Vertices { numbers, sharers: Default::default() };
                let alike = [(space.elements(), space.scope()), (whole.elements(), whole.scope())];
                if alike[0] != alike[1] || space.shape() != whole.shape() {
                    Err(unfit("the space of the whole mesh has other elements than that of the part"))
                } else if number_of(whole.mesh(), &vertices.numbers) != mesh {
                    Err(unfit("the space of the first process is on another mesh than the parts are of"))
                } else {
                    entries_of(&vertices, whole).map(|entries| Some((Arc::clone(whole), places(entries))))
                }
            }
        };
        Ok(world.agree(found)?)
    }
}

fn places(entries: Vec<Entry>) -> Places {
    entries.into_iter().map(|(key, first, count)| (key, (first, count))).collect()
}

/// Writes the values of a list of keys and values to their places; the number of keys.
fn write(words: &[u64], places: &Places, values: &mut [f64]) -> Result<usize, PetscError> {
    let (mut rest, mut count) = (Words(words), 0);
    while let Some(key) = rest.list(|number| *number) {
        let own = rest.list(|bits| f64::from_bits(*bits)).unwrap_or_default();
        let (first, length) = place_of(&key, places)?;
        if own.len() != length {
            return Err(unfit("a node has another number of values than in the whole mesh"));
        }
        values[first..first + length].copy_from_slice(&own);
        count += 1;
    }
    Ok(count)
}

/// The values at the nodes of a list of keys, as bits.
fn values_of(words: &[u64], places: &Places, values: &[f64]) -> Result<Vec<u64>, PetscError> {
    let (mut rest, mut found) = (Words(words), vec![]);
    while let Some(key) = rest.list(|number| *number) {
        let (first, length) = place_of(&key, places)?;
        found.extend(values[first..first + length].iter().map(|value| value.to_bits()));
    }
    Ok(found)
}

fn place_of(key: &Key, places: &Places) -> Result<(usize, usize), PetscError> {
    places.get(key).copied().ok_or_else(|| unfit("the whole mesh has no such node"))
}

fn unfit(message: &str) -> PetscError {
    PetscError::Unfit { message: message.to_owned() }
}

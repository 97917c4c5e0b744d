//! Vectors over the unknowns of spaces on a part: what is at shared nodes goes between the processes that have them.

use std::collections::BTreeSet;
use std::rc::Rc;

use forms_fem::solve::communicator::Fingerprint;
use forms_fem::solve::{CommunicationError, DividedVectors};

use super::shared_nodes::SharedNodes;
use crate::error::PetscError;
use crate::meeting::Meetings;

/// Vectors over the unknowns of some spaces, one after the other.
pub(crate) struct SpacesOnPart {
    meetings: Rc<Meetings>,
    /// The rank that owns each unknown.
    owners: Vec<u32>,
    /// Each other process whose part meets this one, with the unknowns that both have, in the same order on both.
    with: Lists,
    /// Those of them that this process owns, and those that the other one owns.
    owned: Lists,
    of_owners: Lists,
    /// All of the unknowns that others have, too, each once.
    shared: Vec<u32>,
    /// Whether many processes have the same unknowns, at replicated surfaces. Then owners add up.
    replicated: bool,
    /// Number that tells exchanges of other spaces apart.
    number: u64,
}

/// Unknowns for each other process.
type Lists = Vec<(usize, Vec<u32>)>;

impl SpacesOnPart {
    /// Vectors over the unknowns of spaces with the given numbers of components.
    pub(super) fn new(
        meetings: Rc<Meetings>,
        spaces: Vec<(usize, Rc<SharedNodes>)>,
        replicated: bool,
    ) -> Self {
        // Parts that do not meet share what the whole body has one of.
        let ranks: BTreeSet<usize> =
            spaces.iter().flat_map(|(_, nodes)| nodes.with.iter().map(|with| with.0)).collect();
        let mut with: Lists = ranks.into_iter().map(|rank| (rank, vec![])).collect();
        let (mut owners, mut offset) = (vec![], 0);
        for (components, nodes) in &spaces {
            let first = |node: &u32| offset + *node * *components as u32;
            for (rank, unknowns) in &mut with {
                let Some((_, shared)) = nodes.with.iter().find(|(other, _)| other == rank) else { continue };
                unknowns.extend(shared.iter().flat_map(|node| first(node)..first(node) + *components as u32));
            }
            owners.extend(nodes.owners.iter().flat_map(|owner| std::iter::repeat_n(*owner, *components)));
            offset += (nodes.count * components) as u32;
        }
        let mut shared: Vec<u32> = with.iter().flat_map(|(_, unknowns)| unknowns).copied().collect();
        shared.sort_unstable();
        shared.dedup();
        let number = Fingerprint::default().numbers(spaces.iter().map(|(components, _)| *components as u64));
        let own = meetings.rank();
        let owned_by = |owner: &dyn Fn(usize) -> usize| -> Lists {
            let list = |(rank, unknowns): &(usize, Vec<u32>)| {
                let is_one = |unknown: &&u32| owners[**unknown as usize] == owner(*rank) as u32;
                (*rank, unknowns.iter().filter(is_one).copied().collect())
            };
            with.iter().map(list).collect()
        };
        let (owned, of_owners) = (owned_by(&|_| own), owned_by(&|rank| rank));
        let number = number.finish();
        SpacesOnPart { meetings, owners, with, owned, of_owners, shared, replicated, number }
    }

    /// The processes whose parts meet this one.
    pub fn neighbours(&self) -> Vec<usize> {
        self.with.iter().map(|(rank, _)| *rank).collect()
    }

    /// Number of unknowns here.
    pub fn count(&self) -> usize {
        self.owners.len()
    }

    /// Sends each other process the values at the unknowns of a list, and receives its values at those of another list.
    fn exchange(
        &self,
        values: Option<&[f64]>,
        to: &Lists,
        from: &Lists,
    ) -> Result<Vec<Vec<f64>>, PetscError> {
        let lists = values.map(|values| {
            let list = |(rank, unknowns): &(usize, Vec<u32>)| {
                (*rank, unknowns.iter().map(|unknown| values[*unknown as usize].to_bits()).collect())
            };
            to.iter().map(list).collect()
        });
        let lengths: Vec<usize> = from.iter().map(|(_, unknowns)| unknowns.len()).collect();
        let found = self.meetings.exchange_if_all(self.number, lists, &lengths)?;
        Ok(found.into_iter().map(|list| list.into_iter().map(f64::from_bits).collect()).collect())
    }

    /// See [`DividedVectors::add_up_if_all`].
    fn sums(&self, own: Option<&[f64]>) -> Result<Vec<f64>, PetscError> {
        // Each process that adds has all contributions there: all that share an unknown, or its owner.
        let (to, from) =
            if self.replicated { (&self.of_owners, &self.owned) } else { (&self.with, &self.with) };
        let others = self.exchange(own, to, from)?;
        let own = own.unwrap_or_default();
        let mut sums = own.to_vec();
        self.shared.iter().for_each(|unknown| sums[*unknown as usize] = 0.0);
        let add = |sums: &mut [f64], is_one: &dyn Fn(usize) -> bool| {
            for ((_, unknowns), values) in from.iter().zip(&others).filter(|((rank, _), _)| is_one(*rank)) {
                unknowns.iter().zip(values).for_each(|(unknown, value)| sums[*unknown as usize] += value);
            }
        };
        // In the order of the ranks, so that all processes have the same bits.
        add(&mut sums, &|rank| rank < self.meetings.rank());
        self.shared.iter().for_each(|unknown| sums[*unknown as usize] += own[*unknown as usize]);
        add(&mut sums, &|rank| rank > self.meetings.rank());
        if self.replicated {
            self.copy_from_owners(&mut sums)?;
        }
        Ok(sums)
    }

    /// See [`DividedVectors::spread`].
    pub fn copy_from_owners(&self, values: &mut [f64]) -> Result<(), PetscError> {
        let others = self.exchange(Some(values), &self.owned, &self.of_owners)?;
        for ((_, unknowns), found) in self.of_owners.iter().zip(&others) {
            unknowns.iter().zip(found).for_each(|(unknown, value)| values[*unknown as usize] = *value);
        }
        Ok(())
    }
}

fn failed(error: PetscError) -> CommunicationError {
    match error {
        PetscError::Elsewhere { count } => CommunicationError::Elsewhere { count },
        error => CommunicationError::Exchange(error.to_string()),
    }
}

impl DividedVectors for SpacesOnPart {
    fn owns(&self, unknown: usize) -> bool {
        self.owners[unknown] == self.meetings.rank() as u32
    }

    fn add_up_if_all(&self, own: Option<&[f64]>) -> Result<Vec<f64>, CommunicationError> {
        self.sums(own).map_err(failed)
    }

    fn spread(&self, values: &mut [f64]) -> Result<(), CommunicationError> {
        self.copy_from_owners(values).map_err(failed)
    }

    fn sum(&self, own: &[f64]) -> Result<Vec<f64>, CommunicationError> {
        self.meetings.sum(own).map_err(failed)
    }

    fn gather_lists(&self, own: &[f64]) -> Result<Vec<Vec<f64>>, CommunicationError> {
        let own: Vec<u64> = own.iter().map(|number| number.to_bits()).collect();
        let all = self.meetings.gather_lists(&own).map_err(failed)?;
        Ok(all.into_iter().map(|list| list.into_iter().map(f64::from_bits).collect()).collect())
    }
}

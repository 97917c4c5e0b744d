//! Vectors over the unknowns of spaces on a part: what is at shared nodes goes between the processes that have them.

use std::rc::Rc;

use forms_fem::solve::communicator::Fingerprint;
use forms_fem::solve::{CommunicationError, DividedVectors};

use super::shared_nodes::SharedNodes;
use crate::error::PetscError;
use crate::meeting::{Call, Meetings};

/// Vectors over the unknowns of some spaces, one after the other.
pub(crate) struct SpacesOnPart {
    meetings: Rc<Meetings>,
    is_own: Vec<bool>,
    /// Each other process whose part meets this one, with the unknowns that both have, in the same order on both.
    with: Vec<(usize, Vec<u32>)>,
    /// Number of the other processes that have lower ranks.
    lower: usize,
    /// All of these unknowns, each once.
    shared: Vec<u32>,
    /// Number that tells exchanges of other spaces apart.
    number: u64,
}

impl SpacesOnPart {
    /// Vectors over the unknowns of spaces with the given numbers of components.
    pub(super) fn new(meetings: Rc<Meetings>, spaces: Vec<(usize, Rc<SharedNodes>)>) -> Self {
        let ranks: Vec<usize> =
            spaces.first().map_or(&[][..], |(_, nodes)| &nodes.with).iter().map(|with| with.0).collect();
        let mut with: Vec<(usize, Vec<u32>)> = ranks.into_iter().map(|rank| (rank, vec![])).collect();
        let (mut is_own, mut offset) = (vec![], 0);
        for (components, nodes) in &spaces {
            for ((_, unknowns), (_, shared)) in with.iter_mut().zip(&nodes.with) {
                let first = |node: &u32| offset + *node * *components as u32;
                unknowns.extend(shared.iter().flat_map(|node| first(node)..first(node) + *components as u32));
            }
            is_own.extend(nodes.is_own.iter().flat_map(|own| std::iter::repeat_n(*own, *components)));
            offset += (nodes.count * components) as u32;
        }
        let mut shared: Vec<u32> = with.iter().flat_map(|(_, unknowns)| unknowns).copied().collect();
        shared.sort_unstable();
        shared.dedup();
        let number = Fingerprint::default().numbers(spaces.iter().map(|(components, _)| *components as u64));
        let lower = with.iter().filter(|(rank, _)| *rank < meetings.rank()).count();
        SpacesOnPart { meetings, is_own, with, lower, shared, number: number.finish() }
    }

    /// Number of unknowns here.
    pub fn count(&self) -> usize {
        self.is_own.len()
    }

    pub fn is_own(&self) -> &[bool] {
        &self.is_own
    }

    /// The values of other processes at the unknowns that each shares with this one.
    fn values_of_others(&self, own: &[f64]) -> Result<Vec<Vec<f64>>, PetscError> {
        let list = |(rank, unknowns): &(usize, Vec<u32>)| {
            (*rank, unknowns.iter().map(|unknown| own[*unknown as usize].to_bits()).collect())
        };
        let lengths: Vec<usize> = self.with.iter().map(|(_, unknowns)| unknowns.len()).collect();
        let found = self.meetings.exchange(self.number, self.with.iter().map(list).collect(), &lengths)?;
        Ok(found.into_iter().map(|list| list.into_iter().map(f64::from_bits).collect()).collect())
    }

    /// See [`DividedVectors::add_up`].
    pub fn sums(&self, own: &[f64]) -> Result<Vec<f64>, PetscError> {
        let others = self.values_of_others(own)?;
        let mut sums = own.to_vec();
        self.shared.iter().for_each(|unknown| sums[*unknown as usize] = 0.0);
        let add = |sums: &mut [f64], from: usize, to: usize| {
            for ((_, unknowns), values) in self.with[from..to].iter().zip(&others[from..to]) {
                unknowns.iter().zip(values).for_each(|(unknown, value)| sums[*unknown as usize] += value);
            }
        };
        // In the order of the ranks, so that all processes have the same bits.
        add(&mut sums, 0, self.lower);
        self.shared.iter().for_each(|unknown| sums[*unknown as usize] += own[*unknown as usize]);
        add(&mut sums, self.lower, self.with.len());
        Ok(sums)
    }

    /// See [`DividedVectors::spread`].
    pub fn copy_from_owners(&self, values: &mut [f64]) -> Result<(), PetscError> {
        let others = self.values_of_others(values)?;
        // The lowest rank owns an unknown, and is written last.
        for ((_, unknowns), found) in self.with.iter().zip(&others).rev() {
            for (unknown, value) in unknowns.iter().zip(found) {
                if !self.is_own[*unknown as usize] {
                    values[*unknown as usize] = *value;
                }
            }
        }
        Ok(())
    }
}

fn failed(error: PetscError) -> CommunicationError {
    CommunicationError::Exchange(error.to_string())
}

impl DividedVectors for SpacesOnPart {
    fn owns(&self, unknown: usize) -> bool {
        self.is_own[unknown]
    }

    fn add_up(&self, own: &[f64]) -> Result<Vec<f64>, CommunicationError> {
        self.sums(own).map_err(failed)
    }

    fn spread(&self, values: &mut [f64]) -> Result<(), CommunicationError> {
        self.copy_from_owners(values).map_err(failed)
    }

    fn sum(&self, own: &[f64]) -> Result<Vec<f64>, CommunicationError> {
        let length = own.len() as u64;
        self.meetings.meet(Call::Sum { length }).and_then(|_| self.meetings.sum(own)).map_err(failed)
    }

    fn gather(&self, own: f64) -> Result<Vec<f64>, CommunicationError> {
        let all = self.meetings.meet(Call::Gather { number: own.to_bits() }).map_err(failed)?;
        let numbers = all.into_iter().filter_map(|call| match call {
            Call::Gather { number } => Some(f64::from_bits(number)),
            _ => None,
        });
        Ok(numbers.collect())
    }
}

//! Conditions of all processes on a divided mesh: what any of them prescribes, and relations between unknowns.

use std::collections::{BTreeMap, HashMap, HashSet};

use super::{DividedVectors, prescribed_by_all};
use crate::constraints::{Conditions, Dependence, Relation};
use crate::solve::communicator::CommunicationError;
use crate::solve::elimination::Elimination;

/// The largest number of unknowns of a process. An unknown's number on all processes is this times the rank of its owner, and its place there.
const OF_A_PROCESS: f64 = 4_294_967_296.0;

/// Conditions of all processes, by this one's unknowns.
#[doc(hidden)]
#[derive(Debug, Default)]
pub struct ConditionsHere {
    pub prescribed: BTreeMap<usize, f64>,
    pub relations: BTreeMap<usize, Relation>,
    /// Free unknowns of other processes that give unknowns which this process does not have.
    pub rows_elsewhere: Vec<usize>,
}

/// Prescribed values and relations of all processes at this one's unknowns. A process may have a node of a boundary without the facet there.
///
/// All processes get all relations, so their number is that of a surface. Each numbers an unknown by its owner and by its place there, and all
/// eliminate in the same order: the free unknowns are the same on all of them. Values of hanging unknowns come last, as on one process.
///
/// # Errors
/// A failed exchange; [`CommunicationError::Contradiction`]; on this process only [`CommunicationError::SplitRelation`].
#[doc(hidden)]
pub fn conditions_of_all(
    vectors: &dyn DividedVectors,
    rank: usize,
    own: &Elimination,
) -> Result<ConditionsHere, CommunicationError> {
    let ((prescribed, relations), size) = (own.conditions(), own.size());
    let prescribed = prescribed_by_all(vectors, size, prescribed)?;
    if vectors.gather(relations.len() as f64)?.iter().all(|count| *count == 0.0) {
        return Ok(ConditionsHere { prescribed, ..ConditionsHere::default() });
    }
    let at_hanging = prescribed_by_all(vectors, size, own.at_hanging())?;
    let mut numbers: Vec<f64> =
        (0..size).map(|unknown| rank as f64 * OF_A_PROCESS + unknown as f64).collect();
    vectors.spread(&mut numbers)?;
    let number = |unknown: usize| numbers[unknown] as usize;
    let dependence = |(unknown, relation): (&usize, &Relation)| Dependence {
        dependent: number(*unknown),
        terms: relation.terms.iter().map(|(unknown, a)| (number(*unknown), *a)).collect(),
        value: relation.value,
    };
    let is_owned = |(unknown, _): &(&usize, &Relation)| vectors.owns(**unknown);
    let mut all: Vec<Dependence> = relations.iter().filter(is_owned).map(dependence).collect();
    all = listed_by_all(vectors, rank, &all)?;
    // What the owner of an unknown does not know.
    let known = joined(BTreeMap::new(), &all)?;
    let others = relations.iter().filter(|relation| !is_owned(relation)).map(dependence);
    let unknown_there: Vec<Dependence> = others.filter(|one| !known.imply(one)).collect();
    all.extend(listed_by_all(vectors, rank, &unknown_there)?);

    let related: HashSet<usize> = all.iter().flat_map(Dependence::unknowns).collect();
    let is_related = |(unknown, _): &(&usize, &f64)| related.contains(&number(**unknown));
    let of_owner = prescribed.iter().filter(is_related).filter(|(unknown, _)| vectors.owns(**unknown));
    let pair = |(unknown, value): (&usize, &f64)| [numbers[*unknown], *value];
    let values = gathered(vectors, rank, &of_owner.flat_map(pair).collect::<Vec<_>>())?;
    let values = values.as_chunks().0.iter().map(|[number, value]| (*number as usize, *value)).collect();
    let mut conditions = joined(values, &all)?;
    let is_open = |unknown: &usize| vectors.owns(*unknown) && !prescribed.contains_key(unknown);
    let open = at_hanging.iter().filter(|(unknown, _)| is_open(unknown));
    let last = gathered(vectors, rank, &open.flat_map(pair).collect::<Vec<_>>())?;
    for [number, value] in last.as_chunks().0 {
        conditions.add_at_hanging(*number as usize, *value).map_err(contradiction)?;
    }
    here(vectors, conditions, prescribed, &numbers, &related)
}

fn contradiction(difference: f64) -> CommunicationError {
    CommunicationError::Contradiction { difference: difference.to_string() }
}

/// The conditions at this process's unknowns.
fn here(
    vectors: &dyn DividedVectors,
    all: Conditions,
    mut prescribed: BTreeMap<usize, f64>,
    numbers: &[f64],
    related: &HashSet<usize>,
) -> Result<ConditionsHere, CommunicationError> {
    let places = numbers.iter().enumerate().map(|(place, number)| (*number as usize, place));
    let places: HashMap<usize, usize> = places.filter(|(number, _)| related.contains(number)).collect();
    let (values, dependent) = all.into_parts();
    prescribed.extend(values.iter().filter_map(|(number, value)| Some((*places.get(number)?, *value))));
    let (mut relations, mut rows_elsewhere) = (BTreeMap::new(), vec![]);
    for (number, mut relation) in dependent {
        let terms = relation.terms.iter().map(|(number, a)| Some((*places.get(number)?, *a)));
        let found: Option<Vec<(usize, f64)>> = terms.collect();
        match (places.get(&number), found) {
            (Some(place), Some(mut terms)) => {
                terms.sort_unstable_by_key(|(unknown, _)| *unknown);
                relation.terms = terms;
                relations.insert(*place, relation);
            }
            // The owners of those that give it need it, nobody else.
            (None, _) => {
                let known = relation.terms.iter().filter_map(|(number, _)| places.get(number));
                rows_elsewhere.extend(known.copied());
            }
            (Some(_), None) => return Err(CommunicationError::SplitRelation),
        }
    }
    match rows_elsewhere.iter().any(|unknown| vectors.owns(*unknown)) {
        true => Err(CommunicationError::SplitRelation),
        false => Ok(ConditionsHere { prescribed, relations, rows_elsewhere }),
    }
}

/// Prescribed values with dependences, which are added in their order.
fn joined(prescribed: BTreeMap<usize, f64>, all: &[Dependence]) -> Result<Conditions, CommunicationError> {
    let mut conditions = Conditions::prescribing(prescribed);
    for one in all {
        conditions.add(one).map_err(contradiction)?;
    }
    Ok(conditions)
}

/// The lists of all processes, in their order; the same on all.
fn listed_by_all(
    vectors: &dyn DividedVectors,
    rank: usize,
    own: &[Dependence],
) -> Result<Vec<Dependence>, CommunicationError> {
    let all = gathered(vectors, rank, &own.iter().flat_map(Dependence::to_numbers).collect::<Vec<_>>())?;
    let mut rest = &all[..];
    let next = || {
        let (one, behind) = Dependence::of_numbers(rest)?;
        rest = behind;
        Some(one)
    };
    Ok(std::iter::from_fn(next).collect())
}

/// The numbers of all processes, in their order; the same bits on all.
fn gathered(vectors: &dyn DividedVectors, rank: usize, own: &[f64]) -> Result<Vec<f64>, CommunicationError> {
    let counts = vectors.gather(own.len() as f64)?;
    let (before, count) = (counts[..rank].iter().sum::<f64>() as usize, counts.iter().sum::<f64>() as usize);
    if count == 0 {
        return Ok(vec![]);
    }
    // Zeros of the others change no bit.
    let mut all = vec![0.0; count];
    all[before..before + own.len()].copy_from_slice(own);
    vectors.sum(&all)
}

impl Dependence {
    fn unknowns(&self) -> impl Iterator<Item = usize> {
        self.terms.iter().map(|(unknown, _)| *unknown).chain([self.dependent])
    }

    /// The dependent unknown, the addend, the number of terms, the terms.
    fn to_numbers(&self) -> Vec<f64> {
        let terms = self.terms.iter().flat_map(|(unknown, a)| [*unknown as f64, *a]);
        [self.dependent as f64, self.value, self.terms.len() as f64].into_iter().chain(terms).collect()
    }

    /// The first dependence of a list, and what follows it.
    fn of_numbers(list: &[f64]) -> Option<(Self, &[f64])> {
        let ([dependent, value, count], rest) = list.split_first_chunk()?;
        let (terms, rest) = rest.split_at_checked(2 * *count as usize)?;
        let terms = terms.as_chunks().0.iter().map(|[unknown, a]| (*unknown as usize, *a)).collect();
        Some((Dependence { dependent: *dependent as usize, terms, value: *value }, rest))
    }
}

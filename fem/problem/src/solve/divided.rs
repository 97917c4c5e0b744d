//! Vectors over unknowns whose mesh is divided: each process has the entries of its piece, with the same values where pieces meet.

mod conditions;

use std::any::Any;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fmt;
use std::ops::Range;
use std::rc::Rc;

pub use conditions::{ConditionsHere, conditions_of_all};
use forms_core::contract::Source;

use super::communicator::{CommunicationError, Communicator, agreed};
use crate::assemble::AssemblyError;
use crate::contract::Function;
use crate::field::Field;
use crate::linear_algebra::vector::norm;

/// Part of a field's largest value by which copies may differ: positions are rounded.
const GHOST_TOLERANCE: f64 = 1e-9;

/// Vectors over the unknowns of a problem on a divided mesh, space after space. Unknowns where pieces meet are on several processes, and one
/// of these owns each. All processes make the same calls in the same order.
pub trait DividedVectors {
    /// Whether this process owns an unknown of its vectors.
    fn owns(&self, unknown: usize) -> bool;

    /// The sums of what all processes add to their unknowns, with the same bits wherever an unknown is.
    ///
    /// # Errors
    /// [`CommunicationError::Exchange`].
    fn add_up(&self, own: &[f64]) -> Result<Vec<f64>, CommunicationError> {
        self.add_up_if_all(Some(own))
    }

    /// The sums of [`DividedVectors::add_up`] if all processes have something to add, else an error on all.
    ///
    /// # Errors
    /// [`CommunicationError::Elsewhere`], also where this process is the one without; [`CommunicationError::Exchange`].
    fn add_up_if_all(&self, own: Option<&[f64]>) -> Result<Vec<f64>, CommunicationError>;

    /// Copies the values of unknowns from the processes that own them.
    ///
    /// # Errors
    /// [`CommunicationError::Exchange`].
    fn spread(&self, values: &mut [f64]) -> Result<(), CommunicationError>;

    /// The sums over all processes of as many numbers of each; the same bits on all.
    ///
    /// # Errors
    /// [`CommunicationError::Exchange`].
    fn sum(&self, own: &[f64]) -> Result<Vec<f64>, CommunicationError>;

    /// A list of each process, in the order of ranks; the same lists on all. All processes give equally many numbers.
    ///
    /// # Errors
    /// [`CommunicationError::Exchange`].
    fn gather_lists(&self, own: &[f64]) -> Result<Vec<Vec<f64>>, CommunicationError>;

    /// A number of each process, in their order; the same on all.
    ///
    /// # Errors
    /// [`CommunicationError::Exchange`].
    fn gather(&self, own: f64) -> Result<Vec<f64>, CommunicationError> {
        Ok(self.gather_lists(&[own])?.into_iter().flatten().collect())
    }
}

/// Prescribed values of all processes at this one's unknowns. A process may have a node of a boundary without the facet there. Where several
/// prescribe a value, it is their mean, which rounding of positions makes equal to each.
///
/// # Errors
/// Those of [`DividedVectors::add_up`].
fn prescribed_by_all(
    vectors: &dyn DividedVectors,
    size: usize,
    own: &BTreeMap<usize, f64>,
) -> Result<BTreeMap<usize, f64>, CommunicationError> {
    let (mut counts, mut values) = (vec![0.0; size], vec![0.0; size]);
    for (unknown, value) in own {
        (counts[*unknown], values[*unknown]) = (1.0, *value);
    }
    let (counts, values) = (vectors.add_up(&counts)?, vectors.add_up(&values)?);
    let found = counts.iter().zip(&values).enumerate().filter(|(_, (count, _))| **count > 0.0);
    Ok(found
        .map(|(unknown, (count, value))| (unknown, if *count == 1.0 { *value } else { value / count }))
        .collect())
}

/// An error on all processes for a given field of a form that has other values on copies of cells than their owners give it. Integrals over
/// pairs read opposite cells there.
///
/// # Errors
/// [`CommunicationError::GhostValues`]; [`CommunicationError::Divided`] of fields on spaces that are not divided; a failed exchange.
#[doc(hidden)]
pub fn check_ghost_values<const D: usize>(
    all: &dyn Communicator,
    form: &Function<D>,
) -> Result<(), AssemblyError> {
    let name = form.name();
    let failed = |source| AssemblyError::Communication { form: name, source };
    for (description, source) in form.fields().iter().zip(&form.inputs().sources) {
        let Some(Source::Discrete(handle)) = source else { continue };
        let Some(field) = handle.as_any().downcast_ref::<Field<D>>() else { continue };
        if !field.space().mesh().has_copies() {
            continue;
        }
        let Some(divided) = all.divided(&[field.space() as &dyn Any]).map_err(failed)? else { continue };
        let mut owned = field.values().to_vec();
        divided.spread(&mut owned).map_err(failed)?;
        let size = owned.iter().fold(0.0_f64, |size, value| size.max(value.abs()));
        let is_same = |(value, owned): (&f64, &f64)| (value - owned).abs() <= GHOST_TOLERANCE * size;
        let own = match field.values().iter().zip(&owned).all(is_same) {
            true => Ok(()),
            false => Err(failed(CommunicationError::GhostValues { field: description.name })),
        };
        agreed(Some(all), name, own)?;
    }
    Ok(())
}

/// Answers that are the same on all processes: norms, extremes and verdicts on vectors. On a mesh that is not divided they are this
/// process's own.
///
/// After an exchange that failed there are no further ones, numbers are NaN and verdicts false; [`Together::check`] has the error.
#[derive(Clone, Default)]
pub(in crate::solve) struct Together(Option<Rc<Division>>);

struct Division {
    vectors: Rc<dyn DividedVectors>,
    /// Places of the unknowns that this process owns among its free ones.
    own: Vec<usize>,
    failure: RefCell<Option<CommunicationError>>,
}

impl fmt::Debug for Together {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Together").field(&self.0.is_some()).finish()
    }
}

impl Together {
    /// Answers on vectors over all unknowns, and on those over the free ones.
    pub fn new(vectors: Option<Rc<dyn DividedVectors>>, free: &[usize]) -> Self {
        Together(vectors.map(|vectors| {
            let own = (0..free.len()).filter(|place| vectors.owns(free[*place])).collect();
            Rc::new(Division { vectors, own, failure: RefCell::default() })
        }))
    }

    /// The error of an exchange that failed.
    ///
    /// # Errors
    /// That one.
    pub fn check(&self) -> Result<(), CommunicationError> {
        let failure = self.0.as_ref().and_then(|division| division.failure.borrow().clone());
        failure.map_or(Ok(()), Err)
    }

    fn fold(&self, own: f64, fold: impl Fn(f64, f64) -> f64) -> f64 {
        self.fold_each(vec![own], |_, a, b| fold(a, b))[0]
    }

    /// Several numbers of all processes by one exchange; the fold gets the place of each.
    fn fold_each(&self, own: Vec<f64>, fold: impl Fn(usize, f64, f64) -> f64) -> Vec<f64> {
        let Some(division) = &self.0 else { return own };
        let none = vec![f64::NAN; own.len()];
        if division.failure.borrow().is_some() {
            return none;
        }
        let join = |mut sums: Vec<f64>, list: Vec<f64>| {
            sums.iter_mut()
                .zip(list)
                .enumerate()
                .for_each(|(place, (sum, one))| *sum = fold(place, *sum, one));
            sums
        };
        match division.vectors.gather_lists(&own) {
            Ok(all) => all.into_iter().reduce(join).unwrap_or(own),
            Err(error) => {
                *division.failure.borrow_mut() = Some(error);
                none
            }
        }
    }

    /// The largest of all processes' numbers; NaN if there is one.
    pub fn largest(&self, own: f64) -> f64 {
        self.largest_of_each(vec![own])[0]
    }

    /// Largest of all processes' numbers at each place of a list; NaN if there is one.
    pub fn largest_of_each(&self, own: Vec<f64>) -> Vec<f64> {
        self.fold_each(own, |_, a, b| if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) })
    }

    /// The smallest of all processes' numbers; NaN if there is one.
    pub fn smallest(&self, own: f64) -> f64 {
        -self.largest(-own)
    }

    /// The sum of all processes' numbers.
    pub fn sum(&self, own: f64) -> f64 {
        self.fold(own, |a, b| a + b)
    }

    /// Whether something holds on all processes.
    pub fn all(&self, own: bool) -> bool {
        self.smallest(f64::from(u8::from(own))) == 1.0
    }

    /// Whether something holds on one process at least.
    pub fn any(&self, own: bool) -> bool {
        self.largest(f64::from(u8::from(own))) == 1.0
    }

    /// The norm of a vector over the free unknowns, or of those of its entries at some places.
    pub fn norm(&self, reduced: &[f64], places: Range<usize>) -> f64 {
        self.norms_and_sum(&[(reduced, places)], None)[0]
    }

    /// Norms of vectors over the free unknowns at some places, and then the sum of a number of each free unknown, by one exchange.
    pub fn norms_and_sum(
        &self,
        vectors: &[(&[f64], Range<usize>)],
        summed: Option<(usize, &dyn Fn(usize) -> f64)>,
    ) -> Vec<f64> {
        let norm_here = |(reduced, places): &(&[f64], Range<usize>)| match &self.0 {
            None => norm(&reduced[places.clone()]),
            Some(division) => {
                norm(&division.own_in(places).iter().map(|place| reduced[*place]).collect::<Vec<_>>())
            }
        };
        let mut own: Vec<f64> = vectors.iter().map(norm_here).collect();
        own.extend(summed.map(|(count, value)| match &self.0 {
            None => (0..count).map(value).sum::<f64>(),
            Some(division) => division.own_in(&(0..count)).iter().map(|place| value(*place)).sum(),
        }));
        self.fold_each(own, |place, a, b| if place < vectors.len() { a.hypot(b) } else { a + b })
    }

    /// The product of two vectors over all unknowns.
    pub fn dot(&self, a: &[f64], b: &[f64]) -> f64 {
        let Some(division) = &self.0 else { return crate::linear_algebra::vector::dot(a, b) };
        let own = (0..a.len()).filter(|unknown| division.vectors.owns(*unknown));
        self.sum(own.map(|unknown| a[unknown] * b[unknown]).sum())
    }
}

impl Division {
    fn own_in(&self, places: &Range<usize>) -> &[usize] {
        let place = |end: usize| self.own.partition_point(|own| *own < end);
        &self.own[place(places.start)..place(places.end)]
    }
}

//! Processes that solve a problem together.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::ops::Range;

use super::ActivePoints;
use crate::assemble::AssemblyError;

/// The processes that assemble the integrals of a problem together, each over its own cells. All make the same calls in the
/// same order.
pub trait Communicator {
    /// The number of this process, from 0.
    fn rank(&self) -> usize;

    /// This process's part of `count` things in a row.
    fn part(&self, count: usize) -> Range<usize>;

    /// The sums over all processes of as many numbers of each; the same on all.
    ///
    /// # Errors
    /// [`CommunicationError::Exchange`].
    fn sum(&self, own: &[f64]) -> Result<Vec<f64>, CommunicationError>;
}

/// A failed exchange between processes.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CommunicationError {
    /// Others failed, and say why themselves.
    #[error("{count} of the other processes failed")]
    Elsewhere {
        /// Their number.
        count: usize,
    },
    /// The exchange failed.
    #[error("the exchange between processes failed: {0}")]
    Exchange(String),
}

/// A result of this process, if all have one; else an error on all, so that none waits for another for ever.
pub(crate) fn agreed<T>(
    communicator: Option<&dyn Communicator>,
    form: &'static str,
    own: Result<T, AssemblyError>,
) -> Result<T, AssemblyError> {
    let Some(communicator) = communicator else { return own };
    let failed = communicator.sum(&[f64::from(u8::from(own.is_err()))]);
    let own = own?;
    let failed = failed.map_err(|source| AssemblyError::Communication { form, source })?;
    match failed.first().map_or(0, |count| *count as usize) {
        0 => Ok(own),
        count => Err(AssemblyError::Communication { form, source: CommunicationError::Elsewhere { count } }),
    }
}

/// The sum over all processes of what each has; what this one has where it is alone.
pub(crate) fn summed(
    communicator: Option<&dyn Communicator>,
    form: &'static str,
    own: Result<Vec<f64>, AssemblyError>,
) -> Result<Vec<f64>, AssemblyError> {
    let own = agreed(communicator, form, own)?;
    match communicator {
        Some(all) => all.sum(&own).map_err(|source| AssemblyError::Communication { form, source }),
        None => Ok(own),
    }
}

/// The set of all processes' active points: sums of integers below 2⁵³ are exact in any order.
pub(crate) fn all_active(
    communicator: &dyn Communicator,
    own: ActivePoints,
) -> Result<ActivePoints, CommunicationError> {
    let mut hasher = DefaultHasher::new();
    (communicator.rank(), own.fingerprint).hash(&mut hasher);
    let hash = hasher.finish();
    let parts = (0..4).map(|part| ((hash >> (16 * part)) & 0xffff) as f64);
    let sums = communicator.sum(&[own.count as f64].into_iter().chain(parts).collect::<Vec<_>>())?;
    let fingerprint = (1..5).fold(0_u64, |all, part| all.rotate_left(16).wrapping_add(sums[part] as u64));
    Ok(ActivePoints { count: sums[0] as usize, fingerprint })
}

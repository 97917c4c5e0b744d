//! Processes that solve a problem together.

use std::any::Any;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::ops::Range;
use std::rc::Rc;

use super::ActivePoints;
use super::divided::DividedVectors;
use crate::assemble::{Assembler, AssemblyError};
use crate::mesh::Mesh;

/// The processes that assemble the integrals of a problem together, each over its own cells. All make the same calls in the
/// same order; an implementation returns errors where they do not.
pub trait Communicator {
    /// The number of this process, from 0.
    fn rank(&self) -> usize;

    /// Number of processes.
    fn size(&self) -> usize;

    /// This process's part of `count` things in a row.
    fn part(&self, count: usize) -> Range<usize>;

    /// The sums over all processes of as many numbers of each; the same on all.
    ///
    /// # Errors
    /// [`CommunicationError::Exchange`].
    fn sum(&self, own: &[f64]) -> Result<Vec<f64>, CommunicationError>;

    /// A number of each process, in their order; the same on all.
    ///
    /// # Errors
    /// [`CommunicationError::Exchange`].
    fn gather(&self, own: u64) -> Result<Vec<u64>, CommunicationError>;

    /// A list of each process, in the order of ranks; the same lists on all. All processes give equally many numbers.
    ///
    /// # Errors
    /// [`CommunicationError::Exchange`].
    fn gather_lists(&self, own: &[u64]) -> Result<Vec<Vec<u64>>, CommunicationError> {
        let mut lists = vec![vec![]; self.size()];
        for number in own {
            let all = self.gather(*number)?;
            lists.iter_mut().zip(all).for_each(|(list, number)| list.push(number));
        }
        Ok(lists)
    }

    /// The division of vectors over the unknowns of spaces, if the processes have pieces of a mesh; none if each has all of it. Each of
    /// the spaces is an `Arc<Space<D>>`.
    ///
    /// # Errors
    /// [`CommunicationError::Exchange`]; [`CommunicationError::Divided`] of spaces that are not on this process's piece.
    fn divided(&self, _spaces: &[&dyn Any]) -> Result<Option<Rc<dyn DividedVectors>>, CommunicationError> {
        Ok(None)
    }
}

/// A failed exchange between processes.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs)]
pub enum CommunicationError {
    /// Others failed, and say why themselves.
    #[error("{count} of the other processes failed")]
    Elsewhere { count: usize },
    /// The exchange failed.
    #[error("the exchange between processes failed: {0}")]
    Exchange(String),
    /// Something that a divided mesh does not have.
    #[error(
        "{what} are not available on a mesh that is divided among processes; take the whole mesh on each process"
    )]
    Divided {
        /// The thing, in words.
        what: String,
    },
    /// A relation between unknowns, some on this process and some on others only.
    #[error(
        "a process has some of the unknowns of a relation (sliding, periodic, rigid) and lacks others; name its regions in \
         `part.with_surfaces(..)` before spaces are made"
    )]
    SplitRelation,
    /// Conditions of several processes.
    #[error("conditions of several processes contradict each other: one is off by {difference}")]
    Contradiction {
        /// The difference, as a number of the unknown's unit.
        difference: String,
    },
    /// A given field that does not go on in the copies of other processes' cells.
    #[error(
        "the field `{field}` has other values on copies of cells than on the process that owns them; take \
         `part.completed(&field)`"
    )]
    GhostValues {
        /// Its name in the form.
        field: &'static str,
    },
    /// The processes do not solve the same problem.
    #[error("the processes have different problems: what differs is {what}")]
    Different {
        /// The difference, in words.
        what: String,
    },
    /// Assemblers with cells of their own that several processes have, or none.
    #[error(
        "the processes' own cells are no partition of the mesh's: each cell has to be owned by one process"
    )]
    NoPartition,
}

/// A number that tells data apart: of bits, so that the same data have the same one on all processes.
#[doc(hidden)]
#[derive(Clone, Debug, Default)]
pub struct Fingerprint(DefaultHasher);

impl Fingerprint {
    #[must_use]
    pub fn numbers(mut self, numbers: impl IntoIterator<Item = u64>) -> Self {
        let mut count = 0_u64;
        for number in numbers {
            self.0.write_u64(number);
            count += 1;
        }
        self.0.write_u64(count);
        self
    }

    #[must_use]
    pub fn reals<'a>(self, numbers: impl IntoIterator<Item = &'a f64>) -> Self {
        self.numbers(numbers.into_iter().map(|number| number.to_bits()))
    }

    #[must_use]
    pub fn text(mut self, text: &str) -> Self {
        text.hash(&mut self.0);
        self
    }

    /// Cells and nodes, without the names of regions.
    #[must_use]
    pub fn mesh<const D: usize>(self, mesh: &Mesh<D>) -> Self {
        let blocks = mesh.blocks().iter();
        blocks
            .fold(self, |all, block| all.text(block.shape.name()).numbers([block.cells.end as u64]))
            .numbers([mesh.degree() as u64])
            .numbers(mesh.cells().iter().map(|node| u64::from(*node)))
            .reals(mesh.nodes().iter().flatten())
    }

    pub fn finish(&self) -> u64 {
        self.0.finish()
    }
}

/// An assembler of this process's part of the cells, in the mesh's order of cells.
///
/// # Errors
/// [`AssemblyError::Region`]: cells that do not exist.
#[doc(hidden)]
pub fn on_part_of_cells<const D: usize>(
    assembler: &Assembler<D>,
    mesh: &Mesh<D>,
    communicator: &dyn Communicator,
    form: &'static str,
) -> Result<Assembler<D>, AssemblyError> {
    let own = match mesh.is_piece() {
        // All of them are this process's own.
        true => assembler.clone().on_owned_cells(&(0..mesh.body_cells().end as u32).collect::<Vec<_>>()),
        false => {
            let part = &mesh.cell_order().cells()[communicator.part(mesh.cell_count())];
            assembler.clone().on_owned_cells(part)
        }
    };
    own.map_err(|source| AssemblyError::Region { form, symbol: "this process's cells", source })
}

/// A result of this process, if all have one; else an error on all, so that none waits for another for ever.
///
/// # Errors
/// This process's own error, or [`AssemblyError::Communication`].
#[doc(hidden)]
pub fn agreed<T>(
    communicator: Option<&dyn Communicator>,
    form: &'static str,
    own: Result<T, AssemblyError>,
) -> Result<T, AssemblyError> {
    let Some(communicator) = communicator else { return own };
    agreed_or(communicator, own, |source| AssemblyError::Communication { form, source })
}

/// A result of this process, as [`agreed`] with other errors: `failed` makes that of an exchange.
///
/// # Errors
/// As [`agreed`].
#[doc(hidden)]
pub fn agreed_or<T, E>(
    communicator: &dyn Communicator,
    own: Result<T, E>,
    failed: impl Fn(CommunicationError) -> E,
) -> Result<T, E> {
    let of_all = communicator.gather(u64::from(own.is_err()));
    let own = own?;
    match of_all.map_err(&failed)?.iter().sum::<u64>() as usize {
        0 => Ok(own),
        count => Err(failed(CommunicationError::Elsewhere { count })),
    }
}

/// The sum over all processes of what each has; what this one has where it is alone.
///
/// # Errors
/// As [`agreed`].
#[doc(hidden)]
pub fn summed(
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

/// The set of all processes' active points.
pub(crate) fn all_active(
    communicator: &dyn Communicator,
    own: ActivePoints,
) -> Result<ActivePoints, CommunicationError> {
    let all = communicator.gather_lists(&[own.fingerprint, own.count as u64])?;
    let fingerprint = Fingerprint::default().numbers(all.iter().map(|of| of[0])).finish();
    Ok(ActivePoints { count: all.iter().map(|of| of[1]).sum::<u64>() as usize, fingerprint })
}

//! Processes that solve equations together, and the division of vectors over the unknowns between them.

use std::any::Any;
use std::fmt;
use std::rc::Rc;
use std::sync::Arc;

use forms_core::contract::{Entity, Region};

use super::communicator::{
    CommunicationError, Communicator, Fingerprint, agreed, agreed_or, on_part_of_cells, summed,
};
use super::divided::{ConditionsHere, DividedVectors, check_ghost_values, conditions_of_all};
use super::elimination::Elimination;
use crate::assemble::{Assembler, AssemblyError};
use crate::contract::Form;
use crate::linear_algebra::LinearAlgebraError;
use crate::mesh::Mesh;
use crate::space::Space;

/// The processes of some equations. Where all of them have the whole mesh, each has whole vectors, and some are sums of what each assembled. On
/// pieces of a mesh each has the entries of its piece. One process gets back what it gives.
#[doc(hidden)]
#[derive(Clone, Default)]
pub struct Processes<'a> {
    communicator: Option<&'a dyn Communicator>,
    divided: Option<Rc<dyn DividedVectors>>,
}

impl fmt::Debug for Processes<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (size, divided) = (self.communicator.map_or(1, |all| all.size()), self.divided.is_some());
        f.debug_struct("Processes").field("size", &size).field("divided", &divided).finish_non_exhaustive()
    }
}

impl<'a> Processes<'a> {
    /// The processes that solve for unknowns on some spaces. All make this call.
    ///
    /// # Errors
    /// A failed exchange; [`crate::mesh::MeshError::Piece`] of pieces of a mesh with processes that are not those of the part.
    pub fn on<const D: usize>(
        communicator: Option<&'a dyn Communicator>,
        spaces: &[&Arc<Space<D>>],
        form: &'static str,
    ) -> Result<Self, AssemblyError> {
        let Some(all) = communicator else { return Ok(Processes::default()) };
        let known: Vec<&dyn Any> = spaces.iter().map(|space| *space as &dyn Any).collect();
        let divided = all.divided(&known).map_err(|source| AssemblyError::Communication { form, source })?;
        if divided.is_none() {
            let mesh = spaces[0].mesh();
            let whole =
                mesh.without_pieces("`.on(..)` the world", "write `.on(&part)` with the part of the mesh");
            agreed(communicator, form, whole.map_err(|source| AssemblyError::Mesh { form, source }))?;
        }
        Ok(Processes { communicator, divided })
    }

    /// Processes whose division is known.
    pub fn new(communicator: Option<&'a dyn Communicator>, divided: Option<Rc<dyn DividedVectors>>) -> Self {
        Processes { communicator, divided }
    }

    pub fn communicator(&self) -> Option<&'a dyn Communicator> {
        self.communicator
    }

    /// The division of vectors, where the processes have pieces of a mesh.
    pub fn divided(&self) -> Option<&Rc<dyn DividedVectors>> {
        self.divided.as_ref()
    }

    /// An assembler of this process's cells; that which is given where it has such already.
    ///
    /// # Errors
    /// As [`on_part_of_cells`].
    pub fn assembler<const D: usize>(
        &self,
        assembler: &Assembler<D>,
        mesh: &Mesh<D>,
        form: &'static str,
    ) -> Result<Assembler<D>, AssemblyError> {
        match self.communicator {
            Some(all) if !assembler.has_owned_cells() => on_part_of_cells(assembler, mesh, all, form),
            _ => Ok(assembler.clone()),
        }
    }

    /// An error for what a divided mesh does not have in a form, on all processes.
    ///
    /// # Errors
    /// [`CommunicationError::Divided`].
    pub fn check_form<const D: usize>(&self, form: &Form<D>, mesh: &Mesh<D>) -> Result<(), AssemblyError> {
        let has = |entity| form.inputs().regions.iter().any(|region: &Region| region.entity == entity);
        let facets = has(Entity::InteriorFacets) && !mesh.has_facets_between_pieces();
        let without = "interior facets of parts without `part.with_interior_facets()`";
        self.refuse(form.name(), [(has(Entity::Interface), "interfaces"), (facets, without)])?;
        match self.communicator.filter(|_| self.divided.is_some()) {
            Some(all) => check_ghost_values(all, form),
            None => Ok(()),
        }
    }

    /// The error of the first thing that is there, and that a divided mesh does not have; on all processes.
    ///
    /// # Errors
    /// [`CommunicationError::Divided`].
    pub fn refuse(
        &self,
        form: &'static str,
        things: impl IntoIterator<Item = (bool, &'static str)>,
    ) -> Result<(), AssemblyError> {
        if self.divided.is_none() {
            return Ok(());
        }
        let found = things.into_iter().find(|(is_there, _)| *is_there);
        let refused = found.map(|(_, what)| CommunicationError::Divided { what: what.to_owned() });
        let own = refused.map_or(Ok(()), |source| Err(AssemblyError::Communication { form, source }));
        agreed(self.communicator, form, own)
    }

    /// An elimination of what any process prescribes or relates, from that of this one.
    ///
    /// # Errors
    /// Those of [`conditions_of_all`].
    pub fn elimination(&self, form: &'static str, own: Elimination) -> Result<Elimination, AssemblyError> {
        let (Some(divided), Some(all)) = (&self.divided, self.communicator) else { return Ok(own) };
        let failed = |source| AssemblyError::Communication { form, source };
        let known = conditions_of_all(&**divided, all.rank(), &own).map_err(failed);
        let ConditionsHere { prescribed, relations, rows_elsewhere } = self.all_succeed(form, known)?;
        let unfit = |source: LinearAlgebraError| AssemblyError::LinearAlgebra { form, source };
        let made = Elimination::new(own.size(), &prescribed).map_err(unfit)?;
        Ok(made.with_relations(relations).map_err(unfit)?.with_rows_elsewhere(rows_elsewhere))
    }

    /// The sum of what all processes assembled of a vector over the unknowns, each over its own cells.
    ///
    /// # Errors
    /// As [`agreed`].
    pub fn added_up(
        &self,
        form: &'static str,
        own: Result<Vec<f64>, AssemblyError>,
    ) -> Result<Vec<f64>, AssemblyError> {
        let Some(divided) = &self.divided else { return summed(self.communicator, form, own) };
        let sums = divided.add_up_if_all(own.as_deref().ok());
        own?;
        sums.map_err(|source| AssemblyError::Communication { form, source })
    }

    /// The sum at some places of a vector with `count` entries.
    ///
    /// # Errors
    /// As [`agreed`].
    pub fn added_up_at(
        &self,
        form: &'static str,
        places: &[usize],
        own: &[f64],
        count: usize,
    ) -> Result<Vec<f64>, AssemblyError> {
        if self.divided.is_none() {
            return summed(self.communicator, form, Ok(own.to_vec()));
        }
        let mut full = vec![0.0; count];
        places.iter().zip(own).for_each(|(place, value)| full[*place] = *value);
        let sums = self.added_up(form, Ok(full))?;
        Ok(places.iter().map(|place| sums[*place]).collect())
    }

    /// The vector that each process has assembled on its mesh: all of it on a whole mesh, its cells' part on a piece.
    ///
    /// # Errors
    /// As [`agreed`].
    pub fn completed(
        &self,
        form: &'static str,
        own: Result<Vec<f64>, AssemblyError>,
    ) -> Result<Vec<f64>, AssemblyError> {
        if self.divided.is_some() { self.added_up(form, own) } else { own }
    }

    /// The numbers that each process has integrated on its mesh, as [`Self::completed`].
    ///
    /// # Errors
    /// As [`agreed`].
    pub fn totals(
        &self,
        form: &'static str,
        own: Result<Vec<f64>, AssemblyError>,
    ) -> Result<Vec<f64>, AssemblyError> {
        let Some(divided) = &self.divided else { return own };
        let own = agreed(self.communicator, form, own)?;
        divided.sum(&own).map_err(|source| AssemblyError::Communication { form, source })
    }

    /// The largest of the numbers that the processes have on their pieces; NaN if there is one.
    ///
    /// # Errors
    /// A failed exchange.
    pub fn largest(&self, form: &'static str, own: f64) -> Result<f64, AssemblyError> {
        let Some(divided) = &self.divided else { return Ok(own) };
        let all = divided.gather(own).map_err(|source| AssemblyError::Communication { form, source })?;
        let larger = |a: f64, b: f64| if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) };
        Ok(all.into_iter().fold(own, larger))
    }

    /// Whether something holds on one piece at least.
    ///
    /// # Errors
    /// A failed exchange.
    pub fn any(&self, form: &'static str, own: bool) -> Result<bool, AssemblyError> {
        Ok(self.largest(form, f64::from(u8::from(own)))? == 1.0)
    }

    /// A number that tells apart what the processes have on their pieces; none where each has the whole.
    ///
    /// # Errors
    /// A failed exchange.
    pub fn fingerprint(&self, form: &'static str, own: &Fingerprint) -> Result<Option<u64>, AssemblyError> {
        let Some(all) = self.communicator.filter(|_| self.divided.is_some()) else { return Ok(None) };
        let all = all.gather(own.finish()).map_err(|source| AssemblyError::Communication { form, source })?;
        Ok(Some(Fingerprint::default().numbers(all).finish()))
    }

    /// A result on a piece, if all processes have one; else an error on all.
    ///
    /// # Errors
    /// This process's own error, or [`AssemblyError::Communication`].
    pub fn all_succeed<T, E: From<AssemblyError>>(
        &self,
        form: &'static str,
        own: Result<T, E>,
    ) -> Result<T, E> {
        match self.communicator {
            Some(all) if self.divided.is_some() => {
                agreed_or(all, own, |source| AssemblyError::Communication { form, source }.into())
            }
            _ => own,
        }
    }
}

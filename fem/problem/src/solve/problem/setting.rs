//! Constraints, start and cells of a problem: what was given, checked and completed.

use std::borrow::Cow;
use std::sync::Arc;

use super::Problem;
use crate::assemble::AssemblyError;
use crate::constraints::Constraints;
use crate::contract::Form;
use crate::solve::communicator::on_part_of_cells;
use crate::solve::{Elimination, Processes};
use crate::space::Space;

/// A number of commits that no form has.
const OTHER_DATA: u64 = u64::MAX;

impl<'a, const D: usize, const N: usize> Problem<'a, D, N> {
    /// A guess at the first iterates: each vector field on the mesh moved by 1.05 times the mean of its prescribed
    /// values, for a body that is moved at one side follows nearly as it is. None where nothing is moved.
    pub(super) fn extrapolate_prescribed(
        &self,
        u: &[f64],
        constraints: [&Constraints<D>; N],
    ) -> Option<Vec<f64>> {
        let mut guess = u.to_vec();
        let mut offset = 0;
        let mut moved = false;
        for (space, constraints) in self.system.spaces.iter().zip(constraints) {
            for component in 0..if space.components() == D { D } else { 0 } {
                let of_component =
                    constraints.prescribed().iter().filter(|(unknown, _)| *unknown % D == component);
                let (count, sum) =
                    of_component.fold((0.0, 0.0), |(count, sum), (_, value)| (count + 1.0, sum + value));
                if sum != 0.0 {
                    let values = guess[offset..offset + space.unknowns()].iter_mut();
                    values.skip(component).step_by(D).for_each(|value| *value += 1.05 * sum / count);
                    moved = true;
                }
            }
            offset += space.unknowns();
        }
        moved.then_some(guess)
    }

    /// The unknowns of the cells at the facets where nonlinear integrals are expected to act.
    ///
    /// # Errors
    /// [`AssemblyError::Mesh`]: no such facets.
    pub(super) fn expected_unknowns(&self) -> Result<Vec<usize>, AssemblyError> {
        let Some(region) = self.expected else { return Ok(vec![]) };
        let (mut unknowns, mut offset) = (vec![], 0);
        for space in &self.system.spaces {
            let facets = space.mesh().facet_region(region);
            let facets =
                facets.map_err(|source| AssemblyError::Mesh { form: self.system.form.name(), source })?;
            let count = space.components();
            for node in facets.iter().flat_map(|facet| space.cell_nodes(facet.cell as usize)) {
                let first = offset + *node as usize * count;
                unknowns.extend(first..first + count);
            }
            offset += space.unknowns();
        }
        Ok(unknowns)
    }

    /// The constraints of each unknown: given, or none.
    pub(in crate::solve) fn all_constraints(&self) -> Result<[Cow<'a, Constraints<D>>; N], AssemblyError> {
        let mut given: [Option<Cow<'a, Constraints<D>>>; N] = [const { None }; N];
        for constraints in &self.constraints {
            let fits = |number: &usize| {
                given[*number].is_none() && self.system.spaces[*number].numbers_as(constraints.space())
            };
            match (0..N).find(fits) {
                Some(number) => given[number] = Some(constraints.clone()),
                None => return Err(AssemblyError::Constraints { form: self.system.form.name() }),
            }
        }
        let mut number = 0;
        Ok(given.map(|given| {
            let space = &self.system.spaces[number];
            number += 1;
            given.unwrap_or_else(|| Cow::Owned(Constraints::new(space)))
        }))
    }

    pub(in crate::solve) fn check_spaces(
        &self,
        what: &'static str,
        given: [&Arc<Space<D>>; N],
    ) -> Result<(), AssemblyError> {
        match self.system.spaces.iter().zip(given).position(|(own, given)| !own.numbers_as(given)) {
            None => Ok(()),
            Some(number) => {
                let (form, field) = (self.system.form.name(), self.system.unknown_name(number));
                Err(AssemblyError::OtherSpace { form, field, what })
            }
        }
    }

    /// Takes the same form with other data. What was assembled is computed anew, in the same memory.
    pub(in crate::solve) fn replace_form(&mut self, form: Form<D>) {
        self.system.form = form;
        self.split = None;
        if let Some(assembled) = &mut self.assembled {
            assembled.commits = OTHER_DATA;
        }
    }

    /// Learns how vectors are divided, where processes have pieces of the mesh: an elimination of what any of them prescribes.
    ///
    /// # Errors
    /// [`CommunicationError::Divided`](crate::solve::CommunicationError::Divided) of what a divided mesh does not have; a failed exchange.
    pub(in crate::solve) fn divide(&mut self, own: Elimination) -> Result<Elimination, AssemblyError> {
        let form = self.system.form.name();
        let processes = Processes::on(self.communicator, &self.system.spaces.each_ref(), form)?;
        self.divided = processes.divided().cloned();
        if self.divided.is_some() {
            let (assembler, mesh) = (&self.system.assembler, self.system.spaces[0].mesh());
            let own = mesh.body_cells();
            let is_fit = |cell: u32| assembler.owns_cell(cell) == own.contains(&(cell as usize));
            let things = [
                (!(0..mesh.cell_count() as u32).all(is_fit), "assemblers of some cells only"),
                (!self.bounds.is_empty(), "bounds on unknowns"),
                (!self.positive.is_empty(), "quantities that are kept positive"),
                (self.deflation.is_some(), "deflated solutions"),
                (!self.system.loads.is_empty(), "loads of rigid surfaces"),
            ];
            processes.refuse(form, things)?;
            processes.check_form(&self.system.form, mesh)?;
        }
        processes.elimination(form, own)
    }

    /// On several processes the assembler takes this one's part of the cells, unless it has its own already.
    pub(in crate::solve) fn share_cells(&mut self) -> Result<(), AssemblyError> {
        let Some(communicator) = self.communicator else { return Ok(()) };
        if self.system.assembler.has_owned_cells() {
            return Ok(());
        }
        let system = &self.system;
        let (assembler, mesh, form) = (&*system.assembler, system.spaces[0].mesh(), system.form.name());
        self.system.assembler = Cow::Owned(on_part_of_cells(assembler, mesh, communicator, form)?);
        Ok(())
    }
}

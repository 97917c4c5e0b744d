//! Whether all processes were given the same problem. It is asked before they exchange anything: contributions of different problems
//! would be added up, or vectors of different lengths exchanged.

use std::sync::Arc;

use forms_core::contract::{Entity, Region, Source};

use super::Problem;
use crate::assemble::{Assembler, AssemblyError};
use crate::constraints::Constraints;
use crate::contract::Form;
use crate::field::Field;
use crate::history::commits;
use crate::mesh::{Facet, Mesh};
use crate::solve::communicator::{CommunicationError, Communicator, Fingerprint};
use crate::space::Space;

/// A part of a problem, and the number that tells it apart.
type Part = (&'static str, u64);

/// Equations that processes assemble together, as one of them was given them.
#[doc(hidden)]
pub struct GivenEquations<'a, const D: usize> {
    pub form: &'a Form<D>,
    pub spaces: &'a [&'a Arc<Space<D>>],
    pub assembler: &'a Assembler<D>,
    /// Conditions, for each unknown.
    pub constraints: &'a [&'a Constraints<D>],
    /// What else must be the same, by a name and a number.
    pub others: Vec<Part>,
}

impl<const D: usize, const N: usize> Problem<'_, D, N> {
    /// Compares what the processes were given.
    pub(in crate::solve) fn agree_on_problem(
        &self,
        constraints: &[&Constraints<D>; N],
    ) -> Result<(), AssemblyError> {
        let Some(communicator) = self.communicator else { return Ok(()) };
        let system = &self.system;
        let starts = [self.start, self.last_state].map(|state| add_state(Fingerprint::default(), state));
        let entries = system.loads.iter().flat_map(|loads| &loads.entries).flat_map(|(_, entries)| entries);
        let loads = Fingerprint::default()
            .numbers(entries.clone().map(|(unknown, _)| *unknown as u64))
            .reals(entries.map(|(_, force)| force));
        let options = Fingerprint::default().text(&format!("{:?}", self.options));
        let factors = Fingerprint::default().reals(self.factors.iter().flatten());
        let mut others = vec![
            ("the loads of rigid surfaces", loads.finish()),
            ("Newton's options", options.finish()),
            ("the load factors", factors.finish()),
        ];
        if !system.spaces[0].mesh().is_piece() {
            let start = Fingerprint::default().numbers(starts.map(|start| start.finish()));
            others.push(("the start", start.finish()));
        }
        let given = GivenEquations {
            form: &system.form,
            spaces: &system.spaces.each_ref(),
            assembler: &system.assembler,
            constraints,
            others,
        };
        given.agree(communicator)
    }
}

impl<const D: usize> GivenEquations<'_, D> {
    /// An error on all processes where they were given different equations, or cells that are no partition. Values of functions of position are
    /// not compared.
    ///
    /// # Errors
    /// [`AssemblyError::Communication`] with all that differs.
    pub fn agree(self, communicator: &dyn Communicator) -> Result<(), AssemblyError> {
        let form = self.form.name();
        let agreed = self.compare(communicator).and_then(|()| self.check_partition(communicator));
        agreed.map_err(|source| AssemblyError::Communication { form, source })
    }

    fn compare(&self, communicator: &dyn Communicator) -> Result<(), CommunicationError> {
        let differ =
            |number: u64| communicator.gather(number).map(|all| all.iter().any(|one| *one != all[0]));
        let parts = self.parts();
        let whole = Fingerprint::default().numbers(parts.iter().map(|(_, number)| *number));
        if !differ(whole.finish())? {
            return Ok(());
        }
        let mut different = vec![];
        for (what, number) in parts {
            if differ(number)? {
                different.push(what);
            }
        }
        Err(CommunicationError::Different { what: different.join(", ") })
    }

    fn parts(&self) -> Vec<Part> {
        let inputs = self.form.inputs();
        let mesh = self.spaces[0].mesh();
        let spaces = self.spaces.iter().fold(Fingerprint::default(), |all, one| add_space(all, one));
        let constraints =
            self.constraints.iter().fold(Fingerprint::default(), |all, one| add_constraints(all, one));
        let fields = inputs.sources.iter().flatten().fold(Fingerprint::default(), add_source);
        let parameters =
            Fingerprint::default().reals(&inputs.parameters).text(&format!("{:?}", inputs.tables));
        let regions =
            inputs.regions.iter().fold(Fingerprint::default(), |all, one| add_region(all, one, mesh));
        // Kernels have the factors of a sum, which are among no parameters.
        let factors: Vec<f64> = self.form.factors().collect();
        let form = Fingerprint::default().text(self.form.name()).reals(&factors);
        let quadrature = Fingerprint::default().text(&format!("{:?}", self.assembler.quadrature()));
        let mut parts = vec![
            ("the form", form.finish()),
            ("a space", spaces.finish()),
            ("the parameters", parameters.finish()),
            ("a region", regions.finish()),
            ("the quadrature", quadrature.finish()),
        ];
        if !mesh.is_piece() {
            parts.extend([
                ("the mesh", Fingerprint::default().mesh(mesh).finish()),
                ("the constraints", constraints.finish()),
                ("a given field or history", fields.numbers([commits(inputs)]).finish()),
            ]);
        }
        // A process that failed to write a history is a step behind.
        parts.push(("the number of commits to histories", commits(inputs)));
        parts.extend(&self.others);
        parts
    }

    /// Each cell is to be owned by one process.
    fn check_partition(&self, communicator: &dyn Communicator) -> Result<(), CommunicationError> {
        // On pieces each process has the cells of its own.
        if self.spaces[0].mesh().is_piece() {
            return Ok(());
        }
        let count = self.spaces[0].mesh().cell_count() as u32;
        // Two sums: of the cells' number, and of numbers that represent the cells.
        let number = |cell: u32| Fingerprint::default().numbers([u64::from(cell)]).finish();
        let sums = |cells: &mut dyn Iterator<Item = u32>| {
            cells.fold([0_u64; 2], |[count, sum], cell| [count + 1, sum.wrapping_add(number(cell))])
        };
        let own = sums(&mut (0..count).filter(|cell| self.assembler.owns_cell(*cell)));
        let all = sums(&mut (0..count));
        for (own, all) in own.into_iter().zip(all) {
            let found = communicator.gather(own)?.into_iter().fold(0, u64::wrapping_add);
            if found != all {
                return Err(CommunicationError::NoPartition);
            }
        }
        Ok(())
    }
}

fn add_space<const D: usize>(all: Fingerprint, space: &Arc<Space<D>>) -> Fingerprint {
    all.text(&format!("{:?} {:?} {:?}", space.scope(), space.elements(), space.shape()))
        .numbers([space.degree() as u64, if space.mesh().is_piece() { 0 } else { space.node_count() as u64 }])
}

fn add_constraints<const D: usize>(all: Fingerprint, constraints: &Constraints<D>) -> Fingerprint {
    let prescribed = constraints.prescribed();
    let all = all.numbers(prescribed.keys().map(|unknown| *unknown as u64)).reals(prescribed.values());
    constraints.relations().iter().fold(all, |all, (unknown, relation)| {
        let terms = relation.terms.iter();
        all.numbers([*unknown as u64])
            .numbers(terms.clone().map(|(free, _)| *free as u64))
            .reals(terms.map(|(_, factor)| factor).chain([&relation.value]))
    })
}

fn add_source<const D: usize>(all: Fingerprint, source: &Source<D>) -> Fingerprint {
    match source {
        Source::Constant(values) => all.reals(values),
        Source::Discrete(field) => match field.as_any().downcast_ref::<Field<D>>() {
            Some(field) => all.reals(field.values()),
            None => all.numbers([field.components() as u64]),
        },
        // Values that are computed where they are asked for.
        Source::Function { .. } | Source::History(_) => all.numbers([source.components() as u64]),
    }
}

fn add_region<const D: usize>(all: Fingerprint, region: &Region, mesh: &Mesh<D>) -> Fingerprint {
    let number = |facet: &Facet| u64::from(facet.cell) << 8 | u64::from(facet.local);
    // A region that does not exist is an error of its own, on all processes.
    let facets = |all: Fingerprint, name: &str| {
        all.numbers(mesh.facet_region(name).unwrap_or_default().iter().map(number))
    };
    let all = all.text(&region.name).text(&format!("{:?}", region.pairing));
    if mesh.is_piece() {
        return all;
    }
    match region.entity {
        Entity::Cells | Entity::Interface => all
            .numbers(mesh.cell_region(&region.name).unwrap_or_default().iter().map(|cell| u64::from(*cell))),
        Entity::Facets => facets(all, &region.name),
        Entity::InteriorFacets => all.numbers(
            mesh.interior_facet_region(&region.name).unwrap_or_default().iter().flatten().map(number),
        ),
        Entity::Pairs => {
            let surfaces = region.pairing.iter().flat_map(|pairing| &pairing.surfaces);
            surfaces.fold(all, |all, facing| facets(facets(all, &facing.own), &facing.opposite))
        }
    }
}

fn add_state<const D: usize, const N: usize>(all: Fingerprint, state: Option<[&Field<D>; N]>) -> Fingerprint {
    state.iter().flatten().fold(all, |all, field| all.reals(field.values()))
}

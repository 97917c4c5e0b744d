//! Forms without their kernels: what asks for no more than names, data and couplings is compiled once and not for every form.

use std::convert::Infallible;
use std::ops::Deref;
use std::sync::Arc;

use forms_core::contract::{
    BilinearKernel, BilinearVisitor, Degree, Entity, Expression, FieldDescription, Form, Functional, Inputs,
    Integral, Region, Requirements, Role, Side,
};

use super::entities::Entities;
use crate::assemble::Parts;
use crate::assemble::scatter::group_nodes::{Reading, SeenAtFacets};
use crate::mesh::Facet;
use crate::space::Space;

/// Name, fields and data of a form, a functional or a derived field.
#[derive(Clone, Copy)]
#[doc(hidden)]
pub struct Described<'a, const D: usize> {
    name: &'static str,
    fields: &'static [FieldDescription],
    inputs: &'a Inputs<D>,
}

impl<'a, const D: usize> Described<'a, D> {
    pub fn of<F: Form<D>>(form: &'a F) -> Self {
        Described { name: form.name(), fields: form.fields(), inputs: form.inputs() }
    }

    pub fn of_functional<F: Functional<D>>(functional: &'a F) -> Self {
        Described { name: functional.name(), fields: functional.fields(), inputs: functional.inputs() }
    }

    pub fn of_expression<E: Expression<D>>(expression: &'a E) -> Self {
        Described { name: expression.name(), fields: expression.fields(), inputs: expression.inputs() }
    }

    pub fn name(&self) -> &'static str {
        self.name
    }

    pub fn fields(&self) -> &'static [FieldDescription] {
        self.fields
    }

    pub fn inputs(&self) -> &'a Inputs<D> {
        self.inputs
    }

    /// The name of the field with a role; empty if there is none.
    pub fn name_of(&self, role: Role) -> &'static str {
        self.fields.iter().find(|field| field.role == role).map_or("", |field| field.name)
    }
}

/// A form's description with what the tangents of some of its integrals couple.
#[doc(hidden)]
pub struct Outline<'a, const D: usize> {
    described: Described<'a, D>,
    pub(in crate::assemble) couplings: Vec<Coupling>,
    is_symmetric: bool,
}

impl<'a, const D: usize> Outline<'a, D> {
    pub fn of<F: Form<D>>(form: &'a F, parts: Parts) -> Self {
        let (couplings, is_symmetric) = couplings(form, parts);
        Outline { described: Described::of(form), couplings, is_symmetric }
    }

    /// Whether each of the tangents is proved to be symmetric by itself, so that their sum is, except for rounding.
    pub fn is_symmetric(&self) -> bool {
        self.is_symmetric
    }

    /// Whether some of the integrals have tangents.
    pub fn has_tangent(&self) -> bool {
        !self.couplings.is_empty()
    }
}

impl<'a, const D: usize> Deref for Outline<'a, D> {
    type Target = Described<'a, D>;

    fn deref(&self) -> &Described<'a, D> {
        &self.described
    }
}

/// One kind of tangent integral.
#[derive(Clone, Copy)]
pub(crate) struct Coupling {
    pub test: usize,
    pub trial: usize,
    pub region: usize,
    pub sides: [Side; 2],
    /// Of contact pairs, where points decide which cells are coupled, the degree of the rule.
    pub degree: Degree,
    /// Of pairs of displaced surfaces, the fields that displace them.
    pub displacement: Option<&'static [usize]>,
    /// Of contact pairs, among them histories with a rule of their own.
    pub requirements: Requirements,
}

impl Coupling {
    fn is_like(&self, other: &Coupling) -> bool {
        let key = |coupling: &Coupling| (coupling.test, coupling.trial, coupling.region);
        key(self) == key(other) && self.sides == other.sides
    }

    /// The nodes of contact pairs that the kernel sees, test and trial, at the sides on which the functions live: what its tangents write.
    /// None elsewhere, and where the spaces differ, so that all nodes count.
    pub fn seen_on_pairs<const D: usize>(
        &self,
        form: &Described<D>,
        tests: &[&Arc<Space<D>>],
        trials: &[&Arc<Space<D>>],
        entities: &Entities,
    ) -> Option<[SeenAtFacets; 2]> {
        let spaces = [tests[self.test], trials[self.trial]];
        let on_pairs = form.inputs().regions[self.region].entity == Entity::Pairs;
        if !on_pairs || !Arc::ptr_eq(spaces[0], spaces[1]) {
            return None;
        }
        let reading = Reading::of_arguments(&self.requirements);
        Some([0, 1].map(|k| {
            let of_side = |sides: &[Facet]| match self.sides[k] {
                Side::This => sides[0],
                Side::Other => sides[sides.len() - 1],
            };
            let facets = &mut (0..entities.count()).map(|index| of_side(entities.sides(index)));
            SeenAtFacets::new(spaces[k], facets, reading[k])
        }))
    }

    /// Whether it has the pairs of another one, up to the degree of the rule.
    pub fn slides_as(&self, other: &Coupling) -> bool {
        self.region == other.region && self.displacement == other.displacement
    }
}

struct CouplingVisitor<'a> {
    regions: &'a [Region],
    parts: Parts,
    found: Vec<Coupling>,
    are_symmetric: bool,
}

/// The couplings of the tangents of some of a form's integrals, and whether all of these are proved to be symmetric.
fn couplings<F: Form<D>, const D: usize>(form: &F, parts: Parts) -> (Vec<Coupling>, bool) {
    let regions = &form.inputs().regions;
    let mut visitor = CouplingVisitor { regions, parts, found: vec![], are_symmetric: true };
    match form.tangent(&mut visitor) {
        Ok(()) => (visitor.found, visitor.are_symmetric),
        Err(never) => match never {},
    }
}

impl CouplingVisitor<'_> {
    fn add(&mut self, integral: &Integral, requirements: Requirements) {
        let Integral { test, trial, region, test_side, trial_side, degree, displacement, .. } = *integral;
        let sides = [test_side, trial_side];
        let coupling = Coupling { test, trial, region, sides, degree, displacement, requirements };
        let on_pairs = self.regions[region].entity == Entity::Pairs;
        let is_new = on_pairs || !self.found.iter().any(|known| known.is_like(&coupling));
        if self.parts.contain(integral.dependence) {
            self.are_symmetric &= integral.symmetric && test == trial && test_side == trial_side;
            if is_new {
                self.found.push(coupling);
            }
        }
    }
}

impl<const D: usize> BilinearVisitor<D> for CouplingVisitor<'_> {
    type Error = Infallible;

    fn visit<K: BilinearKernel<D>>(&mut self, integral: &Integral, _: &K) -> Result<(), Infallible> {
        self.add(integral, K::REQUIREMENTS);
        Ok(())
    }
}

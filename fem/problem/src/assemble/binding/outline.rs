//! Forms with what the tangents of some of their integrals couple.

use std::ops::Deref;
use std::sync::Arc;

use forms_core::contract::{Degree, Entity, Integral, Means, Requirements, Role, Side};

use super::entities::Entities;
use crate::assemble::Parts;
use crate::assemble::scatter::group_nodes::{Reading, SeenAtFacets};
use crate::contract::Function;
use crate::mesh::Facet;
use crate::space::Space;

/// A form with the couplings in the tangents of some of its integrals.
#[doc(hidden)]
pub struct Outline<'a, const D: usize> {
    form: &'a Function<D>,
    pub(in crate::assemble) couplings: Vec<Coupling>,
    is_symmetric: bool,
}

impl<'a, const D: usize> Outline<'a, D> {
    #[inline(never)]
    pub fn of(form: &'a Function<D>, parts: Parts) -> Self {
        let (mut couplings, mut is_symmetric) = (Vec::<Coupling>::new(), true);
        for term in form.tangent().iter().filter(|term| parts.contain(term.integral.dependence)) {
            let Integral { test, trial, region, test_side, trial_side, degree, displacement, .. } =
                *term.integral;
            let (sides, requirements) = ([test_side, trial_side], *term.kernel.constants().requirements);
            let of_means = false;
            let coupling =
                Coupling { test, trial, region, sides, degree, displacement, requirements, of_means };
            let on_pairs = form.inputs().regions[region].entity == Entity::Pairs;
            is_symmetric &= term.integral.symmetric && test == trial && test_side == trial_side;
            if on_pairs || !couplings.iter().any(|known| known.is_like(&coupling)) {
                couplings.push(coupling);
            }
        }
        let by_means = form.residual_by_means().iter();
        for by in by_means.filter(|term| parts.contain(term.integral.dependence)) {
            let Some(Means { number, .. }) = by.integral.means else { continue };
            for made in form.means_by_unknowns().iter().filter(|term| of_list(term.integral, number)) {
                let (by_requirements, of_trial) =
                    (by.kernel.constants().requirements, made.kernel.constants().requirements);
                let (test, trial) = (by.integral.test, made.integral.trial);
                is_symmetric &= by.integral.symmetric && test == 0 && trial == 0;
                let Integral { region, degree, displacement, .. } = *by.integral;
                let sides = [by.integral.test_side, made.integral.trial_side];
                let trial_derivatives = of_trial.trial_derivatives;
                let requirements = Requirements { trial_derivatives, ..*by_requirements };
                let of_means = true;
                couplings.push(Coupling {
                    test,
                    trial,
                    region,
                    sides,
                    degree,
                    displacement,
                    requirements,
                    of_means,
                });
            }
        }
        let mut outline = Outline { form, couplings, is_symmetric };
        for term in form.residual().iter().filter(|term| parts.contain(term.integral.dependence)) {
            outline.couple_motion(term.integral, term.kernel.constants().requirements, false);
        }
        for term in form.residual_by_means().iter().filter(|term| parts.contain(term.integral.dependence)) {
            outline.couple_motion(term.integral, term.kernel.constants().requirements, true);
        }
        for term in form.motion().iter().filter(|term| parts.contain(term.integral.dependence)) {
            for test_side in [Side::This, Side::Other] {
                let integral = Integral { test_side, ..*term.integral };
                outline.couple_motion(&integral, term.kernel.constants().requirements, false);
            }
        }
        outline
    }

    /// The couplings by the motion of moving segments' points: an integral's test function with the nodes on both sides whose displacement
    /// moves them, where no other coupling has these.
    fn couple_motion(&mut self, integral: &Integral, requirements: &Requirements, of_means: bool) {
        let Integral { test, region, test_side, degree, displacement, .. } = *integral;
        let moves = self.form.inputs().regions[region].is_on_moving_segments(displacement);
        for field in displacement.into_iter().flatten().filter(|_| moves) {
            let Role::Unknown(trial) = self.form.fields()[*field].role else { continue };
            self.is_symmetric = false;
            for trial_side in [Side::This, Side::Other] {
                let sides = [test_side, trial_side];
                // Nodes on the facets are enough.
                let requirements = Requirements { trial_derivatives: false, ..*requirements };
                let coupling =
                    Coupling { test, trial, region, sides, degree, displacement, requirements, of_means };
                let has_it = |known: &Coupling| {
                    known.is_like(&coupling)
                        && (known.displacement, known.of_means) == (displacement, of_means)
                        && known.requirements.test_derivatives >= requirements.test_derivatives
                };
                if !self.couplings.iter().any(has_it) {
                    self.couplings.push(coupling);
                }
                if requirements.varies_energy {
                    let (test, trial, sides) = (trial, test, [trial_side, test_side]);
                    let [test_derivatives, trial_derivatives] = [false, requirements.test_derivatives];
                    let requirements = Requirements { test_derivatives, trial_derivatives, ..requirements };
                    let has_it = |known: &Coupling| {
                        known.is_like(&Coupling { test, trial, sides, ..coupling })
                            && (known.displacement, known.of_means) == (displacement, of_means)
                            && known.requirements.trial_derivatives >= trial_derivatives
                    };
                    if !self.couplings.iter().any(has_it) {
                        self.couplings.push(Coupling { test, trial, sides, requirements, ..coupling });
                    }
                }
            }
        }
    }

    /// Whether each of the tangents is proved to be symmetric by itself, so that their sum is, except for rounding.
    pub fn is_symmetric(&self) -> bool {
        self.is_symmetric
    }

    /// Whether each tangent is of integrals over cells or exterior facets. Points see one cell there, all of whose nodes are coupled: a
    /// tangent by the only unknown reads nothing else of it.
    pub fn sees_one_cell(&self) -> bool {
        let entity = |coupling: &Coupling| self.form.inputs().regions[coupling.region].entity;
        self.couplings.iter().all(|coupling| matches!(entity(coupling), Entity::Cells | Entity::Facets))
    }

    /// Whether some of the integrals have tangents.
    pub fn has_tangent(&self) -> bool {
        !self.couplings.is_empty()
    }
}

impl<const D: usize> Deref for Outline<'_, D> {
    type Target = Function<D>;

    fn deref(&self) -> &Function<D> {
        self.form
    }
}

/// Whether an integral makes or varies a list of means.
fn of_list(integral: &Integral, number: usize) -> bool {
    integral.means.is_some_and(|means| means.number == number)
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
    /// Of means over own facets: all opposite cells of an own facet are coupled.
    pub of_means: bool,
}

impl Coupling {
    fn is_like(&self, other: &Coupling) -> bool {
        let key = |coupling: &Coupling| (coupling.test, coupling.trial, coupling.region);
        key(self) == key(other) && self.sides == other.sides
    }

    /// The nodes of contact pairs whose entries the kernel's tangents write, test and trial, at the sides on which the functions live.
    /// None elsewhere, and where the spaces differ, so that all nodes count.
    pub fn seen_on_pairs<const D: usize>(
        &self,
        form: &Function<D>,
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

    /// The test and trial nodes that means and dual functions couple across the opposite facets of each own facet; the facets are sorted. None for other
    /// couplings: where one of the functions lives at the own facet, each pair of facets has all.
    pub fn across_opposite_facets<const D: usize>(
        &self,
        tests: &[&Arc<Space<D>>],
        trials: &[&Arc<Space<D>>],
        entities: &Entities,
        seen: Option<&[SeenAtFacets; 2]>,
    ) -> Vec<[Vec<u32>; 2]> {
        let mut all = Vec::new();
        let spaces = [tests[self.test], trials[self.trial]];
        // Dual functions change with the whole cover of their facet.
        let is_dual = |space: &&Arc<Space<D>>| space.elements().is_dual();
        let of_covers = self.displacement.is_some() && tests.iter().chain(trials).any(is_dual);
        if !(self.of_means || of_covers) || self.sides != [Side::Other; 2] {
            return all;
        }
        let mut start = 0;
        while start < entities.count() {
            let own = entities.sides(start)[0];
            let mut end = start + 1;
            while end < entities.count() && entities.sides(end)[0] == own {
                end += 1;
            }
            let nodes = |k: usize| {
                let mut nodes: Vec<u32> = Vec::new();
                for index in start..end {
                    match (seen, entities.sides(index)) {
                        (Some(seen), _) => nodes.extend(seen[k].at(index)),
                        (None, [_, .., other] | [other]) => {
                            nodes.extend(spaces[k].nodes_at(other.cell, Some(other.local)));
                        }
                        (None, []) => {}
                    }
                }
                nodes.sort_unstable();
                nodes.dedup();
                nodes
            };
            if end > start + 1 {
                all.push([nodes(0), nodes(1)]);
            }
            start = end;
        }
        all
    }

    /// Whether it has the pairs of another one, up to the degree of the rule.
    pub fn slides_as(&self, other: &Coupling) -> bool {
        self.region == other.region && self.displacement == other.displacement
    }
}

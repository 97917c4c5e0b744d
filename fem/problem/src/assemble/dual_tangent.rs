//! The part of a tangent that changes dual functions with the cover of own facets: ψ = A φ, and A moves with the ends of moving segments.
//!
//! Of a facet, let R be the sum of the element vectors with a dual test function, and K the sum of the element matrices with a dual trial
//! function of coefficients p. With β = δA A⁻¹ a change of A adds β R to the rows of the test function, and K βᵀ p to all rows. β is that of all
//! feet of the facet, so that the cells of all its opposite facets are coupled. Where a facet is covered, β is zero.

use std::collections::{BTreeMap, HashMap};

use forms_core::contract::{Integral, Role, Side, Term};

use super::batch::Cells;
use super::binding::{Values, pair_error};
use super::element_loops::matrices::ElementMatrices;
use super::element_loops::vectors::ElementVectors;
use super::foot_rates::{FunctionsAtFeet, Rates};
use super::groups::dual_functions::{Covers, moments_by_feet};
use super::groups::{Group, groups};
use super::kernels::{MatrixKernel, VectorKernel};
use super::scatter::group_nodes::{GroupNodes, Reading, seen_places};
use super::segment_tangent::displacing_segments;
use super::tangent::{TangentIntegrals, Target};
use super::{AssemblyError, Parts};
use crate::contract::Function;
use crate::element::Element;
use crate::mesh::Facet;
use crate::pairs::PairError;

/// Of the rows of an own facet, by test function and node: for each component the derivatives by the entries of β.
type Rows = BTreeMap<(usize, u32), Vec<f64>>;

impl<const D: usize> TangentIntegrals<'_, D> {
    /// Adds what dual functions on moving segments change.
    ///
    /// # Errors
    /// Errors of the form's data; [`PairError::DualFunctions`] where dual functions are read that are no unknowns.
    pub(super) fn add_rates_of_dual_functions(
        &mut self,
        form: &Function<D>,
        parts: Parts,
    ) -> Result<(), AssemblyError> {
        let elements = self.binding.elements.iter();
        let is_dual: Vec<bool> =
            elements.map(|known| known.elements.values().any(Element::is_dual)).collect();
        if !is_dual.contains(&true) || !matches!(self.target, Target::Matrix { .. }) {
            return Ok(());
        }
        for term in form.residual().iter().filter(|term| parts.contain(term.integral.dependence)) {
            if displacing_segments(form, term).is_none() {
                continue;
            }
            self.check_dual_fields(term, &is_dual)?;
            let Integral { test, test_side, .. } = *term.integral;
            if is_dual[self.test_elements[test]] && test_side == Side::This {
                self.add_rates_of_tests(term)?;
            }
        }
        for term in form.tangent().iter().filter(|term| parts.contain(term.integral.dependence)) {
            let region = &form.inputs().regions[term.integral.region];
            let moves = region.is_on_moving_segments(term.integral.displacement);
            let Integral { trial, trial_side, .. } = *term.integral;
            if moves && is_dual[self.trial_elements[trial]] && trial_side == Side::This {
                self.add_rates_of_trials(term)?;
            }
        }
        Ok(())
    }

    /// A check that dual functions are read as unknowns and test functions only, and in no means over facets.
    fn check_dual_fields(&self, term: &Term<VectorKernel<D>>, is_dual: &[bool]) -> Result<(), AssemblyError> {
        let binding = &self.binding;
        for slot in term.kernel.constants().requirements.fields {
            let Values::Discrete { element, .. } = &binding.values[slot.field] else { continue };
            let is_unknown = matches!(binding.fields[slot.field].role, Role::Unknown(_));
            let is_of_cover = is_dual[*element] && slot.side == Side::This;
            if is_of_cover && (!is_unknown || term.integral.means.is_some()) {
                let source = PairError::DualFunctions { field: binding.fields[slot.field].name };
                return Err(pair_error(binding.name, &binding.regions[term.integral.region], source));
            }
        }
        Ok(())
    }

    fn add_rates_of_tests(&mut self, term: &Term<VectorKernel<D>>) -> Result<(), AssemblyError> {
        let (integral, constants) = (term.integral, term.kernel.constants());
        let (space, element) = (self.tests[integral.test], self.test_elements[integral.test]);
        let arguments = [(Role::Test(integral.test), &**space)];
        let degrees = &self.degrees;
        let groups =
            groups(&self.binding, integral, self.quadrature, degrees, constants.requirements, &arguments)?;
        let (height, mut rows) = (constants.components, HashMap::<Facet, Rows>::new());
        for group in &groups {
            let side = group.side(self.binding.name, integral.test_side)?;
            let cells = Cells::Mesh(self.binding.mesh);
            let task = ElementVectors { binding: &self.binding, group, cells, side, element };
            let nodes = GroupNodes::new(space, &group.sides[side]);
            for (unit, own, _) in units_in_part(group, element) {
                let (of_facet, count) = (rows.entry(own).or_default(), task.nodes());
                term.kernel.compute(&task, unit..unit + 1, &mut |_, vector| {
                    for (i, node) in nodes.of(unit).iter().enumerate() {
                        let known = of_facet.entry((integral.test, *node));
                        let known = known.or_insert_with(|| vec![0.0; height * count * count]);
                        for (k, entries) in vector.chunks_exact(height).enumerate() {
                            for (component, entry) in entries.iter().enumerate() {
                                known[component * count * count + i * count + k] += entry;
                            }
                        }
                    }
                    Ok(())
                })?;
            }
        }
        self.add_rates(integral, element, &groups, &rows)
    }

    fn add_rates_of_trials(&mut self, term: &Term<MatrixKernel<D>>) -> Result<(), AssemblyError> {
        let (integral, constants) = (term.integral, term.kernel.constants());
        let [test, trial] = [self.tests[integral.test], self.trials[integral.trial]];
        let elements = [self.test_elements[integral.test], self.trial_elements[integral.trial]];
        let arguments = [(Role::Test(integral.test), &**test), (Role::Unknown(integral.trial), &**trial)];
        let degrees = &self.degrees;
        let groups =
            groups(&self.binding, integral, self.quadrature, degrees, constants.requirements, &arguments)?;
        let ([height, width], mut rows) = (constants.components, HashMap::<Facet, Rows>::new());
        let reading = Reading::of_arguments(constants.requirements);
        let coefficients = self.coefficients(integral.trial);
        for group in &groups {
            let form = self.binding.name;
            let sides = [group.side(form, integral.test_side)?, group.side(form, integral.trial_side)?];
            let seen =
                [(0, test), (1, trial)].map(|(k, space)| seen_places(group, sides[k], space, reading[k]));
            let task = ElementMatrices {
                binding: &self.binding,
                group,
                cells: Cells::Mesh(self.binding.mesh),
                sides,
                elements,
                symmetric: false,
                seen,
            };
            let at = |space, k: usize| {
                GroupNodes::new(space, &group.sides[sides[k]]).at_places(task.seen[k].as_deref())
            };
            let (tests, trials) = (at(test, 0), at(trial, 1));
            for (unit, own, _) in units_in_part(group, elements[1]) {
                let (of_facet, count) = (rows.entry(own).or_default(), task.nodes()[1]);
                term.kernel.compute(&task, unit..unit + 1, &mut |_, matrix| {
                    let of_row = count * height * width;
                    for (node, blocks) in tests.of(unit).iter().zip(matrix.chunks_exact(of_row)) {
                        let known = of_facet.entry((integral.test, *node));
                        let known = known.or_insert_with(|| vec![0.0; height * count * count]);
                        for (i, other) in trials.of(unit).iter().enumerate() {
                            let values = &coefficients[*other as usize * width..][..width];
                            for (k, block) in blocks.chunks_exact(height * width).enumerate() {
                                for (component, row) in block.chunks_exact(width).enumerate() {
                                    let product: f64 = row.iter().zip(values).map(|(a, b)| a * b).sum();
                                    known[component * count * count + i * count + k] += product;
                                }
                            }
                        }
                    }
                    Ok(())
                })?;
            }
        }
        self.add_rates(integral, elements[1], &groups, &rows)
    }

    /// The coefficients of an unknown.
    fn coefficients(&self, unknown: usize) -> Vec<f64> {
        let is_it = |role: Role| matches!(role, Role::Unknown(number) if number == unknown);
        let place = self.binding.fields.iter().position(|field| is_it(field.role));
        match place.map(|place| &self.binding.values[place]) {
            Some(Values::Discrete { values, .. }) => values.to_vec(),
            _ => vec![0.0; self.trials[unknown].unknowns()],
        }
    }

    /// Adds the products of rows and of the rates of β, which each unit has by its feet.
    fn add_rates(
        &mut self,
        integral: &Integral,
        element: usize,
        groups: &[Group<D>],
        rows: &HashMap<Facet, Rows>,
    ) -> Result<(), AssemblyError> {
        let mut rates = Rates::default();
        for field in integral.displacement.unwrap_or_default() {
            let Role::Unknown(trial) = self.binding.fields[*field].role else { continue };
            let space = self.trials[trial];
            for group in groups {
                let Some(pairs) = group.pairs() else { continue };
                let functions = FunctionsAtFeet::new(&pairs.group, space, self.binding.instructions);
                for (unit, own, covers) in units_in_part(group, element) {
                    let (Some(rows), Some(cover)) = (rows.get(&own), covers.in_part(own)) else { continue };
                    let entries = cover.count() * cover.count();
                    let moments = moments_by_feet(&pairs.group, &self.binding.elements[element], unit);
                    let by_feet: Vec<Vec<f64>> =
                        moments.chunks_exact(entries).map(|of_foot| cover.rate(of_foot)).collect();
                    rates.take(&pairs.group, unit, &functions, space);
                    for ((test, row), known) in rows {
                        let left: Vec<f64> = known
                            .chunks_exact(entries)
                            .flat_map(|of_row| by_feet.iter().map(|beta| dot(of_row, beta)))
                            .collect();
                        for (node, right) in rates.by_node() {
                            let right = (trial, node, right.as_flattened());
                            self.add_block((*test, *row, &left), right, by_feet.len())?;
                        }
                    }
                }
            }
        }
        Ok(())
    }
}

/// The units of own facets that are covered in part, with their own facets, and the covers.
fn units_in_part<const D: usize>(
    group: &Group<D>,
    element: usize,
) -> impl Iterator<Item = (usize, Facet, &Covers)> {
    let of_pairs = group.pairs().and_then(|pairs| Some((&pairs.group, pairs.dual[element].as_ref()?)));
    of_pairs.into_iter().flat_map(|(pairs, dual)| {
        let own = pairs.facets.iter().enumerate().map(|(unit, [own, _])| (unit, *own, &*dual.covers));
        own.filter(|(_, own, covers)| covers.in_part(*own).is_some())
    })
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

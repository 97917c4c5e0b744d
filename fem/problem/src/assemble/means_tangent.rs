//! The derivative of a residual by means over own facets, times that of the means by the unknowns: on each facet, and for each weight, a
//! product of few columns and few rows. It couples the cells of all facets that lie opposite to the own one.

use std::collections::{BTreeMap, HashMap};

use forms_core::contract::{Integral, Role, Side, Term};

use super::batch::Cells;
use super::element_loops::matrices::ElementMatrices;
use super::element_loops::moving_points::PointMotion;
use super::groups::groups;
use super::groups::own_facets::{facet_means, of_list};
use super::kernels::MatrixKernel;
use super::scatter::group_nodes::{GroupNodes, Reading, seen_places};
use super::segment_columns::{Motion, MovingTerm};
use super::segment_tangent::displacing_segments;
use super::tangent::{TangentIntegrals, Target};
use super::{AssemblyError, Parts};
use crate::assemble::groups::degrees::Estimate;
use crate::contract::Function;
use crate::instantiate::instantiate;
use crate::mesh::Facet;

/// The kind of a product's argument.
#[derive(Clone, Copy, PartialEq)]
enum Factor {
    /// ∂R/∂m, rows of test functions.
    ByMeans,
    /// ∂m/∂u, columns of trial functions.
    ByUnknowns,
}

/// Of each own facet and weight, the sums of a factor by space and node.
type Sums = HashMap<(usize, usize), BTreeMap<(usize, u32), Vec<f64>>>;

impl<const D: usize> TangentIntegrals<'_, D> {
    /// Adds the products of all lists of means.
    ///
    /// # Errors
    /// Errors of the form's data; [`AssemblyError::Means`] if element matrices are asked for, which means do not have.
    #[inline(never)]
    pub(super) fn add_products_of_means(
        &mut self,
        form: &Function<D>,
        parts: Parts,
    ) -> Result<(), AssemblyError> {
        let is_asked = |term: &&Term<MatrixKernel<D>>| parts.contain(term.integral.dependence);
        let asked: Vec<_> = form.residual_by_means().iter().filter(is_asked).collect();
        let mut numbers: Vec<usize> =
            asked.iter().filter_map(|term| term.integral.means).map(|means| means.number).collect();
        numbers.sort_unstable();
        numbers.dedup();
        for number in numbers {
            let of_number = |term: &&Term<MatrixKernel<D>>| of_list(term.integral, number).is_some();
            let by_means: Vec<_> = asked.iter().copied().filter(of_number).collect();
            let by_unknowns: Vec<_> = form.means_by_unknowns().iter().filter(of_number).collect();
            self.add_product(form, number, &by_means, &by_unknowns)?;
        }
        Ok(())
    }

    fn add_product(
        &mut self,
        function: &Function<D>,
        number: usize,
        by_means: &[&Term<MatrixKernel<D>>],
        by_unknowns: &[&Term<MatrixKernel<D>>],
    ) -> Result<(), AssemblyError> {
        let Some(first) = by_means.first() else { return Ok(()) };
        let moved = first
            .integral
            .displacement
            .filter(|by| self.binding.regions[first.integral.region].is_on_moving_segments(Some(by)));
        if by_unknowns.is_empty() && moved.is_none() {
            return Ok(());
        }
        let form = self.binding.name;
        let Target::Matrix { .. } = &self.target else { return Err(AssemblyError::Means { form }) };
        let region = &self.binding.regions[first.integral.region];
        let estimate =
            Estimate { integrand: &first.integral.degree, fields: &self.degrees, of_history: None };
        let degree = estimate.on_pairs(self.binding.mesh, region.pairing.as_ref());
        let means = facet_means(&self.binding, number, (self.quadrature, degree))?;
        let (mut rows, mut columns) = (Sums::new(), Sums::new());
        for term in by_means {
            self.collect(term, Factor::ByMeans, &means.facets, &mut rows)?;
        }
        for term in by_unknowns {
            self.collect(term, Factor::ByUnknowns, &means.facets, &mut columns)?;
        }
        self.collect_motion(function, number, &means.facets, &mut columns)?;
        let mut keys: Vec<(usize, usize)> = rows.keys().copied().collect();
        keys.sort_unstable();
        for key in keys {
            let (Some(rows), Some(columns)) = (rows.get(&key), columns.get_mut(&key)) else { continue };
            let (values, volume) = means.of(key.0, key.1);
            if volume == 0.0 {
                continue;
            }
            for ((trial, _), column) in columns.iter_mut() {
                divide(column, values, volume, self.trials[*trial].components());
            }
            for ((test, row), left) in rows {
                for ((trial, column), right) in columns.iter() {
                    self.add_block((*test, *row, left), (*trial, *column, right), means.count)?;
                }
            }
        }
        Ok(())
    }

    /// Adds a block of the matrix: left (test components × means) times right (means × trial components).
    pub(super) fn add_block(
        &mut self,
        (test, row, left): (usize, u32, &[f64]),
        (trial, column, right): (usize, u32, &[f64]),
        count: usize,
    ) -> Result<(), AssemblyError> {
        let [height, width] = [self.tests[test].components(), self.trials[trial].components()];
        let missing = || AssemblyError::Pattern {
            form: self.binding.name,
            test: self.binding.name_of(Role::Test(test)),
            trial: self.binding.name_of(Role::Unknown(trial)),
        };
        let Target::Matrix { pattern, values, zeros, written } = &mut self.target else { return Ok(()) };
        let blocks = pattern.sparsity().pair(test, trial);
        let rows = pattern.sparsity().pair_rows(test, trial);
        let (values, zeros) = (&mut values[blocks.values()], &mut zeros[rows]);
        let written = &mut written[test * self.trials.len() + trial];
        if !std::mem::replace(written, true) {
            values.fill(0.0);
            zeros.fill(true);
        }
        zeros[row as usize] = false;
        let start = blocks.place(row as usize, column).ok_or_else(missing)? * height * width;
        for a in 0..height {
            for b in 0..width {
                let products = (0..count).map(|c| left[a * count + c] * right[c * width + b]);
                values[start + a * width + b] += products.sum::<f64>();
            }
        }
        Ok(())
    }

    /// The part of ∂m/∂u that moves the points of moving segments.
    fn collect_motion(
        &self,
        form: &Function<D>,
        number: usize,
        facets: &HashMap<Facet, usize>,
        sums: &mut Sums,
    ) -> Result<(), AssemblyError> {
        let TangentIntegrals { ref binding, threads, .. } = *self;
        let element = binding.constant_element()?;
        for term in form.means().iter().filter(|term| of_list(term.integral, number).is_some()) {
            let Some(displacing) = displacing_segments(form, term) else { continue };
            let terms = &[MovingTerm { term, element }];
            let motion = Motion { binding, terms, threads };
            let kernel = term.kernel.constants();
            let groups =
                groups(binding, term.integral, self.quadrature, &self.degrees, kernel.requirements, &[])?;
            for field in displacing {
                let Role::Unknown(trial) = binding.fields[*field].role else { continue };
                for group in &groups {
                    let (Some(pairs), Some(means)) = (group.pairs(), &group.means) else { continue };
                    let space = self.trials[trial];
                    motion.each_column(
                        group,
                        &[(0, PointMotion::ByFeet(&[0]))],
                        space,
                        &mut |unit, node, column| {
                            let key = (facets[&pairs.group.facets[unit][0]], means.weight);
                            let of_facet = sums.entry(key).or_default().entry((trial, node));
                            let known = of_facet.or_insert_with(|| vec![0.0; kernel.components * D]);
                            for (row, entries) in known.chunks_exact_mut(D).enumerate() {
                                let rates = column.of(row);
                                (0..D).for_each(|k| entries[k] += rates[k]);
                            }
                            Ok(())
                        },
                    )?;
                }
            }
        }
        Ok(())
    }

    /// Sums of a factor over all units of each own facet, in their order.
    fn collect(
        &self,
        term: &Term<MatrixKernel<D>>,
        factor: Factor,
        facets: &HashMap<Facet, usize>,
        sums: &mut Sums,
    ) -> Result<(), AssemblyError> {
        let (integral, constants) = (term.integral, term.kernel.constants());
        let constant = self.binding.constant_element()?;
        let form = self.binding.name;
        let (number, space, side, element, role) = match factor {
            Factor::ByMeans => {
                let Integral { test, test_side, .. } = *integral;
                (test, self.tests[test], test_side, self.test_elements[test], Role::Test(test))
            }
            Factor::ByUnknowns => {
                let Integral { trial, trial_side, .. } = *integral;
                (trial, self.trials[trial], trial_side, self.trial_elements[trial], Role::Unknown(trial))
            }
        };
        let reading =
            Reading::of_arguments(constants.requirements)[usize::from(factor == Factor::ByUnknowns)];
        let of_argument = [(role, &**space)];
        let [height, width] = constants.components;
        for group in groups(
            &self.binding,
            integral,
            self.quadrature,
            &self.degrees,
            constants.requirements,
            &of_argument,
        )? {
            let (Some(pairs), Some(means)) = (group.pairs(), &group.means) else { continue };
            let side = group.side(form, side)?;
            group.check_support(form, self.binding.name_of(role), space, side)?;
            let own = group.side(form, Side::This)?;
            let seen = seen_places(&group, side, space, reading);
            let (sides, elements, places) = match factor {
                Factor::ByMeans => ([side, own], [element, constant], [seen, None]),
                Factor::ByUnknowns => ([own, side], [constant, element], [None, seen]),
            };
            let task = ElementMatrices {
                binding: &self.binding,
                group: &group,
                cells: Cells::Mesh(self.binding.mesh),
                sides,
                elements,
                symmetric: false,
                seen: places,
            };
            let place = usize::from(factor == Factor::ByUnknowns);
            let nodes = GroupNodes::new(space, &group.sides[side]).at_places(task.seen[place].as_deref());
            let size = task.nodes()[place] * height * width;
            term.kernel.compute(&task, 0..group.entities(), &mut |first, matrices| {
                for (unit, matrix) in matrices.chunks_exact(size).enumerate() {
                    let facet = facets[&pairs.group.facets[first + unit][0]];
                    let of_facet = sums.entry((facet, means.weight)).or_default();
                    let blocks = nodes.of(first + unit).iter().zip(matrix.chunks_exact(height * width));
                    for (node, block) in blocks {
                        let known = of_facet.entry((number, *node)).or_insert_with(|| vec![0.0; block.len()]);
                        known.iter_mut().zip(block).for_each(|(sum, value)| *sum += value);
                    }
                }
                Ok(())
            })?;
        }
        Ok(())
    }
}

/// From the derivatives of ∫ ψ a and of ∫ ψ, row after row, to those of the means: (δ∫ ψ a − m δ∫ ψ) / ∫ ψ.
fn divide(column: &mut [f64], means: &[f64], volume: f64, width: usize) {
    let (sums, of_volume) = column.split_at_mut(means.len() * width);
    for (row, mean) in sums.chunks_exact_mut(width).zip(means) {
        for (value, change) in row.iter_mut().zip(&*of_volume) {
            *value = (*value - mean * change) / volume;
        }
    }
}

instantiate!(means_tangent: TangentIntegrals::<D>::add_products_of_means);

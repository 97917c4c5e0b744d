//! The part of a tangent that moves the points of moving segments: Σ over coordinates c of the feet of opposite nodes of ∂R/∂c ⊗ ∂c/∂u; of
//! derivatives by the shape and by states, that of their integrand J is ∂J/∂c ∂c/∂T.
//!
//! `element_loops/moving_points.rs` has the first factor and `foot_rates.rs` the second one, which has entries for the nodes of the own facet and those
//! of the facet that has the node. `segment_columns.rs` multiplies them.

use std::sync::Arc;

use forms_core::contract::{Role, Term};

use super::binding::{Binding, Values, pair_error};
use super::element_loops::moving_points::PointMotion;
use super::groups::{Group, groups};
use super::kernels::VectorKernel;
use super::scatter::group_nodes::{Reading, seen_places};
use super::scatter::motion_blocks::MotionBlocks;
use super::segment_columns::{Motion, MovingTerm};
use super::{Assembler, AssemblyError, BlockPattern, Parts};
use crate::contract::Function;
use crate::field::FieldView;
use crate::instantiate::instantiate;
use crate::linear_algebra::BlockMatrix;
use crate::pairs::PairError;
use crate::quadrature::Quadrature;
use crate::space::Space;

/// Whether a form has integrals over moving segments.
pub(super) fn has_segments<const D: usize>(form: &Function<D>) -> bool {
    form.residual().iter().chain(form.motion()).any(|term| displacing_segments(form, term).is_some())
}

/// The fields that displace the moving segments of a term; none of other terms.
pub(super) fn displacing_segments<const D: usize>(
    form: &Function<D>,
    term: &Term<VectorKernel<D>>,
) -> Option<&'static [usize]> {
    let region = &form.inputs().regions[term.integral.region];
    term.integral.displacement.filter(|by| region.is_on_moving_segments(Some(by)))
}

/// The unknowns that displace the moving segments of a term.
pub(super) fn displacing_unknowns<const D: usize>(
    form: &Function<D>,
    term: &Term<VectorKernel<D>>,
) -> Vec<usize> {
    let unknown = |field: &usize| match form.fields()[*field].role {
        Role::Unknown(trial) => Some(trial),
        _ => None,
    };
    displacing_segments(form, term).unwrap_or_default().iter().filter_map(unknown).collect()
}

impl<const D: usize> Assembler<D> {
    /// The motion of points, added to the tangent of some of the integrals.
    ///
    /// # Errors
    /// As [`Assembler::tangent`]; [`PairError::NoGradient`] where something is read at the points that knows no derivative.
    #[inline(never)]
    pub(super) fn add_motion_of_segments(
        &self,
        form: &Function<D>,
        (unknowns, tests): (&[FieldView<D>], &[&Arc<Space<D>>]),
        parts: Parts,
        pattern: &BlockPattern<D>,
        matrix: &mut BlockMatrix,
    ) -> Result<(), AssemblyError> {
        let moves = |term: &&Term<VectorKernel<D>>| {
            parts.contain(term.integral.dependence) && displacing_segments(form, term).is_some()
        };
        let moving: Vec<_> = form.residual().iter().filter(moves).collect();
        if !moving.is_empty() {
            let mut binding = self.bind(form, unknowns)?;
            let mut terms = Vec::new();
            for term in moving {
                terms.push(MovingTerm { term, element: binding.element(tests[term.integral.test]) });
            }
            for terms in terms.chunk_by(|first, second| first.has_points_of(second)) {
                for trial in displacing_unknowns(form, terms[0].term) {
                    let motion = Motion { binding: &binding, terms, threads: self.threads };
                    motion.add((trial, unknowns[trial].space, tests), &self.quadrature, pattern, matrix)?;
                }
            }
            for MovingTerm { term, .. } in terms {
                if term.kernel.constants().requirements.varies_energy {
                    let space = unknowns[term.integral.test].space;
                    let terms = &[MovingTerm { term, element: binding.element(space) }];
                    for trial in displacing_unknowns(form, term) {
                        let motion = Motion { binding: &binding, terms, threads: self.threads };
                        motion.add_transposed((trial, space, tests), &self.quadrature, pattern, matrix)?;
                    }
                }
            }
        }
        self.add_second_motion_of_energies(form, (unknowns, tests), parts, pattern, matrix)
    }

    /// The motion of points, added to the residual of a form that is a derivative by the shape, by a state that displaces surfaces, or that of an
    /// energy.
    ///
    /// # Errors
    /// As [`Assembler::add_motion_of_segments`].
    pub(super) fn add_motion_of_integrands(
        &self,
        form: &Function<D>,
        (unknowns, tests): (&[FieldView<D>], &[&Arc<Space<D>>]),
        (parts, left_out): (Parts, &[usize]),
        vector: &mut [f64],
    ) -> Result<(), AssemblyError> {
        for term in form.motion() {
            let (integral, requirements) = (term.integral, term.kernel.constants().requirements);
            let region = &form.inputs().regions[integral.region];
            let asked = parts.contain(integral.dependence) && !left_out.contains(&integral.test);
            if !asked || !region.is_on_moving_segments(integral.displacement) {
                continue;
            }
            let mut binding = self.bind(form, unknowns)?;
            let test = tests[integral.test];
            let element = binding.element(test);
            let degrees = binding.degrees(tests);
            let before: usize = tests[..integral.test].iter().map(|space| space.unknowns()).sum();
            let vector = &mut vector[before..][..test.unknowns()];
            let arguments = [(Role::Test(integral.test), &**test)];
            for group in groups(&binding, integral, &self.quadrature, &degrees, requirements, &arguments)? {
                check_covers(&binding, term, &group)?;
                let terms = &[MovingTerm { term, element }];
                let motion = Motion { binding: &binding, terms, threads: self.threads };
                let integrand = [(0, PointMotion::OfIntegrand)];
                motion.each_column(&group, &integrand, test, &mut |_, node, column| {
                    let entries = &mut vector[node as usize * D..][..D];
                    column.of(0).iter().zip(entries).for_each(|(rate, entry)| *entry += rate);
                    Ok(())
                })?;
            }
        }
        Ok(())
    }
}

/// A check that an integrand reads no dual functions of covers that move: its derivative would hold them.
fn check_covers<const D: usize>(
    binding: &Binding<D>,
    term: &Term<VectorKernel<D>>,
    group: &Group<D>,
) -> Result<(), AssemblyError> {
    let Some(pairs) = group.pairs() else { return Ok(()) };
    for slot in term.kernel.constants().requirements.fields {
        let Values::Discrete { element, .. } = &binding.values[slot.field] else { continue };
        if pairs.dual[*element].as_ref().is_some_and(|dual| dual.covers.has_parts()) {
            let source = PairError::DualFunctions { field: binding.fields[slot.field].name };
            return Err(pair_error(binding.name, &binding.regions[term.integral.region], source));
        }
    }
    Ok(())
}

/// The rows of one integral's test functions on a group.
struct TestRows<'a, const D: usize> {
    test: &'a Space<D>,
    side: usize,
    local: Option<u8>,
    /// The places of the functions that are seen.
    seen: &'a [usize],
    /// Components of a function.
    height: usize,
    /// The starts of the pair of spaces among the values and rows of the matrix.
    starts: [usize; 2],
    places: MotionBlocks<'a>,
    missing: [&'static str; 2],
}

impl<const D: usize> Motion<'_, D> {
    fn add(
        &self,
        (trial, trials, tests): (usize, &Arc<Space<D>>, &[&Arc<Space<D>>]),
        quadrature: &Quadrature<D>,
        pattern: &BlockPattern<D>,
        matrix: &mut BlockMatrix,
    ) -> Result<(), AssemblyError> {
        let Motion { binding, terms, .. } = *self;
        let (integral, requirements) = (terms[0].term.integral, self.requirements());
        let degrees = binding.degrees(tests);
        let number_of = |moving: &MovingTerm<D>| moving.term.integral.test;
        let arguments: Vec<(Role, &Space<D>)> =
            terms.iter().map(|moving| (Role::Test(number_of(moving)), &**tests[number_of(moving)])).collect();
        let blocks: Vec<_> =
            terms.iter().map(|moving| pattern.sparsity().pair(number_of(moving), trial)).collect();
        for group in groups(binding, integral, quadrature, &degrees, &requirements, &arguments)? {
            let (mut sides, mut all_seen) = (Vec::new(), Vec::new());
            for MovingTerm { term, element } in terms {
                let [reading, _] = Reading::of_arguments(term.kernel.constants().requirements);
                let side = group.side(binding.name, term.integral.test_side)?;
                let nodes = group.sides[side].elements[*element].nodes;
                let seen = seen_places(&group, side, tests[term.integral.test], reading);
                sides.push((side, reading));
                all_seen.push(seen.unwrap_or_else(|| (0..nodes).collect()));
            }
            let mut rows = Vec::new();
            for (number, MovingTerm { term, .. }) in terms.iter().enumerate() {
                let ((side, reading), seen) = (sides[number], &all_seen[number][..]);
                let numbers = [term.integral.test, trial];
                let test = &**tests[numbers[0]];
                let of_tests = (test, side, seen, reading);
                rows.push(TestRows {
                    test,
                    side,
                    local: group.sides[side].facet.map(|(local, _)| local),
                    seen,
                    height: term.kernel.constants().components,
                    starts: [
                        blocks[number].values().start,
                        pattern.sparsity().pair_rows(numbers[0], trial).start,
                    ],
                    places: MotionBlocks::new(pattern, (blocks[number], numbers), &group, of_tests, trials),
                    missing: [Role::Test(numbers[0]), Role::Unknown(trial)].map(|role| binding.name_of(role)),
                });
            }
            let motions: Vec<(usize, PointMotion)> =
                rows.iter().map(|rows| (rows.side, PointMotion::ByFeet(rows.seen))).collect();
            let (values, zeros) = matrix.values_and_zero_rows();
            let mut starts = Vec::new();
            self.each_unit(&group, &motions, trials, &mut |unit, columns| {
                // First all places, so that the blocks come from memory while products are made.
                starts.clear();
                for (node, of_cell) in columns.nodes() {
                    for TestRows {
                        test,
                        side,
                        local,
                        seen,
                        height,
                        starts: [first, rows],
                        places,
                        missing,
                    } in &rows
                    {
                        let at = test.nodes_at(group.sides[*side].cells[unit], *local);
                        for (number, place) in seen.iter().enumerate() {
                            let row = at[*place] as usize;
                            let place = places.place((unit, number, row), (node, of_cell));
                            let place = place.ok_or_else(|| {
                                let [test, trial] = *missing;
                                AssemblyError::Pattern { form: binding.name, test, trial }
                            })?;
                            zeros[rows + row] = false;
                            starts.push([first + place * height * D, height * D]);
                        }
                    }
                }
                columns.multiply(values, &starts);
                let mut starts = starts.iter();
                for column in columns.products() {
                    let mut entry = 0;
                    while entry < columns.entries {
                        let Some([start, length]) = starts.next() else { break };
                        for entries in values[*start..][..*length].chunks_exact_mut(D) {
                            let rates = column.of(entry);
                            (0..D).for_each(|k| entries[k] += rates[k]);
                            entry += 1;
                        }
                    }
                }
                Ok(())
            })?;
        }
        Ok(())
    }
}

instantiate!(segment_tangent: has_segments::<D>, Assembler::<D>::add_motion_of_segments, Assembler::<D>::add_second_motion_of_energies,
    Assembler::<D>::add_motion_of_integrands);

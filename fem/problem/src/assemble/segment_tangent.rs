//! The part of a tangent that moves the points of moving segments: Σ over coordinates c of the feet of opposite nodes of ∂R/∂c ⊗ ∂c/∂u; of
//! derivatives by the shape and by states, that of their integrand J is ∂J/∂c ∂c/∂T.
//!
//! `element_loops/moving_points.rs` has the first factor and `foot_rates.rs` the second one, which has entries for the nodes of the own facet and those
//! of the facet that has the node.

use std::ops::Range;
use std::sync::Arc;

use forms_core::contract::{FieldSlot, Role, Term};

use super::batch::Cells;
use super::binding::{Binding, Values, pair_error};
use super::element_loops::moving_points::PointMotion;
use super::element_loops::vectors::ElementVectors;
use super::foot_rates::{FunctionsAtFeet, MotionColumn, Rates};
use super::groups::{Group, groups};
use super::kernels::VectorKernel;
use super::scatter::group_nodes::{Reading, seen_places};
use super::scatter::motion_blocks::MotionBlocks;
use super::{Assembler, AssemblyError, BlockPattern, Parts};
use crate::contract::Function;
use crate::field::FieldView;
use crate::instantiate::instantiate;
use crate::lanes::WIDEST;
use crate::linear_algebra::BlockMatrix;
use crate::pairs::PairError;
use crate::quadrature::Quadrature;
use crate::space::Space;
use crate::threads::Threads;

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
        for term in form.residual().iter().filter(|term| parts.contain(term.integral.dependence)) {
            let Some(displacing) = displacing_segments(form, term) else { continue };
            let mut binding = self.bind(form, unknowns)?;
            let element = binding.element(tests[term.integral.test]);
            for field in displacing {
                if let Role::Unknown(trial) = binding.fields[*field].role {
                    let motion = self.motion(&binding, term, element);
                    motion.add((trial, unknowns[trial].space, tests), &self.quadrature, pattern, matrix)?;
                    if term.kernel.constants().requirements.varies_energy {
                        let space = unknowns[term.integral.test].space;
                        let element = binding.element(space);
                        let motion = self.motion(&binding, term, element);
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
                let motion = self.motion(&binding, term, element);
                motion.each_column((&group, 0), PointMotion::OfIntegrand, test, &mut |_, node, column| {
                    let entries = &mut vector[node as usize * D..][..D];
                    column.of(0).iter().zip(entries).for_each(|(rate, entry)| *entry += rate);
                    Ok(())
                })?;
            }
        }
        Ok(())
    }

    pub(super) fn motion<'a>(
        &self,
        binding: &'a Binding<'a, D>,
        term: &'a Term<VectorKernel<D>>,
        element: usize,
    ) -> Motion<'a, D> {
        Motion { binding, term, element, threads: self.threads }
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

/// One term's segments, whose points move.
pub(super) struct Motion<'a, const D: usize> {
    pub binding: &'a Binding<'a, D>,
    pub term: &'a Term<VectorKernel<D>>,
    /// That of the test function.
    pub element: usize,
    pub threads: Threads,
}

/// Takes a unit, a node of the space that displaces it, and the column of that node.
pub(super) type ReceiveColumn<'r, const D: usize> =
    dyn FnMut(usize, u32, &MotionColumn<D>) -> Result<(), AssemblyError> + 'r;

impl<const D: usize> Motion<'_, D> {
    fn add(
        &self,
        (trial, trials, tests): (usize, &Arc<Space<D>>, &[&Arc<Space<D>>]),
        quadrature: &Quadrature<D>,
        pattern: &BlockPattern<D>,
        matrix: &mut BlockMatrix,
    ) -> Result<(), AssemblyError> {
        let Motion { binding, term, element, .. } = *self;
        let (integral, constants) = (term.integral, term.kernel.constants());
        let (test, form) = (tests[integral.test], binding.name);
        let missing = || AssemblyError::Pattern {
            form,
            test: binding.name_of(Role::Test(integral.test)),
            trial: binding.name_of(Role::Unknown(trial)),
        };
        let degrees = binding.degrees(tests);
        let arguments = [(Role::Test(integral.test), &**test)];
        let blocks = pattern.sparsity().pair(integral.test, trial);
        let rows = pattern.sparsity().pair_rows(integral.test, trial);
        let (height, [reading, _]) = (constants.components, Reading::of_arguments(constants.requirements));
        for group in groups(binding, integral, quadrature, &degrees, constants.requirements, &arguments)? {
            let side = group.side(form, integral.test_side)?;
            let nodes = group.sides[side].elements[element].nodes;
            let seen = seen_places(&group, side, test, reading).unwrap_or_else(|| (0..nodes).collect());
            let local = group.sides[side].facet.map(|(local, _)| local);
            let (values, zeros) = matrix.values_and_zero_rows();
            let (values, zeros) = (&mut values[blocks.values()], &mut zeros[rows.clone()]);
            let motion = PointMotion::ByFeet(&seen);
            let of_tests = (&**test, side, &seen[..], reading);
            let numbers = [integral.test, trial];
            let places = MotionBlocks::new(pattern, (blocks, numbers), &group, of_tests, trials);
            self.each_column((&group, side), motion, trials, &mut |unit, node, column| {
                let at = test.nodes_at(group.sides[side].cells[unit], local);
                for (number, place) in seen.iter().enumerate() {
                    let row = at[*place] as usize;
                    let place = places.place((unit, number, row), (node, column.of_cell));
                    let first = place.ok_or_else(missing)? * height * D;
                    zeros[row] = false;
                    for (component, entries) in values[first..][..height * D].chunks_exact_mut(D).enumerate()
                    {
                        let rates = column.of(number * height + component);
                        (0..D).for_each(|k| entries[k] += rates[k]);
                    }
                }
                Ok(())
            })?;
        }
        Ok(())
    }

    /// The columns of all units of a group, handed over one after the other.
    ///
    /// # Errors
    /// As [`Assembler::add_motion_of_segments`], and those of `receive`.
    pub fn each_column(
        &self,
        (group, side): (&Group<D>, usize),
        motion: PointMotion,
        space: &Space<D>,
        receive: &mut ReceiveColumn<D>,
    ) -> Result<(), AssemblyError> {
        let Some(pairs) = group.pairs() else { return Ok(()) };
        let vectors = self.vectors_by_feet(group, side, motion)?;
        let (units, instructions) = (group.entities(), self.binding.instructions);
        let length = (vectors.len() - WIDEST) / units.max(1);
        let entries = length / pairs.group.motion.coordinates(units).max(1);
        let (own, mut rates) = (FunctionsAtFeet::new(&pairs.group, space, instructions), Rates::default());
        for unit in 0..units {
            rates.take(&pairs.group, unit, &own, space);
            rates.multiply((&vectors, unit * length, entries), instructions);
            for column in rates.products(entries) {
                receive(unit, column.node, &column)?;
            }
        }
        Ok(())
    }

    /// The derivatives of the element vectors of a group by the feet of their segments, unit after unit, with as many zeros behind them as lanes may have.
    fn vectors_by_feet(
        &self,
        group: &Group<D>,
        side: usize,
        motion: PointMotion,
    ) -> Result<Vec<f64>, AssemblyError> {
        let Motion { binding, term, element, threads } = *self;
        let cells = Cells::Mesh(binding.mesh);
        let task = ElementVectors { binding, group, cells, side, element };
        let count = group.entities();
        let number = threads.count().min(count.div_ceil(64)).max(1);
        let parts = (0..number).map(|part| part * count / number..(part + 1) * count / number).collect();
        let found = threads.run(parts, |units: Range<usize>| {
            let mut vectors: Vec<f64> = Vec::new();
            let moving = (motion, units);
            term.kernel.compute_moving(&task, moving, &mut |_, some| {
                vectors.extend_from_slice(some);
                Ok(())
            })?;
            Ok(vectors)
        });
        let mut vectors: Vec<f64> = Vec::new();
        for part in found {
            match part? {
                first if vectors.is_empty() => vectors = first,
                later => vectors.extend(later),
            }
        }
        vectors.resize(vectors.len() + WIDEST, 0.0);
        match vectors.iter().all(|value| value.is_finite()) {
            true => Ok(vectors),
            false => Err(self.no_gradient()),
        }
    }

    #[cold]
    fn no_gradient(&self) -> AssemblyError {
        let field = self.without_derivatives();
        self.refused(PairError::NoGradient { field })
    }

    /// The name of something that is read at the points and has too few derivatives.
    pub fn without_derivatives(&self) -> &'static str {
        let Motion { binding, term, .. } = *self;
        let without = |slot: &&FieldSlot| matches!(binding.values[slot.field], Values::Function { .. });
        let slots = term.kernel.constants().requirements.fields;
        slots.iter().find(without).map_or("external function", |slot| binding.fields[slot.field].name)
    }

    pub fn refused(&self, source: PairError) -> AssemblyError {
        let Motion { binding, term, .. } = *self;
        pair_error(binding.name, &binding.regions[term.integral.region], source)
    }
}

instantiate!(segment_tangent: has_segments::<D>, Assembler::<D>::add_motion_of_segments, Assembler::<D>::add_second_motion_of_energies,
    Assembler::<D>::add_motion_of_integrands);

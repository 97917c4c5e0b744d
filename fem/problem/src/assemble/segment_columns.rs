//! Integrals over moving segments that have their points in common, as those of the test functions of both sides: the derivatives of their element
//! vectors by the coefficients of the space that displaces the surfaces, unit after unit and node after node.

use std::ops::Range;

use forms_core::contract::{FieldSlot, Requirements, Term};

use super::AssemblyError;
use super::binding::{Binding, Values, pair_error};
use super::element_loops::moving_points::{MovingTest, MovingVectors, PointMotion};
use super::foot_rates::{FunctionsAtFeet, MotionColumn, Rates, UnitColumns};
use super::groups::Group;
use super::kernels::{VectorKernel, compute_moving};
use crate::lanes::WIDEST;
use crate::pairs::PairError;
use crate::space::Space;
use crate::threads::Threads;

/// An integral over moving segments.
#[derive(Clone, Copy)]
pub(super) struct MovingTerm<'a, const D: usize> {
    pub term: &'a Term<VectorKernel<D>>,
    /// That of the test function.
    pub element: usize,
}

impl<const D: usize> MovingTerm<'_, D> {
    /// Whether another one has the same points, with the same geometry and fields there: the integrals of both sides' test functions.
    pub fn has_points_of(&self, other: &Self) -> bool {
        let [one, another] = [self, other].map(|moving| {
            let requirements = moving.term.kernel.constants().requirements;
            let without_arguments = Requirements {
                basis_value: false,
                basis_gradient: false,
                test_derivatives: false,
                hessian: false,
                test_mean: false,
                ..*requirements
            };
            let integral = moving.term.integral;
            // Rules of segments do not follow the degree of an integrand.
            (integral.region, integral.displacement, integral.means, without_arguments)
        });
        one == another
    }
}

/// Some integrals over segments with the same points, which move.
pub(super) struct Motion<'a, const D: usize> {
    pub binding: &'a Binding<'a, D>,
    pub terms: &'a [MovingTerm<'a, D>],
    pub threads: Threads,
}

/// Takes a unit, a node of the space that displaces it, and the column of that node.
pub(super) type ReceiveColumn<'r, const D: usize> =
    dyn FnMut(usize, u32, &MotionColumn<D>) -> Result<(), AssemblyError> + 'r;

/// Takes a unit and its columns, before their products are made.
pub(super) type ReceiveUnit<'r, const D: usize> =
    dyn FnMut(usize, &mut UnitColumns<D>) -> Result<(), AssemblyError> + 'r;

impl<const D: usize> Motion<'_, D> {
    /// The inputs of all integrals together.
    pub fn requirements(&self) -> Requirements {
        let mut all = *self.terms[0].term.kernel.constants().requirements;
        for MovingTerm { term, .. } in self.terms {
            let one = term.kernel.constants().requirements;
            all.basis_value |= one.basis_value;
            all.basis_gradient |= one.basis_gradient;
            all.test_derivatives |= one.test_derivatives;
            all.hessian |= one.hessian;
            all.test_mean |= one.test_mean;
        }
        all
    }

    /// The columns of all units of a group, handed over one after the other: entries are those of all integrals, in their order. Of each one the side of
    /// the test function is given, and its motion.
    ///
    /// # Errors
    /// As [`Assembler::add_motion_of_segments`], and those of `receive`.
    pub fn each_column(
        &self,
        group: &Group<D>,
        motions: &[(usize, PointMotion)],
        space: &Space<D>,
        receive: &mut ReceiveColumn<D>,
    ) -> Result<(), AssemblyError> {
        self.each_unit(group, motions, space, &mut |unit, columns| {
            columns.multiply(&[], &[]);
            columns.products().try_for_each(|column| receive(unit, column.node, &column))
        })
    }

    /// [`Motion::each_column`] unit by unit, with the products left to the receiver.
    ///
    /// # Errors
    /// As [`Motion::each_column`].
    pub fn each_unit(
        &self,
        group: &Group<D>,
        motions: &[(usize, PointMotion)],
        space: &Space<D>,
        receive: &mut ReceiveUnit<D>,
    ) -> Result<(), AssemblyError> {
        let Some(pairs) = group.pairs() else { return Ok(()) };
        let vectors = self.vectors_by_feet(group, motions)?;
        let (units, instructions) = (group.entities(), self.binding.instructions);
        let length = (vectors.len() - WIDEST) / units.max(1);
        let entries = length / pairs.group.motion.coordinates(units).max(1);
        let own = FunctionsAtFeet::new(&pairs.group, space, instructions);
        let mut columns =
            UnitColumns { rates: Rates::default(), vectors: &vectors, first: 0, entries, instructions };
        for unit in 0..units {
            columns.rates.take(&pairs.group, unit, &own, space);
            columns.first = unit * length;
            receive(unit, &mut columns)?;
        }
        Ok(())
    }

    /// The derivatives of the element vectors of a group by the feet of their segments, unit after unit, with as many zeros behind them as lanes may have.
    fn vectors_by_feet(
        &self,
        group: &Group<D>,
        motions: &[(usize, PointMotion)],
    ) -> Result<Vec<f64>, AssemblyError> {
        let Motion { binding, terms, threads } = *self;
        let of_terms = terms.iter().zip(motions);
        let of_terms = of_terms.map(|(MovingTerm { term, element }, (side, motion))| {
            let (kernel, factor) = (term.kernel.constants(), term.kernel.factor());
            MovingTest { kernel, factor, motion: *motion, side: *side, element: *element }
        });
        let tests: Vec<MovingTest> = of_terms.collect();
        let kernels: Vec<&VectorKernel<D>> = terms.iter().map(|moving| &moving.term.kernel).collect();
        let task = MovingVectors { binding, group, requirements: self.requirements(), tests: &tests };
        let count = group.entities();
        let number = threads.count().min(count.div_ceil(64)).max(1);
        let parts = (0..number).map(|part| part * count / number..(part + 1) * count / number).collect();
        let found = threads.run(parts, |units: Range<usize>| {
            let mut vectors: Vec<f64> = Vec::new();
            compute_moving(&kernels, &task, units, &mut |_, some| {
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
        let Motion { binding, terms, .. } = *self;
        let without = |slot: &&FieldSlot| matches!(binding.values[slot.field], Values::Function { .. });
        let slots = terms[0].term.kernel.constants().requirements.fields;
        slots.iter().find(without).map_or("external function", |slot| binding.fields[slot.field].name)
    }

    pub fn refused(&self, source: PairError) -> AssemblyError {
        let Motion { binding, terms, .. } = *self;
        pair_error(binding.name, &binding.regions[terms[0].term.integral.region], source)
    }
}

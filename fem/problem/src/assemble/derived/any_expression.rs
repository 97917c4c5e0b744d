//! Type-erased functions of a forms module.
//!
//! Every function of a user's module has its own type, with its kernel as a static type inside. If the code for derived fields were
//! generic over that type, each program would compile all of it (groups, interpolation, projections) once per function. So the type is
//! erased here: [`AnyExpression`] answers four questions through a virtual call, and everything above it takes `&dyn AnyExpression`.
//!
//! Code that needs the kernel's static type stays behind `values`: the loop over the points of a group, with the kernel inlined. A
//! projection of a stress on 1,000 cells of four points thus makes one virtual call per group of cells, and the kernel is inlined at
//! all 4,000 points. `histories` is a walk of its own, because the histories that a kernel reads are needed before the first point.

use forms_core::contract::{
    Expression, ExpressionKernel, ExpressionVisitor, FieldSlot, Integral, Pairing, Requirements,
};

use crate::assemble::batch::{Batch, BatchBuffers, Cells};
use crate::assemble::binding::Binding;
use crate::assemble::binding::outline::Described;
use crate::assemble::functional::{EachPoint, each_point};
use crate::assemble::walk::Group;
use crate::assemble::{Assembler, AssemblyError};
use crate::compiled_here::compiled_here;
use crate::element::CellShape;
use crate::quadrature::Quadrature;

/// A function of a forms module.
pub(super) trait AnyExpression<const D: usize> {
    fn described(&self) -> Described<'_, D>;
    /// The number of components of its value.
    fn components(&self) -> usize;
    fn histories(&self, visitor: &mut HistoryVisitor<D>) -> Result<(), AssemblyError>;
    fn values(&self, visitor: &mut ValueVisitor<D>) -> Result<(), AssemblyError>;
}

impl<E: Expression<D>, const D: usize> AnyExpression<D> for E {
    fn described(&self) -> Described<'_, D> {
        Described::of_expression(self)
    }

    fn components(&self) -> usize {
        self.shape().iter().product()
    }

    fn histories(&self, visitor: &mut HistoryVisitor<D>) -> Result<(), AssemblyError> {
        self.expression(visitor)
    }

    fn values(&self, visitor: &mut ValueVisitor<D>) -> Result<(), AssemblyError> {
        self.expression(visitor)
    }
}

/// Position, weight and value at a point.
pub(super) type PointValue<const D: usize> = ([f64; D], f64, Vec<f64>);

/// Finds the history that a function reads.
pub(super) struct HistoryVisitor<'a, const D: usize> {
    pub binding: &'a Binding<'a, D>,
    pub quadrature: &'a Quadrature<D>,
    /// The pairs at whose points the histories have to be known.
    pub pairing: Option<&'a Pairing>,
    /// The name of a history, and the degree of its rule.
    pub read: Option<(&'static str, usize)>,
    /// The fields that the kernel reads.
    pub fields: &'static [FieldSlot],
}

impl<'a, const D: usize> HistoryVisitor<'a, D> {
    pub fn of(binding: &'a Binding<'a, D>, assembler: &'a Assembler<D>) -> Self {
        HistoryVisitor { binding, quadrature: &assembler.quadrature, pairing: None, read: None, fields: &[] }
    }
}

impl<const D: usize> ExpressionVisitor<D> for HistoryVisitor<'_, D> {
    type Error = AssemblyError;

    fn visit<K: ExpressionKernel<D>>(&mut self, _: &Integral, _: &K) -> Result<(), AssemblyError> {
        self.see(&K::REQUIREMENTS)
    }
}

impl<const D: usize> HistoryVisitor<'_, D> {
    #[inline(never)]
    fn see(&mut self, requirements: &Requirements) -> Result<(), AssemblyError> {
        if let Some(pairing) = self.pairing {
            self.binding.histories_on_pairs(requirements, pairing)?;
        }
        self.fields = requirements.fields;
        self.read = self.binding.history_degree(requirements, self.quadrature)?;
        Ok(())
    }
}

/// Evaluates a function at all points of some groups.
pub(super) struct ValueVisitor<'a, const D: usize> {
    pub binding: &'a Binding<'a, D>,
    pub groups: &'a [Group<D>],
    pub found: Vec<PointValue<D>>,
}

impl<const D: usize> ExpressionVisitor<D> for ValueVisitor<'_, D> {
    type Error = AssemblyError;

    fn visit<K: ExpressionKernel<D>>(&mut self, _: &Integral, kernel: &K) -> Result<(), AssemblyError> {
        self.evaluate(&K::REQUIREMENTS, &|batch, points, range, receive| {
            each_point(batch, points, range, kernel, receive)
        })
    }
}

impl<const D: usize> ValueVisitor<'_, D> {
    #[inline(never)]
    fn evaluate(&mut self, requirements: &Requirements, each: EachPoint<D>) -> Result<(), AssemblyError> {
        let mut buffers = BatchBuffers::default();
        let mut shapes = vec![];
        for group in self.groups {
            // Memory is made for the sizes of the group before.
            let own: Vec<CellShape> = group.sides.iter().map(|side| side.shape).collect();
            if own != shapes {
                (buffers, shapes) = (BatchBuffers::default(), own);
            }
            let cells = Cells::Mesh(self.binding.mesh);
            let located = Requirements { position: true, ..*requirements };
            let mut batch = Batch::<f64, D>::new(self.binding, group, cells, located, &[], &mut buffers)?;
            each(&mut batch, group.points(), 0..group.entities(), &mut |value, weight, position| {
                if !value.iter().all(|entry| entry.is_finite()) {
                    let (form, position) = (self.binding.name, position.to_vec());
                    return Err(AssemblyError::ValueNotFinite { form, position });
                }
                self.found.push((*position, weight, value.to_vec()));
                Ok(())
            })?;
        }
        Ok(())
    }
}

compiled_here!(any_expression: HistoryVisitor::<D>::see, ValueVisitor::<D>::evaluate);

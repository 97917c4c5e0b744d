//! Kernels behind virtual calls: one call runs a kernel over the entities of a range, and inside of it the kernel's type is known.
//!
//! A program compiles the loops of `element_loops` once, and of each of its forms only what is below these calls.

use std::ops::Range;
use std::sync::Arc;

use forms_core::contract::{
    Adaptation, Backend, BilinearConstants, BilinearKernel, CombiningBackend, ExpressionConstants,
    ExpressionKernel, LinearConstants, LinearKernel, Requirements,
};

use super::AssemblyError;
use super::binding::Binding;
use super::element_loops::matrices::ElementMatrices;
use super::element_loops::moving_points::PointMotion;
use super::element_loops::point_values::{PointBuffers, PointValues, ReceivePoint};
use super::element_loops::sink::Deliver;
use super::element_loops::vectors::ElementVectors;
use super::groups::Group;
use crate::lanes::InstructionSet;

/// This backend: kernels run in the lanes of the machine's instruction set.
#[derive(Clone, Copy, Debug)]
pub struct Lanes;

impl<const D: usize> Backend<D> for Lanes {
    type Linear = VectorKernel<D>;
    type Bilinear = MatrixKernel<D>;
    type Expression = PointKernel<D>;

    fn linear<K: LinearKernel<D>>(kernel: K) -> VectorKernel<D> {
        let constants = LinearConstants::of::<K, D>();
        VectorKernel { calls: Arc::new(kernel), constants, factor: 1.0 }
    }

    fn bilinear<K: BilinearKernel<D>>(kernel: K) -> MatrixKernel<D> {
        let constants = BilinearConstants::of::<K, D>();
        MatrixKernel { calls: Arc::new(kernel), constants, factor: 1.0 }
    }

    fn expression<K: ExpressionKernel<D>>(kernel: K) -> PointKernel<D> {
        let constants = ExpressionConstants::of::<K, D>();
        PointKernel { calls: Arc::new(kernel), constants, factor: 1.0 }
    }
}

impl<const D: usize> CombiningBackend<D> for Lanes {
    fn adapt_linear(kernel: &VectorKernel<D>, adaptation: Adaptation) -> VectorKernel<D> {
        let VectorKernel { calls, constants, factor } = kernel.clone();
        let constants =
            LinearConstants { requirements: adaptation.requirements(constants.requirements), ..constants };
        VectorKernel { calls, constants, factor: adaptation.factor() * factor }
    }

    fn adapt_bilinear(kernel: &MatrixKernel<D>, adaptation: Adaptation) -> MatrixKernel<D> {
        let MatrixKernel { calls, constants, factor } = kernel.clone();
        let constants =
            BilinearConstants { requirements: adaptation.requirements(constants.requirements), ..constants };
        MatrixKernel { calls, constants, factor: adaptation.factor() * factor }
    }

    fn adapt_expression(kernel: &PointKernel<D>, adaptation: Adaptation) -> PointKernel<D> {
        let PointKernel { calls, constants, factor } = kernel.clone();
        let constants = ExpressionConstants {
            requirements: adaptation.requirements(constants.requirements),
            ..constants
        };
        PointKernel { calls, constants, factor: adaptation.factor() * factor }
    }
}

/// The kernel of an integral that is linear in a test function, with a factor.
#[derive(Clone)]
pub struct VectorKernel<const D: usize> {
    calls: Arc<dyn VectorCalls<D>>,
    constants: LinearConstants,
    factor: f64,
}

/// The kernel of an integral that is linear in a test and in a trial function, with a factor.
#[derive(Clone)]
pub struct MatrixKernel<const D: usize> {
    calls: Arc<dyn MatrixCalls<D>>,
    constants: BilinearConstants,
    factor: f64,
}

/// The kernel of a density, a derived field, or switches, with a factor.
#[derive(Clone)]
pub struct PointKernel<const D: usize> {
    calls: Arc<dyn PointCalls<D>>,
    constants: ExpressionConstants,
    factor: f64,
}

/// Hands over what is computed, times a factor.
#[cold]
fn scaled(
    factor: f64,
    deliver: Deliver,
    compute: &dyn Fn(Deliver) -> Result<(), AssemblyError>,
) -> Result<(), AssemblyError> {
    let mut scaled = Vec::new();
    compute(&mut |first, values| {
        scaled.clear();
        scaled.extend(values.iter().map(|value| factor * value));
        deliver(first, &scaled)
    })
}

impl<const D: usize> VectorKernel<D> {
    /// Constants of the kernel.
    pub fn constants(&self) -> LinearConstants {
        self.constants
    }

    /// See [`ElementVectors::compute`].
    pub(in crate::assemble) fn compute(
        &self,
        task: &ElementVectors<D>,
        set: InstructionSet,
        entities: Range<usize>,
        deliver: Deliver,
    ) -> Result<(), AssemblyError> {
        let compute =
            |deliver: Deliver| self.calls.compute(task, &self.constants, set, entities.clone(), deliver);
        if self.factor == 1.0 { compute(deliver) } else { scaled(self.factor, deliver, &compute) }
    }

    /// See [`ElementVectors::compute_moving`].
    pub(in crate::assemble) fn compute_moving(
        &self,
        task: &ElementVectors<D>,
        set: InstructionSet,
        (motion, entities): (PointMotion, Range<usize>),
        deliver: Deliver,
    ) -> Result<(), AssemblyError> {
        let compute = |deliver: Deliver| {
            self.calls.compute_moving(task, &self.constants, set, (motion, entities.clone()), deliver)
        };
        if self.factor == 1.0 { compute(deliver) } else { scaled(self.factor, deliver, &compute) }
    }
}

impl<const D: usize> MatrixKernel<D> {
    /// Constants of the kernel.
    pub fn constants(&self) -> BilinearConstants {
        self.constants
    }

    /// See [`ElementMatrices::compute`].
    pub(in crate::assemble) fn compute(
        &self,
        task: &ElementMatrices<D>,
        set: InstructionSet,
        entities: Range<usize>,
        deliver: Deliver,
    ) -> Result<(), AssemblyError> {
        let compute =
            |deliver: Deliver| self.calls.compute(task, &self.constants, set, entities.clone(), deliver);
        if self.factor == 1.0 { compute(deliver) } else { scaled(self.factor, deliver, &compute) }
    }
}

impl<const D: usize> PointKernel<D> {
    /// Constants of the kernel.
    pub fn constants(&self) -> ExpressionConstants {
        self.constants
    }

    /// The inputs of the values at a group's points.
    pub(in crate::assemble) fn at_points<'a>(
        &self,
        binding: &'a Binding<'a, D>,
        group: &'a Group<D>,
    ) -> PointValues<'a, D> {
        let ExpressionConstants { requirements, shape } = self.constants;
        let requirements = Requirements { position: true, ..*requirements };
        PointValues { binding, group, requirements, components: shape.iter().product() }
    }

    /// See [`PointValues::compute`].
    pub(in crate::assemble) fn each_point(
        &self,
        task: &PointValues<D>,
        buffers: &mut PointBuffers,
        entities: Range<usize>,
        receive: &mut ReceivePoint<D>,
    ) -> Result<(), AssemblyError> {
        let (factor, set) = (self.factor, task.binding.instructions);
        if factor == 1.0 {
            return self.calls.compute(task, set, buffers, entities, receive);
        }
        let mut scaled = Vec::new();
        self.calls.compute(task, set, buffers, entities, &mut |value, weight, position| {
            scaled.clear();
            scaled.extend(value.iter().map(|value| factor * value));
            receive(&scaled, weight, position)
        })
    }
}

trait VectorCalls<const D: usize>: Send + Sync {
    fn compute(
        &self,
        task: &ElementVectors<D>,
        constants: &LinearConstants,
        set: InstructionSet,
        entities: Range<usize>,
        deliver: Deliver,
    ) -> Result<(), AssemblyError>;

    fn compute_moving(
        &self,
        task: &ElementVectors<D>,
        constants: &LinearConstants,
        set: InstructionSet,
        moving: (PointMotion, Range<usize>),
        deliver: Deliver,
    ) -> Result<(), AssemblyError>;
}

impl<K: LinearKernel<D>, const D: usize> VectorCalls<D> for K {
    fn compute(
        &self,
        task: &ElementVectors<D>,
        constants: &LinearConstants,
        set: InstructionSet,
        entities: Range<usize>,
        deliver: Deliver,
    ) -> Result<(), AssemblyError> {
        task.compute((self, constants), set, entities, deliver)
    }

    fn compute_moving(
        &self,
        task: &ElementVectors<D>,
        constants: &LinearConstants,
        set: InstructionSet,
        moving: (PointMotion, Range<usize>),
        deliver: Deliver,
    ) -> Result<(), AssemblyError> {
        if moving.0 == PointMotion::OfRecords && !K::MOVED_BY_LEVEL_SET {
            return Err(AssemblyError::NoLevelSetDerivative { form: task.binding.name });
        }
        // Kernels whose points nothing moves are not compiled once more.
        if const { K::MOVED_BY_LEVEL_SET || K::SLIDES } {
            return task.compute_moving((self, constants), set, moving, deliver);
        }
        Ok(())
    }
}

trait MatrixCalls<const D: usize>: Send + Sync {
    fn compute(
        &self,
        task: &ElementMatrices<D>,
        constants: &BilinearConstants,
        set: InstructionSet,
        entities: Range<usize>,
        deliver: Deliver,
    ) -> Result<(), AssemblyError>;
}

impl<K: BilinearKernel<D>, const D: usize> MatrixCalls<D> for K {
    fn compute(
        &self,
        task: &ElementMatrices<D>,
        constants: &BilinearConstants,
        set: InstructionSet,
        entities: Range<usize>,
        deliver: Deliver,
    ) -> Result<(), AssemblyError> {
        task.compute((self, constants), set, entities, deliver)
    }
}

trait PointCalls<const D: usize>: Send + Sync {
    fn compute(
        &self,
        task: &PointValues<D>,
        set: InstructionSet,
        buffers: &mut PointBuffers,
        entities: Range<usize>,
        receive: &mut ReceivePoint<D>,
    ) -> Result<(), AssemblyError>;
}

impl<K: ExpressionKernel<D>, const D: usize> PointCalls<D> for K {
    fn compute(
        &self,
        task: &PointValues<D>,
        set: InstructionSet,
        buffers: &mut PointBuffers,
        entities: Range<usize>,
        receive: &mut ReceivePoint<D>,
    ) -> Result<(), AssemblyError> {
        task.compute(self, set, buffers, entities, receive)
    }
}

//! Kernels behind virtual calls: one call runs a kernel over the entities of a range, and inside of it the kernel's type is known.
//!
//! A program compiles the loops of `element_loops` once, and of each of its forms only what is below these calls.

use std::ops::Range;
use std::sync::Arc;

use forms_core::contract::{
    Backend, BilinearConstants, BilinearKernel, ExpressionConstants, ExpressionKernel, LinearConstants,
    LinearKernel,
};

use super::AssemblyError;
use super::batch::Batch;
use super::element_loops::matrices::ElementMatrices;
use super::element_loops::sink::Deliver;
use super::element_loops::vectors::ElementVectors;
use super::functional::{ReceivePoint, each_point};
use crate::lanes::InstructionSet;

/// This backend: kernels run in the lanes of the machine's instruction set.
#[derive(Clone, Copy, Debug)]
pub struct Lanes;

impl<const D: usize> Backend<D> for Lanes {
    type Linear = VectorKernel<D>;
    type Bilinear = MatrixKernel<D>;
    type Expression = PointKernel<D>;

    fn linear<K: LinearKernel<D>>(kernel: K) -> VectorKernel<D> {
        VectorKernel(Arc::new(kernel))
    }

    fn bilinear<K: BilinearKernel<D>>(kernel: K) -> MatrixKernel<D> {
        MatrixKernel(Arc::new(kernel))
    }

    fn expression<K: ExpressionKernel<D>>(kernel: K) -> PointKernel<D> {
        PointKernel(Arc::new(kernel))
    }
}

/// The kernel of an integral that is linear in a test function.
#[derive(Clone)]
pub struct VectorKernel<const D: usize>(Arc<dyn VectorCalls<D>>);

/// The kernel of an integral that is linear in a test and in a trial function.
#[derive(Clone)]
pub struct MatrixKernel<const D: usize>(Arc<dyn MatrixCalls<D>>);

/// The kernel of a density, a derived field, or switches.
#[derive(Clone)]
pub struct PointKernel<const D: usize>(Arc<dyn PointCalls<D>>);

impl<const D: usize> VectorKernel<D> {
    /// Constants of the kernel.
    pub fn constants(&self) -> LinearConstants {
        self.0.constants()
    }

    /// See [`ElementVectors::compute`].
    pub(in crate::assemble) fn compute(
        &self,
        task: &ElementVectors<D>,
        set: InstructionSet,
        entities: Range<usize>,
        deliver: Deliver,
    ) -> Result<(), AssemblyError> {
        self.0.compute(task, set, entities, deliver)
    }
}

impl<const D: usize> MatrixKernel<D> {
    /// Constants of the kernel.
    pub fn constants(&self) -> BilinearConstants {
        self.0.constants()
    }

    /// See [`ElementMatrices::compute`].
    pub(in crate::assemble) fn compute(
        &self,
        task: &ElementMatrices<D>,
        set: InstructionSet,
        entities: Range<usize>,
        deliver: Deliver,
    ) -> Result<(), AssemblyError> {
        self.0.compute(task, set, entities, deliver)
    }
}

impl<const D: usize> PointKernel<D> {
    /// Constants of the kernel.
    pub fn constants(&self) -> ExpressionConstants {
        self.0.constants()
    }

    /// See [`each_point`].
    pub(in crate::assemble) fn each_point(
        &self,
        batch: &mut Batch<f64, D>,
        points: usize,
        entities: Range<usize>,
        receive: &mut ReceivePoint<D>,
    ) -> Result<(), AssemblyError> {
        self.0.each_point(batch, points, entities, receive)
    }
}

trait VectorCalls<const D: usize>: Send + Sync {
    fn constants(&self) -> LinearConstants;
    fn compute(
        &self,
        task: &ElementVectors<D>,
        set: InstructionSet,
        entities: Range<usize>,
        deliver: Deliver,
    ) -> Result<(), AssemblyError>;
}

impl<K: LinearKernel<D>, const D: usize> VectorCalls<D> for K {
    fn constants(&self) -> LinearConstants {
        LinearConstants::of::<K, D>()
    }

    fn compute(
        &self,
        task: &ElementVectors<D>,
        set: InstructionSet,
        entities: Range<usize>,
        deliver: Deliver,
    ) -> Result<(), AssemblyError> {
        task.compute(self, set, entities, deliver)
    }
}

trait MatrixCalls<const D: usize>: Send + Sync {
    fn constants(&self) -> BilinearConstants;
    fn compute(
        &self,
        task: &ElementMatrices<D>,
        set: InstructionSet,
        entities: Range<usize>,
        deliver: Deliver,
    ) -> Result<(), AssemblyError>;
}

impl<K: BilinearKernel<D>, const D: usize> MatrixCalls<D> for K {
    fn constants(&self) -> BilinearConstants {
        BilinearConstants::of::<K, D>()
    }

    fn compute(
        &self,
        task: &ElementMatrices<D>,
        set: InstructionSet,
        entities: Range<usize>,
        deliver: Deliver,
    ) -> Result<(), AssemblyError> {
        task.compute(self, set, entities, deliver)
    }
}

trait PointCalls<const D: usize>: Send + Sync {
    fn constants(&self) -> ExpressionConstants;
    fn each_point(
        &self,
        batch: &mut Batch<f64, D>,
        points: usize,
        entities: Range<usize>,
        receive: &mut ReceivePoint<D>,
    ) -> Result<(), AssemblyError>;
}

impl<K: ExpressionKernel<D>, const D: usize> PointCalls<D> for K {
    fn constants(&self) -> ExpressionConstants {
        ExpressionConstants::of::<K, D>()
    }

    fn each_point(
        &self,
        batch: &mut Batch<f64, D>,
        points: usize,
        entities: Range<usize>,
        receive: &mut ReceivePoint<D>,
    ) -> Result<(), AssemblyError> {
        each_point(batch, points, entities, self, receive)
    }
}

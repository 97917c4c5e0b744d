//! Kernels behind virtual calls: one call runs a kernel over the entities of a range, and inside of it the types of the kernel and of its
//! lanes are known.
//!
//! A program compiles the loops of `element_loops` once, and of each of its forms only what is below these calls.

use std::any::Any;
use std::ops::Range;
use std::sync::Arc;

use forms_core::contract::{
    Adaptation, Backend, BilinearConstants, BilinearKernel, CombiningBackend, ExpressionConstants,
    ExpressionKernel, LinearConstants, LinearKernel, Requirements,
};

use super::AssemblyError;
use super::binding::Binding;
use super::element_loops::matrices::{self, ElementMatrices, block_order};
use super::element_loops::moving_points::{self, MovingVectors};
use super::element_loops::piece_slopes;
use super::element_loops::point_values::{self, ExpressionCalls, PointBuffers, PointValues, ReceivePoint};
use super::element_loops::second_motion::{self, Twice};
use super::element_loops::sink::{Buffered, Deliver, Sink};
use super::element_loops::vectors::{self, ElementVectors};
use super::element_loops::{BilinearCalls, Factors, LinearCalls, MovingCalls};
use super::groups::Group;
use crate::lanes::{Both, Checked, Moving, Order, SimdLane, SimdSlope, with_lanes};

/// This backend: kernels run in the lanes of the machine's instruction set.
#[derive(Clone, Copy, Debug)]
pub struct Lanes;

impl<const D: usize> Backend<D> for Lanes {
    type Linear = VectorKernel<D>;
    type Bilinear = MatrixKernel<D>;
    type Expression = PointKernel<D>;

    fn linear<K: LinearKernel<D>>(kernel: K) -> VectorKernel<D> {
        let constants = LinearConstants::of::<K, D>();
        VectorKernel { kernel: Arc::new(kernel), constants, factor: 1.0 }
    }

    fn bilinear<K: BilinearKernel<D>>(kernel: K) -> MatrixKernel<D> {
        let constants = BilinearConstants::of::<K, D>();
        MatrixKernel { kernel: Arc::new(kernel), constants, factor: 1.0 }
    }

    fn expression<K: ExpressionKernel<D>>(kernel: K) -> PointKernel<D> {
        let constants = ExpressionConstants::of::<K, D>();
        PointKernel { kernel: Arc::new(kernel), constants, factor: 1.0 }
    }
}

impl<const D: usize> CombiningBackend<D> for Lanes {
    fn adapt_linear(kernel: &VectorKernel<D>, adaptation: Adaptation) -> VectorKernel<D> {
        let VectorKernel { kernel, constants, factor } = kernel.clone();
        let constants =
            LinearConstants { requirements: adaptation.requirements(constants.requirements), ..constants };
        VectorKernel { kernel, constants, factor: adaptation.factor() * factor }
    }

    fn adapt_bilinear(kernel: &MatrixKernel<D>, adaptation: Adaptation) -> MatrixKernel<D> {
        let MatrixKernel { kernel, constants, factor } = kernel.clone();
        let constants =
            BilinearConstants { requirements: adaptation.requirements(constants.requirements), ..constants };
        MatrixKernel { kernel, constants, factor: adaptation.factor() * factor }
    }

    fn adapt_expression(kernel: &PointKernel<D>, adaptation: Adaptation) -> PointKernel<D> {
        let PointKernel { kernel, constants, factor } = kernel.clone();
        let constants = ExpressionConstants {
            requirements: adaptation.requirements(constants.requirements),
            ..constants
        };
        PointKernel { kernel, constants, factor: adaptation.factor() * factor }
    }
}

/// The kernel of an integral that is linear in a test function, with a factor.
#[derive(Clone)]
pub struct VectorKernel<const D: usize> {
    kernel: Arc<dyn AnyLinearKernel<D>>,
    constants: LinearConstants,
    factor: f64,
}

/// The kernel of an integral that is linear in a test and in a trial function, with a factor.
#[derive(Clone)]
pub struct MatrixKernel<const D: usize> {
    kernel: Arc<dyn AnyBilinearKernel<D>>,
    constants: BilinearConstants,
    factor: f64,
}

/// The kernel of a density, a derived field, or switches, with a factor.
#[derive(Clone)]
pub struct PointKernel<const D: usize> {
    kernel: Arc<dyn AnyExpressionKernel<D>>,
    constants: ExpressionConstants,
    factor: f64,
}

impl<const D: usize> VectorKernel<D> {
    /// Constants of the kernel.
    pub fn constants(&self) -> LinearConstants {
        self.constants
    }

    /// The element vectors of some of the group's entities, handed over in their order: `deliver(first, vectors)` gets whole element
    /// vectors, that of entity `first` first, each as `[node][component]`.
    ///
    /// # Errors
    /// Errors of the form's data, or of `deliver`.
    pub(in crate::assemble) fn compute(
        &self,
        task: &ElementVectors<D>,
        entities: Range<usize>,
        deliver: Deliver,
    ) -> Result<(), AssemblyError> {
        self.kernel.compute(task, &self.constants, entities, &mut Buffered::new(self.factor, deliver))
    }

    /// The first and second derivatives of the energies of a group's units by their feet, handed over in the same way.
    ///
    /// # Errors
    /// Errors of the form's data, or of `deliver`.
    pub(in crate::assemble) fn compute_twice_moving(
        &self,
        task: &ElementVectors<D>,
        range: Range<usize>,
        deliver: Deliver,
    ) -> Result<(), AssemblyError> {
        let mut scaled = Vec::new();
        self.kernel.compute_twice_moving(task, &self.constants, range, &mut |first, values| {
            scaled.clear();
            scaled.extend(values.iter().map(|value| self.factor * value));
            deliver(first, &scaled)
        })
    }

    /// The slopes by all numbers of the points of a group of pieces, of the integral with a field in the place of the test function.
    ///
    /// # Errors
    /// Errors of the form's data, or of `deliver`; a module without derivatives by level set functions.
    pub(in crate::assemble) fn slopes_on_pieces(
        &self,
        task: &ElementVectors<D>,
        pieces: (&[f64], Range<usize>),
        deliver: Deliver,
    ) -> Result<(), AssemblyError> {
        self.kernel.slopes_on_pieces(task, &self.constants, pieces, deliver)
    }

    /// The factor by which its values are multiplied.
    pub(in crate::assemble) fn factor(&self) -> f64 {
        self.factor
    }
}

/// The derivatives of the element vectors of a group whose points move, one kernel per test function, handed over as [`VectorKernel::compute`] does; nothing
/// of kernels that do not slide.
///
/// # Errors
/// Errors of the form's data, or of `deliver`.
pub(in crate::assemble) fn compute_moving<const D: usize>(
    kernels: &[&VectorKernel<D>],
    task: &MovingVectors<D>,
    range: Range<usize>,
    deliver: Deliver,
) -> Result<(), AssemblyError> {
    with_lanes!(task.binding.instructions.checked(), L => match D {
        2 => moving_in_lanes::<L, L, D>(kernels, task, range, deliver),
        _ => moving_in_lanes::<L, Both<L>, D>(kernels, task, range, deliver),
    })
}

fn moving_in_lanes<L: SimdLane, S: SimdSlope<L>, const D: usize>(
    kernels: &[&VectorKernel<D>],
    task: &MovingVectors<D>,
    range: Range<usize>,
    deliver: Deliver,
) -> Result<(), AssemblyError> {
    let set = task.binding.instructions.checked();
    let calls_of = |kernel: &&VectorKernel<D>| {
        let calls = Arc::clone(&kernel.kernel).moving_calls(set)?;
        calls.downcast::<MovingCalls<L, S, D>>().ok().map(|calls| *calls)
    };
    let Some(mut calls) = kernels.iter().map(calls_of).collect::<Option<Vec<_>>>() else { return Ok(()) };
    L::call(moving_points::Loops { task, calls: &mut calls, range, deliver })
}

impl<const D: usize> MatrixKernel<D> {
    /// Constants of the kernel.
    pub fn constants(&self) -> BilinearConstants {
        self.constants
    }

    /// The element matrices of some of the group's entities, handed over in their order: `deliver(first, matrices)` gets whole element
    /// matrices, that of entity `first` first, each as `[test node][trial node][row component][column component]`.
    ///
    /// # Errors
    /// Errors of the form's data, or of `deliver`.
    pub(in crate::assemble) fn compute(
        &self,
        task: &ElementMatrices<D>,
        entities: Range<usize>,
        deliver: Deliver,
    ) -> Result<(), AssemblyError> {
        let places = block_order(task.nodes(), self.constants.components, task.symmetric);
        let order = Order::new(places, task.binding.instructions.checked().width());
        let sink = &mut Buffered::new(self.factor, deliver);
        self.kernel.compute(task, &self.constants, &order, entities, sink)
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

    /// The values at every quadrature point of some of the group's entities: `receive(value, weight, position)` is called with each in turn.
    ///
    /// # Errors
    /// Errors of the form's data, or of `receive`.
    pub(in crate::assemble) fn each_point(
        &self,
        task: &PointValues<D>,
        buffers: &mut PointBuffers,
        entities: Range<usize>,
        receive: &mut ReceivePoint<D>,
    ) -> Result<(), AssemblyError> {
        let factor = self.factor;
        if factor == 1.0 {
            return self.kernel.compute(task, buffers, entities, receive);
        }
        let mut scaled = Vec::new();
        self.kernel.compute(task, buffers, entities, &mut |value, weight, position| {
            scaled.clear();
            scaled.extend(value.iter().map(|value| factor * value));
            receive(&scaled, weight, position)
        })
    }
}

/// A kernel that is linear in a test function, of any type.
trait AnyLinearKernel<const D: usize>: Send + Sync {
    fn compute(
        &self,
        task: &ElementVectors<D>,
        constants: &LinearConstants,
        range: Range<usize>,
        sink: &mut dyn Sink,
    ) -> Result<(), AssemblyError>;

    /// Its calls as [`MovingCalls`] of a set's lanes, along each coordinate of a facet. None of kernels whose points nothing moves: they are not
    /// compiled once more.
    fn moving_calls(self: Arc<Self>, set: Checked) -> Option<Box<dyn Any>>;

    fn compute_twice_moving(
        &self,
        task: &ElementVectors<D>,
        constants: &LinearConstants,
        range: Range<usize>,
        deliver: Deliver,
    ) -> Result<(), AssemblyError>;

    fn slopes_on_pieces(
        &self,
        task: &ElementVectors<D>,
        constants: &LinearConstants,
        pieces: (&[f64], Range<usize>),
        deliver: Deliver,
    ) -> Result<(), AssemblyError>;
}

impl<K: LinearKernel<D>, const D: usize> AnyLinearKernel<D> for K {
    fn compute(
        &self,
        task: &ElementVectors<D>,
        kernel: &LinearConstants,
        range: Range<usize>,
        sink: &mut dyn Sink,
    ) -> Result<(), AssemblyError> {
        with_lanes!(task.binding.instructions.checked(), L => {
            let calls = &mut LinearCalls::<&K, L, D>::new(self);
            L::call(vectors::Loops { task, kernel, calls, order: None, range, buffers: None, sink })
        })
    }

    fn moving_calls(self: Arc<Self>, set: Checked) -> Option<Box<dyn Any>> {
        if const { K::SLIDES && D == 2 } {
            return with_lanes!(set, L => {
                let calls = Box::new(LinearCalls::<Arc<K>, Moving<L>, D>::new(self));
                Some(Box::new(MovingCalls::<L, L, D>(calls)))
            });
        }
        if const { K::SLIDES && D != 2 } {
            return with_lanes!(set, L => {
                let calls = Box::new(LinearCalls::<Arc<K>, Moving<L, Both<L>>, D>::new(self));
                Some(Box::new(MovingCalls::<L, Both<L>, D>(calls)))
            });
        }
        None
    }

    fn compute_twice_moving(
        &self,
        task: &ElementVectors<D>,
        kernel: &LinearConstants,
        range: Range<usize>,
        deliver: Deliver,
    ) -> Result<(), AssemblyError> {
        if const { K::OF_ENERGY } {
            return with_lanes!(task.binding.instructions.checked(), L => {
                let calls = &mut LinearCalls::<&K, Twice<L>, D>::new(self);
                L::call(second_motion::Loops { task, kernel, calls, range, deliver })
            });
        }
        Ok(())
    }

    fn slopes_on_pieces(
        &self,
        task: &ElementVectors<D>,
        kernel: &LinearConstants,
        (tests, range): (&[f64], Range<usize>),
        deliver: Deliver,
    ) -> Result<(), AssemblyError> {
        if const { K::MOVED_BY_LEVEL_SET } {
            return with_lanes!(task.binding.instructions.checked(), L => {
                let calls = &mut LinearCalls::<&K, Moving<L>, D>::new(self);
                L::call(piece_slopes::Loops { task, kernel, calls, tests, range, deliver })
            });
        }
        Err(AssemblyError::NoLevelSetDerivative { form: task.binding.name })
    }
}

/// A kernel that is linear in a test and in a trial function, of any type.
trait AnyBilinearKernel<const D: usize>: Send + Sync {
    fn compute(
        &self,
        task: &ElementMatrices<D>,
        constants: &BilinearConstants,
        order: &Order,
        range: Range<usize>,
        sink: &mut dyn Sink,
    ) -> Result<(), AssemblyError>;
}

impl<K: BilinearKernel<D>, const D: usize> AnyBilinearKernel<D> for K {
    fn compute(
        &self,
        task: &ElementMatrices<D>,
        kernel: &BilinearConstants,
        order: &Order,
        range: Range<usize>,
        sink: &mut dyn Sink,
    ) -> Result<(), AssemblyError> {
        with_lanes!(task.binding.instructions.checked(), L => {
            let mut factors = Factors::default();
            let calls = &mut BilinearCalls::<K, L, D>::new(self, &mut factors);
            L::call(matrices::Loops { task, kernel, calls, order, range, buffers: None, sink })
        })
    }
}

/// A kernel of values at points, of any type.
trait AnyExpressionKernel<const D: usize>: Send + Sync {
    fn compute(
        &self,
        task: &PointValues<D>,
        buffers: &mut PointBuffers,
        range: Range<usize>,
        receive: &mut ReceivePoint<D>,
    ) -> Result<(), AssemblyError>;
}

impl<K: ExpressionKernel<D>, const D: usize> AnyExpressionKernel<D> for K {
    fn compute(
        &self,
        task: &PointValues<D>,
        buffers: &mut PointBuffers,
        range: Range<usize>,
        receive: &mut ReceivePoint<D>,
    ) -> Result<(), AssemblyError> {
        with_lanes!(task.binding.instructions.checked(), L => {
            let calls = &mut ExpressionCalls::<K, L, D>::new(self);
            L::call(point_values::Loops { task, calls, buffers, range, receive })
        })
    }
}

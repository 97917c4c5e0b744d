//! Element matrices of a bilinear integral on cells, facets and pairs: the loops over batches, points and pairs of basis functions,
//! where the integral's kernel is called. Strategies for many basis functions stand in `reference_tensor` and `sum_factorisation`,
//! loops of lengths that are known in `fixed`.

// Closures and iterator adaptors do not inherit a caller's target features, and copies of slices may become calls:
// loops over lane values are plain.
#![allow(clippy::needless_range_loop, clippy::manual_memcpy)]

use std::ops::Range;

use forms_core::contract::{Basis, BilinearKernel};

use super::NodePairs;
use crate::assemble::AssemblyError;
use crate::assemble::batch::{ArgumentBasis, Batch, BatchBuffers, Cells};
use crate::assemble::binding::Binding;
use crate::assemble::kernel_calls::reference_tensor::{ReferenceTensor, contract, suits};
use crate::assemble::kernel_calls::sink::{Buffered, Deliver, Sink};
use crate::assemble::kernel_calls::sum_factorisation::{
    Derivatives, MatrixStages, PairSums, ProductTables, matrix_operations, unit,
};
use crate::assemble::scatter::group_nodes::Reading;
use crate::assemble::walk::Group;
use crate::lanes::{InstructionSet, LaneWork, Order, Ordered, SimdLane, Transposition};

/// Inputs of the element matrices of a group, besides the kernel.
pub(in crate::assemble) struct ElementMatrices<'a, const D: usize> {
    pub binding: &'a Binding<'a, D>,
    pub group: &'a Group<D>,
    /// The source of the cells' nodes.
    pub cells: Cells<'a, D>,
    /// The sides on which test and trial functions live.
    pub sides: [usize; 2],
    /// Their elements, by index into the binding's.
    pub elements: [usize; 2],
    /// Places of the nodes whose functions are seen, where not all are.
    pub seen: [Option<Vec<usize>>; 2],
    /// Only pairs of nodes i ≤ j are computed, and mirrored.
    pub symmetric: bool,
}

/// Memory of the loops, kept from one run to the next.
pub(in crate::assemble) struct MatrixBuffers<K: BilinearKernel<D>, L: SimdLane, const D: usize> {
    batch: BatchBuffers<L, D>,
    /// Factors of test node i at point q, at `i * points + q`.
    tests: Vec<K::Test<L>>,
    trials: Vec<K::Trial<L>>,
    /// Blocks of the pairs (i, j), at `(i * columns + j) * entries`; of symmetric ones only i ≤ j.
    blocks: Vec<L>,
    /// Blocks of pairs of directions, of a reference tensor.
    directions: Vec<L>,
    stages: MatrixStages<L>,
    /// The reference tensor, once it is known whether there is one.
    tensor: Option<Option<ReferenceTensor>>,
}

impl<K: BilinearKernel<D>, L: SimdLane, const D: usize> Default for MatrixBuffers<K, L, D> {
    fn default() -> Self {
        MatrixBuffers {
            batch: BatchBuffers::default(),
            tests: vec![],
            trials: vec![],
            blocks: vec![],
            directions: vec![],
            stages: MatrixStages::default(),
            tensor: None,
        }
    }
}

impl<const D: usize> ElementMatrices<'_, D> {
    /// Number of test and of trial nodes.
    #[inline]
    pub fn nodes(&self) -> [usize; 2] {
        let nodes = |k: usize| match &self.seen[k] {
            Some(places) => places.len(),
            None => self.group.sides[self.sides[k]].elements[self.elements[k]].nodes,
        };
        [nodes(0), nodes(1)]
    }

    /// The place of a test (0) or trial (1) node among those of its element.
    #[inline(always)]
    fn place(&self, argument: usize, node: usize) -> usize {
        match &self.seen[argument] {
            Some(places) => places[node],
            None => node,
        }
    }

    /// Computes the element matrices of the group's entities in a range, and hands them over in their order:
    /// `deliver(first, matrices)` gets whole element matrices, that of entity `first` first, each as
    /// `[test node][trial node][row component][column component]`.
    ///
    /// # Errors
    /// Errors of the form's data, or of `deliver`.
    pub fn compute<K: BilinearKernel<D>>(
        &self,
        kernel: &K,
        set: InstructionSet,
        range: Range<usize>,
        deliver: Deliver,
    ) -> Result<(), AssemblyError> {
        let [rows, columns] = self.nodes();
        let components = [K::TEST_COMPONENTS, K::TRIAL_COMPONENTS];
        let order = block_order([rows, columns], components, self.symmetric);
        set.checked().run(Compute { task: self, kernel, order: &order, range, sink: Buffered::new(deliver) })
    }

    /// The factors of all test and trial functions at all points, function by function; where sums go along the axes,
    /// of the functions whose value, or whose derivative along one axis of the reference cell, is one.
    #[inline(always)]
    fn factors<K: BilinearKernel<D>, L: SimdLane>(
        &self,
        kernel: &K,
        cell: &K::Cell<L>,
        batch: &mut Batch<L, D>,
        factorised: Option<&ProductTables>,
        tests: &mut Vec<K::Test<L>>,
        trials: &mut Vec<K::Trial<L>>,
    ) -> Result<(), AssemblyError> {
        let zero = L::splat(0.0);
        let derivatives = Derivatives::of_arguments(&K::REQUIREMENTS);
        let asked = derivatives.count::<D>();
        let [rows, columns] = if factorised.is_some() { [asked; 2] } else { self.nodes() };
        let points = self.group.points();
        let none = &[[[zero; D]; D]; 4][..asked];
        let (test, trial) = K::zero_factors::<L>();
        tests.resize(rows * points, test);
        trials.resize(columns * points, trial);
        let (tests, trials) = (&mut tests[..], &mut trials[..]);
        for q in 0..points {
            batch.point(q)?;
            let geometry = batch.geometry();
            let point = kernel.point(cell, geometry, batch.fields());
            let mut units = [Basis { value: zero, gradient: [zero; D] }; 4];
            let (mut basis, mut hessians);
            if factorised.is_some() {
                for k in 0..asked {
                    units[k] = unit(batch.inverse(), derivatives.kind(k));
                }
                (basis, hessians) = (&units[..asked], none);
            } else {
                basis = batch.basis(self.sides[0], self.elements[0]);
                hessians = batch.hessians(self.sides[0], self.elements[0]);
            }
            for i in 0..rows {
                let place = self.place(0, i);
                tests[i * points + q] = kernel.test(&point, &basis[place], &hessians[place]);
            }
            if factorised.is_none() {
                basis = batch.basis(self.sides[1], self.elements[1]);
                hessians = batch.hessians(self.sides[1], self.elements[1]);
            }
            for j in 0..columns {
                let place = self.place(1, j);
                trials[j * points + q] = kernel.trial(&point, &basis[place], &hessians[place]);
            }
        }
        Ok(())
    }

    /// The entries of all pairs, from those of the functions asked for at each point, axis by axis.
    #[inline(always)]
    fn sum_along_axes<K: BilinearKernel<D>, L: SimdLane>(
        &self,
        factors: &NodePairs<K, L, D>,
        tables: &ProductTables,
        stages: &mut MatrixStages<L>,
        blocks: &mut [L],
    ) {
        let (symmetric, derivatives) = (self.symmetric, Derivatives::of_arguments(&K::REQUIREMENTS));
        stages.prepare::<D>(tables, symmetric);
        let &NodePairs { kernel, cell, tests, trials, points, .. } = factors;
        let asked = derivatives.count::<D>();
        for s in 0..asked {
            for t in 0..asked {
                let target = stages.coefficients::<D>([derivatives.kind(s), derivatives.kind(t)]);
                for q in 0..points {
                    let mut sum = K::zero::<L>();
                    K::pair(&mut sum, &tests[s * points + q], &trials[t * points + q]);
                    target[tables.place_of[q] as usize] = kernel.finish(cell, &sum).as_ref()[0];
                }
            }
        }
        L::call(PairSums::<L, D> { tables, derivatives, symmetric, stages, blocks });
    }

    /// The loops. The entries of an element matrix come out in the order that [`block_order`] gives to
    /// the computed blocks, or any other.
    #[inline(always)]
    pub fn compute_in_lanes<K: BilinearKernel<D>, L: SimdLane>(
        &self,
        kernel: &K,
        order: &Order,
        range: Range<usize>,
        buffers: &mut MatrixBuffers<K, L, D>,
        sink: &mut impl Sink,
    ) -> Result<(), AssemblyError> {
        let [rows, columns] = self.nodes();
        let MatrixBuffers { batch, tests, trials, blocks, directions, stages, tensor } = buffers;
        if tensor.is_none() && !range.is_empty() {
            let side = &self.group.sides[self.sides[0]];
            let weights = &self.group.weights;
            *tensor = Some(ReferenceTensor::for_kernel::<K, D>(side, self.elements, weights, self.symmetric));
        }
        let tensor = tensor.as_ref().and_then(Option::as_ref);
        let factorised = self.factorised::<K>();
        let reading = Reading::of_arguments(&K::REQUIREMENTS);
        let basis =
            |k: usize| ArgumentBasis { side: self.sides[k], element: self.elements[k], reading: reading[k] };
        let both = [basis(0), basis(1)];
        let arguments: &[ArgumentBasis] = if factorised.is_some() { &[] } else { &both };
        let mut batch =
            Batch::<L, D>::new(self.binding, self.group, self.cells, K::REQUIREMENTS, arguments, batch)?;
        let entries = K::TEST_COMPONENTS * K::TRIAL_COMPONENTS;
        let size = rows * columns * entries;
        let mut start = range.start;
        while start < range.end {
            let filled = L::WIDTH.min(range.end - start);
            let cell = kernel.cell(&batch.load(start, filled));
            blocks.resize(size, L::splat(0.0));
            match (tensor, factorised) {
                (Some(tensor), _) if const { suits::<K, D>() } => {
                    let (determinant, inverse) = batch.affine_map(self.sides[0]);
                    let blocks = &mut blocks[..];
                    contract::<K, L, _, D>(kernel, &cell, tensor, determinant, &inverse, directions, blocks);
                }
                _ => {
                    self.factors::<K, L>(kernel, &cell, &mut batch, factorised, tests, trials)?;
                    let (nodes, points, symmetric) = ([rows, columns], self.group.points(), self.symmetric);
                    let pairs = NodePairs { kernel, cell: &cell, tests, trials, nodes, points, symmetric };
                    match factorised {
                        Some(tables) if const { scalar::<K, D>() } => {
                            self.sum_along_axes(&pairs, tables, stages, blocks);
                        }
                        _ => pairs.sum(&mut blocks[..]),
                    }
                }
            }
            let source = Ordered::new(blocks, order, size);
            let target = sink.room(start, filled, size);
            L::call(Transposition { source, filled, target, stride: size });
            sink.filled(start, filled, size)?;
            start += filled;
        }
        batch.check_weights(range)
    }

    /// The tables, if sums go along the axes.
    fn factorised<K: BilinearKernel<D>>(&self) -> Option<&ProductTables> {
        let suited = self.elements[0] == self.elements[1] && self.sides == [0, 0];
        let tables = self.group.sides[0].products[self.elements[0]].as_ref().filter(|_| suited)?;
        along_axes::<K, D>(tables, self.symmetric).then_some(tables)
    }
}

/// Cost of an operation along an axis, in operations on a pair of nodes, whose sums stay in registers: its sums
/// are as short as a row of points, and go through memory from axis to axis (docs/decisions/lanes.md).
const ALONG_AN_AXIS: usize = 2;

/// Whether sum factorisation takes less than sums over the points for each pair. Of vector forms it does
/// not: each of the D² entries of a block would need sums of its own for each pair of derivatives.
pub(in crate::assemble) fn along_axes<K: BilinearKernel<D>, const D: usize>(
    tables: &ProductTables,
    symmetric: bool,
) -> bool {
    let requirements = &K::REQUIREMENTS;
    if !const { scalar::<K, D>() } || requirements.hessian {
        return false;
    }
    let count = K::OPERATIONS;
    let (nodes, points) = (tables.node_at.len(), tables.place_of.len());
    let pairs = if symmetric { nodes * (nodes + 1) / 2 } else { nodes * nodes };
    let derivatives = Derivatives::of_arguments(requirements);
    let transformed = if derivatives.gradient { D * D } else { 0 };
    let direct = points * (nodes * (count.test + count.trial + transformed) + pairs * count.pair)
        + pairs * count.finish;
    let asked = derivatives.count::<D>();
    let at_point = asked * (count.test + count.trial) + asked * asked * (count.pair + count.finish);
    points * at_point + ALONG_AN_AXIS * matrix_operations::<D>(tables, derivatives, symmetric) < direct
}

/// Whether a block is a number.
pub(in crate::assemble) const fn scalar<K: BilinearKernel<D>, const D: usize>() -> bool {
    K::TEST_COMPONENTS * K::TRIAL_COMPONENTS == 1
}

struct Compute<'a, 'd, K, const D: usize> {
    task: &'a ElementMatrices<'a, D>,
    kernel: &'a K,
    order: &'a Order,
    range: Range<usize>,
    sink: Buffered<'d>,
}

impl<K: BilinearKernel<D>, const D: usize> LaneWork for Compute<'_, '_, K, D> {
    type Output = Result<(), AssemblyError>;

    #[inline(always)]
    fn run<L: SimdLane>(mut self) -> Self::Output {
        let mut buffers = MatrixBuffers::<K, L, D>::default();
        let (task, sink) = (self.task, &mut self.sink);
        task.compute_in_lanes::<K, L>(self.kernel, self.order, self.range, &mut buffers, sink)
    }
}

/// Places in the computed blocks of an element matrix's entries, for the entries block after block. Of a
/// symmetric matrix only the blocks of pairs i ≤ j are computed.
pub(in crate::assemble) fn block_order(
    [rows, columns]: [usize; 2],
    [height, width]: [usize; 2],
    symmetric: bool,
) -> Order {
    let entries = height * width;
    let mut computed = vec![0_u32; rows * columns];
    let mut next = 0;
    for i in 0..rows {
        for j in 0..columns {
            if !symmetric || j >= i {
                computed[i * columns + j] = next;
                next += entries as u32;
            }
        }
    }
    let mut order = Vec::with_capacity(rows * columns * entries);
    for i in 0..rows {
        for j in 0..columns {
            for a in 0..height {
                for b in 0..width {
                    order.push(if symmetric && j < i {
                        computed[j * columns + i] + (b * width + a) as u32
                    } else {
                        computed[i * columns + j] + (a * width + b) as u32
                    });
                }
            }
        }
    }
    Order::new(order)
}

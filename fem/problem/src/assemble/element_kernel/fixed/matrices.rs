//! Element matrices with loops of known lengths.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lane values are plain.
#![allow(clippy::needless_range_loop)]

use forms_core::contract::{Basis, BilinearKernel};

use super::batch::FixedBatch;
use super::fields::FieldBuffers;
use super::{Call, FixedIntegral, FixedTables, store};
use crate::assemble::element_kernel::ElementCells;
use crate::assemble::element_kernel::sizes::{Array, Sizes};
use crate::assemble::kernel_calls::reference_tensor::{ReferenceTensor, contract, suits};
use crate::assemble::kernel_calls::{BilinearConstants, NodePairs};
use crate::assemble::walk::Group;
use crate::lanes::{LaneWork, Order, Ordered, SharedWork, SimdLane};

/// Makes an integral of a tangent ready for a lane type.
pub(in crate::assemble) struct PrepareMatrices<'a, K, S: Sizes, const D: usize> {
    pub kernel: &'a K,
    pub group: &'a Group<D>,
    pub tables: FixedTables<S, D>,
    /// Places in the computed blocks of a matrix's entries.
    pub order: &'a Order,
}

/// An integral of a tangent.
struct Matrices<K: BilinearKernel<D>, L: SimdLane, S: Sizes, const D: usize> {
    kernel: K,
    tables: FixedTables<S, D>,
    order: Order,
    tensor: Option<ReferenceTensor>,
    buffers: Buffers<K, L, D>,
}

struct Buffers<K: BilinearKernel<D>, L: SimdLane, const D: usize> {
    fields: FieldBuffers<L>,
    /// Factors of node i at point q, at `i * points + q`.
    tests: Vec<K::Test<L>>,
    trials: Vec<K::Trial<L>>,
    blocks: Vec<L>,
    directions: Vec<L>,
}

/// Numbers of nodes and points, of entries of a block, and of blocks that are computed.
const fn lengths<K: BilinearKernel<D>, S: Sizes, const D: usize>() -> [usize; 4] {
    let nodes = <S::Nodes<f64> as Array<f64>>::LENGTH;
    let pairs = if K::SYMMETRIC { nodes * (nodes + 1) / 2 } else { nodes * nodes };
    [nodes, <S::Points<f64> as Array<f64>>::LENGTH, K::TEST_COMPONENTS * K::TRIAL_COMPONENTS, pairs]
}

/// Possibility of a reference tensor. Linear functions at one point need none: it would copy the blocks of their gradients.
const fn has_tensor<K: BilinearKernel<D>, S: Sizes, const D: usize>() -> bool {
    let one_point = <S::Points<f64> as Array<f64>>::LENGTH == 1;
    suits::<K, D>() && !(FixedTables::<S, D>::LINEAR && one_point)
}

impl<K: BilinearKernel<D>, S: Sizes, const D: usize> LaneWork for PrepareMatrices<'_, K, S, D> {
    type Output = Box<dyn FixedIntegral>;

    #[inline(always)]
    fn run<L: SimdLane>(self) -> Self::Output {
        let PrepareMatrices { kernel, group, tables, order } = self;
        let [nodes, points, entries, pairs] = const { lengths::<K, S, D>() };
        let (test, trial) = K::zero_factors::<L>();
        let blocks = vec![L::splat(0.0); pairs * entries];
        let tensor = if const { has_tensor::<K, S, D>() } {
            let kernel = const { &BilinearConstants::of::<K, D>() };
            ReferenceTensor::new(kernel, &group.sides[0], [0, 0], &group.weights, K::SYMMETRIC)
        } else {
            None
        };
        let buffers = Buffers {
            fields: FieldBuffers::new(&K::REQUIREMENTS, &tables),
            tests: vec![test; nodes * points],
            trials: vec![trial; nodes * points],
            blocks,
            directions: vec![],
        };
        Box::new(Matrices::<K, L, S, D> {
            kernel: kernel.clone(),
            tables,
            order: order.clone(),
            tensor,
            buffers,
        })
    }
}

impl<K: BilinearKernel<D>, L: SimdLane, S: Sizes, const D: usize> FixedIntegral for Matrices<K, L, S, D> {
    fn run(&mut self, cells: &ElementCells, target: &mut [f64], add: bool) {
        L::call(Call { integral: self, cells, target, add });
    }
}

impl<K: BilinearKernel<D>, L: SimdLane, S: Sizes, const D: usize> SharedWork<L>
    for Call<'_, Matrices<K, L, S, D>>
{
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Call { integral, cells, target, add } = self;
        let [nodes, _, entries, _] = const { lengths::<K, S, D>() };
        let size = nodes * nodes * entries;
        let mut start = 0;
        while start < cells.count {
            let filled = L::WIDTH.min(cells.count - start);
            integral.blocks(cells, start, filled);
            let source = Ordered::new(&integral.buffers.blocks, &integral.order, size);
            store(source, size, filled, &mut target[start * size..][..filled * size], add);
            start += filled;
        }
    }
}

impl<K: BilinearKernel<D>, L: SimdLane, S: Sizes, const D: usize> Matrices<K, L, S, D> {
    /// The blocks of `filled` cells from `start` on.
    #[inline(always)]
    fn blocks(&mut self, cells: &ElementCells, start: usize, filled: usize) {
        let requirements = &K::REQUIREMENTS;
        let [nodes, points, entries, pairs] = const { lengths::<K, S, D>() };
        let Matrices { kernel, tables, tensor, buffers, .. } = self;
        let Buffers { fields, tests, trials, blocks, directions } = buffers;
        // Of a known length: where loops are unrolled nothing is checked per entry.
        let blocks = &mut blocks[..pairs * entries];
        let kernel = &*kernel;
        let batch = FixedBatch::<L, S, D>::load(requirements, tables, cells, start, filled, fields);
        let cell = kernel.cell(&batch.cell_geometry(requirements));
        if const { has_tensor::<K, S, D>() }
            && let Some(tensor) = tensor
        {
            let map = batch.map_at(0);
            contract::<K, L, D>(kernel, &cell, tensor, map.determinant, &map.inverse, directions, blocks);
            return;
        }
        let zero = L::splat(0.0);
        let hessian = [[zero; D]; D];
        let mut basis = S::Nodes::filled(Basis { value: zero, gradient: [zero; D] });
        if const { <S::Points<f64> as Array<f64>>::LENGTH == 1 } {
            let map = batch.map_at(0);
            let geometry = batch.point(requirements, 0, &map, fields);
            let point = kernel.point(&cell, &geometry, &fields.fields);
            batch.evaluate_basis(requirements, 0, &map, &mut basis);
            let basis = basis.entries();
            let (test, trial) = K::zero_factors::<L>();
            let (mut tests, mut trials) = (S::Nodes::filled(test), S::Nodes::filled(trial));
            for i in 0..nodes {
                tests.entries_mut()[i] = kernel.test(&point, &basis[i], &hessian);
                trials.entries_mut()[i] = kernel.trial(&point, &basis[i], &hessian);
            }
            let (tests, trials) = (tests.entries(), trials.entries());
            let symmetric = K::SYMMETRIC;
            NodePairs { kernel, cell: &cell, tests, trials, nodes: [nodes, nodes], points, symmetric }
                .sum(blocks);
            return;
        }
        let (tests, trials) = (&mut tests[..nodes * points], &mut trials[..nodes * points]);
        for q in 0..points {
            let map = batch.map_at(q);
            let geometry = batch.point(requirements, q, &map, fields);
            let point = kernel.point(&cell, &geometry, &fields.fields);
            batch.evaluate_basis(requirements, q, &map, &mut basis);
            let basis = basis.entries();
            for i in 0..nodes {
                tests[i * points + q] = kernel.test(&point, &basis[i], &hessian);
                trials[i * points + q] = kernel.trial(&point, &basis[i], &hessian);
            }
        }
        // The compiler is not to see the number of points: it would unroll, load all factors first, and spill them.
        let points = tables.points;
        let symmetric = K::SYMMETRIC;
        NodePairs { kernel, cell: &cell, tests, trials, nodes: [nodes, nodes], points, symmetric }
            .sum(blocks);
    }
}

//! Element matrices with loops of known lengths.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lane values are plain.
#![allow(clippy::needless_range_loop)]

use forms_core::contract::{Basis, BilinearKernel};

use super::batch::{FieldBuffers, FixedBatch};
use super::{FixedTask, put_out};
use crate::assemble::element_kernel::{Kept, recall};
use crate::assemble::pairs::Pairs;
use crate::assemble::reference_tensor::{LARGEST_BLOCK, ReferenceTensor, contract, suits};
use crate::assemble::sizes::{Array, Sizes};
use crate::lanes::{LaneWork, Order, Ordered, SimdLane};

/// Sums over more points are loops.
const UNROLLED_POINTS: usize = 4;

/// One run over the cells that the caller lists.
pub(in crate::assemble) struct FixedMatrices<'a, K, S: Sizes, const D: usize> {
    pub task: FixedTask<'a, K, S, D>,
    /// Where the computed blocks have the entries of a matrix.
    pub order: &'a Order,
    pub memory: &'a mut Kept,
    pub target: &'a mut [f64],
    /// Adds to what is there.
    pub add: bool,
}

struct Buffers<K: BilinearKernel<D>, L: SimdLane, const D: usize> {
    fields: FieldBuffers<L>,
    /// Factors of node i at point q, at `i * points + q`.
    tests: Vec<K::Test<L>>,
    trials: Vec<K::Trial<L>>,
    blocks: Vec<L>,
    directions: Vec<[L; LARGEST_BLOCK]>,
    tensor: Option<Option<ReferenceTensor>>,
}

impl<K: BilinearKernel<D>, L: SimdLane, const D: usize> Default for Buffers<K, L, D> {
    fn default() -> Self {
        let fields = FieldBuffers::default();
        Buffers { fields, tests: vec![], trials: vec![], blocks: vec![], directions: vec![], tensor: None }
    }
}

impl<K: BilinearKernel<D>, S: Sizes, const D: usize> LaneWork for FixedMatrices<'_, K, S, D> {
    type Output = ();

    #[inline(always)]
    fn run<L: SimdLane>(self) {
        let FixedTask { group, listed, .. } = self.task;
        let mut buffers = recall::<Buffers<K, L, D>>(self.memory);
        let nodes = <S::Nodes<f64> as Array<f64>>::LENGTH;
        let pairs = if K::SYMMETRIC { nodes * (nodes + 1) / 2 } else { nodes * nodes };
        let entries = K::TEST_COMPONENTS * K::TRIAL_COMPONENTS;
        let size = nodes * nodes * entries;
        if buffers.blocks.len() != pairs * entries {
            let tensor =
                ReferenceTensor::for_kernel::<K, D>(&group.sides[0], [0, 0], &group.weights, K::SYMMETRIC);
            buffers.tensor = Some(tensor);
            buffers.blocks.resize(pairs * entries, L::splat(0.0));
        }
        let mut start = 0;
        while start < listed.count {
            let filled = L::WIDTH.min(listed.count - start);
            self.task.blocks::<L>(start, filled, &mut buffers);
            let source = &Ordered::new(&buffers.blocks, self.order, size);
            let target = &mut self.target[start * size..][..filled * size];
            put_out(source, size, filled, target, self.add);
            start += filled;
        }
        *self.memory = Some(buffers);
    }
}

impl<K: BilinearKernel<D>, S: Sizes, const D: usize> FixedTask<'_, K, S, D> {
    #[inline(always)]
    fn blocks<L: SimdLane>(&self, start: usize, filled: usize, buffers: &mut Buffers<K, L, D>) {
        let requirements = &K::REQUIREMENTS;
        let points = <S::Points<f64> as Array<f64>>::LENGTH;
        let nodes = <S::Nodes<f64> as Array<f64>>::LENGTH;
        let kernel = self.kernel;
        let Buffers { fields, tests, trials, blocks, directions, tensor } = buffers;
        let batch = FixedBatch::<L, S, D>::load(
            requirements,
            self.group,
            self.tables,
            &self.listed,
            start,
            filled,
            fields,
        );
        let cell = kernel.cell(&batch.cell_geometry(requirements));
        if const { suits::<K, D>() }
            && let Some(Some(tensor)) = tensor
        {
            let place = batch.place(0);
            contract::<K, L, D>(kernel, &cell, tensor, place.determinant, &place.inverse, directions, blocks);
            return;
        }
        let zero = L::splat(0.0);
        let hessian = [[zero; D]; D];
        let mut basis = S::Nodes::filled(Basis { value: zero, gradient: [zero; D] });
        if const { <S::Points<f64> as Array<f64>>::LENGTH == 1 } {
            let place = batch.place(0);
            let geometry = batch.point(requirements, 0, &place, fields);
            let point = kernel.point(&cell, &geometry, &fields.fields);
            batch.evaluate_basis(requirements, 0, &place, &mut basis);
            let basis = basis.entries();
            let mut tests = S::Nodes::filled(kernel.test(&point, &basis[0], &hessian));
            let mut trials = S::Nodes::filled(kernel.trial(&point, &basis[0], &hessian));
            for i in 1..nodes {
                tests.entries_mut()[i] = kernel.test(&point, &basis[i], &hessian);
                trials.entries_mut()[i] = kernel.trial(&point, &basis[i], &hessian);
            }
            let (tests, trials) = (tests.entries(), trials.entries());
            let symmetric = K::SYMMETRIC;
            Pairs { kernel, cell: &cell, tests, trials, nodes: [nodes, nodes], points, symmetric }
                .sum(blocks);
            return;
        }
        for q in 0..points {
            let place = batch.place(q);
            let geometry = batch.point(requirements, q, &place, fields);
            let point = kernel.point(&cell, &geometry, &fields.fields);
            batch.evaluate_basis(requirements, q, &place, &mut basis);
            let basis = basis.entries();
            // There is no empty factor: the memory is made with the first one.
            if tests.len() != nodes * points {
                tests.resize(nodes * points, kernel.test(&point, &basis[0], &hessian));
                trials.resize(nodes * points, kernel.trial(&point, &basis[0], &hessian));
            }
            let (tests, trials) = (&mut tests[..nodes * points], &mut trials[..nodes * points]);
            for i in 0..nodes {
                tests[i * points + q] = kernel.test(&point, &basis[i], &hessian);
                trials[i * points + q] = kernel.trial(&point, &basis[i], &hessian);
            }
        }
        // Of many points an unrolled loop would load all factors first, and spill them.
        let points = if points > UNROLLED_POINTS { self.group.points() } else { points };
        let (tests, trials) = (&tests[..nodes * points], &trials[..nodes * points]);
        let symmetric = K::SYMMETRIC;
        Pairs { kernel, cell: &cell, tests, trials, nodes: [nodes, nodes], points, symmetric }.sum(blocks);
    }
}

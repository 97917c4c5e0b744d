//! Element matrices of a bilinear integral: the loops over batches, points and pairs of basis functions.

// Closures and iterator adaptors do not inherit a caller's target features, and copies of slices may become calls:
// loops over lane values are plain.
#![allow(clippy::needless_range_loop, clippy::manual_memcpy)]

use std::ops::Range;

use forms_core::contract::{Basis, BilinearKernel, PointGeometry};

use super::AssemblyError;
use super::batch::{Batch, BatchBuffers, Cells};
use super::binding::Binding;
use super::receiver::{Buffered, Deliver, Receiver};
use super::reference_tensor::{LARGEST_BLOCK, ReferenceTensor};
use super::sizes::{Counted, Sizes};
use super::walk::Group;
use crate::lanes::{Entries, InstructionSet, LaneWork, SimdLane, Transposition};

/// What the element matrices of a group depend on, besides the kernel.
pub(super) struct ElementMatrices<'a, const D: usize> {
    pub binding: &'a Binding<'a, D>,
    pub group: &'a Group<D>,
    /// Where the cells' nodes come from.
    pub cells: Cells<'a, D>,
    /// The sides on which test and trial functions live.
    pub sides: [usize; 2],
    /// Their elements, by index into the binding's.
    pub elements: [usize; 2],
    /// Only pairs of nodes i ≤ j are computed, and mirrored.
    pub symmetric: bool,
}

/// Memory of the loops, kept from one run to the next.
pub(super) struct MatrixBuffers<K: BilinearKernel<D>, L: SimdLane, const D: usize> {
    batch: BatchBuffers<L, D>,
    /// Factors of test node i at point q, at `i * points + q`.
    tests: Vec<K::Test<L>>,
    trials: Vec<K::Trial<L>>,
    /// Blocks of the pairs (i, j), at `(i * columns + j) * entries`; of symmetric ones only i ≤ j.
    blocks: Vec<L>,
    /// Blocks of pairs of directions, of a reference tensor.
    directions: Vec<L>,
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
            tensor: None,
        }
    }
}

impl<const D: usize> ElementMatrices<'_, D> {
    /// Number of test and of trial nodes.
    #[inline]
    pub fn nodes(&self) -> [usize; 2] {
        let nodes = |k: usize| self.group.sides[self.sides[k]].elements[self.elements[k]].nodes;
        [nodes(0), nodes(1)]
    }

    /// Computes the element matrices of the group's entities in a range, and hands them over in their order:
    /// `deliver(first, matrices)` gets whole element matrices, that of entity `first` first, each as
    /// `[test node][trial node][row component][column component]`.
    ///
    /// # Errors
    /// What the data of the form, or `deliver`, has to say.
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
        set.checked().run(Compute {
            task: self,
            kernel,
            order: &order,
            range,
            receiver: Buffered::new(deliver),
        })
    }

    /// The blocks of all pairs by the loop over points.
    #[inline(always)]
    fn integrate<K: BilinearKernel<D>, L: SimdLane, S: Sizes>(
        &self,
        kernel: &K,
        cell: &K::Cell<L>,
        batch: &mut Batch<L, D>,
        tests: &mut Vec<K::Test<L>>,
        trials: &mut Vec<K::Trial<L>>,
        blocks: &mut [L],
    ) -> Result<(), AssemblyError> {
        let [rows, columns] = self.nodes();
        let (rows, columns) = (S::nodes(rows), S::nodes(columns));
        let points = S::points(self.group.points());
        for q in 0..points {
            let geometry = batch.point::<S>(&K::REQUIREMENTS, q)?;
            let point = kernel.point(cell, &geometry, batch.fields());
            let basis = batch.basis(self.sides[0], self.elements[0]);
            let hessians = batch.hessians(self.sides[0], self.elements[0]);
            let (basis, hessians) = (&basis[..rows], &hessians[..rows]);
            // There is no empty factor: the memory is made with the first one.
            if tests.len() != rows * points {
                tests.clear();
                tests.resize(rows * points, kernel.test(&point, &basis[0], &hessians[0]));
            }
            let tests = &mut tests[q * rows..][..rows];
            for i in 0..rows {
                tests[i] = kernel.test(&point, &basis[i], &hessians[i]);
            }
            let basis = batch.basis(self.sides[1], self.elements[1]);
            let hessians = batch.hessians(self.sides[1], self.elements[1]);
            let (basis, hessians) = (&basis[..columns], &hessians[..columns]);
            if trials.len() != columns * points {
                trials.clear();
                trials.resize(columns * points, kernel.trial(&point, &basis[0], &hessians[0]));
            }
            let trials = &mut trials[q * columns..][..columns];
            for j in 0..columns {
                trials[j] = kernel.trial(&point, &basis[j], &hessians[j]);
            }
        }
        let pairs = Pairs {
            kernel,
            cell,
            tests: &tests[..rows * points],
            trials: &trials[..columns * points],
            nodes: [rows, columns],
            points,
            symmetric: self.symmetric,
        };
        // Each factor that is loaded serves several pairs, as many as there are registers for accumulators.
        match size_of::<K::Accumulator<L>>() / size_of::<L>() {
            0 | 1 => pairs.sweep::<4, 4>(blocks),
            2..=4 => pairs.sweep::<1, 4>(blocks),
            5..=9 => pairs.sweep::<2, 1>(blocks),
            _ => pairs.sweep::<1, 1>(blocks),
        }
        Ok(())
    }

    /// The loops. The entries of an element matrix come out in the order that [`block_order`] gives to
    /// the computed blocks, or any other.
    #[inline(always)]
    pub fn compute_in_lanes<K: BilinearKernel<D>, L: SimdLane, S: Sizes>(
        &self,
        kernel: &K,
        order: &[u32],
        range: Range<usize>,
        buffers: &mut MatrixBuffers<K, L, D>,
        receiver: &mut impl Receiver,
    ) -> Result<(), AssemblyError> {
        let [rows, columns] = self.nodes();
        let (rows, columns) = (S::nodes(rows), S::nodes(columns));
        let MatrixBuffers { batch, tests, trials, blocks, directions, tensor } = buffers;
        if tensor.is_none() && !range.is_empty() {
            let side = &self.group.sides[self.sides[0]];
            let weights = &self.group.weights;
            *tensor = Some(ReferenceTensor::for_kernel::<K, D>(side, self.elements, weights, self.symmetric));
        }
        let tensor = tensor.as_ref().and_then(Option::as_ref);
        let mut batch =
            Batch::<L, D>::new(self.binding, self.group, self.cells, K::REQUIREMENTS, &self.elements, batch)?;
        let entries = K::TEST_COMPONENTS * K::TRIAL_COMPONENTS;
        let size = rows * columns * entries;
        let order = &order[..size];
        let mut start = range.start;
        while start < range.end {
            let filled = L::WIDTH.min(range.end - start);
            let cell = kernel.cell(&batch.load::<S>(&K::REQUIREMENTS, start, filled));
            blocks.resize(size, L::splat(0.0));
            match tensor {
                Some(tensor) if K::CELL_CONSTANT => {
                    let (determinant, inverse) = batch.affine_map(self.sides[0]);
                    contract::<K, L, D>(kernel, &cell, tensor, determinant, &inverse, directions, blocks);
                }
                _ => self.integrate::<K, L, S>(kernel, &cell, &mut batch, tests, trials, blocks)?,
            }
            let source = &Ordered { values: blocks, order };
            let target = receiver.room(start, filled, size);
            if S::SHARED {
                L::call(Transposition { source, count: size, filled, target, stride: size });
            } else {
                L::store_transposed(source, size, filled, target, size);
            }
            receiver.filled(start, filled, size)?;
            start += filled;
        }
        Ok(())
    }
}

/// The sums over the points of a cell, pair by pair.
struct Pairs<'a, K: BilinearKernel<D>, L: SimdLane, const D: usize> {
    kernel: &'a K,
    cell: &'a K::Cell<L>,
    /// Factors of node i at point q, at `q * nodes + i`.
    tests: &'a [K::Test<L>],
    trials: &'a [K::Trial<L>],
    nodes: [usize; 2],
    points: usize,
    symmetric: bool,
}

impl<K: BilinearKernel<D>, L: SimdLane, const D: usize> Pairs<'_, K, L, D> {
    /// All blocks, in tiles of ROWS × COLUMNS pairs.
    #[inline(always)]
    fn sweep<const ROWS: usize, const COLUMNS: usize>(&self, blocks: &mut [L]) {
        let [rows, columns] = self.nodes;
        let mut i = 0;
        while i + ROWS <= rows {
            let mut j = if self.symmetric { i } else { 0 };
            while j + COLUMNS <= columns {
                self.tile::<ROWS, COLUMNS>(i, j, blocks);
                j += COLUMNS;
            }
            while COLUMNS > 1 && j < columns {
                self.tile::<ROWS, 1>(i, j, blocks);
                j += 1;
            }
            i += ROWS;
        }
        while ROWS > 1 && i < rows {
            let mut j = if self.symmetric { i } else { 0 };
            while j + COLUMNS <= columns {
                self.tile::<1, COLUMNS>(i, j, blocks);
                j += COLUMNS;
            }
            while COLUMNS > 1 && j < columns {
                self.tile::<1, 1>(i, j, blocks);
                j += 1;
            }
            i += 1;
        }
    }

    #[inline(always)]
    fn tile<const ROWS: usize, const COLUMNS: usize>(&self, i: usize, j: usize, blocks: &mut [L]) {
        let [rows, columns] = self.nodes;
        let entries = K::TEST_COMPONENTS * K::TRIAL_COMPONENTS;
        let mut accumulators = [[K::zero::<L>(); COLUMNS]; ROWS];
        for q in 0..self.points {
            let tests = &self.tests[q * rows + i..][..ROWS];
            let trials = &self.trials[q * columns + j..][..COLUMNS];
            for a in 0..ROWS {
                for b in 0..COLUMNS {
                    K::pair(&mut accumulators[a][b], &tests[a], &trials[b]);
                }
            }
        }
        for a in 0..ROWS {
            for b in 0..COLUMNS {
                let (i, j) = (i + a, j + b);
                // Below the diagonal a symmetric matrix is mirrored.
                if self.symmetric && j < i {
                    continue;
                }
                let before = if self.symmetric { i * columns - i * (i + 1) / 2 } else { i * columns };
                let block = self.kernel.finish(self.cell, &accumulators[a][b]);
                copy_block(block.as_ref(), &mut blocks[(before + j) * entries..][..entries]);
            }
        }
    }
}

/// Copies a block. Copying slices as such would be a call.
#[inline(always)]
fn copy_block<L: Copy>(block: &[L], target: &mut [L]) {
    let block = &block[..target.len()];
    for entry in 0..target.len() {
        target[entry] = block[entry];
    }
}

/// The blocks of all pairs by a reference tensor.
#[inline(always)]
fn contract<K: BilinearKernel<D>, L: SimdLane, const D: usize>(
    kernel: &K,
    cell: &K::Cell<L>,
    tensor: &ReferenceTensor,
    determinant: L,
    inverse: &[[L; D]; D],
    directions: &mut Vec<L>,
    blocks: &mut [L],
) {
    let zero = L::splat(0.0);
    let entries = K::TEST_COMPONENTS * K::TRIAL_COMPONENTS;
    let count = tensor.directions;
    let geometry =
        PointGeometry { weight: determinant, position: [zero; D], normal: [zero; D], curvature: zero };
    let point = kernel.point(cell, &geometry, &[]);
    let hessian = [[zero; D]; D];
    directions.resize(count * count * entries, zero);
    for a in 0..count {
        let test = kernel.test(&point, &direction(tensor, inverse, a), &hessian);
        for b in if K::SYMMETRIC { a } else { 0 }..count {
            let trial = kernel.trial(&point, &direction(tensor, inverse, b), &hessian);
            let mut accumulator = K::zero::<L>();
            K::pair(&mut accumulator, &test, &trial);
            let block = kernel.finish(cell, &accumulator);
            let block = &block.as_ref()[..entries];
            let target = &mut directions[(a * count + b) * entries..][..entries];
            for entry in 0..entries {
                target[entry] = block[entry];
            }
            if K::SYMMETRIC && b != a {
                let target = &mut directions[(b * count + a) * entries..][..entries];
                for entry in 0..entries {
                    target[entry % K::TEST_COMPONENTS * K::TEST_COMPONENTS + entry / K::TEST_COMPONENTS] =
                        block[entry];
                }
            }
        }
    }
    for pair in 0..tensor.pairs() {
        let target = &mut blocks[pair * entries..][..entries];
        let (places, coefficients) = tensor.terms(pair);
        let mut sums = [zero; LARGEST_BLOCK];
        for term in 0..places.len() {
            let block = &directions[places[term] as usize * entries..][..entries];
            let coefficient = L::splat(coefficients[term]);
            for entry in 0..entries {
                if K::NONZERO[entry] {
                    sums[entry] = block[entry].multiply_add(coefficient, sums[entry]);
                }
            }
        }
        for entry in 0..entries {
            target[entry] = sums[entry];
        }
    }
}

/// A function whose gradient is that of a barycentric coordinate, or whose value is one.
#[inline(always)]
fn direction<L: SimdLane, const D: usize>(
    tensor: &ReferenceTensor,
    inverse: &[[L; D]; D],
    a: usize,
) -> Basis<L, D> {
    let zero = L::splat(0.0);
    let mut basis = Basis { value: zero, gradient: [zero; D] };
    if tensor.value == Some(a) {
        basis.value = L::splat(1.0);
    } else if a == 0 {
        for i in 0..D {
            let mut sum = inverse[i][0];
            for j in 1..D {
                sum += inverse[i][j];
            }
            basis.gradient[i] = -sum;
        }
    } else {
        for i in 0..D {
            basis.gradient[i] = inverse[i][a - 1];
        }
    }
    basis
}

struct Compute<'a, 'd, K, const D: usize> {
    task: &'a ElementMatrices<'a, D>,
    kernel: &'a K,
    order: &'a [u32],
    range: Range<usize>,
    receiver: Buffered<'d>,
}

impl<K: BilinearKernel<D>, const D: usize> LaneWork for Compute<'_, '_, K, D> {
    type Output = Result<(), AssemblyError>;

    #[inline(always)]
    fn run<L: SimdLane>(mut self) -> Self::Output {
        let mut buffers = MatrixBuffers::<K, L, D>::default();
        let (task, receiver) = (self.task, &mut self.receiver);
        task.compute_in_lanes::<K, L, Counted>(self.kernel, self.order, self.range, &mut buffers, receiver)
    }
}

/// Entries of a list in another order.
pub(super) struct Ordered<'a, L> {
    pub values: &'a [L],
    pub order: &'a [u32],
}

impl<L> Entries<L> for Ordered<'_, L> {
    #[inline(always)]
    fn entry(&self, k: usize) -> &L {
        &self.values[self.order[k] as usize]
    }
}

/// Where the computed blocks have the entries of an element matrix, for the entries block after block. Of a
/// symmetric matrix only the blocks of pairs i ≤ j are computed.
pub(super) fn block_order(
    [rows, columns]: [usize; 2],
    [height, width]: [usize; 2],
    symmetric: bool,
) -> Vec<u32> {
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
    order
}

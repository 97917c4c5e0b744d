//! Element matrices with loops of known lengths.

// Closures and iterator adaptors do not inherit a caller's target features, and copies of slices may become calls:
// loops over lane values are plain.
#![allow(clippy::needless_range_loop, clippy::manual_memcpy)]

use forms_core::contract::{BilinearConstants, BilinearKernel, Further};

use super::batch::FixedBatch;
use super::by_moments::{self, ByMoments};
use super::field_buffers::FieldBuffers;
use super::in_place::{self, Destination, Numbers};
use super::tables::MOST_NUMBERS;
use super::{Call, FixedIntegral, FixedTables, store};
use crate::assemble::element_kernel::ElementCells;
use crate::assemble::element_kernel::sizes::{Array, Sizes};
use crate::assemble::element_loops::block_sink::BlockSink;
use crate::assemble::element_loops::reference_tensor::{
    InLanes, ReferenceTensor, contract, contract_numbers, products, suits,
};
use crate::assemble::element_loops::{NodePairs, no_products};
use crate::assemble::groups::Group;
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
    /// The order is that in which pairs are numbered.
    ordered: bool,
    tensor: Option<ReferenceTensor>,
    /// Coefficients of a reference tensor of numbers, where they are kept in all lanes: of the computed pairs, or of the matrix's entries
    /// ([`entry_by_entry`]).
    coefficients: Vec<InLanes<L>>,
    destination: Destination,
    moments: Option<ByMoments<L>>,
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

/// Linear functions at one point.
const fn simple<S: Sizes, const D: usize>() -> bool {
    FixedTables::<S, D>::LINEAR && <S::Points<f64> as Array<f64>>::LENGTH == 1
}

/// Numbers of the blocks of linear functions that are kept in registers, at most: numbers in space, two rows and columns in the plane.
const LINEAR_NUMBERS: usize = 36;

/// Possibility of a reference tensor. Linear functions at one point need none: it would copy the blocks of their gradients.
const fn has_tensor<K: BilinearKernel<D>, S: Sizes, const D: usize>() -> bool {
    suits::<K, D>() && !simple::<S, D>()
}

/// Whether coefficients of a reference tensor are kept in all lanes: with 32 registers the instructions that multiply take a number
/// from memory for all of them.
const fn in_lanes<L: SimdLane>() -> bool {
    L::REGISTERS < 32
}

/// Bytes of a matrix's coefficients, at most, for which those of each entry are kept and not those of each pair: a quarter of the first
/// cache.
const MOST_COEFFICIENTS: usize = 8 << 10;

/// Whether a reference tensor of numbers makes each entry of the matrix in its turn: more products, but no number is stored and read
/// again by place.
const fn entry_by_entry<K: BilinearKernel<D>, L: SimdLane, S: Sizes, const D: usize>() -> bool {
    let constants = BilinearConstants::of::<K, D>();
    let nodes = <S::Nodes<f64> as Array<f64>>::LENGTH;
    let bytes = nodes * nodes * products::<D>(&constants) * size_of::<L>();
    let by_tensor = has_tensor::<K, S, D>() && constants.scalar();
    L::STORES_FEW && in_lanes::<L>() && by_tensor && bytes <= MOST_COEFFICIENTS
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
        let mut coefficients = vec![];
        if let Some(ReferenceTensor::Numbers(numbers)) = &tensor
            && in_lanes::<L>()
        {
            let count = const { products::<D>(&BilinearConstants::of::<K, D>()) };
            let in_order = order.places().map(|place| place as usize);
            let pairs =
                if entry_by_entry::<K, L, S, D>() { in_order.collect() } else { Vec::from_iter(0..pairs) };
            for pair in pairs {
                for number in &numbers[pair * count..][..count] {
                    coefficients.push(InLanes(L::splat(*number)));
                }
            }
        }
        let room = L::WIDTH * nodes * nodes * entries;
        let destination = if const { in_place::by_pairs::<K, L, D>() && !simple::<S, D>() } {
            Destination::of_blocks(order, nodes, K::SYMMETRIC, room)
        } else if const { entry_by_entry::<K, L, S, D>() } {
            Destination::in_order(room)
        } else {
            Destination::default()
        };
        let buffers = Buffers {
            fields: FieldBuffers::new(&K::REQUIREMENTS, &tables),
            tests: vec![test; nodes * points],
            trials: vec![trial; nodes * points],
            blocks,
            directions: vec![],
        };
        let moments = if const { by_moments::suits::<K, S, D>() } {
            ByMoments::new::<K, D>(group, order)
        } else {
            None
        };
        let mut computed = order.places().enumerate();
        Box::new(Matrices::<K, L, S, D> {
            kernel: kernel.clone(),
            tables,
            order: order.clone(),
            ordered: K::TEST_COMPONENTS == K::TRIAL_COMPONENTS
                && computed.all(|(k, place)| {
                    place as usize == in_place::place_of(k, nodes, K::TEST_COMPONENTS, K::SYMMETRIC)
                }),
            tensor,
            coefficients,
            destination,
            moments,
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
        let Matrices { kernel, tables, order, ordered, tensor, coefficients, destination, moments, buffers } =
            integral;
        let work =
            Work { kernel, tables, cells, order, ordered: *ordered, tensor: tensor.as_ref(), coefficients };
        let mut start = 0;
        if const { by_moments::suits::<K, S, D>() }
            && let Some(moments) = moments
        {
            let size = const {
                <S::Nodes<f64> as Array<f64>>::LENGTH.pow(2) * K::TEST_COMPONENTS * K::TRIAL_COMPONENTS
            };
            while start < cells.count {
                let filled = L::WIDTH.min(cells.count - start);
                let batch = work.load(start, &mut buffers.fields);
                let target = &mut target[start * size..][..filled * size];
                moments.write(work.kernel, &batch, &buffers.fields, filled, target, add);
                start += filled;
            }
            return;
        }
        if const { !beforehand::<K, L, S, D>() } {
            while start < cells.count {
                let batch = work.load(start, &mut buffers.fields);
                start = work.write(&batch, start, destination, buffers, target, add);
            }
            return;
        }
        if cells.count == 0 {
            return;
        }
        // The quotients of the next batch are on their way while one is computed.
        let mut batch = work.load(start, &mut buffers.fields);
        loop {
            let following = start + L::WIDTH;
            let more = following < cells.count;
            let next = if more { work.load(following, &mut buffers.fields) } else { batch };
            work.write(&batch, start, destination, buffers, target, add);
            if !more {
                return;
            }
            (batch, start) = (next, following);
        }
    }
}

/// Whether the next cells are loaded before the results of some are computed: where that is nothing but their map, and lanes are few.
const fn beforehand<K: BilinearKernel<D>, L: SimdLane, S: Sizes, const D: usize>() -> bool {
    FixedTables::<S, D>::AFFINE && K::REQUIREMENTS.fields.is_empty() && L::REGISTERS < 32
}

/// Data that the cells of a call have in common.
struct Work<'a, K, L, S: Sizes, const D: usize> {
    kernel: &'a K,
    tables: &'a FixedTables<S, D>,
    cells: &'a ElementCells<'a>,
    order: &'a Order,
    ordered: bool,
    tensor: Option<&'a ReferenceTensor>,
    coefficients: &'a [InLanes<L>],
}

impl<'a, K: BilinearKernel<D>, L: SimdLane, S: Sizes, const D: usize> Work<'a, K, L, S, D> {
    /// The cells from `start` on.
    #[inline(always)]
    fn load(&self, start: usize, fields: &mut FieldBuffers<L>) -> FixedBatch<'a, L, S, D> {
        let filled = L::WIDTH.min(self.cells.count - start);
        FixedBatch::load(&K::REQUIREMENTS, self.tables, self.cells, start, filled, fields)
    }

    /// The matrices of the cells from `start` on, written or added to those of all cells; where the next cells start.
    #[inline(always)]
    fn write(
        &self,
        batch: &FixedBatch<L, S, D>,
        start: usize,
        destination: &mut Destination,
        buffers: &mut Buffers<K, L, D>,
        target: &mut [f64],
        add: bool,
    ) -> usize {
        let [nodes, _, entries, pairs] = const { lengths::<K, S, D>() };
        let size = nodes * nodes * entries;
        let filled = L::WIDTH.min(self.cells.count - start);
        let target = &mut target[start * size..][..filled * size];
        let whole = filled == L::WIDTH && !add;
        if const { in_place::by_pairs::<K, L, D>() && !simple::<S, D>() } {
            let callers = whole && destination.is_the_callers();
            self.blocks(batch, buffers, &mut destination.sink::<L>(target, callers, nodes));
            if !callers {
                destination.copy(target, size, add);
            }
        } else if const { entry_by_entry::<K, L, S, D>() } && self.tensor.is_some() {
            let target_of_all = destination.room(target, whole, L::WIDTH * size);
            self.numbers(batch, &mut Numbers { target: target_of_all, size });
            if !whole {
                destination.copy(target, size, add);
            }
        } else if const { simple::<S, D>() && in_place::at_once::<K, L, D>() } {
            let mut numbers = [L::splat(0.0); LINEAR_NUMBERS];
            self.linear_blocks(batch, &buffers.fields, &mut numbers[..]);
            if whole && self.ordered {
                in_place::write(
                    &numbers,
                    [nodes, K::TEST_COMPONENTS],
                    K::SYMMETRIC,
                    &mut target[..L::WIDTH * size],
                );
            } else {
                let blocks = &mut buffers.blocks[..pairs * entries];
                // One by one, so that they stay in registers where they are written as they are.
                for number in 0..pairs * entries {
                    blocks[number] = numbers[number];
                }
                store(Ordered::new(blocks, self.order, size), size, filled, target, add);
            }
        } else {
            // Of a known length: where loops are unrolled nothing is checked per entry.
            let mut blocks = std::mem::take(&mut buffers.blocks);
            self.blocks(batch, buffers, &mut blocks[..pairs * entries]);
            if const { simple::<S, D>() && in_place::in_space::<K, L, D>() } && whole && self.ordered {
                let blocks = &blocks[..pairs * entries];
                in_place::write_in_space(blocks, K::SYMMETRIC, &mut target[..L::WIDTH * size]);
            } else {
                store(Ordered::new(&blocks, self.order, size), size, filled, target, add);
            }
            buffers.blocks = blocks;
        }
        start + filled
    }

    /// The factors of linear functions at one point.
    #[inline(always)]
    fn linear_factors(
        &self,
        batch: &FixedBatch<L, S, D>,
        cell: &K::Cell<L>,
        fields: &FieldBuffers<L>,
        tests: &mut S::Nodes<K::Test<L>>,
        trials: &mut S::Nodes<K::Trial<L>>,
    ) {
        let requirements = &K::REQUIREMENTS;
        let further = Further::none();
        let map = batch.map_at(0);
        let mut numbers = [L::splat(0.0); MOST_NUMBERS];
        let geometry = batch.point(requirements, 0, &map, fields, &mut numbers);
        let point = self.kernel.point(cell, &geometry, &numbers);
        for i in 0..<S::Nodes<f64> as Array<f64>>::LENGTH {
            let basis = batch.basis(requirements, 0, &map, i);
            tests.entries_mut()[i] = self.kernel.test(&point, &basis, &further);
            trials.entries_mut()[i] = self.kernel.trial(&point, &basis, &further);
        }
    }

    /// The blocks of all pairs of linear functions at one point.
    #[inline(always)]
    fn linear_blocks<B: BlockSink<L> + ?Sized>(
        &self,
        batch: &FixedBatch<L, S, D>,
        fields: &FieldBuffers<L>,
        sink: &mut B,
    ) {
        let [nodes, _, entries, _] = const { lengths::<K, S, D>() };
        let cell = self.kernel.cell(&batch.cell_geometry(&K::REQUIREMENTS));
        let (test, trial) = K::zero_factors::<L>();
        let (mut tests, mut trials) = (S::Nodes::filled(test), S::Nodes::filled(trial));
        self.linear_factors(batch, &cell, fields, &mut tests, &mut trials);
        let (tests, trials) = (tests.entries(), trials.entries());
        // Written out: factors and places are those of the pair then, and nothing is counted.
        macro_rules! pairs {
            ($($i:literal $j:literal),*) => {
                $(if usize::max($i, $j) < nodes && ($i <= $j || !K::SYMMETRIC) {
                    let mut sum = no_products::<K, L, D>();
                    K::pair(&mut sum, &tests[$i], &trials[$j]);
                    let block = self.kernel.finish(&cell, &sum);
                    let number = in_place::place_of($i * nodes + $j, nodes, 1, K::SYMMETRIC);
                    sink.put(number, &block.as_ref()[..entries]);
                })*
            };
        }
        pairs!(0 0, 0 1, 0 2, 0 3, 1 0, 1 1, 1 2, 1 3, 2 0, 2 1, 2 2, 2 3, 3 0, 3 1, 3 2, 3 3);
    }

    /// The numbers of all pairs, or of all entries, by a reference tensor.
    #[inline(always)]
    fn numbers<B: BlockSink<L> + ?Sized>(&self, batch: &FixedBatch<L, S, D>, sink: &mut B) {
        let (kernel, map) = (self.kernel, batch.map_at(0));
        let cell = kernel.cell(&batch.cell_geometry(&K::REQUIREMENTS));
        let (coefficients, inverse) = (self.coefficients, &map.inverse);
        contract_numbers::<K, L, _, B, D>(kernel, &cell, coefficients, map.determinant, inverse, sink);
    }

    /// The blocks of some cells.
    #[inline(always)]
    fn blocks<B: BlockSink<L> + ?Sized>(
        &self,
        batch: &FixedBatch<L, S, D>,
        buffers: &mut Buffers<K, L, D>,
        sink: &mut B,
    ) {
        let requirements = &K::REQUIREMENTS;
        let [nodes, points, ..] = const { lengths::<K, S, D>() };
        let &Work { kernel, tables, tensor, .. } = self;
        let Buffers { fields, tests, trials, directions, .. } = buffers;
        let cell = kernel.cell(&batch.cell_geometry(requirements));
        if const { has_tensor::<K, S, D>() && !entry_by_entry::<K, L, S, D>() }
            && let Some(tensor) = tensor
        {
            if const { BilinearConstants::of::<K, D>().scalar() && in_lanes::<L>() } {
                self.numbers(batch, sink);
            } else {
                let map = batch.map_at(0);
                let (determinant, inverse) = (map.determinant, &map.inverse);
                contract::<K, L, B, D>(kernel, &cell, tensor, determinant, inverse, directions, sink);
            }
            return;
        }
        let zero = L::splat(0.0);
        let further = Further::none();
        if const { simple::<S, D>() } {
            let map = batch.map_at(0);
            let mut numbers = [zero; MOST_NUMBERS];
            let geometry = batch.point(requirements, 0, &map, fields, &mut numbers);
            let point = kernel.point(&cell, &geometry, &numbers);
            let (test, trial) = K::zero_factors::<L>();
            let (mut tests, mut trials) = (S::Nodes::filled(test), S::Nodes::filled(trial));
            for i in 0..nodes {
                let basis = batch.basis(requirements, 0, &map, i);
                tests.entries_mut()[i] = kernel.test(&point, &basis, &further);
                trials.entries_mut()[i] = kernel.trial(&point, &basis, &further);
            }
            let (tests, trials) = (tests.entries(), trials.entries());
            let symmetric = K::SYMMETRIC;
            NodePairs { kernel, cell: &cell, tests, trials, nodes: [nodes, nodes], points, symmetric }
                .sum(sink);
            return;
        }
        let (tests, trials) = (&mut tests[..nodes * points], &mut trials[..nodes * points]);
        let mut numbers = [zero; MOST_NUMBERS];
        for q in 0..points {
            let map = batch.map_at(q);
            let geometry = batch.point(requirements, q, &map, fields, &mut numbers);
            let point = kernel.point(&cell, &geometry, &numbers);
            // One after the other: gradients of all functions at once do not fit into registers.
            for i in 0..nodes {
                let basis = batch.basis(requirements, q, &map, i);
                tests[i * points + q] = kernel.test(&point, &basis, &further);
                trials[i * points + q] = kernel.trial(&point, &basis, &further);
            }
        }
        // The compiler is not to see the number of points: it would unroll, load all factors first, and spill them.
        let points = tables.points;
        let symmetric = K::SYMMETRIC;
        NodePairs { kernel, cell: &cell, tests, trials, nodes: [nodes, nodes], points, symmetric }.sum(sink);
    }
}

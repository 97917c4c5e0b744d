//! Element matrices of a bilinear integral on cells, facets and pairs: the loops over batches and points, from which the integral's
//! kernel is called. Strategies for many basis functions are in `reference_tensor` and `sum_factorisation`, loops of lengths that
//! are known in `fixed`.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lane values are plain.
#![allow(clippy::needless_range_loop)]

use std::ops::Range;

use forms_core::contract::{Basis, BilinearConstants, Further};

use super::bilinear_calls::{Functions, MatrixCall, MatrixCalls};
use crate::assemble::AssemblyError;
use crate::assemble::batch::{ArgumentBasis, Batch, BatchBuffers, Cells};
use crate::assemble::binding::Binding;
use crate::assemble::element_loops::reference_tensor::ReferenceTensor;
use crate::assemble::element_loops::sink::Sink;
use crate::assemble::element_loops::sum_factorisation::{
    Derivatives, MatrixStages, Moments, PairSums, ProductTables, matrix_operations, unit,
};
use crate::assemble::groups::Group;
use crate::assemble::scatter::group_nodes::Reading;
use crate::instantiate::instantiate;
use crate::lanes::{Order, Ordered, SharedWork, SimdLane, Transposition};

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
pub(in crate::assemble) struct MatrixBuffers<L, const D: usize> {
    batch: BatchBuffers<L, D>,
    /// Blocks of the pairs (i, j), at `(i * columns + j) * entries`; of symmetric ones only i ≤ j. By moments the same numbers in an order of
    /// their own.
    blocks: Vec<L>,
    /// Blocks of pairs of directions, of a reference tensor.
    directions: Vec<L>,
    stages: MatrixStages<L>,
    /// The reference tensor, once it is known whether there is one.
    tensor: Option<Option<ReferenceTensor>>,
    /// The same of sums by moments, and the order of a matrix's entries among them.
    moments: Option<Option<(Moments, Order)>>,
    /// Numbers of blocks at the points, and memory of the sums by moments.
    numbers: Vec<L>,
    room: Vec<L>,
}

impl<L: SimdLane, const D: usize> Default for MatrixBuffers<L, D> {
    fn default() -> Self {
        MatrixBuffers {
            batch: BatchBuffers::default(),
            blocks: vec![],
            directions: vec![],
            stages: MatrixStages::default(),
            tensor: None,
            moments: None,
            numbers: vec![],
            room: vec![],
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

    /// The functions of an argument at a point, test (0) or trial (1).
    #[inline(always)]
    fn functions<'b, L: SimdLane>(&'b self, argument: usize, batch: &'b Batch<L, D>) -> Functions<'b, L, D> {
        let (side, element) = (self.sides[argument], self.elements[argument]);
        Functions {
            basis: batch.basis(side, element),
            further: batch.further(side, element),
            places: self.seen[argument].as_deref(),
        }
    }

    /// The tables of a grid, if there is one.
    fn grid(&self) -> Option<&ProductTables> {
        let suited = self.elements[0] == self.elements[1] && self.sides == [0, 0];
        self.group.sides[0].products[self.elements[0]].as_ref().filter(|_| suited)
    }
}

/// The loops over the batches of a range: element matrices of its entities, in their order.
pub(in crate::assemble) struct Loops<'a, 'd, L, const D: usize> {
    pub task: &'a ElementMatrices<'d, D>,
    pub kernel: &'a BilinearConstants,
    pub calls: &'a mut dyn MatrixCalls<L, D>,
    /// Entries of a matrix by those of the computed blocks: [`block_order`], or any other.
    pub order: &'a Order,
    pub range: Range<usize>,
    /// Memory that is kept; without it the loops have their own.
    pub buffers: Option<&'a mut MatrixBuffers<L, D>>,
    pub sink: &'a mut dyn Sink,
}

impl<L: SimdLane, const D: usize> SharedWork<L> for Loops<'_, '_, L, D> {
    type Output = Result<(), AssemblyError>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Loops { task, kernel, calls, order, range, buffers, sink } = self;
        let ElementMatrices { group, symmetric, .. } = *task;
        let ([rows, columns], points) = (task.nodes(), group.points());
        let mut own;
        let buffers = match buffers {
            Some(kept) => kept,
            None => {
                own = MatrixBuffers::default();
                &mut own
            }
        };
        let MatrixBuffers { batch, blocks, directions, stages, tensor, moments, numbers, room } = buffers;
        if tensor.is_none() && !range.is_empty() {
            let side = &group.sides[task.sides[0]];
            // Its sums over the points are the same for all cells.
            let shared = group.own.is_none();
            *tensor = Some(match shared {
                true => ReferenceTensor::new(kernel, side, task.elements, &group.weights, symmetric),
                false => None,
            });
        }
        let tensor = tensor.as_ref().and_then(Option::as_ref);
        let grid = task.grid();
        if moments.is_none() && !range.is_empty() {
            *moments = Some(grid.and_then(|tables| {
                let moments = by_moments::<D>(kernel, tables, symmetric)?;
                let order = moments.order::<D>(tables, order, L::WIDTH);
                Some((moments, order))
            }));
        }
        let moments = moments.as_ref().and_then(Option::as_ref);
        let factorised =
            grid.filter(|tables| moments.is_some() || along_axes::<D>(kernel, tables, symmetric));
        let slope = L::splat(moments.map_or(1.0, |(moments, _)| moments.slope));
        let (length, order) = match moments {
            Some((moments, order)) => (moments.length::<D>(), order),
            None => (rows * columns * kernel.entries(), order),
        };
        let reading = Reading::of_arguments(kernel.requirements);
        let means = [kernel.requirements.test_mean, kernel.requirements.trial_mean];
        let basis = |k: usize| ArgumentBasis {
            side: task.sides[k],
            element: task.elements[k],
            reading: reading[k],
            mean: means[k],
        };
        let both = [basis(0), basis(1)];
        let arguments: &[ArgumentBasis] = if factorised.is_some() { &[] } else { &both };
        let requirements = *kernel.requirements;
        let mut batch = Batch::<L, D>::new(task.binding, group, task.cells, requirements, arguments, batch)?;
        let derivatives = Derivatives::of_arguments(&requirements);
        let asked = derivatives.count::<D>();
        let size = rows * columns * kernel.entries();
        let zero = L::splat(0.0);
        // Functions whose value, or whose derivative along one axis of the reference cell, is one.
        let mut units = [Basis { value: zero, gradient: [zero; D] }; 4];
        let nothing_further = [Further::none(); 4];
        let together = if group.own.is_some() { POINTS_AT_ONCE } else { points.max(1) };
        let mut start = range.start;
        while start < range.end {
            let filled = L::WIDTH.min(range.end - start);
            let geometry = &batch.load(start, filled);
            blocks.resize(length, zero);
            if let Some(tensor) = tensor {
                let map = &batch.affine_map(task.sides[0]);
                calls.call(&mut MatrixCall::Tensor { geometry, tensor, map, directions, blocks });
            } else if let Some(tables) = factorised {
                calls.call(&mut MatrixCall::Cell { geometry, functions: [asked; 2], points });
                for q in 0..points {
                    batch.point(q)?;
                    for k in 0..asked {
                        units[k] = unit(batch.inverse(), derivatives.kind(k));
                        for i in 0..D {
                            units[k].gradient[i] = units[k].gradient[i] * slope;
                        }
                    }
                    let (basis, further) = (&units[..asked], &nothing_further[..asked]);
                    let functions = || Functions { basis, further, places: None };
                    let (geometry, fields) = (batch.geometry(), batch.fields());
                    let (tests, trials) = (functions(), functions());
                    calls.call(&mut MatrixCall::Point { q, geometry, fields, tests, trials });
                }
                let place_of = &tables.place_of;
                if let Some((moments, _)) = moments {
                    numbers.resize(asked * asked * kernel.entries() * points, zero);
                    let mut lists = numbers.chunks_exact_mut(kernel.entries() * points);
                    for s in 0..asked {
                        for t in if symmetric { s } else { 0 }..asked {
                            let Some(target) = lists.next() else { break };
                            calls.call(&mut MatrixCall::Numbers { pair: [s, t], place_of, target });
                        }
                    }
                    moments.sum::<L, D>(numbers, room, blocks);
                } else {
                    stages.prepare::<D>(tables, symmetric);
                    for s in 0..asked {
                        for t in 0..asked {
                            let target = stages.coefficients::<D>([derivatives.kind(s), derivatives.kind(t)]);
                            calls.call(&mut MatrixCall::Numbers { pair: [s, t], place_of, target });
                        }
                    }
                    L::call(PairSums::<L, D> { tables, derivatives, symmetric, stages, blocks });
                }
            } else {
                for first in (0..points.max(1)).step_by(together) {
                    let points = together.min(points - first);
                    calls.call(&mut MatrixCall::Cell { geometry, functions: [rows, columns], points });
                    for q in 0..points {
                        batch.point(first + q)?;
                        let (geometry, fields) = (batch.geometry(), batch.fields());
                        let (tests, trials) = (task.functions(0, &batch), task.functions(1, &batch));
                        calls.call(&mut MatrixCall::Point { q, geometry, fields, tests, trials });
                    }
                    if first == 0 {
                        calls.call(&mut MatrixCall::Pairs { symmetric, blocks });
                        continue;
                    }
                    room.resize(length, zero);
                    calls.call(&mut MatrixCall::Pairs { symmetric, blocks: room });
                    for k in 0..length {
                        blocks[k] += room[k];
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
}

/// Points whose factors are made at a time, where entities have their own: parts of cut cells can have hundreds, whose factors no cache holds.
const POINTS_AT_ONCE: usize = 32;

/// Cost of an operation along an axis, in operations on a pair of nodes, whose sums stay in registers: its sums
/// are as short as a row of points, and go through memory from axis to axis (docs/decisions/lanes.md).
const ALONG_AN_AXIS: usize = 2;

/// Cost of a number of all pairs by moments, in the same operations.
const BY_MOMENTS: usize = 10;

/// Operations of the kernel where it is asked at the points alone, for the functions whose value, or whose derivative along an axis, is one.
fn at_points<const D: usize>(kernel: &BilinearConstants, points: usize) -> usize {
    let count = kernel.operations;
    let asked = Derivatives::of_arguments(kernel.requirements).count::<D>();
    points * (asked * (count.test + count.trial) + asked * asked * (count.pair + count.finish))
}

/// Operations of sums over the points for each pair.
fn by_pairs<const D: usize>(kernel: &BilinearConstants, tables: &ProductTables, symmetric: bool) -> usize {
    let (count, derivatives) = (kernel.operations, Derivatives::of_arguments(kernel.requirements));
    let (nodes, points) = (tables.node_at.len(), tables.place_of.len());
    let pairs = if symmetric { nodes * (nodes + 1) / 2 } else { nodes * nodes };
    let transformed = if derivatives.gradient { D * D } else { 0 };
    points * (nodes * (count.test + count.trial + transformed) + pairs * count.pair) + pairs * count.finish
}

/// Whether sum factorisation takes less than sums over the points for each pair. Of vector forms it does
/// not: each of the D² entries of a block would need sums of its own for each pair of derivatives.
pub(in crate::assemble) fn along_axes<const D: usize>(
    kernel: &BilinearConstants,
    tables: &ProductTables,
    symmetric: bool,
) -> bool {
    if !kernel.scalar() || kernel.requirements.reads_further() {
        return false;
    }
    let derivatives = Derivatives::of_arguments(kernel.requirements);
    let sums = ALONG_AN_AXIS * matrix_operations::<D>(tables, derivatives, symmetric);
    at_points::<D>(kernel, tables.place_of.len()) + sums < by_pairs::<D>(kernel, tables, symmetric)
}

/// The plan of sums by moments, where they take less than sums over the points for each pair.
#[inline(never)]
pub(in crate::assemble) fn by_moments<const D: usize>(
    kernel: &BilinearConstants,
    tables: &ProductTables,
    symmetric: bool,
) -> Option<Moments> {
    if kernel.requirements.reads_further() {
        return None;
    }
    let derivatives = Derivatives::of_arguments(kernel.requirements);
    let moments = Moments::new::<D>(tables, derivatives, kernel.components, symmetric)?;
    let sums = BY_MOMENTS * moments.length::<D>();
    (at_points::<D>(kernel, tables.place_of.len()) + sums < by_pairs::<D>(kernel, tables, symmetric))
        .then_some(moments)
}

/// Places in the computed blocks of an element matrix's entries, for the entries block after block. Of a
/// symmetric matrix only the blocks of pairs i ≤ j are computed.
pub(in crate::assemble) fn block_order(
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

instantiate!(
    element_matrices in lanes:
    Moments::sum::<L, D>,
    by_moments::<D>,
    L::call::<Loops<L, D>>,
);

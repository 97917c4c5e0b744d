//! The calls of a bilinear kernel whose type is forgotten, for each point of a batch of cells and for all pairs of its functions: what
//! surrounds them is compiled once and not for every kernel.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lane values are plain.
#![allow(clippy::needless_range_loop)]

use forms_core::contract::{Basis, BilinearKernel, CellGeometry, Further, PointGeometry};

use super::NodePairs;
use super::reference_tensor::{ReferenceTensor, contract, suits};
use crate::lanes::{SharedWork, SimdLane};

/// A call for the cells of a batch.
pub(in crate::assemble) enum MatrixCall<'a, L, const D: usize> {
    /// Quantities that are constant on the cells, before the first point; room for the factors of the given numbers of test and trial functions and
    /// points.
    Cell { geometry: &'a CellGeometry<L>, functions: [usize; 2], points: usize },
    /// The factors of all functions at the q-th point.
    Point {
        q: usize,
        geometry: &'a PointGeometry<L, D>,
        fields: &'a [L],
        tests: Functions<'a, L, D>,
        trials: Functions<'a, L, D>,
    },
    /// The blocks of all pairs (i, j), one after the other, from the factors at all points; of symmetric ones only i ≤ j.
    Pairs { symmetric: bool, blocks: &'a mut [L] },
    /// The block of a pair of functions at each point q, entry after entry, each at all places `place_of[q]`.
    Numbers { pair: [usize; 2], place_of: &'a [u32], target: &'a mut [L] },
    /// The blocks of all pairs by a reference tensor, without a call before it.
    Tensor {
        geometry: &'a CellGeometry<L>,
        tensor: &'a ReferenceTensor,
        /// det J and J⁻ᵀ of the cells.
        map: &'a (L, [[L; D]; D]),
        /// Memory that is kept.
        directions: &'a mut Vec<L>,
        blocks: &'a mut [L],
    },
}

/// Functions at a point.
pub(in crate::assemble) struct Functions<'a, L, const D: usize> {
    pub basis: &'a [Basis<L, D>],
    pub further: &'a [Further<L, D>],
    /// The places of those that count, where not all do.
    pub places: Option<&'a [usize]>,
}

impl<L, const D: usize> Functions<'_, L, D> {
    #[inline(always)]
    fn at(&self, function: usize) -> (&Basis<L, D>, &Further<L, D>) {
        let place = match self.places {
            Some(places) => places[function],
            None => function,
        };
        (&self.basis[place], &self.further[place])
    }
}

/// A kernel, and what it knows of the cells at hand.
pub(in crate::assemble) trait MatrixCalls<L, const D: usize> {
    fn call(&mut self, call: &mut MatrixCall<L, D>);
}

/// The factors of functions at points, kept from one run to the next.
pub(in crate::assemble) struct Factors<K: BilinearKernel<D>, L: SimdLane, const D: usize> {
    /// Of test function i at point q, at `i * points + q`.
    tests: Vec<K::Test<L>>,
    trials: Vec<K::Trial<L>>,
    functions: [usize; 2],
    points: usize,
}

impl<K: BilinearKernel<D>, L: SimdLane, const D: usize> Default for Factors<K, L, D> {
    fn default() -> Self {
        Factors { tests: vec![], trials: vec![], functions: [0; 2], points: 0 }
    }
}

/// The calls of a kernel of a known type.
pub(in crate::assemble) struct BilinearCalls<'a, K: BilinearKernel<D>, L: SimdLane, const D: usize> {
    kernel: &'a K,
    cell: Option<K::Cell<L>>,
    factors: &'a mut Factors<K, L, D>,
}

impl<'a, K: BilinearKernel<D>, L: SimdLane, const D: usize> BilinearCalls<'a, K, L, D> {
    #[inline(always)]
    pub fn new(kernel: &'a K, factors: &'a mut Factors<K, L, D>) -> Self {
        BilinearCalls { kernel, cell: None, factors }
    }
}

impl<K: BilinearKernel<D>, L: SimdLane, const D: usize> MatrixCalls<L, D> for BilinearCalls<'_, K, L, D> {
    fn call(&mut self, call: &mut MatrixCall<L, D>) {
        L::call(Work { calls: self, call });
    }
}

/// A call, compiled for the lane type's instructions. Two pointers: what is longer would be copied on its way.
struct Work<'a, 'c, C, L, const D: usize> {
    calls: &'a mut C,
    call: &'a mut MatrixCall<'c, L, D>,
}

impl<K: BilinearKernel<D>, L: SimdLane, const D: usize> SharedWork<L>
    for Work<'_, '_, BilinearCalls<'_, K, L, D>, L, D>
{
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let BilinearCalls { kernel, cell, factors } = self.calls;
        let Factors { tests: own_tests, trials: own_trials, functions: nodes, points: count } =
            &mut **factors;
        let (kernel, points) = (*kernel, *count);
        match self.call {
            MatrixCall::Cell { geometry, functions, points } => {
                *cell = Some(kernel.cell(geometry));
                if (*nodes, *count) != (*functions, *points) {
                    let (test, trial) = K::zero_factors::<L>();
                    own_tests.resize(functions[0] * *points, test);
                    own_trials.resize(functions[1] * *points, trial);
                    (*nodes, *count) = (*functions, *points);
                }
            }
            MatrixCall::Point { q, geometry, fields, tests, trials } => {
                let point = kernel.point(&copied(cell), geometry, fields);
                let (own_tests, own_trials) = (&mut own_tests[..], &mut own_trials[..]);
                for i in 0..nodes[0] {
                    let (basis, further) = tests.at(i);
                    own_tests[i * points + *q] = kernel.test(&point, basis, further);
                }
                for j in 0..nodes[1] {
                    let (basis, further) = trials.at(j);
                    own_trials[j * points + *q] = kernel.trial(&point, basis, further);
                }
            }
            MatrixCall::Pairs { symmetric, blocks } => {
                let (cell, tests, trials) = (&copied(cell), &own_tests[..], &own_trials[..]);
                let (nodes, symmetric) = (*nodes, *symmetric);
                NodePairs { kernel, cell, tests, trials, nodes, points, symmetric }.sum(&mut **blocks);
            }
            MatrixCall::Numbers { pair: [s, t], place_of, target } => {
                let cell = &copied(cell);
                for q in 0..points {
                    let mut sum = K::zero::<L>();
                    K::pair(&mut sum, &own_tests[*s * points + q], &own_trials[*t * points + q]);
                    let (block, place) = (kernel.finish(cell, &sum), place_of[q] as usize);
                    let block = block.as_ref();
                    for entry in 0..const { K::TEST_COMPONENTS * K::TRIAL_COMPONENTS } {
                        target[entry * points + place] = block[entry];
                    }
                }
            }
            MatrixCall::Tensor { geometry, tensor, map, directions, blocks } => {
                if const { suits::<K, D>() } {
                    let ((determinant, inverse), cell) = (**map, kernel.cell(geometry));
                    let blocks = &mut **blocks;
                    contract::<K, L, _, D>(kernel, &cell, tensor, determinant, &inverse, directions, blocks);
                }
            }
        }
    }
}

/// The constants of the cells. A copy: the compiler sees that nothing that is written changes them.
#[inline(always)]
fn copied<C: Copy>(cell: &Option<C>) -> C {
    match cell {
        Some(cell) => *cell,
        None => unreachable!("a cell comes before its points"),
    }
}

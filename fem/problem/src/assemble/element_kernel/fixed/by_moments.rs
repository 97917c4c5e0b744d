//! Element matrices on quadrilaterals and hexahedra by moments: the kernel is called at the points alone, with the functions that have a
//! value or a derivative of one; all pairs of nodes are summed by code that is compiled once for all kernels.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lane values are plain.
#![allow(clippy::needless_range_loop)]

use forms_core::contract::{BilinearConstants, BilinearKernel, Further};

use super::batch::FixedBatch;
use super::field_buffers::FieldBuffers;
use super::store;
use super::tables::MOST_NUMBERS;
use crate::assemble::element_kernel::sizes::{Array, Sizes};
use crate::assemble::element_loops::matrices::by_moments;
use crate::assemble::element_loops::no_products;
use crate::assemble::element_loops::sum_factorisation::{Derivatives, Moments, unit};
use crate::assemble::groups::Group;
use crate::lanes::{Order, Ordered, SimdLane};

/// Functions that a kernel is asked for at a point, at most.
const MOST_ASKED: usize = 4;

/// The sums of an integral by moments, and their memory.
pub(super) struct ByMoments<L> {
    moments: Moments,
    /// The place of each point on the grid.
    place_of: Vec<u32>,
    /// Places of a matrix's entries among the sums.
    order: Order,
    numbers: Vec<L>,
    room: Vec<L>,
    sums: Vec<L>,
}

/// Whether there may be as many nodes and points as in a grid of two or three along each axis.
pub(super) const fn suits<K: BilinearKernel<D>, S: Sizes, const D: usize>() -> bool {
    let (nodes, points) = (<S::Nodes<f64> as Array<f64>>::LENGTH, <S::Points<f64> as Array<f64>>::LENGTH);
    let grid = nodes == 1 << D || nodes == usize::pow(3, D as u32);
    grid && nodes == points && K::REQUIREMENTS.basis_gradient
}

/// Functions that a kernel is asked for at a point, the pairs of these, and numbers of a block.
const fn lengths<K: BilinearKernel<D>, const D: usize>() -> [usize; 3] {
    let asked = D + K::REQUIREMENTS.basis_value as usize;
    let pairs = if K::SYMMETRIC { asked * (asked + 1) / 2 } else { asked * asked };
    [asked, pairs, K::TEST_COMPONENTS * K::TRIAL_COMPONENTS]
}

impl<L: SimdLane> ByMoments<L> {
    /// The sums, where counted operations say that they take less than others.
    pub fn new<K: BilinearKernel<D>, const D: usize>(group: &Group<D>, order: &Order) -> Option<Self> {
        let tables = group.sides[0].products[0].as_ref()?;
        let moments = by_moments::<D>(const { &BilinearConstants::of::<K, D>() }, tables, K::SYMMETRIC)?;
        let [_, pairs, entries] = const { lengths::<K, D>() };
        Some(ByMoments {
            place_of: tables.place_of.clone(),
            order: moments.order::<D>(tables, order, L::WIDTH),
            numbers: vec![L::splat(0.0); pairs * entries * tables.place_of.len()],
            room: vec![],
            sums: vec![L::splat(0.0); moments.length::<D>()],
            moments,
        })
    }

    /// The matrices of some cells, written or added.
    #[inline(always)]
    pub fn write<K: BilinearKernel<D>, S: Sizes, const D: usize>(
        &mut self,
        kernel: &K,
        batch: &FixedBatch<L, S, D>,
        fields: &FieldBuffers<L>,
        filled: usize,
        target: &mut [f64],
        add: bool,
    ) {
        self.numbers(kernel, batch, fields);
        let ByMoments { moments, order, numbers, room, sums, .. } = self;
        moments.sum::<L, D>(numbers, room, sums);
        let size = const { <S::Nodes<f64> as Array<f64>>::LENGTH.pow(2) * lengths::<K, D>()[2] };
        store(Ordered::new(sums, order, size), size, filled, target, add);
    }

    /// The numbers of the block of each pair of functions at each point.
    #[inline(always)]
    fn numbers<K: BilinearKernel<D>, S: Sizes, const D: usize>(
        &mut self,
        kernel: &K,
        batch: &FixedBatch<L, S, D>,
        fields: &FieldBuffers<L>,
    ) {
        let requirements = &K::REQUIREMENTS;
        let derivatives = Derivatives::of_arguments(requirements);
        let ([asked, pairs, entries], points) =
            const { (lengths::<K, D>(), <S::Points<f64> as Array<f64>>::LENGTH) };
        let slope = L::splat(self.moments.slope);
        let target = &mut self.numbers[..pairs * entries * points];
        let further = Further::none();
        let cell = kernel.cell(&batch.cell_geometry(requirements));
        let mut numbers = [L::splat(0.0); MOST_NUMBERS];
        let (test, trial) = K::zero_factors::<L>();
        let (mut tests, mut trials) = ([test; MOST_ASKED], [trial; MOST_ASKED]);
        for q in 0..points {
            let map = batch.map_at(q);
            let geometry = batch.point(requirements, q, &map, fields, &mut numbers);
            let point = kernel.point(&cell, &geometry, &numbers);
            let mut inverse = map.inverse;
            for i in 0..D {
                for j in 0..D {
                    inverse[i][j] = inverse[i][j] * slope;
                }
            }
            for k in 0..asked {
                let function = unit::<L, D>(&inverse, derivatives.kind(k));
                tests[k] = kernel.test(&point, &function, &further);
                trials[k] = kernel.trial(&point, &function, &further);
            }
            let place = self.place_of[q] as usize;
            assert!(place < points);
            let mut pair = 0;
            for s in 0..asked {
                for t in if K::SYMMETRIC { s } else { 0 }..asked {
                    let mut sum = no_products::<K, L, D>();
                    K::pair(&mut sum, &tests[s], &trials[t]);
                    let block = kernel.finish(&cell, &sum);
                    let block = &block.as_ref()[..entries];
                    for entry in 0..entries {
                        target[(pair * entries + entry) * points + place] = block[entry];
                    }
                    pair += 1;
                }
            }
        }
    }
}

//! Matrices that are written as they are computed, from the registers: blocks of two rows and two columns pair by pair, matrices of
//! linear simplices as a whole.
//!
//! Blocks that are stored and read again by place, entry by entry, take twice as many instructions.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lane values are plain.
#![allow(clippy::needless_range_loop)]

use forms_core::contract::BilinearKernel;

use crate::assemble::element_loops::block_sink::{BlockSink, sum};
use crate::assemble::element_loops::reference_tensor::Coefficient;
use crate::lanes::{Order, PairPlaces, PlacedBlocks, SimdLane};

/// Whether blocks are written pair by pair.
pub(super) const fn by_pairs<K: BilinearKernel<D>, L: SimdLane, const D: usize>() -> bool {
    L::STORES_FEW && K::TEST_COMPONENTS == 2 && K::TRIAL_COMPONENTS == 2
}

/// Destination of results that are written as they are computed.
#[derive(Default)]
pub(super) struct Destination {
    /// Of the blocks of the computed pairs, where rows and columns are two per node.
    places: PairPlaces,
    /// Where the caller's rows of a node are not side by side: which entry of the matrix in our order each of the caller's is.
    rearranged: Option<Vec<u32>>,
    /// Matrices that are not the caller's, or fewer than lanes, or to be added.
    scratch: Vec<f64>,
}

impl Destination {
    /// The places of blocks in matrices whose entries are the computed ones in an order.
    pub fn of_blocks(order: &Order, nodes: usize, symmetric: bool, room: usize) -> Self {
        let (computed, width): (Vec<u32>, usize) = (order.places().collect(), 2 * nodes);
        let (mut own, mut first_with) = (vec![], vec![]);
        for i in 0..nodes {
            for j in if symmetric { i } else { 0 }..nodes {
                let [direct, mirrored] = [[i, j], [j, i]].map(|[i, j]| 2 * (i * width + j));
                own.push([direct, if symmetric { mirrored } else { direct }].map(|place| place as u32));
                first_with.extend([0, 1, width, width + 1].map(|distance| (direct + distance) as u32));
            }
        }
        let scratch = vec![0.0; room];
        match places(&computed, width, own.len()) {
            Some(places) => Destination { places: PairPlaces::new(places, width), rearranged: None, scratch },
            _ => {
                let rearranged = computed.iter().map(|place| first_with[*place as usize]).collect();
                Destination { places: PairPlaces::new(own, width), rearranged: Some(rearranged), scratch }
            }
        }
    }

    /// A destination of matrices whose entries are computed in the caller's order.
    pub fn in_order(room: usize) -> Self {
        Destination { scratch: vec![0.0; room], ..Self::default() }
    }

    /// A sink of the blocks of all lanes, in matrices of the caller's or others.
    #[inline(always)]
    pub fn sink<'a, L: SimdLane>(
        &'a mut self,
        target: &'a mut [f64],
        callers: bool,
        nodes: usize,
    ) -> PlacedBlocks<'a> {
        let target = if callers { target } else { &mut self.scratch[..] };
        PlacedBlocks::new::<L>(target, &self.places, 2 * nodes)
    }

    /// Memory for the matrices of all lanes: the caller's, or other.
    #[inline(always)]
    pub fn room<'a>(&'a mut self, target: &'a mut [f64], callers: bool, length: usize) -> &'a mut [f64] {
        &mut (if callers { target } else { &mut self.scratch[..] })[..length]
    }

    /// Whether the caller's matrices can be written as they are.
    #[inline(always)]
    pub fn is_the_callers(&self) -> bool {
        self.rearranged.is_none()
    }

    /// Matrices of some lanes, of `size` numbers each, copied from where they were written.
    #[cold]
    #[inline(never)]
    pub fn copy(&self, target: &mut [f64], size: usize, add: bool) {
        for (target, own) in target.chunks_exact_mut(size).zip(self.scratch.chunks_exact(size)) {
            for (k, entry) in target.iter_mut().enumerate() {
                let value = own[self.rearranged.as_ref().map_or(k, |places| places[k] as usize)];
                *entry = if add { *entry + value } else { value };
            }
        }
    }
}

/// The places of blocks in an order in which a node's rows, and columns, are side by side.
fn places(computed: &[u32], width: usize, pairs: usize) -> Option<Vec<[u32; 2]>> {
    let mut places = vec![[None; 2]; pairs];
    for (k, first) in computed.iter().enumerate().filter(|(_, place)| **place % 4 == 0) {
        let entry = |distance: usize| computed.get(k + distance).map(|place| place.wrapping_sub(*first));
        let kind = match [entry(1)?, entry(width)?, entry(width + 1)?] {
            [1, 2, 3] => 0,
            [2, 1, 3] => 1,
            _ => return None,
        };
        places.get_mut(*first as usize / 4)?[kind] = Some(k as u32);
    }
    places.into_iter().map(|[direct, mirrored]| Some([direct?, mirrored.or(direct)?])).collect()
}

impl<L: SimdLane> BlockSink<L> for PlacedBlocks<'_> {
    #[inline(always)]
    fn put(&mut self, number: usize, block: &[L]) {
        PlacedBlocks::put(self, number, [block[0], block[1], block[2], block[3]]);
    }

    #[inline(always)]
    fn put_sums<C: Coefficient<L>, const PRODUCTS: usize>(&mut self, _: &[L; PRODUCTS], _: &[[C; PRODUCTS]]) {
        unreachable!("blocks of two rows and two columns are no numbers");
    }
}

/// Matrices of all lanes whose entries are numbers of pairs, each with the given number of them.
pub(super) struct Numbers<'a> {
    pub target: &'a mut [f64],
    pub size: usize,
}

impl<L: SimdLane> BlockSink<L> for Numbers<'_> {
    #[inline(always)]
    fn put(&mut self, _: usize, _: &[L]) {
        unreachable!("all numbers of a matrix come at once");
    }

    /// Entry by entry, in the order of memory: four are in registers when they are written.
    #[inline(always)]
    fn put_sums<C: Coefficient<L>, const PRODUCTS: usize>(
        &mut self,
        products: &[L; PRODUCTS],
        coefficients: &[[C; PRODUCTS]],
    ) {
        let (size, coefficients) = (self.size, &coefficients[..self.size]);
        let target = &mut self.target[..L::WIDTH * size];
        let mut k = 0;
        while k + 4 <= size {
            let mut entries = [products[0]; 4];
            for entry in 0..4 {
                entries[entry] = sum(products, &coefficients[k + entry]);
            }
            L::store_few(entries, target, k, size);
            k += 4;
        }
        while k < size {
            L::store_few([sum(products, &coefficients[k])], target, k, size);
            k += 1;
        }
    }
}

/// Whether the matrices of linear simplices are written as a whole.
pub(super) const fn at_once<K: BilinearKernel<D>, L: SimdLane, const D: usize>() -> bool {
    let square = K::TEST_COMPONENTS == K::TRIAL_COMPONENTS;
    L::STORES_FEW && square && (K::TEST_COMPONENTS == 1 || D == 2 && K::TEST_COMPONENTS == 2)
}

/// The place of the k-th entry, of a matrix whose rows are in our order, among the computed blocks.
#[inline(always)]
pub(super) const fn place_of(k: usize, nodes: usize, components: usize, symmetric: bool) -> usize {
    let (row, column) = (k / (nodes * components), k % (nodes * components));
    let ([i, a], [j, b]) = ([row / components, row % components], [column / components, column % components]);
    let entries = components * components;
    if !symmetric {
        return (i * nodes + j) * entries + a * components + b;
    }
    let ([i, a], [j, b]) = if i <= j { ([i, a], [j, b]) } else { ([j, b], [i, a]) };
    (i * nodes - i * (i + 1) / 2 + j) * entries + a * components + b
}

/// Writes the matrices of all lanes, from the blocks of their pairs, by four numbers of a matrix one after the other: registers that begin
/// at multiples of 32 bytes where the caller's memory does.
#[inline(always)]
pub(super) fn write<L: SimdLane, const NUMBERS: usize>(
    numbers: &[L; NUMBERS],
    [nodes, components]: [usize; 2],
    symmetric: bool,
    target: &mut [f64],
) {
    let size = (nodes * components).pow(2);
    // Written out: a loop would look its places up.
    macro_rules! four {
        ($($number:literal)*) => {
            $(if 4 * $number + 4 <= size {
                let mut entries = [numbers[0]; 4];
                for entry in 0..4 {
                    entries[entry] = numbers[place_of(4 * $number + entry, nodes, components, symmetric)];
                }
                L::store_few(entries, target, 4 * $number, size);
            })*
        };
    }
    four!(0 1 2 3 4 5 6 7 8);
    for k in size / 4 * 4..size {
        L::store_few([numbers[place_of(k, nodes, components, symmetric)]], target, k, size);
    }
}

/// Whether the matrices of linear tetrahedra are written from blocks of three rows and three columns at places that are constants.
pub(super) const fn in_space<K: BilinearKernel<D>, L: SimdLane, const D: usize>() -> bool {
    L::STORES_FEW && D == 3 && K::TEST_COMPONENTS == 3 && K::TRIAL_COMPONENTS == 3
}

/// Writes the matrices of linear tetrahedra, twelve rows each, from their blocks.
#[inline(always)]
pub(super) fn write_in_space<L: SimdLane>(blocks: &[L], symmetric: bool, target: &mut [f64]) {
    const SIZE: usize = 144;
    // Written out: a loop would look its places up.
    macro_rules! four {
        ($($number:literal)*) => {
            $({
                let mut entries = [blocks[0]; 4];
                for entry in 0..4 {
                    entries[entry] = blocks[place_of(4 * $number + entry, 4, 3, symmetric)];
                }
                L::store_few(entries, target, 4 * $number, SIZE);
            })*
        };
    }
    four!(0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32 33 34 35);
}

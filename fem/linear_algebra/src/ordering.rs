//! Fill-reducing orderings of symmetric patterns.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::amd;
use feral_metis::CscPattern;

use super::block_graph::BlockGraph;
use super::cell_blocks::CellBlocks;
use super::dissection::dissect;
use super::error::{LinearAlgebraError, check_size};
use super::pattern::SparsityPattern;
use super::symbolic::{Fill, Runs};
use super::threads::Threads;

/// The order in which unknowns are eliminated. Minimum degree and nested dissection work on the graph of blocks: a
/// block is a run of consecutive unknowns whose rows have the same pattern, the free components of one node.
/// Ordering blocks is faster than ordering unknowns and keeps the components of a node together.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Ordering {
    /// The one of the least symbolic fill among those that are worth trying: minimum degree; the dissection of cells where the
    /// pattern knows its [`Cells`](super::Cells); and multilevel nested dissection where the factorisation would take twice as long
    /// as that, or twenty times as long where cells are known: in 3D, not in 2D.
    #[default]
    LeastFill,
    /// Approximate minimum degree.
    MinimumDegree,
    /// Multilevel nested dissection.
    NestedDissection,
    /// Nested dissection of cells by their places; minimum degree where the pattern knows no cells.
    CellDissection,
    /// The unknown to eliminate first, the next, and so on. It should be postordered (descendants in the
    /// elimination tree just before their ancestors), as nested dissection is, or supernodes stay small.
    Given(Vec<u32>),
}

/// An ordering that was computed, and the fill that it leads to, without unknowns that are to come last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// "minimum degree", "nested dissection", "dissection of cells" or "given".
    pub name: &'static str,
    /// Cost of a Cholesky factorisation in that order; none for a given order.
    pub fill: Option<Fill>,
}

/// An elimination order and how it was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Chosen {
    /// Unknowns in the order of their elimination.
    pub order: Vec<u32>,
    /// The orderings that were compared, the one that was taken first.
    pub candidates: Vec<Candidate>,
}

/// Multiplications that a factorisation carries out in twice the time in which nested dissection treats one entry of
/// the graph: it has to save half of them to pay. Measured: 0.35 µs per entry of a graph of 10⁶ entries, 1.3 µs where
/// it leaves the caches; 14 multiplications per ns.
const DISSECTION_COST: f64 = 36_000.0;

/// After a dissection of cells it rarely saves anything, and is tried where it costs a twentieth of the factorisation.
const BESIDE_CELLS: f64 = 10.0;

/// Blocks from which on a dissection of cells is first compared with minimum degree, the number of samples and the blocks of each: the
/// larger a mesh, the more a dissection gains.
const SAMPLED: usize = 1 << 15;
const SAMPLES: usize = 4;
const SAMPLE: usize = 1 << 12;
/// In the samples it may have so much more.
const NEARLY: f64 = 1.05;

impl Ordering {
    /// Unknowns in the order of their elimination.
    ///
    /// # Errors
    /// If a given order is not a permutation, or the pattern is too large or memory too small.
    pub fn elimination_order(&self, pattern: &SparsityPattern) -> Result<Vec<u32>, LinearAlgebraError> {
        Ok(self.choose(pattern)?.order)
    }

    /// The best ordering, with the orderings that were compared.
    ///
    /// # Errors
    /// As [`Ordering::elimination_order`].
    pub fn choose(&self, pattern: &SparsityPattern) -> Result<Chosen, LinearAlgebraError> {
        if let Self::Given(order) = self {
            check_size("the elimination order", pattern.rows(), order.len())?;
            inverse(order)?;
            let candidates = vec![Candidate { name: "given", fill: None }];
            return Ok(Chosen { order: order.clone(), candidates });
        }
        self.choose_with_last(pattern, &[])
    }

    /// An order that ends with some unknowns, ascending; the others are ordered as if these were not there.
    ///
    /// # Errors
    /// As [`Ordering::elimination_order`], and if an unknown is not one of the pattern's.
    pub fn choose_with_last(
        &self,
        pattern: &SparsityPattern,
        last: &[u32],
    ) -> Result<Chosen, LinearAlgebraError> {
        let threads = Threads::all();
        Ok(self.choose_on(threads, &BlockGraph::new(threads, pattern)?, pattern, last)?.0)
    }

    /// The same on some threads with the graph of the pattern, and with the runs of the whole blocks that the order begins with, where they
    /// are known.
    pub(super) fn choose_on(
        &self,
        threads: Threads,
        graph: &BlockGraph,
        pattern: &SparsityPattern,
        last: &[u32],
    ) -> Result<(Chosen, Option<Runs>), LinearAlgebraError> {
        if let (Self::Given(_), []) = (self, last) {
            return Ok((self.choose(pattern)?, None));
        }
        let size = pattern.rows();
        let mut is_last = vec![false; size];
        for &unknown in last {
            let Some(mark) = is_last.get_mut(unknown as usize) else {
                let what = "unknown to eliminate last";
                return Err(LinearAlgebraError::IndexOutOfRange { what, index: unknown as usize, size });
            };
            *mark = true;
        }
        // Blocks that are last only in part come between.
        let mixed = |block: &usize| is_last[graph.begins[*block]..graph.begins[*block + 1]].contains(&true);
        let kept: Vec<u32> =
            (0..graph.blocks()).filter(|block| !mixed(block)).map(|block| block as u32).collect();
        let mut places = vec![u32::MAX; graph.blocks()];
        kept.iter().zip(0..).for_each(|(block, place)| places[*block as usize] = place);
        let cells = pattern.cells().map(|cells| CellBlocks::new(cells, graph, &places));
        let restricted;
        let ordered = if last.is_empty() {
            graph
        } else {
            restricted = graph.restricted(&kept);
            &restricted
        };
        let (order, runs, candidates) = self.of_blocks(threads, ordered, cells.as_ref())?;
        let order: Vec<u32> = order.into_iter().map(|place| kept[place as usize]).collect();
        let mut unknowns = graph.unknowns_in(&order);
        for block in (0..graph.blocks()).filter(mixed) {
            let of_block = graph.begins[block]..graph.begins[block + 1];
            unknowns.extend(of_block.filter(|unknown| !is_last[*unknown]).map(|unknown| unknown as u32));
        }
        unknowns.extend_from_slice(last);
        Ok((Chosen { order: unknowns, candidates }, Some(runs)))
    }

    /// An order of the blocks of a graph, with its runs.
    fn of_blocks(
        &self,
        threads: Threads,
        graph: &BlockGraph,
        cells: Option<&CellBlocks>,
    ) -> Result<(Vec<u32>, Runs, Vec<Candidate>), LinearAlgebraError> {
        let measured = |name, order: Vec<u32>| -> Result<_, LinearAlgebraError> {
            let runs = Runs::of_blocks(graph, &order, &inverse(&order)?, threads);
            Ok((Candidate { name, fill: Some(runs.fill()) }, order, runs))
        };
        let mut found = Vec::new();
        let cells = cells.filter(|_| matches!(self, Self::LeastFill | Self::CellDissection));
        // Minimum degree is better where cells are small or lie in no order.
        let mut cells_are_enough = false;
        if let Some(cells) = cells {
            let order = dissect(graph, cells, threads);
            let (dissection, is_better) = threads.both(
                || measured("dissection of cells", order.clone()),
                || match self {
                    Self::CellDissection => Ok(true),
                    _ => is_better_in_samples(threads, graph, &order),
                },
            );
            found.push(dissection?);
            cells_are_enough = is_better?;
        }
        if *self != Self::NestedDissection && !cells_are_enough {
            found.push(measured("minimum degree", minimum_degree(graph)?)?);
        }
        let cost_of_trying = DISSECTION_COST
            * graph.neighbours.len() as f64
            * if cells.is_some() { BESIDE_CELLS } else { 1.0 };
        let worth_trying = |(candidate, ..): &(Candidate, Vec<u32>, Runs)| {
            candidate.fill.map_or(0.0, |fill| fill.multiplications) > cost_of_trying
        };
        let multilevel = *self == Self::LeastFill && found.iter().all(worth_trying);
        if *self == Self::NestedDissection || multilevel {
            found.push(measured("nested dissection", nested_dissection(graph)?)?);
        }
        let cost = |candidate: &Candidate| candidate.fill.map_or(f64::INFINITY, |fill| fill.multiplications);
        found.sort_by(|a, b| cost(&a.0).total_cmp(&cost(&b.0)));
        let candidates = found.iter().map(|(candidate, ..)| *candidate).collect();
        // At least one of them was computed.
        let (_, order, runs) = found.swap_remove(0);
        Ok((order, runs, candidates))
    }
}

/// Whether an order of a large graph leads to less fill than minimum degree in parts of it, each a run of the order by itself.
fn is_better_in_samples(
    threads: Threads,
    graph: &BlockGraph,
    order: &[u32],
) -> Result<bool, LinearAlgebraError> {
    if order.len() < SAMPLED {
        return Ok(false);
    }
    let multiplications = |part: &BlockGraph, order: &[u32]| -> Result<f64, LinearAlgebraError> {
        Ok(Runs::of_blocks(part, order, &inverse(order)?, Threads::ONE).fill().multiplications)
    };
    let of_sample = |first: usize| -> Result<[f64; 2], LinearAlgebraError> {
        let sample = &order[first..order.len().min(first + SAMPLE)];
        let mut kept = sample.to_vec();
        kept.sort_unstable();
        let part = graph.restricted(&kept);
        let numbers: Vec<u32> =
            sample.iter().map(|block| kept.partition_point(|other| other < block) as u32).collect();
        Ok([multiplications(&part, &numbers)?, multiplications(&part, &minimum_degree(&part)?)?])
    };
    let samples = (0..order.len()).step_by(order.len().div_ceil(SAMPLES)).collect();
    let found: Vec<[f64; 2]> = threads.run(samples, of_sample).into_iter().collect::<Result<_, _>>()?;
    let [own, by_degree] = [0, 1].map(|k| found.iter().map(|costs| costs[k]).sum::<f64>());
    Ok(own < NEARLY * by_degree)
}

/// The inverse of a permutation.
///
/// # Errors
/// If the list is not a permutation of 0..n.
pub(crate) fn inverse(order: &[u32]) -> Result<Vec<u32>, LinearAlgebraError> {
    let size = order.len();
    let mut result = vec![u32::MAX; size];
    for (position, &unknown) in order.iter().enumerate() {
        match result.get_mut(unknown as usize) {
            Some(slot) if *slot == u32::MAX => *slot = position as u32,
            // Out of range, or named twice (then some other unknown is missing).
            _ => {
                return Err(LinearAlgebraError::IndexOutOfRange {
                    what: "unknown of the elimination order",
                    index: unknown as usize,
                    size,
                });
            }
        }
    }
    Ok(result)
}

fn minimum_degree(graph: &BlockGraph) -> Result<Vec<u32>, LinearAlgebraError> {
    let blocks = graph.blocks();
    let matrix =
        SymbolicSparseColMatRef::new_checked(blocks, blocks, &graph.pointers, None, &graph.neighbours);
    let mut order = vec![0_u32; blocks];
    let mut positions = vec![0_u32; blocks];
    let scratch = amd::order_scratch::<u32>(blocks, graph.neighbours.len());
    let mut memory = MemBuffer::try_new(scratch).map_err(|_| NO_MEMORY)?;
    amd::order(&mut order, &mut positions, matrix, amd::Control::default(), MemStack::new(&mut memory))
        .map_err(|_| TOO_LARGE)?;
    Ok(order)
}

fn nested_dissection(graph: &BlockGraph) -> Result<Vec<u32>, LinearAlgebraError> {
    let signed = |list: &[u32]| -> Result<Vec<i32>, LinearAlgebraError> {
        list.iter().map(|&value| i32::try_from(value).map_err(|_| TOO_LARGE)).collect()
    };
    let (pointers, neighbours) = (signed(&graph.pointers)?, signed(&graph.neighbours)?);
    let pattern = CscPattern::new(graph.blocks(), &pointers, &neighbours).ok_or(TOO_LARGE)?;
    let order = feral_metis::metis_order(&pattern).map_err(|_| TOO_LARGE)?;
    let order: Vec<u32> = order.into_iter().map(|block| block as u32).collect();
    check_size("the nested dissection", graph.blocks(), order.len())?;
    inverse(&order)?;
    Ok(order)
}

const TOO_LARGE: LinearAlgebraError = LinearAlgebraError::TooLarge { what: "the graph to order" };
const NO_MEMORY: LinearAlgebraError = LinearAlgebraError::OutOfMemory { what: "the ordering" };

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CsrMatrix;

    /// A star of `leaves` nodes around node 0, two unknowns per node.
    fn star(leaves: usize) -> CsrMatrix {
        let mut triplets = Vec::new();
        for node in 0..=leaves {
            for other in [0, node] {
                for k in 0..4 {
                    triplets.push((2 * node + k / 2, 2 * other + k % 2, 1.0));
                    triplets.push((2 * other + k / 2, 2 * node + k % 2, 1.0));
                }
            }
        }
        CsrMatrix::from_triplets(2 * leaves + 2, 2 * leaves + 2, &triplets).unwrap()
    }

    #[test]
    fn the_centre_of_a_star_goes_last_and_nodes_stay_together() {
        let matrix = star(10);
        assert_eq!(BlockGraph::new(Threads::ONE, matrix.pattern()).unwrap().blocks(), 11);
        let order = Ordering::MinimumDegree.elimination_order(matrix.pattern()).unwrap();
        inverse(&order).unwrap();
        for pair in order.chunks(2) {
            assert_eq!((pair[0] % 2, pair[1]), (0, pair[0] + 1));
        }
        // The centre and the last leaf have the same degree at the end.
        let centre = order.iter().position(|&unknown| unknown == 0).unwrap();
        assert!(centre >= 18, "the centre was eliminated at {centre}");
    }

    #[test]
    fn some_unknowns_come_last() {
        let matrix = grid(6);
        // Both unknowns of a node, one of another.
        let last = [20, 21, 101];
        for ordering in [Ordering::LeastFill, Ordering::NestedDissection] {
            let order = ordering.choose_with_last(matrix.pattern(), &last).unwrap().order;
            inverse(&order).unwrap();
            assert_eq!(order[429..], last);
            assert_eq!(order[428], 100);
        }
        assert!(Ordering::LeastFill.choose_with_last(matrix.pattern(), &[432]).is_err());
        let none = Ordering::LeastFill.choose_with_last(matrix.pattern(), &[]).unwrap();
        assert_eq!(none, Ordering::LeastFill.choose(matrix.pattern()).unwrap());
    }

    #[test]
    fn a_given_order_must_be_a_permutation() {
        let matrix = star(1);
        let order = |list: &[u32]| Ordering::Given(list.to_vec()).elimination_order(matrix.pattern());
        assert_eq!(order(&[3, 1, 0, 2]).unwrap(), [3, 1, 0, 2]);
        assert!(order(&[3, 1, 0, 1]).is_err());
        assert!(order(&[4, 1, 0, 2]).is_err());
        assert!(order(&[1, 0, 2]).is_err());
    }

    /// The seven-point stencil on m × m × m nodes, two unknowns per node.
    fn grid(m: usize) -> CsrMatrix {
        let mut triplets = Vec::new();
        for node in 0..m * m * m {
            let mut couple = |other: usize| {
                for k in 0..4 {
                    triplets.push((2 * node + k / 2, 2 * other + k % 2, 1.0));
                    triplets.push((2 * other + k / 2, 2 * node + k % 2, 1.0));
                }
            };
            couple(node);
            for step in [1, m, m * m] {
                if (node / step) % m + 1 < m {
                    couple(node + step);
                }
            }
        }
        CsrMatrix::from_triplets(2 * m * m * m, 2 * m * m * m, &triplets).unwrap()
    }

    #[test]
    fn the_ordering_of_least_fill_is_taken() {
        let matrix = grid(28);
        let chosen = Ordering::LeastFill.choose(matrix.pattern()).unwrap();
        inverse(&chosen.order).unwrap();
        assert_eq!(chosen.candidates.len(), 2, "in 3D both are tried");
        let fill = |name: &str| {
            let one = chosen.candidates.iter().find(|candidate| candidate.name == name).unwrap();
            one.fill.unwrap().multiplications
        };
        let (degree, dissection) = (fill("minimum degree"), fill("nested dissection"));
        assert_eq!(chosen.candidates[0].fill.unwrap().multiplications, degree.min(dissection));
        // The top separator alone is a dense triangle of about 2 m² unknowns.
        assert!(dissection > (2.0 * 28.0 * 28.0_f64).powi(3) / 6.0);
        let best = if dissection < degree { Ordering::NestedDissection } else { Ordering::MinimumDegree };
        assert_eq!(chosen.order, best.elimination_order(matrix.pattern()).unwrap());
        // A chain is not worth a dissection.
        let chain: Vec<_> = (0..50).flat_map(|i: usize| [(i, i, 1.0), (i, (i + 1).min(49), 1.0)]).collect();
        let chain = CsrMatrix::from_triplets(50, 50, &chain).unwrap().symmetric_part().unwrap();
        assert_eq!(Ordering::LeastFill.choose(chain.pattern()).unwrap().candidates.len(), 1);
    }

    #[test]
    fn nested_dissection_keeps_nodes_together() {
        let matrix = grid(8);
        let order = Ordering::NestedDissection.elimination_order(matrix.pattern()).unwrap();
        inverse(&order).unwrap();
        assert!(order.chunks(2).all(|pair| pair[0] % 2 == 0 && pair[1] == pair[0] + 1));
    }

    #[test]
    fn an_empty_pattern_has_an_empty_order() {
        let empty = CsrMatrix::from_triplets(0, 0, &[]).unwrap();
        for ordering in [Ordering::LeastFill, Ordering::MinimumDegree, Ordering::NestedDissection] {
            assert!(ordering.elimination_order(empty.pattern()).unwrap().is_empty());
        }
    }
}

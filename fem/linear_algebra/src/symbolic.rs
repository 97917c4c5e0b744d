//! Fill of a Cholesky factor from the graph of blocks alone: elimination tree, column counts and supernodes.
//!
//! Unknowns of a block have the same neighbours. Of those that follow each other in an order of elimination, a run, each is the
//! parent of the one before it, and has one entry less in its column of the factor: tree and counts are found run by run.

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::SymbolicSupernodalParams;
use faer::sparse::linalg::cholesky::simplicial;
use faer::sparse::linalg::cholesky::supernodal::{self, SymbolicSupernodalCholesky};

use super::block_graph::BlockGraph;
use super::error::LinearAlgebraError;
use super::threads::Threads;

const NO_MEMORY: LinearAlgebraError = LinearAlgebraError::OutOfMemory { what: "the symbolic analysis" };
const TOO_LARGE: LinearAlgebraError = LinearAlgebraError::TooLarge { what: "the factor" };

/// Cost of a Cholesky factor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fill {
    /// Entries of the factor that are not zero by its structure.
    pub entries: f64,
    /// Multiplications of the factorisation.
    pub multiplications: f64,
}

impl Fill {
    /// From the number of entries of each column, the diagonal included.
    pub(super) fn of_counts(counts: impl Iterator<Item = f64>) -> Self {
        counts.fold(Fill::default(), |sum, count| Fill {
            entries: sum.entries + count,
            multiplications: sum.multiplications + 0.5 * count * (count + 3.0),
        })
    }
}

/// Marks that there is no run.
const NONE: u32 = u32::MAX;
/// Rows of the factor that a thread counts one after the other: neighbours climb the tree along the same path.
const ROWS: usize = 64;
/// Most threads that count, each in memory of its own.
const MOST_PARTS: usize = 16;

/// Runs of unknowns of one block each that follow each other in an order of elimination, with their elimination tree.
pub(super) struct Runs {
    /// First place of each run, and the number of places at the end.
    begins: Vec<u32>,
    /// Starts of each run's earlier ones.
    pointers: Vec<u32>,
    /// The earlier runs that each is coupled with.
    earlier: Vec<u32>,
    tree: Vec<Node>,
}

/// A run in the elimination tree.
struct Node {
    parent: u32,
    /// The last run from which the tree was climbed through this one.
    seen: u32,
    /// Entries of its first column of the factor, the diagonal included.
    count: u32,
}

impl Runs {
    /// Without runs yet, with room for those of a graph's blocks; each block is its own neighbour.
    fn with_room(graph: &BlockGraph) -> Self {
        let couplings = graph.neighbours.len().saturating_sub(graph.blocks()) / 2;
        let [mut begins, mut pointers, earlier] =
            [graph.blocks() + 1, graph.blocks() + 1, couplings].map(Vec::with_capacity);
        begins.push(0);
        pointers.push(0);
        Runs { begins, pointers, earlier, tree: Vec::with_capacity(graph.blocks()) }
    }

    /// Runs of whole blocks in the given order, the same on any number of threads.
    pub(super) fn of_blocks(graph: &BlockGraph, order: &[u32], place: &[u32], threads: Threads) -> Self {
        let mut runs = Runs::with_room(graph);
        let near = |run: u32, block: u32| {
            let near = graph.row(block as usize).iter().map(|other| place[*other as usize]);
            near.filter(move |other| *other < run)
        };
        if threads.for_work(graph.neighbours.len()) == 1 {
            for (run, &block) in (0..).zip(order) {
                runs.add(graph.size(block as usize) as u32, near(run, block));
            }
            return runs;
        }
        for (run, &block) in (0..).zip(order) {
            runs.earlier.extend(near(run, block));
            runs.pointers.push(runs.earlier.len() as u32);
            runs.begins.push(runs.begins[run as usize] + graph.size(block as usize) as u32);
        }
        let parents = runs.parents();
        let counts = runs.counts(&parents, threads);
        runs.tree.extend(parents.into_iter().zip(counts).map(|(parent, count)| Node {
            parent,
            seen: NONE,
            count,
        }));
        runs
    }

    /// The parent of each run in the elimination tree, by paths to roots that are shortened on the way (Liu 1990).
    fn parents(&self) -> Vec<u32> {
        let count = self.pointers.len() - 1;
        let (mut parents, mut ancestors) = (vec![NONE; count], vec![NONE; count]);
        for run in 0..count {
            for near in self.earlier(run) {
                let mut node = *near as usize;
                while node != run {
                    let next = std::mem::replace(&mut ancestors[node], run as u32);
                    if next == NONE {
                        parents[node] = run as u32;
                        break;
                    }
                    node = next as usize;
                }
            }
        }
        parents
    }

    /// Entries of each run's first column. Runs are rows of the factor, which threads share: each climbs the tree from the earlier runs that its
    /// rows are coupled with, up to the row.
    fn counts(&self, parents: &[u32], threads: Threads) -> Vec<u32> {
        let (count, parts) = (parents.len(), threads.count().min(MOST_PARTS));
        let width = |run: usize| self.begins[run + 1] - self.begins[run];
        let of_part = |part: usize| {
            let (mut counts, mut seen) = (vec![0_u32; count], vec![NONE; count]);
            for first in (part * ROWS..count).step_by(parts * ROWS) {
                for run in first..count.min(first + ROWS) {
                    seen[run] = run as u32;
                    counts[run] += width(run);
                    for near in self.earlier(run) {
                        let mut node = *near as usize;
                        while seen[node] != run as u32 {
                            seen[node] = run as u32;
                            counts[node] += width(run);
                            node = parents[node] as usize;
                        }
                    }
                }
            }
            counts
        };
        let mut found = threads.run((0..parts).collect(), of_part).into_iter();
        let mut counts = found.next().unwrap_or_default();
        for other in found {
            counts.iter_mut().zip(other).for_each(|(sum, count)| *sum += count);
        }
        counts
    }

    /// Unknowns in some order. Runs of whole blocks that it begins with may be known.
    pub(super) fn of_unknowns(graph: &BlockGraph, order: &[u32], known: Option<Runs>) -> Self {
        let mut runs = known.unwrap_or_else(|| Runs::with_room(graph));
        let mut block_of = vec![0_u32; order.len()];
        for (block, ends) in (0..).zip(graph.begins.windows(2)) {
            block_of[ends[0]..ends[1]].fill(block);
        }
        // The first and the last run of each block, and the next one of the same block.
        let (mut first, mut last) = (vec![NONE; graph.blocks()], vec![NONE; graph.blocks()]);
        let mut next = vec![];
        let mut rest = order;
        while let Some(unknown) = rest.first() {
            let (run, block) = (next.len() as u32, block_of[*unknown as usize]);
            let width = rest.iter().take_while(|other| block_of[**other as usize] == block).count();
            if next.len() == runs.tree.len() {
                let is_known = |run: u32| (run != NONE).then_some(run);
                let later = |run: &u32| is_known(next[*run as usize]);
                let of_block = |other: &u32| std::iter::successors(is_known(first[*other as usize]), later);
                runs.add(width as u32, graph.row(block as usize).iter().flat_map(of_block));
            }
            match std::mem::replace(&mut last[block as usize], run) {
                NONE => first[block as usize] = run,
                before => next[before as usize] = run,
            }
            next.push(NONE);
            rest = &rest[width..];
        }
        runs
    }

    /// Adds a run of the given number of unknowns with the earlier ones that it is coupled with: from each of them the tree is climbed up to the
    /// run itself (Liu 1990).
    fn add(&mut self, width: u32, earlier: impl Iterator<Item = u32>) {
        let run = self.tree.len() as u32;
        self.tree.push(Node { parent: NONE, seen: run, count: width });
        for near in earlier {
            self.earlier.push(near);
            let mut node = &mut self.tree[near as usize];
            while node.seen != run {
                node.seen = run;
                node.count += width;
                if node.parent == NONE {
                    node.parent = run;
                }
                let parent = node.parent as usize;
                node = &mut self.tree[parent];
            }
        }
        self.pointers.push(self.earlier.len() as u32);
        self.begins.push(self.begins[run as usize] + width);
    }

    fn earlier(&self, run: usize) -> &[u32] {
        &self.earlier[self.pointers[run] as usize..self.pointers[run + 1] as usize]
    }

    /// The fill, without the zeros inside supernodes.
    pub(super) fn fill(&self) -> Fill {
        Fill::of_counts(self.columns().map(f64::from))
    }

    /// Entries of each column of the factor.
    fn columns(&self) -> impl Iterator<Item = u32> {
        self.tree
            .iter()
            .zip(self.begins.windows(2))
            .flat_map(|(node, ends)| (0..ends[1] - ends[0]).map(|k| node.count - k))
    }

    /// Supernodes of the factor, and its fill without the zeros inside supernodes.
    pub(super) fn supernodes(self) -> Result<(SymbolicSupernodalCholesky<u32>, Fill), LinearAlgebraError> {
        let size = self.begins[self.tree.len()] as usize;
        let counts: Vec<u32> = self.columns().collect();
        let fill = Fill::of_counts(counts.iter().map(|count| f64::from(*count)));
        // faer reads a tree from a matrix: this one couples each unknown with its parent alone.
        let mut parents: Vec<u32> = (1..=size as u32).collect();
        for (node, ends) in self.tree.iter().zip(self.begins.windows(2)) {
            let parent = self.begins.get(node.parent as usize).filter(|_| node.parent != NONE);
            parents[ends[1] as usize - 1] = parent.map_or(NONE, |parent| *parent);
        }
        let (pointers, children) = children_of(&parents);
        let coupled = SymbolicSparseColMatRef::new_checked(size, size, &pointers, None, &children);
        let scratch = StackReq::or(
            simplicial::prefactorize_symbolic_cholesky_scratch::<u32>(size, children.len()),
            supernodal::factorize_supernodal_symbolic_cholesky_scratch::<u32>(size),
        );
        let mut memory = MemBuffer::try_new(scratch).map_err(|_| NO_MEMORY)?;
        let stack = MemStack::new(&mut memory);
        let (mut parents, mut ignored) = (vec![0_i32; size], vec![0_u32; size]);
        let parents = simplicial::prefactorize_symbolic_cholesky(&mut parents, &mut ignored, coupled, stack);
        let (pointers, rows) = self.skeleton();
        drop(self);
        let upper = SymbolicSparseColMatRef::new_unsorted_checked(size, size, &pointers, None, &rows);
        let params = SymbolicSupernodalParams::default();
        let stack = MemStack::new(&mut memory);
        let found =
            supernodal::factorize_supernodal_symbolic_cholesky(upper, parents, &counts, stack, params);
        Ok((found.map_err(|_| TOO_LARGE)?, fill))
    }

    /// The upper triangle by columns of a matrix of all unknowns that has the same factor: of each earlier run the first unknown
    /// is enough, which passes its neighbours on to the others.
    fn skeleton(&self) -> (Vec<u32>, Vec<u32>) {
        let of_run =
            |(run, ends): (usize, &[u32])| (ends[1] - ends[0]) as usize * (self.earlier(run).len() + 1);
        let entries = self.begins.windows(2).enumerate().map(of_run).sum();
        let (mut pointers, mut rows) = (vec![0_u32], Vec::with_capacity(entries));
        for (run, ends) in self.begins.windows(2).enumerate() {
            for place in ends[0]..ends[1] {
                rows.extend(self.earlier(run).iter().map(|earlier| self.begins[*earlier as usize]));
                rows.extend((place > ends[0]).then_some(ends[0]));
                pointers.push(rows.len() as u32);
            }
        }
        (pointers, rows)
    }
}

/// The children of each unknown by their parents, ascending, and where those of each begin.
fn children_of(parents: &[u32]) -> (Vec<u32>, Vec<u32>) {
    let mut pointers = vec![0_u32; parents.len() + 2];
    let known = || (0..).zip(parents).filter(|(_, parent)| **parent != NONE);
    known().for_each(|(_, parent)| pointers[*parent as usize + 2] += 1);
    for k in 2..pointers.len() {
        pointers[k] += pointers[k - 1];
    }
    let mut children = vec![0_u32; known().count()];
    for (child, parent) in known() {
        let next = &mut pointers[*parent as usize + 1];
        children[*next as usize] = child;
        *next += 1;
    }
    pointers.pop();
    (pointers, children)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::sync::Arc;

    use super::*;
    use crate::{Analysis, CsrMatrix, Ordering, SparsityPattern};

    /// Nodes of one, two and three unknowns on a path with some shortcuts.
    fn nodes() -> Arc<SparsityPattern> {
        let begins: Vec<usize> = (0..=40).map(|node| 2 * node + [0, 0, 1][node % 3]).collect();
        let mut triplets = vec![];
        for node in 0..40_usize {
            for other in [node, (node + 1).min(39), (7 * node + 3) % 40] {
                for (i, j) in (begins[node]..begins[node + 1])
                    .flat_map(|i| (begins[other]..begins[other + 1]).map(move |j| (i, j)))
                {
                    triplets.extend([(i, j, 1.0), (j, i, 1.0)]);
                }
            }
        }
        CsrMatrix::from_triplets(begins[40], begins[40], &triplets).unwrap().pattern().clone()
    }

    /// The columns of the factor, by elimination of one unknown after the other from sets of neighbours.
    fn eliminated(pattern: &SparsityPattern, order: &[u32]) -> Vec<BTreeSet<u32>> {
        let place = crate::ordering::inverse(order).unwrap();
        let later = |at: usize, unknown: &u32| Some(place[*unknown as usize]).filter(|p| *p as usize > at);
        let mut columns: Vec<BTreeSet<u32>> = (0..order.len())
            .map(|at| pattern.row(order[at] as usize).iter().filter_map(|u| later(at, u)).collect())
            .collect();
        for at in 0..order.len() {
            if let Some(&parent) = columns[at].first() {
                let rest: Vec<u32> = columns[at].iter().skip(1).copied().collect();
                columns[parent as usize].extend(rest);
            }
        }
        columns
    }

    #[test]
    fn columns_are_those_of_elimination() {
        let pattern = nodes();
        let size = pattern.rows() as u32;
        // Nodes as they come; their unknowns apart from each other; all out of order.
        let odd_first = (1..size).step_by(2).chain((0..size).step_by(2)).collect();
        let shuffled = (0..size).map(|k| (k * 29 + 11) % size).collect();
        for ordering in [
            Ordering::MinimumDegree,
            Ordering::Given((0..size).rev().collect()),
            Ordering::Given(odd_first),
            Ordering::Given(shuffled),
        ] {
            let analysis = Analysis::new(&pattern, &ordering).unwrap();
            let columns = eliminated(&pattern, analysis.elimination_order());
            assert_eq!(analysis.fill(), Fill::of_counts(columns.iter().map(|c| c.len() as f64 + 1.0)));
            let supernodes = &analysis.supernodes;
            for s in 0..supernodes.n_supernodes() {
                let (begin, end) = (supernodes.supernode_begin()[s], supernodes.supernode_end()[s]);
                let rows = supernodes.supernode(s).pattern();
                // Those of its last column, which hold those of all others.
                assert!(rows.iter().eq(&columns[end as usize - 1]), "{ordering:?}, supernode {s}");
                for column in begin..end {
                    let held = |row: &u32| *row < end || rows.contains(row);
                    assert!(columns[column as usize].iter().all(held));
                }
            }
        }
    }

    #[test]
    fn tree_and_counts_are_the_same_on_any_number_of_threads() {
        // Nine-point stencils on a strip and a patch that are not coupled, in an odd order.
        let (mut triplets, size) = (vec![], 9000_usize);
        let widths = [(0, 4000, 10), (4000, size, 100)];
        for (begin, end, width) in widths {
            for node in begin..end {
                for step in [0, 1, width - 1, width, width + 1].into_iter().filter(|step| node + step < end) {
                    triplets.extend([(node, node + step, 1.0), (node + step, node, 1.0)]);
                }
            }
        }
        let matrix = CsrMatrix::from_triplets(size, size, &triplets).unwrap();
        let order: Vec<u32> = (0..size as u32).map(|k| (k * 4001 + 17) % size as u32).collect();
        let place = crate::ordering::inverse(&order).unwrap();
        let found = |threads: Threads| {
            let graph = BlockGraph::new(threads, matrix.pattern()).unwrap();
            let runs = Runs::of_blocks(&graph, &order, &place, threads);
            let tree: Vec<_> = runs.tree.iter().map(|node| (node.parent, node.count)).collect();
            (graph.begins, graph.pointers, graph.neighbours, runs.begins, runs.pointers, runs.earlier, tree)
        };
        let one = found(Threads::ONE);
        assert!(one.2.len() > 1 << 15 && one.6.iter().any(|(parent, _)| *parent == NONE));
        for threads in [2, 3, 7, 16, 100] {
            assert!(found(Threads::new(threads)) == one, "{threads} threads");
        }
    }
}

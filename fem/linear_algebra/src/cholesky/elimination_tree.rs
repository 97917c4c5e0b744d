//! The elimination tree of supernodes: parents, an order that bounds the memory of updates, and parts for threads.

use std::ops::Range;

use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;

/// A supernode without a parent has this one.
const NONE: u32 = u32::MAX;

/// Whose updates each supernode takes, and in which order supernodes can be eliminated.
#[derive(Debug)]
pub(super) struct EliminationTree {
    /// The children of supernode s, ascending, are `children[starts[s]..starts[s + 1]]`.
    starts: Vec<u32>,
    children: Vec<u32>,
    /// A postorder: each subtree is a run that ends with its root.
    order: Vec<u32>,
    /// Number of supernodes of each subtree.
    sizes: Vec<u32>,
    /// Multiplications of each subtree, and of all.
    work: Vec<f64>,
    total_work: f64,
}

impl EliminationTree {
    /// The tree of a symbolic factor, whose parents come after their children.
    pub(super) fn new(supernodes: &SymbolicSupernodalCholesky<u32>) -> Self {
        let count = supernodes.n_supernodes();
        let ends = supernodes.supernode_end();
        let mut parents = vec![NONE; count];
        let mut starts = vec![0_u32; count + 1];
        let (mut sizes, mut work) = (vec![1_u32; count], vec![0.0; count]);
        // Numbers that are kept until the parent has them, and the most that a subtree needs at once.
        let mut total_work = 0.0;
        let (mut kept, mut peak) = (vec![0.0_f64; count], vec![0.0_f64; count]);
        for s in 0..count {
            let node = supernodes.supernode(s);
            let (own, below) = ((ends[s] as usize - node.start()) as f64, node.pattern().len() as f64);
            let here = own * (own * own / 6.0 + own * below / 2.0 + below * below / 2.0);
            work[s] += here;
            total_work += here;
            kept[s] = below * below;
            if let Some(&first) = node.pattern().first() {
                let parent = ends.partition_point(|end| *end <= first);
                parents[s] = parent as u32;
                starts[parent + 1] += 1;
                sizes[parent] += sizes[s];
                work[parent] += work[s];
            }
        }
        for s in 0..count {
            starts[s + 1] += starts[s];
        }
        let mut next = starts.clone();
        let mut children = vec![0; starts[count] as usize];
        for (s, &parent) in parents.iter().enumerate().filter(|(_, parent)| **parent != NONE) {
            children[next[parent as usize] as usize] = s as u32;
            next[parent as usize] += 1;
        }
        let mut tree =
            EliminationTree { starts, children, order: Vec::with_capacity(count), sizes, work, total_work };
        // Children in the order of Liu (1986): the one whose memory shrinks most goes first.
        let mut by_memory = tree.children.clone();
        for s in 0..count {
            let own = &mut by_memory[tree.starts[s] as usize..tree.starts[s + 1] as usize];
            let shrinks = |child: &u32| peak[*child as usize] - kept[*child as usize];
            own.sort_by(|a, b| shrinks(b).total_cmp(&shrinks(a)).then(a.cmp(b)));
            let mut before = 0.0;
            for &child in own.iter() {
                peak[s] = peak[s].max(before + peak[child as usize]);
                before += kept[child as usize];
            }
            peak[s] = peak[s].max(before + kept[s]);
        }
        let roots = (0..count as u32).rev().filter(|s| parents[*s as usize] == NONE);
        let mut pending: Vec<(u32, bool)> = roots.map(|root| (root, false)).collect();
        while let Some((s, open)) = pending.pop() {
            if open {
                tree.order.push(s);
                continue;
            }
            pending.push((s, true));
            let own = &by_memory[tree.starts[s as usize] as usize..tree.starts[s as usize + 1] as usize];
            pending.extend(own.iter().rev().map(|child| (*child, false)));
        }
        tree
    }

    /// The children of a supernode, ascending.
    pub(super) fn children(&self, supernode: usize) -> &[u32] {
        &self.children[self.starts[supernode] as usize..self.starts[supernode + 1] as usize]
    }

    /// Supernodes from the leaves to the roots.
    pub(super) fn order(&self) -> &[u32] {
        &self.order
    }

    /// Subtrees of at most a part of the whole work, as runs of the order, those of most work first; and the supernodes above
    /// them, from below to the top.
    pub(super) fn parts(&self, part: f64) -> (Vec<Range<usize>>, Vec<u32>) {
        let limit = part * self.total_work;
        let (mut subtrees, mut above) = (Vec::new(), Vec::new());
        // From the end, the root of a run comes before what the run holds.
        let mut position = self.order.len();
        while position > 0 {
            let s = self.order[position - 1] as usize;
            if self.work[s] <= limit {
                subtrees.push(position - self.sizes[s] as usize..position);
                position -= self.sizes[s] as usize;
            } else {
                above.push(s as u32);
                position -= 1;
            }
        }
        above.reverse();
        let work = |run: &Range<usize>| self.work[self.order[run.end - 1] as usize];
        subtrees.sort_by(|a, b| work(b).total_cmp(&work(a)).then(a.start.cmp(&b.start)));
        (subtrees, above)
    }
}

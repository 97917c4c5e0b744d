//! Units of an elimination tree, their costs and tasks.

use std::ops::Range;

use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;

use super::{MOVED, OVERHEAD, PANEL, Task, Unit, Updates};
use crate::task_graph::TaskGraph;

/// A subtree with less than this part of the whole cost is not cut.
const SHARE: f64 = 1.0 / 512.0;
/// Nor is one of this cost: a task of about a tenth of a millisecond \[multiplications\].
const LEAST: f64 = 1e6;

/// Supernodes with their dependences and costs.
pub(super) struct Tree<'a> {
    symbolic: &'a SymbolicSupernodalCholesky<u32>,
    /// The first supernode that each depends on, over others too.
    first: Vec<u32>,
    /// The supernode above each, and their number for a root.
    parents: Vec<u32>,
    /// Cost of all before each, and of all at the end.
    cost: Vec<f64>,
}

impl<'a> Tree<'a> {
    pub(super) fn new(symbolic: &'a SymbolicSupernodalCholesky<u32>, updates: &Updates) -> Self {
        let count = symbolic.n_supernodes();
        let (mut first, mut cost) = (Vec::with_capacity(count), vec![0.0]);
        let ends = symbolic.supernode_end();
        let mut tree = Tree { symbolic, first: vec![], parents: Vec::with_capacity(count), cost: vec![] };
        let mut sum = 0.0;
        for s in 0..count {
            sum += OVERHEAD + tree.triangle(s, tree.width(s));
            let mut earliest = s as u32;
            for update in updates.of(s) {
                let earlier = update.supernode as usize;
                earliest = earliest.min(first[earlier]);
                let rows = symbolic.supernode(earlier).pattern().len() - update.first as usize;
                sum += tree.product(earlier, rows, update.count as usize);
            }
            let parent = symbolic.supernode(s).pattern().first();
            tree.parents.push(parent.map_or(count as u32, |row| {
                // The first that ends behind the row.
                ends.partition_point(|end| end <= row) as u32
            }));
            first.push(earliest);
            cost.push(sum);
        }
        (tree.first, tree.cost) = (first, cost);
        tree
    }

    fn width(&self, s: usize) -> usize {
        (self.symbolic.supernode_end()[s] - self.symbolic.supernode_begin()[s]) as usize
    }

    /// Cost of the factorisation of a block of a supernode's first columns.
    fn triangle(&self, s: usize, width: usize) -> f64 {
        let below = (self.symbolic.supernode(s).pattern().len() + self.width(s) - width) as f64;
        let width = width as f64;
        0.5 * width * width * (width / 3.0 + below)
    }

    /// Cost of a product of the last rows of a supernode with some of them.
    fn product(&self, earlier: usize, rows: usize, count: usize) -> f64 {
        let moved = count as f64 * (rows as f64 - 0.5 * count as f64);
        OVERHEAD + moved * (MOVED + self.width(earlier) as f64)
    }

    /// Entries of a supernode.
    pub(super) fn entries(&self, s: usize) -> f64 {
        let (width, below) = (self.width(s) as f64, self.symbolic.supernode(s).pattern().len() as f64);
        width * (0.5 * (width + 1.0) + below)
    }

    fn cost_of(&self, range: &Range<usize>) -> f64 {
        self.cost[range.end] - self.cost[range.start]
    }

    /// The ranges that are left of one without its last supernode and depend on nothing outside. Neighbours of little cost stay together.
    fn cut(&self, range: &Range<usize>, limit: f64) -> Vec<Range<usize>> {
        let mut found: Vec<Range<usize>> = vec![];
        let mut end = range.end - 1;
        while end > range.start {
            let mut at = end - 1;
            let mut first = self.first[at] as usize;
            while at > first {
                at -= 1;
                first = first.min(self.first[at] as usize);
            }
            match found.last_mut() {
                Some(later) if self.cost_of(&(first..later.end)) < limit => later.start = first,
                _ => found.push(first..end),
            }
            end = first;
        }
        found
    }

    /// All units, ascending. Where the tree is in an order in which subtrees are not ranges, there is one.
    pub(super) fn units(&self) -> Vec<Unit> {
        let count = self.first.len();
        let ranges = match count {
            0 => vec![],
            _ => self.ranges(),
        };
        let mut unit_of = vec![0_u32; count];
        for (number, range) in (0..).zip(&ranges) {
            unit_of[range.clone()].fill(number);
        }
        let mut units = Vec::with_capacity(ranges.len());
        for range in ranges {
            let Ok(parent) = self.parent(&range, &unit_of) else {
                let supernodes = 0..count;
                return vec![Unit { supernodes, parent: None, panels: 0, outer: vec![] }];
            };
            let is_wide = range.len() == 1 && self.width(range.start) > PANEL && self.cost_of(&range) > LEAST;
            let panels = if is_wide { self.width(range.start).div_ceil(PANEL) } else { 0 };
            units.push(Unit { outer: self.outer(&range), supernodes: range, parent, panels });
        }
        units
    }

    /// Ranges of supernodes: subtrees of little cost, and what is above them, chains of little cost together.
    fn ranges(&self) -> Vec<Range<usize>> {
        let count = self.first.len();
        let limit = (SHARE * self.cost[count]).max(LEAST);
        let mut found = vec![];
        let mut rest = Vec::with_capacity(64);
        rest.push(0..count);
        while let Some(range) = rest.pop() {
            if self.cost_of(&range) <= limit {
                found.push(range);
                continue;
            }
            // Above a single subtree there is a chain.
            let (mut chain, mut below) = (range.end..range.end, range);
            loop {
                let last = below.end - 1;
                if !chain.is_empty()
                    && (self.width(last) > PANEL
                        || self.width(chain.end - 1) > PANEL
                        || self.cost_of(&(last..chain.end)) > 0.25 * limit)
                {
                    rest.push(below);
                    break;
                }
                chain.start = last;
                let mut parts = self.cut(&below, limit);
                match (parts.pop(), parts.is_empty()) {
                    (Some(part), true) if self.cost_of(&part) > limit => below = part,
                    (Some(part), _) => {
                        rest.push(part);
                        rest.extend(parts);
                        break;
                    }
                    (None, _) => break,
                }
            }
            found.push(chain);
        }
        found.sort_unstable_by_key(|range| range.start);
        found
    }

    /// The one unit above a range; an error if there are several.
    fn parent(&self, range: &Range<usize>, unit_of: &[u32]) -> Result<Option<u32>, ()> {
        let mut found = None;
        for s in range.clone() {
            let parent = self.parents[s] as usize;
            if parent >= range.end && parent < unit_of.len() {
                let unit = unit_of[parent];
                if found.is_some_and(|other| other != unit) {
                    return Err(());
                }
                found = Some(unit);
            }
        }
        Ok(found)
    }

    /// The rows below a range: those of the roots in it.
    fn outer(&self, range: &Range<usize>) -> Vec<u32> {
        let roots = range.clone().filter(|s| self.parents[*s] as usize >= range.end);
        let mut rows: Vec<u32> =
            roots.flat_map(|s| self.symbolic.supernode(s).pattern().iter().copied()).collect();
        rows.sort_unstable();
        rows.dedup();
        rows
    }

    /// The tasks of a factorisation in units.
    pub(super) fn tasks(&self, units: &[Unit], updates: &Updates) -> (Vec<Task>, TaskGraph) {
        let (mut tasks, mut costs, mut edges) = (vec![], vec![], vec![]);
        // Tasks after which a unit is known, and those that its parent has to do then.
        let mut waiting: Vec<Vec<u32>> = vec![vec![]; units.len()];
        for (number, unit) in units.iter().enumerate() {
            let before = std::mem::take(&mut waiting[number]);
            let next = tasks.len() as u32;
            edges.extend(before.into_iter().map(|before| (before, next)));
            let name = number as u32;
            if unit.panels == 0 {
                tasks.push(Task::Range(name));
                costs.push(self.cost_of(&unit.supernodes));
            } else {
                tasks.push(Task::Open(name));
                costs.push(0.0);
                self.panels(name, unit, updates, (&mut tasks, &mut costs, &mut edges));
            }
            if let Some(parent) = unit.parent {
                waiting[parent as usize].push(tasks.len() as u32 - 1);
            }
        }
        let graph = TaskGraph::new(costs, &edges);
        (tasks, graph)
    }

    /// The tasks of a wide supernode's panels, the last panel's last one at the end.
    fn panels(
        &self,
        name: u32,
        unit: &Unit,
        updates: &Updates,
        (tasks, costs, edges): (&mut Vec<Task>, &mut Vec<f64>, &mut Vec<(u32, u32)>),
    ) {
        let (s, opened) = (unit.supernodes.start, tasks.len() as u32 - 1);
        let (width, begin) = (self.width(s), self.symbolic.supernode_begin()[s]);
        let height = width + self.symbolic.supernode(s).pattern().len();
        let mut gathered = vec![0.0; unit.panels];
        for update in updates.of(s) {
            let earlier = update.supernode as usize;
            let rows = &self.symbolic.supernode(earlier).pattern()[update.first as usize..];
            let mut done = 0;
            while done < update.count as usize {
                let panel = (rows[done] - begin) as usize / PANEL;
                let end = begin + ((panel + 1) * PANEL) as u32;
                let count = rows[done..update.count as usize].partition_point(|row| *row < end);
                gathered[panel] += self.product(earlier, rows.len() - done, count);
                done += count;
            }
        }
        let columns = |panel: usize| PANEL.min(width - panel * PANEL);
        let factored = |panel: usize| {
            let (columns, below) = (columns(panel) as f64, (height - panel * PANEL - columns(panel)) as f64);
            OVERHEAD + 0.5 * columns * columns * (columns / 3.0 + below)
        };
        let mut last_of_panel: Vec<u32> = vec![];
        for (panel, gathered) in gathered.into_iter().enumerate() {
            edges.push((opened, tasks.len() as u32));
            tasks.push(Task::Gather(name, panel as u32));
            costs.push(gathered + if panel == 0 { factored(0) } else { 0.0 });
            let rows = (height - panel * PANEL) as f64 - 0.5 * columns(panel) as f64;
            for (earlier, last) in last_of_panel.iter().enumerate() {
                let own = tasks.len() as u32;
                edges.extend([(own - 1, own), (*last, own)]);
                tasks.push(Task::Take(name, panel as u32, earlier as u32));
                let is_last = earlier + 1 == panel;
                let taken = columns(panel) as f64 * rows * PANEL as f64;
                costs.push(taken + if is_last { factored(panel) } else { 0.0 });
            }
            last_of_panel.push(tasks.len() as u32 - 1);
        }
    }
}

//! Groups of unknowns to eliminate, and which of them a pattern lets be eliminated.

use crate::error::LinearAlgebraError;
use crate::pattern::SparsityPattern;

/// Marks an unknown of no group.
pub(super) const NONE: u32 = u32::MAX;

/// Groups of unknowns, as those that live in one cell each, with a rank: where unknowns of two groups are coupled, those of the higher
/// rank are not eliminated, and neither of both if their ranks are equal. They are hints: what a matrix does not allow is
/// not eliminated.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Groups {
    /// End of each group's unknowns.
    ends: Vec<usize>,
    ranks: Vec<u8>,
    unknowns: Vec<u32>,
    multipliers: Vec<MultiplierNode>,
}

/// Multipliers at a node, with the unknowns on which they act, as a displacement there. [`BlockElimination`](super::BlockElimination) does not read them:
/// they are eliminated by the equations of these unknowns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MultiplierNode {
    /// Those of all multipliers of the node, and of what is defined with them.
    pub unknowns: Vec<u32>,
    /// The unknowns on which they act.
    pub balances: Vec<u32>,
}

impl Groups {
    /// One more node with multipliers.
    pub fn add_multipliers(&mut self, node: MultiplierNode) {
        self.multipliers.push(node);
    }

    /// The nodes with multipliers.
    pub fn multipliers(&self) -> &[MultiplierNode] {
        &self.multipliers
    }

    /// One more group with its rank. Unknowns that are in an earlier group stay there.
    pub fn add(&mut self, rank: u8, unknowns: impl IntoIterator<Item = u32>) {
        self.unknowns.extend(unknowns);
        if self.ends.last().copied().unwrap_or(0) < self.unknowns.len() {
            self.ends.push(self.unknowns.len());
            self.ranks.push(rank);
        }
    }

    /// Whether there are no groups.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty() && self.multipliers.is_empty()
    }

    /// The groups all of whose unknowns meet a condition.
    pub fn where_all(&self, holds: impl Fn(usize) -> bool) -> Groups {
        let mut groups = Groups::default();
        for group in 0..self.ends.len() {
            let unknowns = self.of(group);
            if unknowns.iter().all(|unknown| holds(*unknown as usize)) {
                groups.add(self.ranks[group], unknowns.iter().copied());
            }
        }
        groups
    }

    fn of(&self, group: usize) -> &[u32] {
        let start = if group == 0 { 0 } else { self.ends[group - 1] };
        &self.unknowns[start..self.ends[group]]
    }
}

/// Numbers of local unknowns that are eliminated, and of those that are not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Those that are eliminated.
    pub eliminated: usize,
    /// Counts because an entry couples them with another group.
    pub coupled: usize,
    /// Counts because a pivot of their group is below 1e-10 of its scale.
    pub by_pivots: usize,
}

impl std::fmt::Display for Counts {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} local unknowns eliminated", self.eliminated)?;
        if self.coupled > 0 {
            write!(f, ", {} kept because an entry couples them with other cells", self.coupled)?;
        }
        if self.by_pivots > 0 {
            write!(f, ", {} kept because a pivot is below 1e-10 of its scale", self.by_pivots)?;
        }
        Ok(())
    }
}

/// Groups that a pattern lets be eliminated, and what they are coupled with.
#[derive(Debug)]
pub(super) struct Plan {
    /// The group of each unknown.
    pub(super) owner: Vec<u32>,
    /// The number of each unknown in its group, or among the remaining ones.
    pub(super) number: Vec<u32>,
    pub(super) rest: Vec<u32>,
    pub(super) members: Vec<u32>,
    ends: Vec<usize>,
    /// Numbers of the remaining unknowns in whose rows, and in whose columns, a group has entries, ascending.
    rows: Lists,
    columns: Lists,
}

/// Lists of numbers, one after the other.
#[derive(Debug, Default)]
struct Lists {
    ends: Vec<usize>,
    numbers: Vec<u32>,
}

impl Lists {
    fn of(&self, list: usize) -> &[u32] {
        let start = if list == 0 { 0 } else { self.ends[list - 1] };
        &self.numbers[start..self.ends[list]]
    }
}

impl Plan {
    /// The plan without unknowns that are refused, and the number of unknowns that couplings keep.
    pub(super) fn new(pattern: &SparsityPattern, groups: &Groups, refused: &[bool]) -> (Self, usize) {
        let size = pattern.rows();
        let mut owner = vec![NONE; size];
        for group in 0..groups.ends.len() {
            for &unknown in groups.of(group).iter().filter(|unknown| (**unknown as usize) < size) {
                let own = &mut owner[unknown as usize];
                if *own == NONE && !refused[unknown as usize] {
                    *own = group as u32;
                }
            }
        }
        let coupled = release_coupled(pattern, &groups.ranks, &mut owner);
        let (members, ends) = components(pattern, &mut owner);
        let mut number = vec![0; size];
        let rest: Vec<u32> = (0..size as u32).filter(|unknown| owner[*unknown as usize] == NONE).collect();
        (0..).zip(&rest).for_each(|(place, unknown)| number[*unknown as usize] = place);
        let mut start = 0;
        for end in &ends {
            (0..).zip(&members[start..*end]).for_each(|(place, unknown)| number[*unknown as usize] = place);
            start = *end;
        }
        let mut plan =
            Plan { owner, number, rest, members, ends, rows: Lists::default(), columns: Lists::default() };
        for group in 0..plan.count() {
            let entries = plan.members_of(group).iter().flat_map(|member| pattern.row(*member as usize));
            let outside = entries.filter(|unknown| plan.owner[**unknown as usize] == NONE);
            let mut own: Vec<u32> = outside.map(|unknown| plan.number[*unknown as usize]).collect();
            own.sort_unstable();
            own.dedup();
            plan.columns.numbers.extend(own);
            plan.columns.ends.push(plan.columns.numbers.len());
        }
        plan.rows = plan.rows_of_groups(pattern);
        (plan, coupled)
    }

    /// Rows come in ascending order, so those of a group need no sorting.
    fn rows_of_groups(&self, pattern: &SparsityPattern) -> Lists {
        let mut last = vec![NONE; self.count()];
        let mut visit = |each: &mut dyn FnMut(usize, u32)| {
            last.fill(NONE);
            for (row, unknown) in (0..).zip(&self.rest) {
                for other in pattern.row(*unknown as usize) {
                    let group = self.owner[*other as usize];
                    if group != NONE && last[group as usize] != row {
                        last[group as usize] = row;
                        each(group as usize, row);
                    }
                }
            }
        };
        let mut ends = vec![0; self.count()];
        visit(&mut |group, _| ends[group] += 1);
        let mut next = Vec::with_capacity(ends.len());
        let mut sum = 0;
        for end in &mut ends {
            next.push(sum);
            sum += *end;
            *end = sum;
        }
        let mut numbers = vec![0; sum];
        visit(&mut |group, row| {
            numbers[next[group]] = row;
            next[group] += 1;
        });
        Lists { ends, numbers }
    }

    pub(super) fn count(&self) -> usize {
        self.ends.len()
    }

    pub(super) fn members_of(&self, group: usize) -> &[u32] {
        let start = if group == 0 { 0 } else { self.ends[group - 1] };
        &self.members[start..self.ends[group]]
    }

    pub(super) fn rows_of(&self, group: usize) -> &[u32] {
        self.rows.of(group)
    }

    pub(super) fn columns_of(&self, group: usize) -> &[u32] {
        self.columns.of(group)
    }

    /// The pattern of what is left.
    pub(super) fn pattern_of_rest(
        &self,
        pattern: &SparsityPattern,
    ) -> Result<SparsityPattern, LinearAlgebraError> {
        let (mut pointers, mut indices) = (vec![0], vec![]);
        let (mut seen, mut seen_groups) = (vec![NONE; self.rest.len()], vec![NONE; self.count()]);
        for (row, unknown) in (0..).zip(&self.rest) {
            let start = indices.len();
            let mut add = |column: u32, indices: &mut Vec<u32>| {
                if seen[column as usize] != row {
                    seen[column as usize] = row;
                    indices.push(column);
                }
            };
            for other in pattern.row(*unknown as usize) {
                let group = self.owner[*other as usize];
                if group == NONE {
                    add(self.number[*other as usize], &mut indices);
                } else if seen_groups[group as usize] != row {
                    seen_groups[group as usize] = row;
                    self.columns_of(group as usize).iter().for_each(|column| add(*column, &mut indices));
                }
            }
            indices[start..].sort_unstable();
            pointers.push(indices.len());
        }
        let cells = pattern.cells().map(|cells| {
            cells.renumbered(|unknown, visit| {
                if self.owner[unknown as usize] == NONE {
                    visit(self.number[unknown as usize]);
                }
            })
        });
        let size = self.rest.len();
        SparsityPattern::new(size, size, pointers, indices)?.with_cells(cells.map(std::sync::Arc::new))
    }
}

/// Takes unknowns out of their groups that entries couple with other groups; their number.
fn release_coupled(pattern: &SparsityPattern, ranks: &[u8], owner: &mut [u32]) -> usize {
    let mut released = vec![false; owner.len()];
    let highest = ranks.iter().copied().max().unwrap_or(0);
    // What a lower rank has left decides on the higher ones.
    for rank in 0..=highest {
        for row in 0..owner.len() {
            for column in pattern.row(row) {
                let column = *column as usize;
                let (a, b) = (owner[row], owner[column]);
                if a == b || a == NONE || b == NONE || released[row] && released[column] {
                    continue;
                }
                let (first, second) = (ranks[a as usize], ranks[b as usize]);
                let is_decided = |first: u8, second: u8| first == rank && second <= rank;
                if is_decided(first, second) && !(second < first && released[column]) {
                    released[row] = true;
                }
                if is_decided(second, first) && !(first < second && released[row]) {
                    released[column] = true;
                }
            }
        }
    }
    for (own, _) in owner.iter_mut().zip(&released).filter(|(_, released)| **released) {
        *own = NONE;
    }
    released.iter().filter(|released| **released).count()
}

/// Cuts groups into parts that are not coupled with each other. Members of all of them, and the ends of each.
fn components(pattern: &SparsityPattern, owner: &mut [u32]) -> (Vec<u32>, Vec<usize>) {
    let size = owner.len();
    let mut parent: Vec<u32> = (0..size as u32).collect();
    fn root(parent: &mut [u32], mut unknown: u32) -> u32 {
        while parent[unknown as usize] != unknown {
            parent[unknown as usize] = parent[parent[unknown as usize] as usize];
            unknown = parent[unknown as usize];
        }
        unknown
    }
    for row in (0..size).filter(|row| owner[*row] != NONE) {
        for column in pattern.row(row) {
            if owner[*column as usize] == owner[row] {
                let (a, b) = (root(&mut parent, row as u32), root(&mut parent, *column));
                // The first unknown leads.
                parent[a.max(b) as usize] = a.min(b);
            }
        }
    }
    let mut numbers = vec![NONE; size];
    let mut sizes: Vec<usize> = vec![];
    for (unknown, own) in owner.iter_mut().enumerate().filter(|(_, own)| **own != NONE) {
        let leader = root(&mut parent, unknown as u32) as usize;
        if numbers[leader] == NONE {
            numbers[leader] = sizes.len() as u32;
            sizes.push(0);
        }
        *own = numbers[leader];
        sizes[numbers[leader] as usize] += 1;
    }
    let mut next = Vec::with_capacity(sizes.len());
    let mut ends = sizes;
    let mut sum = 0;
    for end in &mut ends {
        next.push(sum);
        sum += *end;
        *end = sum;
    }
    let mut members = vec![0; sum];
    for unknown in (0..size).filter(|unknown| owner[*unknown] != NONE) {
        let place = &mut next[owner[unknown] as usize];
        members[*place] = unknown as u32;
        *place += 1;
    }
    (members, ends)
}

//! The supernodes that a supernode depends on.

use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;

/// Rows of an earlier supernode that are columns of a later one.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Update {
    pub(crate) supernode: u32,
    /// The first of them among the rows below the earlier one's triangle.
    pub(crate) first: u32,
    pub(crate) count: u32,
}

/// For each supernode those before it that have rows in it, ascending.
#[derive(Debug)]
pub(crate) struct Updates {
    /// With two numbers more than there are supernodes.
    ends: Vec<u32>,
    all: Vec<Update>,
}

impl Updates {
    pub(crate) fn new(symbolic: &SymbolicSupernodalCholesky<u32>) -> Self {
        let count = symbolic.n_supernodes();
        let ends_of_columns = symbolic.supernode_end();
        let mut holders = vec![0_u32; symbolic.nrows()];
        let mut begin = 0;
        for (number, end) in (0..).zip(ends_of_columns) {
            holders[begin..*end as usize].fill(number);
            begin = *end as usize;
        }
        let visit = |each: &mut dyn FnMut(usize, Update)| {
            for supernode in 0..count {
                let rows = symbolic.supernode(supernode).pattern();
                let mut first = 0;
                while first < rows.len() {
                    let holder = holders[rows[first] as usize] as usize;
                    let end = ends_of_columns[holder];
                    let held = rows[first..].iter().take_while(|row| **row < end).count();
                    let update =
                        Update { supernode: supernode as u32, first: first as u32, count: held as u32 };
                    each(holder, update);
                    first += held;
                }
            }
        };
        let mut ends = vec![0_u32; count + 2];
        visit(&mut |holder, _| ends[holder + 2] += 1);
        for k in 2..ends.len() {
            ends[k] += ends[k - 1];
        }
        let mut all = vec![Update::default(); ends[count + 1] as usize];
        visit(&mut |holder, update| {
            let next = &mut ends[holder + 1];
            all[*next as usize] = update;
            *next += 1;
        });
        Updates { ends, all }
    }

    /// Of no supernodes.
    pub(crate) fn none() -> Self {
        Updates { ends: vec![], all: vec![] }
    }

    pub(crate) fn of(&self, supernode: usize) -> &[Update] {
        &self.all[self.ends[supernode] as usize..self.ends[supernode + 1] as usize]
    }
}

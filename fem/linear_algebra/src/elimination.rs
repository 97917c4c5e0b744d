//! Elimination as tasks for threads: units of the elimination tree, panels of wide supernodes, and their counted costs.
//!
//! A unit is a range of supernodes that one thread treats one after the other, or one wide supernode, whose panels are tasks of their own. Units
//! follow from the costs and from nothing else. Each waits for the units below it in the tree.

mod units;
mod updates;

use std::ops::Range;

use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;

use self::units::Tree;
pub(crate) use self::updates::Updates;
use crate::task_graph::TaskGraph;

/// Columns of a panel.
pub(crate) const PANEL: usize = 64;
/// Cost of a product of rows relative to that of its entries \[multiplications\].
const OVERHEAD: f64 = 500.0;
/// Cost of an entry of a product relative to its multiplications \[multiplications\].
const MOVED: f64 = 8.0;
/// Cost of a supernode in a triangular solve next to that of its entries \[multiplications\].
const VISITED: f64 = 64.0;

/// A part of the elimination that comes after the units below it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Unit {
    pub(crate) supernodes: Range<usize>,
    /// The unit above.
    pub(crate) parent: Option<u32>,
    /// Panels of a supernode that is a unit by itself; zero for a range of supernodes.
    pub(crate) panels: usize,
    /// Rows of the factor below the unit's columns, ascending.
    pub(crate) outer: Vec<u32>,
}

/// A task of a factorisation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Task {
    /// All supernodes of a unit.
    Range(u32),
    /// Memory of a wide supernode's unit is cut into panels.
    Open(u32),
    /// What earlier supernodes take from a panel, and its factorisation if it is the first.
    Gather(u32, u32),
    /// What an earlier panel of its supernode takes from a panel, and its factorisation if that is the last one before it.
    Take(u32, u32, u32),
}

/// The units with their tasks.
#[derive(Debug)]
pub(crate) struct Elimination {
    pub(crate) updates: Updates,
    pub(crate) units: Vec<Unit>,
    /// Unit of each supernode.
    pub(crate) unit_of: Vec<u32>,
    pub(crate) tasks: Vec<Task>,
    pub(crate) factorisation: TaskGraph,
    /// One task for each unit.
    pub(crate) forward: TaskGraph,
    /// One task for each unit, the last unit first.
    pub(crate) backward: TaskGraph,
}

impl Elimination {
    pub(crate) fn new(symbolic: &SymbolicSupernodalCholesky<u32>) -> Self {
        let updates = Updates::new(symbolic);
        let tree = Tree::new(symbolic, &updates);
        let units = tree.units();
        let mut unit_of = vec![0_u32; symbolic.n_supernodes()];
        for (number, unit) in (0..).zip(&units) {
            unit_of[unit.supernodes.clone()].fill(number);
        }
        let (tasks, factorisation) = tree.tasks(&units, &updates);
        let solved = |unit: &Unit| unit.supernodes.clone().map(|s| tree.entries(s) + VISITED).sum::<f64>();
        let costs: Vec<f64> = units.iter().map(solved).collect();
        let last = (units.len() as u32).saturating_sub(1);
        let up = (0..).zip(&units).filter_map(|(number, unit)| Some((number, unit.parent?)));
        let (up, down): (Vec<_>, Vec<_>) = up.map(|(a, b)| ((a, b), (last - b, last - a))).unzip();
        let backward = TaskGraph::new(costs.iter().rev().copied().collect(), &down);
        Elimination {
            updates,
            unit_of,
            tasks,
            factorisation,
            forward: TaskGraph::new(costs, &up),
            backward,
            units,
        }
    }

    /// The part that solves need.
    pub(crate) fn for_solves(self) -> Self {
        let factorisation = TaskGraph::default();
        Elimination { updates: Updates::none(), unit_of: vec![], tasks: vec![], factorisation, ..self }
    }
}

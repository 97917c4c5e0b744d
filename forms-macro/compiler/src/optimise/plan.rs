//! A plan: which products of factors a node pair accumulates, and what the block is in terms of the sums. What its
//! functions cost is counted in the instructions that are emitted.

use super::collect::collected;
use super::elements::StandardElement;
use super::linear::{Coefficients, of_component};
use super::scalar::{Argument, Graph, Node, Scalar};
use super::straight_line::{Code, Level, Value};

/// Plans for the blocks of a bilinear integral.
#[derive(Clone, Debug, Default)]
pub struct BilinearPlan {
    /// Factors of a test node, free of the weight.
    pub tests: Vec<Scalar>,
    /// Factors of a trial node, which hold the weight.
    pub trials: Vec<Scalar>,
    /// Per accumulated sum: the products (test factor, trial factor) that a point adds to it.
    pub sums: Vec<Vec<(usize, usize)>>,
    /// Row-major block in terms of [`Node::Accumulated`]; its other terminals are constant on the cell.
    pub block: Vec<Scalar>,
}

/// Operations of one call of each function, as `contract::Operations`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Operations {
    pub point: usize,
    pub test: usize,
    pub trial: usize,
    pub pair: usize,
    pub finish: usize,
}

impl Operations {
    /// Operations of the direct loops on an element with a number of points.
    pub fn on(&self, element: &StandardElement, points: usize, symmetric: bool) -> usize {
        let nodes = element.nodes;
        let pairs = if symmetric { nodes * (nodes + 1) / 2 } else { nodes * nodes };
        points * (self.point + nodes * (self.test + self.trial) + pairs * self.pair) + pairs * self.finish
    }
}

impl BilinearPlan {
    /// A new sum; its index.
    pub fn add_sum(&mut self) -> usize {
        self.sums.push(vec![]);
        self.sums.len() - 1
    }

    /// Adds a product to a sum.
    pub fn add(&mut self, sum: usize, test: Scalar, trial: Scalar) {
        let test = position(&mut self.tests, test);
        let trial = position(&mut self.trials, trial);
        self.sums[sum].push((test, trial));
    }

    /// Cost of the kernel's functions.
    pub fn operations(&self, graph: &Graph) -> Operations {
        let roots: Vec<Scalar> = self.roots().copied().collect();
        let mut code = Code::new(graph, &roots);
        let mut lower =
            |list: &[Scalar]| -> Vec<Value> { list.iter().map(|scalar| code.lower(*scalar)).collect() };
        let lists = [&self.tests, &self.trials, &self.block].map(|list| lower(list));
        let own = lists.each_ref().map(|roots| code.own(roots, Level::Node));
        let [test, trial, finish] = own.each_ref().map(|own| code.operations(own));
        let asked = [0, 1].map(|side| code.asked(&lists[side], &own[side]));
        let point = code.operations(&code.own(&asked.concat(), Level::Point));
        Operations { point, test, trial, pair: self.sums.iter().map(Vec::len).sum(), finish }
    }

    /// The same with common factors taken out, where that does not take too much work.
    pub fn collected(&self, graph: &mut Graph) -> Option<Self> {
        let roots: Vec<Scalar> = self.roots().copied().collect();
        let changed = collected(graph, &roots)?;
        let (tests, rest) = changed.split_at(self.tests.len());
        let (trials, block) = rest.split_at(self.trials.len());
        Some(BilinearPlan {
            tests: tests.to_vec(),
            trials: trials.to_vec(),
            sums: self.sums.clone(),
            block: block.to_vec(),
        })
    }

    /// All scalars that are computed.
    pub fn roots(&self) -> impl Iterator<Item = &Scalar> {
        self.tests.iter().chain(&self.trials).chain(&self.block)
    }
}

fn position(list: &mut Vec<Scalar>, scalar: Scalar) -> usize {
    list.iter().position(|known| *known == scalar).unwrap_or_else(|| {
        list.push(scalar);
        list.len() - 1
    })
}

/// A linear expression applied to φ e_a, times a factor, for each component a; `None` where it vanishes.
pub fn on_basis(
    graph: &mut Graph,
    coefficients: &Coefficients,
    components: usize,
    argument: Argument,
    factor: Scalar,
) -> Vec<Option<Scalar>> {
    (0..components)
        .map(|component| {
            let mut parts = Vec::new();
            for (derivative, coefficient) in of_component(coefficients, component) {
                let basis = graph.intern(Node::Basis(argument, derivative));
                parts.push(graph.product(&[(factor, 1), (coefficient, 1), (basis, 1)]));
            }
            (!parts.is_empty()).then(|| graph.sum(&parts))
        })
        .collect()
}

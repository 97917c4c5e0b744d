//! Reachability among scalars: operands, all nodes below, and which nodes hold a terminal.

use super::scalar::{Graph, Node, Scalar};

impl Graph {
    /// The nodes that a node is made of.
    pub fn operands(&self, scalar: Scalar) -> Vec<Scalar> {
        let mut operands = Vec::new();
        self.each_operand(scalar, |operand| operands.push(operand));
        operands
    }

    /// Hands over the nodes that a node is made of.
    fn each_operand(&self, scalar: Scalar, take: impl FnMut(Scalar)) {
        self.each_operand_of(self.node(scalar), take);
    }

    /// Hands over the operands of a node that need not be in the graph yet.
    pub fn each_operand_of(&self, node: &Node, mut take: impl FnMut(Scalar)) {
        match node {
            Node::Sum { terms, .. } => terms.iter().for_each(|(_, term)| take(*term)),
            Node::Product(factors) => factors.iter().for_each(|(factor, _)| take(*factor)),
            Node::Apply(_, a) | Node::Not(a) => take(*a),
            Node::Power(a, b)
            | Node::Atan2(a, b)
            | Node::Minimum(a, b)
            | Node::Maximum(a, b)
            | Node::Less(a, b)
            | Node::LessEqual(a, b)
            | Node::Equal(a, b)
            | Node::And(a, b)
            | Node::Or(a, b) => [a, b].into_iter().for_each(|operand| take(*operand)),
            Node::Select(truth, a, b) => [truth, a, b].into_iter().for_each(|operand| take(*operand)),
            Node::External { inputs, .. } => inputs.iter().for_each(|input| take(*input)),
            _ => {}
        }
    }

    /// Every node that `roots` are made of, operands first.
    pub fn reachable(&self, roots: &[Scalar]) -> Vec<Scalar> {
        let mut seen = vec![false; roots.iter().map(|root| root.0 as usize + 1).max().unwrap_or(0)];
        let mut pending = roots.to_vec();
        let mut found = Vec::new();
        while let Some(scalar) = pending.pop() {
            if !std::mem::replace(&mut seen[scalar.0 as usize], true) {
                found.push(scalar);
                self.each_operand(scalar, |operand| pending.push(operand));
            }
        }
        self.count_work(found.len());
        // Operands are older than what is made of them.
        found.sort_unstable();
        found
    }

    /// Does the expression hold a node elsewhere than below another one?
    pub fn reaches(&self, root: Scalar, node: Scalar, other: Scalar) -> bool {
        let mut seen = vec![false; root.0 as usize + 1];
        let mut pending = vec![root];
        while let Some(scalar) = pending.pop() {
            // Operands are older than what is made of them.
            if scalar < node || scalar == other || std::mem::replace(&mut seen[scalar.0 as usize], true) {
                continue;
            }
            if scalar == node {
                return true;
            }
            self.count_work(1);
            self.each_operand(scalar, |operand| pending.push(operand));
        }
        false
    }

    /// Does the expression hold a terminal for which `test` is true?
    pub fn depends(&self, root: Scalar, test: impl Fn(&Node) -> bool) -> bool {
        let mut seen = vec![false; root.0 as usize + 1];
        let mut pending = vec![root];
        while let Some(scalar) = pending.pop() {
            if !std::mem::replace(&mut seen[scalar.0 as usize], true) {
                if test(self.node(scalar)) {
                    return true;
                }
                self.each_operand(scalar, |operand| pending.push(operand));
            }
        }
        false
    }

    /// Is the expression proved to be zero where the terminals are for which `test` is true, and all else is a number?
    pub fn vanishes_with(&self, root: Scalar, test: impl Fn(&Node) -> bool) -> bool {
        let mut vanishes = vec![false; root.0 as usize + 1];
        for scalar in self.reachable(&[root]) {
            let of = |operand: &Scalar| vanishes[operand.0 as usize];
            vanishes[scalar.0 as usize] = match self.node(scalar) {
                Node::Number(bits) => f64::from_bits(*bits) == 0.0,
                Node::Sum { constant, terms } => {
                    f64::from_bits(*constant) == 0.0 && terms.iter().all(|(_, term)| of(term))
                }
                Node::Product(factors) => {
                    let divides = |(factor, exponent): &(Scalar, i32)| *exponent < 0 && of(factor);
                    let vanishes = |(factor, exponent): &(Scalar, i32)| *exponent > 0 && of(factor);
                    factors.iter().any(vanishes) && !factors.iter().any(divides)
                }
                Node::Select(_, a, b) => of(a) && of(b),
                node => test(node),
            };
        }
        vanishes[root.0 as usize]
    }

    /// Which nodes below `roots` hold a terminal for which `test` is true. Nothing is said of the graph's other nodes: a
    /// function has many integrals, and each has a few of them.
    pub fn mark(&self, roots: &[Scalar], test: impl Fn(&Node) -> bool) -> Marks {
        self.mark_if(roots, |scalar| test(self.node(scalar)))
    }

    /// Which nodes below `root` hold a node, or are it.
    pub fn mark_above(&self, root: Scalar, node: Scalar) -> Marks {
        self.mark_if(&[root], |scalar| scalar == node)
    }

    /// For each node below `roots`, in order, how many terminals it holds for which `test` is true.
    pub fn terminals(&self, roots: &[Scalar], test: impl Fn(&Node) -> bool) -> Vec<usize> {
        let nodes = self.reachable(roots);
        let count = nodes.iter().filter(|scalar| test(self.node(**scalar))).count();
        // Sets of terminals, as bits: what two operands have in common counts once.
        let words = count.div_ceil(64);
        let mut place = vec![0; nodes.last().map_or(0, |last| last.0 as usize + 1)];
        let mut sets = vec![0_u64; nodes.len() * words];
        let mut terminals = 0;
        for (index, &scalar) in nodes.iter().enumerate() {
            place[scalar.0 as usize] = index;
            let (below, from_here) = sets.split_at_mut(index * words);
            if test(self.node(scalar)) {
                from_here[terminals / 64] |= 1 << (terminals % 64);
                terminals += 1;
            }
            self.each_operand(scalar, |operand| {
                let start = place[operand.0 as usize] * words;
                for (own, other) in from_here.iter_mut().zip(&below[start..start + words]) {
                    *own |= other;
                }
            });
        }
        self.count_work(sets.len());
        let size = |set: &[u64]| set.iter().map(|word| word.count_ones() as usize).sum();
        if words == 0 { vec![0; nodes.len()] } else { sets.chunks(words).map(size).collect() }
    }

    fn mark_if(&self, roots: &[Scalar], test: impl Fn(Scalar) -> bool) -> Marks {
        let nodes = self.reachable(roots);
        let mut marked = vec![false; nodes.last().map_or(0, |last| last.0 as usize + 1)];
        for &scalar in &nodes {
            let mut mark = test(scalar);
            self.each_operand(scalar, |operand| mark |= marked[operand.0 as usize]);
            marked[scalar.0 as usize] = mark;
        }
        Marks { nodes, marked }
    }
}

/// The nodes below some roots, some of them marked.
pub struct Marks {
    nodes: Vec<Scalar>,
    /// By number of the node.
    marked: Vec<bool>,
}

impl Marks {
    /// Is the node marked? Those that are not below the roots never are.
    pub fn holds(&self, scalar: Scalar) -> bool {
        self.marked.get(scalar.0 as usize).copied().unwrap_or(false)
    }

    /// The nodes below the roots, operands first.
    pub fn nodes(&self) -> &[Scalar] {
        &self.nodes
    }
}

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

    /// Which nodes hold a terminal for which `test` is true: operands come before what is made of them.
    pub fn mark(&self, test: impl Fn(&Node) -> bool) -> Vec<bool> {
        let mut marks = vec![false; self.len()];
        self.count_work(self.len());
        for index in 0..self.len() {
            let mut mark = test(self.node(Scalar(index as u32)));
            self.each_operand(Scalar(index as u32), |operand| mark |= marks[operand.0 as usize]);
            marks[index] = mark;
        }
        marks
    }

    /// Which nodes hold a node, or are it.
    pub fn mark_above(&self, node: Scalar) -> Vec<bool> {
        let mut marks = vec![false; self.len()];
        marks[node.0 as usize] = true;
        self.count_work(self.len() - node.0 as usize);
        for index in node.0 as usize + 1..self.len() {
            let mut mark = false;
            self.each_operand(Scalar(index as u32), |operand| mark |= marks[operand.0 as usize]);
            marks[index] = mark;
        }
        marks
    }
}

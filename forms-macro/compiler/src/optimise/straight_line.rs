//! Scalars → instructions with at most three operands, each at the earliest level where its operands
//! exist.

mod instruction;

use super::hashing::Map;
use super::scalar::{Argument, Graph, Node, Scalar};
use crate::sorted::{SortedMap, SortedSet};
use crate::tensor::{External, Geometry};
pub use instruction::{Instruction, Level, Value};

/// A function at some inputs, and the order of the derivative.
type CallKey = (External, Vec<Scalar>, usize);

/// The instructions of one kernel.
pub struct Code<'a> {
    pub graph: &'a Graph,
    pub instructions: Vec<(Instruction, Level)>,
    interned: Map<Instruction, Value>,
    /// By number of the scalar.
    lowered: Vec<Option<Value>>,
    /// Number of parents of each scalar in this kernel.
    uses: Vec<u32>,
    /// In how many products each scalar divides.
    divides: Vec<u32>,
    /// All derivatives of one order that the kernel needs of a function at some inputs: one call gives them.
    calls: Map<CallKey, SortedSet<Vec<usize>>>,
}

impl<'a> Code<'a> {
    pub fn new(graph: &'a Graph, roots: &[Scalar]) -> Self {
        let count = roots.iter().map(|root| root.0 as usize + 1).max().unwrap_or(0);
        let (mut uses, mut divides) = (vec![0; count], vec![0; count]);
        let mut calls: Map<CallKey, SortedSet<Vec<usize>>> = Map::default();
        for scalar in graph.reachable(roots) {
            if let Node::External { function, inputs, derivative, .. } = graph.node(scalar) {
                let key = (*function, inputs.clone(), derivative.len());
                calls.entry(key).or_default().insert(derivative.clone());
            }
            if let Node::Product(factors) = graph.node(scalar) {
                for (factor, _) in factors.iter().filter(|(_, exponent)| *exponent < 0) {
                    divides[factor.0 as usize] += 1;
                }
            }
            for operand in graph.operands(scalar) {
                uses[operand.0 as usize] += 1;
            }
        }
        for root in roots {
            uses[root.0 as usize] += 1;
        }
        Code {
            graph,
            instructions: vec![],
            interned: Map::default(),
            lowered: vec![None; count],
            uses,
            divides,
            calls,
        }
    }

    /// Does any instruction read a table?
    pub fn reads_tables(&self) -> bool {
        let table = |instruction: &Instruction| {
            matches!(instruction, Instruction::Call { function: External::Table(_), .. })
        };
        self.instructions.iter().any(|(instruction, _)| table(instruction))
    }

    fn push(&mut self, instruction: Instruction) -> Value {
        if let Some(known) = self.interned.get(&instruction) {
            return *known;
        }
        let level = match &instruction {
            Instruction::Number(_) => Level::Form,
            Instruction::Terminal(scalar) => terminal_level(self.graph.node(*scalar)),
            other => other.operands().iter().map(|operand| self.level(*operand)).max().unwrap_or(Level::Form),
        };
        self.instructions.push((instruction.clone(), level));
        let value = Value(self.instructions.len() as u32 - 1);
        self.interned.insert(instruction, value);
        value
    }

    pub fn level(&self, value: Value) -> Level {
        self.instructions[value.0 as usize].1
    }

    pub fn instruction(&self, value: Value) -> &Instruction {
        &self.instructions[value.0 as usize].0
    }

    fn number(&mut self, value: f64) -> Value {
        self.push(Instruction::Number((value + 0.0).to_bits()))
    }

    /// The nodes that the function of a level computes itself for these results, operands first.
    pub fn own(&self, roots: &[Value], level: Level) -> Vec<Value> {
        let mut own: Vec<Value> = Vec::new();
        let mut pending: Vec<Value> = roots.to_vec();
        let mut seen = vec![false; self.instructions.len()];
        while let Some(value) = pending.pop() {
            if std::mem::replace(&mut seen[value.0 as usize], true) {
                continue;
            }
            let instruction = self.instruction(value);
            if self.level(value) == level || instruction.is_truth() {
                own.push(value);
                pending.extend(instruction.operands());
            }
        }
        own.sort_unstable();
        own
    }

    /// The number of these instructions that cost anything.
    pub fn operations(&self, values: &[Value]) -> usize {
        values.iter().filter(|value| self.instruction(**value).is_operation()).count()
    }

    /// Operations of everything that was lowered.
    pub fn all_operations(&self) -> usize {
        self.instructions.iter().filter(|(instruction, _)| instruction.is_operation()).count()
    }

    /// The values of earlier levels that a function asks for, given what it computes itself.
    pub fn asked(&self, roots: &[Value], own: &[Value]) -> Vec<Value> {
        let operands = own.iter().flat_map(|value| self.instruction(*value).operands());
        let mut asked: Vec<Value> = operands.chain(roots.iter().copied()).collect();
        asked.sort_unstable();
        asked.dedup();
        asked.retain(|value| {
            let number = matches!(self.instruction(*value), Instruction::Number(_));
            !number && own.binary_search(value).is_err()
        });
        asked
    }

    /// The instruction that computes a scalar.
    pub fn lower(&mut self, scalar: Scalar) -> Value {
        if let Some(known) = self.lowered[scalar.0 as usize] {
            return known;
        }
        let value = match self.graph.node(scalar).clone() {
            Node::Number(bits) => self.push(Instruction::Number(bits)),
            Node::Sum { constant, terms } => self.lower_sum(f64::from_bits(constant), &terms),
            Node::Product(factors) => match self.lower_product(&factors) {
                (None, last) => last,
                (Some(head), last) => self.push(Instruction::Multiply(head, last)),
            },
            Node::Apply(function, a) => {
                let a = self.lower(a);
                self.push(Instruction::Apply(function, a))
            }
            Node::Power(a, b) => self.lower_pair(a, b, Instruction::Power),
            Node::Atan2(a, b) => self.lower_pair(a, b, Instruction::Atan2),
            Node::Minimum(a, b) => self.lower_pair(a, b, Instruction::Minimum),
            Node::Maximum(a, b) => self.lower_pair(a, b, Instruction::Maximum),
            Node::Less(a, b) => self.lower_pair(a, b, Instruction::Less),
            Node::LessEqual(a, b) => self.lower_pair(a, b, Instruction::LessEqual),
            Node::Equal(a, b) => self.lower_pair(a, b, Instruction::Equal),
            Node::And(a, b) => self.lower_pair(a, b, Instruction::And),
            Node::Or(a, b) => self.lower_pair(a, b, Instruction::Or),
            Node::Not(a) => {
                let a = self.lower(a);
                self.push(Instruction::Not(a))
            }
            Node::Select(truth, a, b) => {
                let (truth, a, b) = (self.lower(truth), self.lower(a), self.lower(b));
                self.push(Instruction::Select(truth, a, b))
            }
            Node::External { function, inputs, outputs, output, derivative } => {
                let values = inputs.iter().map(|input| self.lower(*input)).collect();
                let derivatives: Vec<Vec<usize>> =
                    self.calls[&(function, inputs, derivative.len())].iter().cloned().collect();
                let list = derivatives.iter().position(|known| *known == derivative).unwrap_or_default();
                let call = self.push(Instruction::Call { function, inputs: values, outputs, derivatives });
                self.push(Instruction::Entry(call, list, output))
            }
            _ => self.push(Instruction::Terminal(scalar)),
        };
        self.lowered[scalar.0 as usize] = Some(value);
        value
    }

    fn lower_pair(&mut self, a: Scalar, b: Scalar, make: fn(Value, Value) -> Instruction) -> Value {
        let (a, b) = (self.lower(a), self.lower(b));
        self.push(make(a, b))
    }

    /// Terms of early levels first, so that partial sums are computed early.
    fn lower_sum(&mut self, constant: f64, terms: &[(u64, Scalar)]) -> Value {
        let terms: Vec<(f64, Scalar)> =
            terms.iter().map(|(bits, term)| (f64::from_bits(*bits), *term)).collect();
        // One common factor, as in ½(a + b), is multiplied last.
        let common = terms[0].0.abs();
        if constant == 0.0 && terms.len() > 1 && common != 1.0 && terms.iter().all(|(c, _)| c.abs() == common)
        {
            let signs: Vec<(u64, Scalar)> =
                terms.iter().map(|(c, term)| (c.signum().to_bits(), *term)).collect();
            let sum = self.lower_sum(0.0, &signs);
            let factor = self.number(common);
            return self.push(Instruction::Multiply(factor, sum));
        }
        // Products after what is no product: each is one instruction with the sum before it.
        let mut ordered: Vec<(Level, [bool; 2], f64, Scalar)> = terms
            .iter()
            .map(|(c, term)| {
                let is_product = c.abs() != 1.0 || self.split(*term).is_some();
                (self.scalar_level(*term), [is_product, *c < 0.0], *c, *term)
            })
            .collect();
        ordered.sort_by_key(|(level, kind, _, _)| (*level, *kind));
        let mut sum = (constant != 0.0).then(|| self.number(constant));
        for (_, _, coefficient, term) in ordered {
            sum = Some(self.lower_term(sum, coefficient, term));
        }
        sum.unwrap_or_else(|| self.number(0.0))
    }

    /// The last two factors of a product that nothing else reads.
    fn split(&mut self, term: Scalar) -> Option<(Value, Value)> {
        match self.graph.node(term).clone() {
            Node::Product(factors) if self.uses[term.0 as usize] == 1 => {
                let (head, last) = self.lower_product(&factors);
                Some((head?, last))
            }
            _ => None,
        }
    }

    /// sum + coefficient × term
    fn lower_term(&mut self, sum: Option<Value>, coefficient: f64, term: Scalar) -> Value {
        let split = self.split(term);
        let Some(sum) = sum else {
            let value = self.lower(term);
            return match coefficient {
                1.0 => value,
                -1.0 => self.push(Instruction::Negate(value)),
                _ => {
                    let factor = self.number(coefficient);
                    self.push(Instruction::Multiply(factor, value))
                }
            };
        };
        match (split, coefficient) {
            (Some((head, last)), 1.0) => self.push(Instruction::MultiplyAdd(head, last, sum)),
            (Some((head, last)), -1.0) => self.push(Instruction::MultiplySubtract(head, last, sum)),
            (Some((head, last)), c) => {
                let factor = self.number(c);
                let head = self.push(Instruction::Multiply(factor, head));
                self.push(Instruction::MultiplyAdd(head, last, sum))
            }
            (_, c) => {
                let value = self.lower(term);
                match c {
                    1.0 => self.push(Instruction::Add(sum, value)),
                    -1.0 => self.push(Instruction::Subtract(sum, value)),
                    _ => {
                        let factor = self.number(c);
                        self.push(Instruction::MultiplyAdd(factor, value, sum))
                    }
                }
            }
        }
    }

    /// A product as `head * last` (or `last` alone): factors of early levels first.
    fn lower_product(&mut self, factors: &[(Scalar, i32)]) -> (Option<Value>, Value) {
        let mut levels: SortedMap<Level, (Vec<Value>, Vec<Value>)> = SortedMap::new();
        for (factor, exponent) in factors {
            let value = self.lower(*factor);
            // What divides more than once is inverted once.
            if *exponent < 0 && self.divides[factor.0 as usize] > 1 {
                let one = self.number(1.0);
                let inverse = self.push(Instruction::Divide(one, value));
                let power = self.lower_power(inverse, exponent.unsigned_abs());
                levels.get_or_default(self.level(power)).0.push(power);
                continue;
            }
            let power = self.lower_power(value, exponent.unsigned_abs());
            let (above, below) = levels.get_or_default(self.level(power));
            if *exponent > 0 { above.push(power) } else { below.push(power) }
        }
        let mut head: Option<Value> = None;
        let mut last: Option<Value> = None;
        for (above, below) in levels.into_values() {
            for value in above {
                head = self.join(head, last);
                last = Some(value);
            }
            let below = below.into_iter().reduce(|a, b| self.push(Instruction::Multiply(a, b)));
            if let Some(below) = below {
                let above = match self.join(head, last) {
                    Some(above) => above,
                    None => self.number(1.0),
                };
                head = None;
                last = Some(self.push(Instruction::Divide(above, below)));
            }
        }
        match last {
            Some(last) => (head, last),
            None => (None, self.number(1.0)),
        }
    }

    fn join(&mut self, head: Option<Value>, last: Option<Value>) -> Option<Value> {
        match (head, last) {
            (Some(head), Some(last)) => Some(self.push(Instruction::Multiply(head, last))),
            (one, None) | (None, one) => one,
        }
    }

    fn lower_power(&mut self, value: Value, exponent: u32) -> Value {
        match exponent {
            1 => value,
            _ => {
                let half = self.lower_power(value, exponent / 2);
                let square = self.push(Instruction::Multiply(half, half));
                if exponent % 2 == 1 { self.push(Instruction::Multiply(square, value)) } else { square }
            }
        }
    }

    fn scalar_level(&mut self, scalar: Scalar) -> Level {
        let value = self.lower(scalar);
        self.level(value)
    }
}

fn terminal_level(node: &Node) -> Level {
    match node {
        Node::Geometry(Geometry::Diameter | Geometry::CellVolume | Geometry::FacetArea, _)
        | Node::Opposite(_) => Level::Cell,
        Node::Field { .. } | Node::Geometry(..) | Node::Weight => Level::Point,
        Node::Basis(Argument::Test | Argument::Trial, _) | Node::Accumulated(_) => Level::Node,
        _ => Level::Form,
    }
}

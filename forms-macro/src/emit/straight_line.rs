//! Scalars → instructions with at most three operands, each at the earliest level where its operands
//! exist, and their printing as straight-line Rust.

use std::collections::{BTreeMap, HashMap};

use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use crate::optimise::scalar::{Argument, Graph, Node, Scalar};
use crate::tensor::{Function, Geometry};

/// When a value is known: with the parameters, per cell, per point, per basis function (or pair).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Level {
    Form,
    Cell,
    Point,
    Node,
}

/// An instruction of a [`Code`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Value(u32);

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Instruction {
    Number(u64),
    Terminal(Scalar),
    Add(Value, Value),
    Subtract(Value, Value),
    Multiply(Value, Value),
    /// a * b + c
    MultiplyAdd(Value, Value, Value),
    Divide(Value, Value),
    Negate(Value),
    Apply(Function, Value),
    Power(Value, Value),
    Minimum(Value, Value),
    Maximum(Value, Value),
    Select(Value, Value, Value),
    Less(Value, Value),
    LessEqual(Value, Value),
    Equal(Value, Value),
    And(Value, Value),
    Or(Value, Value),
    Not(Value),
}

impl Instruction {
    fn operands(&self) -> Vec<Value> {
        use Instruction::*;
        match self {
            Number(_) | Terminal(_) => vec![],
            Negate(a) | Apply(_, a) | Not(a) => vec![*a],
            Add(a, b)
            | Subtract(a, b)
            | Multiply(a, b)
            | Divide(a, b)
            | Power(a, b)
            | Minimum(a, b)
            | Maximum(a, b)
            | Less(a, b)
            | LessEqual(a, b)
            | Equal(a, b)
            | And(a, b)
            | Or(a, b) => vec![*a, *b],
            MultiplyAdd(a, b, c) | Select(a, b, c) => vec![*a, *b, *c],
        }
    }

    /// Truth values are not stored between functions: they are computed where they are used.
    fn is_truth(&self) -> bool {
        use Instruction::*;
        matches!(self, Less(..) | LessEqual(..) | Equal(..) | And(..) | Or(..) | Not(..))
    }
}

/// The instructions of one kernel.
pub struct Code<'a> {
    graph: &'a Graph,
    instructions: Vec<(Instruction, Level)>,
    interned: HashMap<Instruction, Value>,
    lowered: HashMap<Scalar, Value>,
    /// Number of parents of each scalar in this kernel.
    uses: HashMap<Scalar, usize>,
}

/// The text of one function, and what it wants from the functions before it.
pub struct Body {
    pub statements: TokenStream,
    pub results: Vec<TokenStream>,
}

/// Values that one function leaves to later ones, in the order of their slots.
#[derive(Default)]
pub struct Store {
    pub values: Vec<Value>,
}

impl Store {
    fn slot(&mut self, value: Value) -> usize {
        self.values.iter().position(|known| *known == value).unwrap_or_else(|| {
            self.values.push(value);
            self.values.len() - 1
        })
    }
}

impl<'a> Code<'a> {
    pub fn new(graph: &'a Graph, roots: &[Scalar]) -> Self {
        let mut uses = HashMap::new();
        for scalar in graph.reachable(roots) {
            for operand in graph.operands(scalar) {
                *uses.entry(operand).or_insert(0) += 1;
            }
        }
        for root in roots {
            *uses.entry(*root).or_insert(0) += 1;
        }
        Code { graph, instructions: vec![], interned: HashMap::new(), lowered: HashMap::new(), uses }
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

    fn level(&self, value: Value) -> Level {
        self.instructions[value.0 as usize].1
    }

    fn instruction(&self, value: Value) -> &Instruction {
        &self.instructions[value.0 as usize].0
    }

    fn number(&mut self, value: f64) -> Value {
        self.push(Instruction::Number((value + 0.0).to_bits()))
    }

    /// The instruction that computes a scalar.
    pub fn lower(&mut self, scalar: Scalar) -> Value {
        if let Some(known) = self.lowered.get(&scalar) {
            return *known;
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
            _ => self.push(Instruction::Terminal(scalar)),
        };
        self.lowered.insert(scalar, value);
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
        let mut ordered: Vec<(Level, bool, f64, Scalar)> =
            terms.iter().map(|(c, term)| (self.scalar_level(*term), *c < 0.0, *c, *term)).collect();
        ordered.sort_by_key(|(level, negative, _, _)| (*level, *negative));
        let mut sum = (constant != 0.0).then(|| self.number(constant));
        for (_, _, coefficient, term) in ordered {
            sum = Some(self.lower_term(sum, coefficient, term));
        }
        sum.unwrap_or_else(|| self.number(0.0))
    }

    /// sum + coefficient × term
    fn lower_term(&mut self, sum: Option<Value>, coefficient: f64, term: Scalar) -> Value {
        let alone = self.uses.get(&term) == Some(&1);
        let split = match self.graph.node(term).clone() {
            Node::Product(factors) if alone => match self.lower_product(&factors) {
                (Some(head), last) => Some((head, last)),
                (None, _) => None,
            },
            _ => None,
        };
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
            (Some((head, last)), c) if c != -1.0 => {
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
        let mut levels: BTreeMap<Level, (Vec<Value>, Vec<Value>)> = BTreeMap::new();
        for (factor, exponent) in factors {
            let value = self.lower(*factor);
            let power = self.lower_power(value, exponent.unsigned_abs());
            let (above, below) = levels.entry(self.level(power)).or_default();
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

    /// Prints the function of a level that computes `roots`. Terminals are printed by `terminal`;
    /// values of earlier levels are asked for by `earlier`, which gives their text.
    pub fn print(
        &self,
        roots: &[Value],
        level: Level,
        terminal: &dyn Fn(&Node) -> TokenStream,
        earlier: &mut dyn FnMut(Value, Level) -> TokenStream,
    ) -> Body {
        // What this function computes itself, operands first.
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
        let mut texts: HashMap<Value, TokenStream> = HashMap::new();
        let mut statements = TokenStream::new();
        for value in own {
            let right = self.print_instruction(value, level, terminal, earlier, &mut texts);
            let name = format_ident!("t{}", value.0);
            statements.extend(quote! { let #name = #right; });
            texts.insert(value, quote! { #name });
        }
        let results = roots.iter().map(|root| self.text(*root, level, earlier, &mut texts)).collect();
        Body { statements, results }
    }

    fn text(
        &self,
        value: Value,
        level: Level,
        earlier: &mut dyn FnMut(Value, Level) -> TokenStream,
        texts: &mut HashMap<Value, TokenStream>,
    ) -> TokenStream {
        if let Some(text) = texts.get(&value) {
            return text.clone();
        }
        let text = match self.instruction(value) {
            Instruction::Number(bits) => print_number(f64::from_bits(*bits)),
            _ => earlier(value, self.level(value)),
        };
        let _ = level;
        texts.insert(value, text.clone());
        text
    }

    fn print_instruction(
        &self,
        value: Value,
        level: Level,
        terminal: &dyn Fn(&Node) -> TokenStream,
        earlier: &mut dyn FnMut(Value, Level) -> TokenStream,
        texts: &mut HashMap<Value, TokenStream>,
    ) -> TokenStream {
        use Instruction::*;
        let instruction = self.instruction(value).clone();
        let operands: Vec<TokenStream> =
            instruction.operands().iter().map(|operand| self.text(*operand, level, earlier, texts)).collect();
        let [a, b, c] = std::array::from_fn(|index| operands.get(index).cloned().unwrap_or_default());
        match instruction {
            Number(bits) => print_number(f64::from_bits(bits)),
            Terminal(scalar) => terminal(self.graph.node(scalar)),
            Add(..) => quote! { #a + #b },
            Subtract(..) => quote! { #a - #b },
            Multiply(..) => quote! { #a * #b },
            MultiplyAdd(..) => quote! { L::multiply_add(#a, #b, #c) },
            Divide(..) => quote! { #a / #b },
            Negate(_) => quote! { -#a },
            Apply(function, _) => {
                let name = format_ident!("{}", function_name(function));
                quote! { L::#name(#a) }
            }
            Power(..) => quote! { L::powf(#a, #b) },
            Minimum(..) => quote! { L::minimum(#a, #b) },
            Maximum(..) => quote! { L::maximum(#a, #b) },
            Select(..) => quote! { L::select(#a, #b, #c) },
            Less(..) => quote! { L::less(#a, #b) },
            LessEqual(..) => quote! { L::less_equal(#a, #b) },
            Equal(..) => quote! { L::equal(#a, #b) },
            And(..) => quote! { L::and(#a, #b) },
            Or(..) => quote! { L::or(#a, #b) },
            Not(_) => quote! { L::not(#a) },
        }
    }
}

fn print_number(value: f64) -> TokenStream {
    if value.is_nan() {
        quote! { L::splat(f64::NAN) }
    } else if value.is_infinite() {
        if value > 0.0 {
            quote! { L::splat(f64::INFINITY) }
        } else {
            quote! { L::splat(f64::NEG_INFINITY) }
        }
    } else if value < 0.0 {
        let value = -value;
        quote! { L::splat(-#value) }
    } else {
        quote! { L::splat(#value) }
    }
}

/// Name of the `Lane` method; the kinks have become selects.
fn function_name(function: Function) -> &'static str {
    match function {
        Function::Sqrt => "sqrt",
        Function::Exp => "exp",
        Function::Ln => "ln",
        Function::Sin => "sin",
        Function::Cos => "cos",
        Function::Tan => "tan",
        Function::Tanh => "tanh",
        _ => "abs",
    }
}

fn terminal_level(node: &Node) -> Level {
    match node {
        Node::Geometry(Geometry::Diameter | Geometry::CellVolume | Geometry::FacetArea, _) => Level::Cell,
        Node::Field { .. } | Node::Geometry(..) | Node::Weight => Level::Point,
        Node::Basis(Argument::Test | Argument::Trial, _) | Node::Accumulated(_) => Level::Node,
        _ => Level::Form,
    }
}

/// Keeps what a function asks of the functions before it: values known with the form's parameters,
/// and values of the cell.
pub struct Demand<'s> {
    pub form: &'s mut Store,
    pub cell: &'s mut Store,
}

impl Demand<'_> {
    /// The text of an earlier value in a function that sees `self.form` and `cell`.
    pub fn text(&mut self, value: Value, level: Level) -> TokenStream {
        match level {
            Level::Form => {
                let slot = self.form.slot(value);
                quote! { L::splat(self.form[#slot]) }
            }
            _ => {
                let slot = self.cell.slot(value);
                quote! { cell[#slot] }
            }
        }
    }
}

/// The text of an earlier value in a function that sees only what the point left.
pub fn from_point(store: &mut Store, value: Value) -> TokenStream {
    let slot = store.slot(value);
    quote! { point[#slot] }
}

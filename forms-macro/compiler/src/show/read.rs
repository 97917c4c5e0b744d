//! From tensor nodes to a [`Formula`].

mod sides;

use super::formula::{Fence, Formula, Infix};
use super::names::Names;
use super::same::same;
use super::symbols::Symbol;
use crate::parse::syntax::{Comparison, Module};
use crate::tensor::{
    Arena, External, FieldInfo, Function, Geometry, LinearMap, Named, Operator, Side, Tensor, Truth, Variable,
};
use syn::Attribute;

/// Reads the nodes of one arena.
pub struct Reader<'a> {
    pub module: &'a Module,
    pub arena: &'a Arena,
    pub fields: &'a [FieldInfo],
    pub dimension: usize,
    pub names: &'a Names,
}

impl Reader<'_> {
    pub fn read(&self, tensor: Tensor) -> Formula {
        match self.names.use_name(tensor) {
            Some(name) => Formula::name(name),
            None => self.read_node(tensor),
        }
    }

    /// The operator of a node, whether it has a name or not.
    pub fn read_node(&self, tensor: Tensor) -> Formula {
        use Operator::*;
        let node = self.arena.node(tensor);
        match &node.operator {
            Number(value) => Formula::Number(*value),
            Zero => Formula::Number(0.0),
            Identity => Formula::name("I"),
            Parameter(index) => self.parameter(*index),
            Field { field, order: 0 } => self.field(*field),
            Field { field, order: 1 } => Formula::Prefix("∇", Box::new(self.field(*field))),
            Field { field, .. } => Formula::Prefix("∇²", Box::new(self.field(*field))),
            Geometry(kind) => geometry(*kind),
            Add(a, b) => {
                if let Some(jump) = self.jump(*a, *b) {
                    return jump;
                }
                let left = self.read(*a);
                match self.arena.node(*b).operator {
                    Negate(inner) => left.plus(true, self.read(inner)),
                    _ => left.plus(false, self.read(*b)),
                }
            }
            Negate(a) => self.read(*a).negative(),
            Scale(a, b) if self.average(*a, *b).is_some() => {
                Formula::Fence(Fence::Average, Box::new(self.average(*a, *b).unwrap_or(Formula::Number(0.0))))
            }
            Scale(a, b) => self.scaled(self.read(*a), self.read(*b)),
            Divide(a, b) => Formula::Fraction(Box::new(self.read(*a)), Box::new(self.read(*b))),
            Contract(a, b) => {
                let ranks = (self.arena.shape(*a).len(), self.arena.shape(*b).len());
                let (left, right) = (self.read(*a), self.read(*b));
                match ranks {
                    (2, 1) | (2, 2) => left.times(right),
                    _ => Formula::infix(Infix::Dot, left, right),
                }
            }
            Inner(a, b) => {
                let (left, right) = (self.read(*a), self.read(*b));
                match self.arena.shape(*a).len() {
                    0 => left.times(right),
                    1 => Formula::infix(Infix::Dot, left, right),
                    _ => Formula::infix(Infix::DoubleDot, left, right),
                }
            }
            Outer(a, b) => Formula::infix(Infix::Outer, self.read(*a), self.read(*b)),
            Map(map, a) => self.map(*map, *a),
            Inverse(a) => self.read(*a).power(Formula::Number(-1.0)),
            Component(a, index) => self.component(*a, index),
            Stack(entries) => self.stack(entries),
            Apply(function, a) => self.apply(*function, *a),
            Power(a, b) => self.read(*a).power(self.read(*b)),
            Select(..) => Formula::Cases(self.cases(tensor)),
            Restrict(side, a) => {
                let sign = if *side == Side::This { "+" } else { "−" };
                self.read(*a).power(Formula::word(sign))
            }
            CellMean(a) | FacetMean(a) => Formula::Fence(Fence::Mean, Box::new(self.read(*a))),
            Opposite(a, _) => self.read(*a).power(Formula::word("−")),
            Sliding(kind, _) => geometry(*kind),
            Gradient(a) => Formula::Prefix("∇", Box::new(self.read(*a))),
            Partial(expression, variable) => {
                let by = match variable {
                    Variable::Field(field) => self.field(*field),
                    Variable::Parameter(index) => self.parameter(*index),
                    Variable::Node(node) => self.read(*node),
                    Variable::Size(size) => geometry(*size),
                    Variable::Shape(_) => Formula::word("shape"),
                };
                let partial = |one| Box::new(Formula::Prefix("∂", Box::new(one)));
                Formula::Fraction(partial(self.read(*expression)), partial(by))
            }
            Gateaux { expression, direction, .. } => {
                let of = Box::new(self.read(*expression));
                let derivative = Formula::Derivative { order: 1, by: None, of };
                Formula::Directions(Box::new(derivative), vec![self.read(*direction)])
            }
            Named(self::Named::Value { name, .. }) => Formula::name(if name == "PI" { "pi" } else { name }),
            Named(self::Named::Call { function, arguments, directions }) => {
                self.call(*function, arguments, directions)
            }
            External { function, arguments, order } => self.external(*function, arguments, *order),
            other => self.word(&function_name(other), &other.operands()),
        }
    }

    pub fn field(&self, field: usize) -> Formula {
        let info = &self.fields[field];
        let members = self.module.members();
        let member = members.filter(|_| info.role.is_data()).find(|member| member.name == info.name);
        match member {
            Some(member) => Formula::Symbol(symbol(&member.name, &member.attributes)),
            None => Formula::name(&info.name),
        }
    }

    fn parameter(&self, index: usize) -> Formula {
        let mut members = self.module.members();
        match members.nth(index) {
            Some(member) => Formula::Symbol(symbol(&member.name, &member.attributes)),
            None => Formula::word("parameter"),
        }
    }

    pub fn function(&self, function: usize) -> Formula {
        let function = &self.module.functions[function];
        let mut sign = symbol(&function.name, &function.attributes);
        // What was imported carries its module's identity behind its name.
        if function.foreign.is_some()
            && let Some((name, _)) = sign.base.rsplit_once("__")
        {
            sign = Symbol::of(name);
        }
        Formula::Symbol(sign)
    }

    /// A product with a sign takes a scalar into its first factor: s A:B.
    fn scaled(&self, scalar: Formula, tensor: Formula) -> Formula {
        match tensor {
            Formula::Infix(infix, left, right) => Formula::infix(infix, scalar.times(*left), *right),
            other => scalar.times(other),
        }
    }

    fn word(&self, word: &str, operands: &[Tensor]) -> Formula {
        Formula::call(Formula::word(word), operands.iter().map(|operand| self.read(*operand)).collect())
    }

    /// A function whose inside is not seen, or its derivative by all arguments.
    fn external(&self, function: External, arguments: &[Tensor], order: usize) -> Formula {
        let name = match function {
            External::Function(index) => Formula::name(&self.module.externals[index].name.to_string()),
            External::Table(member) => self.parameter(member),
            External::TensorExponential => Formula::word("exp"),
            External::TensorLogarithm => Formula::word("ln"),
            External::TensorSquareRoot => Formula::word("sqrt"),
        };
        let head = match order {
            0 => name,
            _ => Formula::Derivative { order, by: None, of: Box::new(name) },
        };
        Formula::call(head, arguments.iter().map(|argument| self.read(*argument)).collect())
    }

    /// The operand of a gradient, as a formula.
    fn gradient_of(&self, tensor: Tensor) -> Option<Formula> {
        match self.arena.node(tensor).operator {
            Operator::Field { field, order: 1 } => Some(self.field(field)),
            Operator::Gradient(a) => Some(self.read(a)),
            _ => None,
        }
    }

    fn map(&self, map: LinearMap, a: Tensor) -> Formula {
        let vector = self.arena.shape(a).len() == 2;
        match (map, self.gradient_of(a)) {
            (LinearMap::Symmetric, Some(of)) if vector => Formula::call(Formula::name("ε"), vec![of]),
            (LinearMap::Trace, Some(of)) if vector => Formula::call(Formula::word("div"), vec![of]),
            (LinearMap::Transpose, _) => match self.arena.node(a).operator {
                Operator::Inverse(inner) => self.read(inner).power(Formula::word("−T")),
                _ => self.read(a).power(Formula::word("T")),
            },
            (LinearMap::Trace, _) => self.word("tr", &[a]),
            (LinearMap::Symmetric, _) => self.word("sym", &[a]),
            (LinearMap::Deviator, _) => self.word("dev", &[a]),
            (other, _) => self.word(&lower(&other), &[a]),
        }
    }

    /// x, y, z along the axes of space, else numbers from 1.
    fn component(&self, a: Tensor, index: &[usize]) -> Formula {
        let shape = self.arena.shape(a);
        let axes = index.iter().zip(shape).map(|(index, extent)| match (*extent == self.dimension, index) {
            (true, 0) => Formula::name("x"),
            (true, 1) => Formula::name("y"),
            (true, 2) => Formula::name("z"),
            _ => Formula::Number(*index as f64 + 1.0),
        });
        Formula::Subscript(Box::new(self.read(a)), axes.collect())
    }

    fn stack(&self, entries: &[Tensor]) -> Formula {
        if let Some(divergence) = self.rows_of_divergence(entries) {
            return divergence;
        }
        let row = |entry: &Tensor| match &self.arena.node(*entry).operator {
            Operator::Stack(inner) => inner.iter().map(|one| self.read(*one)).collect(),
            Operator::Zero if self.arena.shape(*entry).len() == 1 => {
                vec![Formula::Number(0.0); self.arena.shape(*entry)[0]]
            }
            _ if self.arena.shape(*entry).is_empty() => vec![self.read(*entry)],
            _ => vec![self.read(*entry).power(Formula::word("T"))],
        };
        Formula::Matrix(entries.iter().map(row).collect())
    }

    /// `div` of a tensor is written row by row.
    fn rows_of_divergence(&self, entries: &[Tensor]) -> Option<Formula> {
        let mut whole = None;
        for (row, entry) in entries.iter().enumerate() {
            let Operator::Map(LinearMap::Trace, block) = self.arena.node(*entry).operator else {
                return None;
            };
            let Operator::Component(gradient, index) = &self.arena.node(block).operator else { return None };
            if *index != [row] || whole.is_some_and(|other| other != *gradient) {
                return None;
            }
            whole = Some(*gradient);
        }
        Some(Formula::call(Formula::word("div"), vec![self.gradient_of(whole?)?]))
    }

    fn apply(&self, function: Function, a: Tensor) -> Formula {
        let inner = || Box::new(self.read(a));
        match function {
            Function::Sqrt => match self.arena.node(a).operator {
                Operator::Inner(first, second) | Operator::Contract(first, second)
                    if same(self.arena, first, second) =>
                {
                    Formula::Fence(Fence::DoubleBars, Box::new(self.read(first)))
                }
                _ => Formula::Root(inner()),
            },
            Function::Abs => Formula::Fence(Fence::Bars, inner()),
            Function::PositivePart => Formula::Fence(Fence::PositivePart, inner()),
            Function::NegativePart => Formula::Fence(Fence::NegativePart, inner()),
            Function::Heaviside => Formula::call(Formula::name("H"), vec![self.read(a)]),
            Function::Sign => self.word("sgn", &[a]),
            other => self.word(&lower(&other), &[a]),
        }
    }

    /// `if a { .. } else if b { .. } else { .. }` as one list.
    fn cases(&self, tensor: Tensor) -> Vec<(Formula, Option<Formula>)> {
        match &self.arena.node(tensor).operator {
            Operator::Select(truth, taken, otherwise) => {
                let mut rows = vec![(self.read(*taken), Some(self.truth(truth)))];
                rows.extend(self.cases(*otherwise));
                rows
            }
            _ => vec![(self.read(tensor), None)],
        }
    }

    fn truth(&self, truth: &Truth) -> Formula {
        let relation = |sign, left, right| Formula::Relation(sign, Box::new(left), Box::new(right));
        match truth {
            Truth::Compare(comparison, a, b) => {
                let sign = match comparison {
                    Comparison::Less => "<",
                    Comparison::LessEqual => "≤",
                    Comparison::Greater => ">",
                    Comparison::GreaterEqual => "≥",
                    Comparison::Equal => "=",
                    Comparison::NotEqual => "≠",
                };
                relation(sign, self.read(*a), self.read(*b))
            }
            Truth::And(a, b) => relation("∧", self.truth(a), self.truth(b)),
            Truth::Or(a, b) => relation("∨", self.truth(a), self.truth(b)),
            Truth::Not(a) => Formula::Prefix("¬", Box::new(self.truth(a))),
        }
    }

    fn call(&self, function: usize, arguments: &[Tensor], directions: &[Vec<Tensor>]) -> Formula {
        let read = |list: &[Tensor]| list.iter().map(|one| self.read(*one)).collect::<Vec<_>>();
        let head = self.function(function);
        if directions.is_empty() {
            return self.called(head, read(arguments));
        }
        let rows = directions.iter().map(|row| match read(row) {
            mut row if row.len() == 1 => row.remove(0),
            row => Formula::Tuple(row),
        });
        let derivative = Formula::Derivative { order: directions.len(), by: None, of: Box::new(head) };
        Formula::Directions(Box::new(Formula::call(derivative, read(arguments))), rows.collect())
    }

    /// f(a), or an index of a where the function's sign says so.
    pub fn called(&self, head: Formula, mut arguments: Vec<Formula>) -> Formula {
        match head {
            Formula::Symbol(symbol) if symbol.is_index() && arguments.len() == 1 => {
                let indices = symbol.subscripts.iter().map(|index| Formula::name(index)).collect();
                Formula::Subscript(Box::new(arguments.remove(0)), indices)
            }
            head => Formula::call(head, arguments),
        }
    }

    /// The calls of a formula, in the order in which they appear: function, and which arguments vary.
    pub fn calls(&self, roots: &[Tensor]) -> Vec<(usize, Vec<Vec<bool>>)> {
        let mut found = Vec::new();
        for node in self.arena.reachable(roots) {
            if let Operator::Named(Named::Call { function, directions, .. }) = &self.arena.node(node).operator
            {
                let call = (*function, varied(self.arena, directions));
                if !found.contains(&call) {
                    found.push(call);
                }
            }
        }
        found
    }
}

/// An operator that is written as a function of its operands.
fn function_name(operator: &Operator) -> String {
    match operator {
        Operator::Determinant(_) => "det".into(),
        Operator::Cofactor(_) | Operator::MixedCofactor(..) => "cof".into(),
        Operator::Minimum(..) => "min".into(),
        Operator::Maximum(..) => "max".into(),
        other => lower(other),
    }
}

/// `Tanh` is `tanh`: what has no sign of its own is shown by its name.
fn lower(operator: &impl std::fmt::Debug) -> String {
    let name = format!("{operator:?}");
    let name = name.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default();
    name.to_lowercase()
}

fn geometry(kind: Geometry) -> Formula {
    match kind {
        Geometry::Diameter => Formula::name("h"),
        Geometry::CellVolume => Formula::Fence(Fence::Bars, Box::new(Formula::name("T"))),
        Geometry::FacetArea => Formula::Fence(Fence::Bars, Box::new(Formula::name("F"))),
        Geometry::Normal => Formula::name("n"),
        Geometry::Position => Formula::name("x"),
        Geometry::Gap => Formula::name("gap"),
        Geometry::Toward => Formula::name("n_y"),
        // What has no sign of its own is shown by its name.
        other => match lower(&other).as_str() {
            "curvature" => Formula::name("kappa"),
            name => Formula::name(name),
        },
    }
}

/// The sign of a declared name: what its first `#[doc(alias = "..")]` says, else the name itself.
pub fn symbol(name: &proc_macro2::Ident, attributes: &[Attribute]) -> Symbol {
    let alias =
        attributes.iter().filter(|attribute| attribute.path().is_ident("doc")).find_map(|attribute| {
            let mut alias = None;
            // Other arguments of `doc` are none of our concern.
            let _ = attribute.parse_nested_meta(|meta| {
                if meta.path.is_ident("alias") {
                    alias = Some(meta.value()?.parse::<syn::LitStr>()?.value());
                }
                Ok(())
            });
            alias
        });
    Symbol::of(&alias.unwrap_or_else(|| name.to_string()))
}

/// Which arguments vary, for each order of a derivative.
pub type Varied = Vec<Vec<bool>>;

/// Which directions of a call are not zero.
pub fn varied(arena: &Arena, directions: &[Vec<Tensor>]) -> Varied {
    directions.iter().map(|row| row.iter().map(|one| !arena.is_zero(*one)).collect()).collect()
}

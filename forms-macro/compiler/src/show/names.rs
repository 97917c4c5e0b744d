//! Names for what a large formula holds more than once, and the largest size of what is shown: nodes are shared, and
//! written out as a tree they would double with each level.

use std::cell::RefCell;
use std::collections::HashMap;

use super::formula::Formula;
use crate::parse::syntax::Module;
use crate::sorted::SortedSet;
use crate::tensor::{Arena, FieldInfo, Named, Operator, Tensor};

/// Formulas with no more nodes than this are written as they are.
const LARGE: usize = 1000;

/// In a larger one, what is used more than once and has at least this number of nodes gets a name,
const WORTH_A_NAME: usize = 6;

/// and so does all that has more than these: no single equation is longer than a few of them.
const LONGEST: usize = 200;

/// More nodes than all equations of a function have together; what follows is left out, with an ellipsis.
pub const MOST_SHOWN: usize = 3000;

/// Expressions of more nodes than this have no derivatives shown, but an ellipsis.
pub const MOST_DIFFERENTIATED: usize = 20_000;

/// The names of an arena's nodes.
#[derive(Default)]
pub struct Names {
    of: HashMap<Tensor, String>,
    used: RefCell<SortedSet<Tensor>>,
}

impl Names {
    /// The name of a node, which is noted as used.
    pub fn use_name(&self, tensor: Tensor) -> Option<&str> {
        let name = self.of.get(&tensor)?;
        self.used.borrow_mut().insert(tensor);
        Some(name)
    }

    /// The name of a node.
    pub fn name(&self, tensor: Tensor) -> &str {
        self.of.get(&tensor).map_or("", String::as_str)
    }

    /// The last node that is used before a given one: operands come before what is made of them.
    pub fn last_used(&self, before: Option<Tensor>) -> Option<Tensor> {
        let used = self.used.borrow();
        match before {
            Some(before) => used.last_before(&before).copied(),
            None => used.iter().last().copied(),
        }
    }
}

/// Gives names, each once.
pub struct Namer {
    letter: &'static str,
    given: usize,
}

impl Namer {
    /// Names of a letter with a number, `s1` and so on, which no name of the module is.
    pub fn new(module: &Module, fields: &[FieldInfo], arena: &Arena) -> Self {
        let members = module.members().map(|member| member.name.to_string());
        let functions = module.functions.iter().flat_map(|function| {
            let arguments = function.arguments.iter().map(|argument| argument.name.to_string());
            arguments.chain([function.name.to_string()])
        });
        let fields = fields.iter().map(|field| field.name.clone());
        let taken: SortedSet<String> =
            members.chain(functions).chain(fields).chain(arena.names().map(ToString::to_string)).collect();
        let is_free = |letter: &&str| {
            let numbered = |name: &String| {
                let rest = name.strip_prefix(*letter).map(|rest| rest.trim_start_matches('_'));
                rest.is_some_and(|rest| rest.chars().all(|digit| digit.is_ascii_digit()))
            };
            !taken.iter().any(numbered)
        };
        let letter = ["s", "t", "r", "q", "z", "y"].into_iter().find(is_free).unwrap_or("shared_");
        Namer { letter, given: 0 }
    }

    /// Names for the nodes of some expressions, if these are large.
    pub fn names(&mut self, arena: &Arena, roots: &[Tensor]) -> Names {
        let nodes = arena.reachable(roots);
        // A `let`'s value is an equation of its own.
        let values = nodes.iter().filter_map(|node| match arena.node(*node).operator {
            Operator::Named(Named::Value { value, .. }) => Some(value),
            _ => None,
        });
        let equations: Vec<Tensor> = roots.iter().copied().chain(values).collect();
        let mut names = Names::default();
        let mut sizes: HashMap<Tensor, usize> = HashMap::new();
        let size = |sizes: &HashMap<Tensor, usize>, node: Tensor| match &arena.node(node).operator {
            Operator::Named(Named::Value { .. }) => 1,
            operator => operator.operands().iter().fold(1, |sum: usize, one| sum.saturating_add(sizes[one])),
        };
        for node in &nodes {
            sizes.insert(*node, size(&sizes, *node));
        }
        let total = equations.iter().fold(0, |sum: usize, root| sum.saturating_add(sizes[root]));
        if total <= LARGE {
            return names;
        }
        let mut users: HashMap<Tensor, usize> = HashMap::new();
        let operands = nodes.iter().flat_map(|node| arena.node(*node).operator.operands());
        for operand in operands.chain(roots.iter().copied()) {
            *users.entry(operand).or_default() += 1;
        }
        for node in nodes {
            let own = size(&sizes, node);
            let several = users.get(&node).is_some_and(|count| *count > 1);
            let named = (several && own >= WORTH_A_NAME) || own > LONGEST;
            sizes.insert(node, if named { 1 } else { own });
            if named && !matches!(arena.node(node).operator, Operator::Named(Named::Value { .. })) {
                self.given += 1;
                names.of.insert(node, format!("{}{}", self.letter, self.given));
            }
        }
        names
    }
}

/// The mark of what is left out.
pub fn ellipsis() -> Formula {
    Formula::word("…")
}

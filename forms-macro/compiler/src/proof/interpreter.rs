//! Runs the straight-line Rust of emitted kernels: `let`s, arithmetic, calls of `L::…`, indices, members.
//!
//! It is strict: syntax it does not know, an index out of range or an array of another length than the
//! function's type says stop the test.

use std::collections::BTreeMap;

use crate::reference::error_function;
use syn::{Expr, Lit, Member, Pat, Stmt, UnOp};

/// The value of an emitted expression.
#[derive(Clone, Debug)]
pub enum Value {
    Number(f64),
    Truth(bool),
    List(Vec<Value>),
    Structure(BTreeMap<String, Value>),
    /// The last word of a path such as `contract::Order::Value`.
    Word(String),
}

impl Value {
    pub fn numbers(list: impl IntoIterator<Item = f64>) -> Self {
        Value::List(list.into_iter().map(Value::Number).collect())
    }

    pub fn structure<const N: usize>(members: [(&str, Value); N]) -> Self {
        Value::Structure(members.into_iter().map(|(name, value)| (name.to_string(), value)).collect())
    }

    pub fn number(&self) -> f64 {
        match self {
            Value::Number(number) => *number,
            other => panic!("{other:?} is not a number"),
        }
    }

    pub fn truth(&self) -> bool {
        match self {
            Value::Truth(truth) => *truth,
            other => panic!("{other:?} is not a mask"),
        }
    }

    pub fn list(&self) -> &[Value] {
        match self {
            Value::List(list) => list,
            other => panic!("{other:?} is not an array"),
        }
    }

    pub fn member(&self, name: &str) -> &Value {
        match self {
            Value::Structure(members) => &members[name],
            other => panic!("{other:?} has no members"),
        }
    }

    pub fn index(&self) -> usize {
        self.number() as usize
    }

    pub fn word(&self) -> &str {
        match self {
            Value::Word(word) => word,
            other => panic!("{other:?} is not a word"),
        }
    }

    pub fn to_numbers(&self) -> Vec<f64> {
        self.list().iter().map(Value::number).collect()
    }
}

/// Names and their values.
pub type Scope = BTreeMap<String, Value>;

/// Runs a block; assignments to elements of arrays change the scope.
pub fn run(block: &syn::Block, scope: &mut Scope) -> Option<Value> {
    let mut result = None;
    for statement in &block.stmts {
        result = None;
        match statement {
            Stmt::Local(local) => {
                let init = local.init.as_ref().expect("a `let` has a value");
                let value = evaluate(&init.expr, scope);
                bind(&local.pat, value, scope);
            }
            // `type L = f64;`
            Stmt::Item(syn::Item::Type(_)) => {}
            Stmt::Expr(Expr::Assign(assign), Some(_)) => {
                let value = evaluate(&assign.right, scope);
                let Expr::Index(place) = &*assign.left else { panic!("an assignment to no element") };
                let Expr::Path(name) = &*place.expr else { panic!("an assignment to no array") };
                let index = index_of(&place.index);
                let name = name.path.get_ident().expect("a name").to_string();
                let Some(Value::List(list)) = scope.get_mut(&name) else { panic!("`{name}` is no array") };
                list[index] = value;
            }
            Stmt::Expr(expression, None) => result = Some(evaluate(expression, scope)),
            other => panic!("the interpreter does not know this statement: {}", show(other)),
        }
    }
    result
}

/// Names in the scope for a value, or for the entries of a list.
fn bind(pattern: &Pat, value: Value, scope: &mut Scope) {
    match (pattern, value) {
        (Pat::Ident(name), value) => {
            scope.insert(name.ident.to_string(), value);
        }
        (Pat::Tuple(names), Value::List(entries)) => {
            assert_eq!(names.elems.len(), entries.len(), "names: {}", show(pattern));
            names.elems.iter().zip(entries).for_each(|(name, entry)| bind(name, entry, scope));
        }
        _ => panic!("a pattern in emitted code: {}", show(pattern)),
    }
}

fn show(tokens: &impl quote::ToTokens) -> String {
    tokens.to_token_stream().to_string()
}

fn index_of(expression: &Expr) -> usize {
    match expression {
        Expr::Lit(literal) => match &literal.lit {
            Lit::Int(integer) => integer.base10_parse().expect("an index"),
            _ => panic!("an index is no integer: {}", show(expression)),
        },
        _ => panic!("an index is not known: {}", show(expression)),
    }
}

/// The value of an expression.
pub fn evaluate(expression: &Expr, scope: &Scope) -> Value {
    match expression {
        Expr::Paren(inner) => evaluate(&inner.expr, scope),
        Expr::Group(inner) => evaluate(&inner.expr, scope),
        Expr::Reference(inner) => evaluate(&inner.expr, scope),
        Expr::Lit(literal) => match &literal.lit {
            Lit::Float(float) => Value::Number(float.base10_parse().expect("a number")),
            Lit::Int(integer) => Value::Number(integer.base10_parse().expect("a number")),
            Lit::Bool(truth) => Value::Truth(truth.value),
            _ => panic!("the interpreter does not know the literal {}", show(expression)),
        },
        Expr::Path(path) if path.path.segments.len() > 1 => match show(path).replace(' ', "").as_str() {
            "f64::NAN" => Value::Number(f64::NAN),
            "f64::INFINITY" => Value::Number(f64::INFINITY),
            "f64::NEG_INFINITY" => Value::Number(f64::NEG_INFINITY),
            text => Value::Word(text.rsplit("::").next().unwrap_or_default().to_string()),
        },
        Expr::Path(_) | Expr::Field(_) | Expr::Index(_) => place(expression, scope).clone(),
        Expr::Array(array) => Value::List(array.elems.iter().map(|entry| evaluate(entry, scope)).collect()),
        Expr::Tuple(tuple) => Value::List(tuple.elems.iter().map(|entry| evaluate(entry, scope)).collect()),
        // Its names end with it.
        Expr::Block(block) => run(&block.block, &mut scope.clone()).expect("a block has a value"),
        Expr::Repeat(repeat) => Value::List(vec![evaluate(&repeat.expr, scope); index_of(&repeat.len)]),
        Expr::Struct(structure) => {
            let members = structure.fields.iter().map(|field| match &field.member {
                Member::Named(name) => (name.to_string(), evaluate(&field.expr, scope)),
                Member::Unnamed(_) => panic!("a member without name"),
            });
            Value::Structure(members.collect())
        }
        Expr::Unary(unary) if matches!(unary.op, UnOp::Neg(_)) => {
            Value::Number(-evaluate(&unary.expr, scope).number())
        }
        Expr::Binary(binary) => {
            let (a, b) = (evaluate(&binary.left, scope).number(), evaluate(&binary.right, scope).number());
            Value::Number(match binary.op {
                syn::BinOp::Add(_) => a + b,
                syn::BinOp::Sub(_) => a - b,
                syn::BinOp::Mul(_) => a * b,
                syn::BinOp::Div(_) => a / b,
                _ => panic!("the interpreter does not know this operator: {}", show(expression)),
            })
        }
        Expr::Call(call) => {
            let arguments: Vec<Value> = call.args.iter().map(|argument| evaluate(argument, scope)).collect();
            let name = show(&call.func).replace(' ', "");
            let method = name.strip_prefix("L::").unwrap_or_else(|| panic!("a call of `{name}`"));
            lane_method(method, &arguments)
        }
        _ => panic!("the interpreter does not know this: {}", show(expression)),
    }
}

/// The value of a name, a member or an element.
fn place<'s>(expression: &Expr, scope: &'s Scope) -> &'s Value {
    match expression {
        Expr::Path(path) => {
            let name = path.path.get_ident().expect("a name").to_string();
            scope.get(&name).unwrap_or_else(|| panic!("emitted code reads `{name}`, which it has not"))
        }
        Expr::Field(field) => match (place(&field.base, scope), &field.member) {
            (Value::Structure(members), Member::Named(name)) => {
                members.get(&name.to_string()).unwrap_or_else(|| panic!("no member: {}", show(expression)))
            }
            _ => panic!("no member: {}", show(expression)),
        },
        Expr::Index(index) => {
            let (list, index) = (place(&index.expr, scope).list(), index_of(&index.index));
            assert!(index < list.len(), "{} is out of range: {} entries", show(expression), list.len());
            &list[index]
        }
        _ => panic!("not a place: {}", show(expression)),
    }
}

/// The methods of `Lane` for one number, as the contract states them.
fn lane_method(name: &str, arguments: &[Value]) -> Value {
    let number = |index: usize| arguments[index].number();
    let truth = |index: usize| arguments[index].truth();
    let expected = match name {
        "multiply_add" | "select" => 3,
        "powf" | "atan2" | "minimum" | "maximum" | "less" | "less_equal" | "equal" | "and" | "or" => 2,
        _ => 1,
    };
    assert_eq!(arguments.len(), expected, "arguments of L::{name}");
    Value::Number(match name {
        "splat" => number(0),
        "multiply_add" => number(0) * number(1) + number(2),
        "sqrt" => number(0).sqrt(),
        "exp" => number(0).exp(),
        "ln" => number(0).ln(),
        "sin" => number(0).sin(),
        "cos" => number(0).cos(),
        "tan" => number(0).tan(),
        "tanh" => number(0).tanh(),
        "asin" => number(0).asin(),
        "acos" => number(0).acos(),
        "atan" => number(0).atan(),
        "atan2" => number(0).atan2(number(1)),
        "sinh" => number(0).sinh(),
        "cosh" => number(0).cosh(),
        "asinh" => number(0).asinh(),
        "acosh" => number(0).acosh(),
        "atanh" => number(0).atanh(),
        "log10" => number(0).log10(),
        "erf" => error_function(number(0)),
        "erfc" => 1.0 - error_function(number(0)),
        "abs" => number(0).abs(),
        "powf" => number(0).powf(number(1)),
        "minimum" => {
            if number(1) < number(0) {
                number(1)
            } else {
                number(0)
            }
        }
        "maximum" => {
            if number(1) > number(0) {
                number(1)
            } else {
                number(0)
            }
        }
        "select" => return if truth(0) { arguments[1].clone() } else { arguments[2].clone() },
        "less" => return Value::Truth(number(0) < number(1)),
        "less_equal" => return Value::Truth(number(0) <= number(1)),
        "equal" => return Value::Truth(number(0) == number(1)),
        "and" => return Value::Truth(truth(0) && truth(1)),
        "or" => return Value::Truth(truth(0) || truth(1)),
        "not" => return Value::Truth(!truth(0)),
        other => panic!("the interpreter does not know L::{other}"),
    })
}

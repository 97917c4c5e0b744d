//! Rust expressions → the expressions of a weak form; anything else is reported on its tokens.

use quote::ToTokens;
use syn::{BinOp, Expr, ExprIf, Lit, Member, Pat, PatIdent, Stmt, UnOp};

use super::declared_type::{self, Unread};
use super::syntax::*;
use super::whole_number::WholeNumber;
use crate::check::elsewhere;
use crate::diagnostics::{Diagnostics, SourceSpan};

/// Reads `{ let ..; result }`.
pub fn read_block(block: &syn::Block, diagnostics: &mut Diagnostics) -> Option<Block> {
    let mut lets = Vec::new();
    let mut result = None;
    let mut complete = true;
    let last = block.stmts.len().saturating_sub(1);
    for (index, statement) in block.stmts.iter().enumerate() {
        match statement {
            Stmt::Local(local) => match read_let(local, diagnostics) {
                Some(binding) => lets.push(binding),
                None => complete = false,
            },
            Stmt::Expr(expression, None) if index == last => {
                result = read(expression, diagnostics);
                complete &= result.is_some();
            }
            other => {
                diagnostics.error_with_help(
                    SourceSpan::of(other),
                    "unsupported statement in a weak form",
                    "a body is a list of `let name = ..;` and one final expression without semicolon",
                );
                complete = false;
            }
        }
    }
    if result.is_none() && complete {
        diagnostics.error(SourceSpan::of(block), "this body has no final expression, so it gives nothing");
    }
    match (complete, result) {
        (true, Some(result)) => Some(Block { lets, result: Box::new(result) }),
        _ => None,
    }
}

fn read_let(local: &syn::Local, diagnostics: &mut Diagnostics) -> Option<(proc_macro2::Ident, Expression)> {
    let (pattern, declared) = match &local.pat {
        Pat::Type(typed) => (&*typed.pat, Some(&*typed.ty)),
        other => (other, None),
    };
    let (Pat::Ident(name @ PatIdent { by_ref: None, subpat: None, .. }), Some(init)) = (pattern, &local.init)
    else {
        diagnostics.error(SourceSpan::of(local), "unsupported `let`: write `let name = expression;`");
        return None;
    };
    if name.mutability.is_some() || init.diverge.is_some() {
        diagnostics.error(
            SourceSpan::of(local),
            "unsupported `let`: names in a weak form are neither mutable nor conditional",
        );
        return None;
    }
    let value = read(&init.expr, diagnostics)?;
    let Some(ty) = declared else { return Some((name.ident.clone(), value)) };
    let rank = match declared_type::rank(ty, diagnostics) {
        Ok(rank) => rank,
        Err(Unread::Reported) => return None,
        Err(Unread::Unknown) => {
            let help = "leave it out, or write `Scalar`, `Vector` or `Tensor`";
            diagnostics.error_with_help(SourceSpan::of(ty), "this type is not known here", help);
            return None;
        }
    };
    let declared = Expression { span: value.span, kind: ExpressionKind::Declared(rank, Box::new(value)) };
    Some((name.ident.clone(), declared))
}

/// Reads an expression. What cannot be read becomes [`ExpressionKind::Mistake`], after a report, so that
/// the mistakes in the rest of the body are reported in the same run.
pub fn read(expression: &Expr, diagnostics: &mut Diagnostics) -> Option<Expression> {
    let mistake = Expression { span: SourceSpan::of(expression), kind: ExpressionKind::Mistake };
    Some(read_expression(expression, diagnostics).unwrap_or(mistake))
}

/// `None` after a report.
fn read_expression(expression: &Expr, diagnostics: &mut Diagnostics) -> Option<Expression> {
    let span = SourceSpan::of(expression);
    let kind = match expression {
        Expr::Paren(inner) => {
            return read(&inner.expr, diagnostics).map(|inner| Expression { span, ..inner });
        }
        Expr::Group(inner) => return read(&inner.expr, diagnostics),
        Expr::Block(block) if block.label.is_none() => {
            ExpressionKind::Block(read_block(&block.block, diagnostics)?)
        }
        Expr::Lit(literal) => ExpressionKind::Number(read_number(&literal.lit, span, diagnostics)?),
        Expr::Path(path) => match path.path.get_ident() {
            Some(name) => ExpressionKind::Name(name.clone()),
            None => {
                return unsupported(expression, "a path", "names in a weak form have no `::`", diagnostics);
            }
        },
        Expr::Unary(unary) => match unary.op {
            UnOp::Neg(_) => ExpressionKind::Negate(Box::new(read(&unary.expr, diagnostics)?)),
            _ => return unsupported(expression, "this operator", "the prefix operator is `-`", diagnostics),
        },
        Expr::Binary(binary) => {
            let operator = match binary.op {
                BinOp::Add(_) => BinaryOperator::Add,
                BinOp::Sub(_) => BinaryOperator::Subtract,
                BinOp::Mul(_) => BinaryOperator::Multiply,
                BinOp::Div(_) => BinaryOperator::Divide,
                BinOp::BitXor(_) => {
                    return unsupported(expression, "`^`", "a power is `pow(base, exponent)`", diagnostics);
                }
                _ => {
                    let help = "operators are `+ - * /`; comparisons stand between `if` and `{`";
                    return unsupported(expression, "this operator", help, diagnostics);
                }
            };
            // Both sides are read before giving up, so that both sides' mistakes are reported.
            let (left, right) = (read(&binary.left, diagnostics), read(&binary.right, diagnostics));
            ExpressionKind::Binary(operator, Box::new(left?), Box::new(right?))
        }
        Expr::Call(call) => {
            let name = match &*call.func {
                Expr::Path(path) => path.path.get_ident().cloned(),
                _ => None,
            };
            let Some(name) = name else {
                let help = "a call is `name(arguments)`";
                return unsupported(&call.func, "this kind of call", help, diagnostics);
            };
            let arguments: Vec<_> = call.args.iter().map(|argument| read(argument, diagnostics)).collect();
            ExpressionKind::Call(name, arguments.into_iter().collect::<Option<_>>()?)
        }
        Expr::Index(index) => {
            let base = read(&index.expr, diagnostics);
            let indices = read_indices(&index.index, diagnostics);
            match base? {
                // `F[0][1]` is `F[(0, 1)]`; an index behind a range applies to the result of the range.
                Expression { kind: ExpressionKind::Index(inner, mut first), .. }
                    if first.iter().all(|index| matches!(index.kind, IndexKind::One(_))) =>
                {
                    first.extend(indices?);
                    ExpressionKind::Index(inner, first)
                }
                base => ExpressionKind::Index(Box::new(base), indices?),
            }
        }
        Expr::Array(array) => {
            let entries: Vec<_> = array.elems.iter().map(|entry| read(entry, diagnostics)).collect();
            ExpressionKind::Array(entries.into_iter().collect::<Option<_>>()?)
        }
        Expr::Repeat(repeat) => {
            let entry = read(&repeat.expr, diagnostics);
            let span = SourceSpan::of(&repeat.len);
            let count = WholeNumber::read(&repeat.len);
            if count.is_none() {
                declared_type::report_extent(span, diagnostics);
            }
            ExpressionKind::Repeat(Box::new(entry?), count?, span)
        }
        Expr::If(branch) => read_if(branch, diagnostics)?,
        Expr::MethodCall(call) => {
            let word = |expression: &Expr| match expression {
                Expr::Path(path) => path.path.get_ident().map(ToString::to_string),
                _ => None,
            };
            let words: Option<Vec<_>> = [&*call.receiver].into_iter().chain(&call.args).map(word).collect();
            let arguments = words.map_or_else(|| "..".into(), |words| words.join(", "));
            let known = elsewhere::help(&call.method.to_string()).map(str::to_string);
            let help = known.unwrap_or_else(|| format!("write `{}({arguments})`, a function", call.method));
            return unsupported(expression, "a method call", &help, diagnostics);
        }
        Expr::Field(field) => {
            let help = match &field.member {
                Member::Named(name) => match elsewhere::help(&name.to_string()) {
                    Some(help) => help.to_string(),
                    None => format!("members of the data struct are used by their name, `{name}`"),
                },
                Member::Unnamed(index) => format!("a component is `name[{}]`", index.index),
            };
            return unsupported(expression, "`.`", &help, diagnostics);
        }
        Expr::Closure(_) => {
            return unsupported(expression, "a closure", "write a local function", diagnostics);
        }
        Expr::Macro(_) => {
            return unsupported(expression, "a macro call", "macros are not expanded here", diagnostics);
        }
        Expr::Match(_) => {
            return unsupported(expression, "`match`", "write `if .. { .. } else { .. }`", diagnostics);
        }
        Expr::Cast(_) => {
            return unsupported(expression, "`as`", "every number is real: leave it out", diagnostics);
        }
        Expr::Loop(_) | Expr::While(_) | Expr::ForLoop(_) => {
            return unsupported(
                expression,
                "a loop",
                "sums over indices are `dot`, `inner`, `tr`",
                diagnostics,
            );
        }
        _ => {
            let help = "a weak form is made of names, numbers, `+ - * /`, calls, `if`, `let` and indices";
            return unsupported(expression, "this Rust syntax", help, diagnostics);
        }
    };
    Some(Expression { span, kind })
}

fn read_if(branch: &ExprIf, diagnostics: &mut Diagnostics) -> Option<ExpressionKind> {
    let condition = read_condition(&branch.cond, diagnostics);
    let taken = read_block(&branch.then_branch, diagnostics);
    let Some((_, otherwise)) = &branch.else_branch else {
        diagnostics.error_with_help(
            SourceSpan::of(branch),
            "this `if` has no `else`",
            "a weak form needs a value in both cases: add `else { 0 }` or what is meant",
        );
        return None;
    };
    let otherwise = match &**otherwise {
        Expr::Block(block) => read_block(&block.block, diagnostics),
        other => read(other, diagnostics).map(|result| Block { lets: vec![], result: Box::new(result) }),
    };
    Some(ExpressionKind::If(Box::new(condition?), taken?, otherwise?))
}

fn read_condition(condition: &Expr, diagnostics: &mut Diagnostics) -> Option<Condition> {
    match condition {
        Expr::Paren(inner) => read_condition(&inner.expr, diagnostics),
        Expr::Unary(unary) if matches!(unary.op, UnOp::Not(_)) => {
            read_condition(&unary.expr, diagnostics).map(|inner| Condition::Not(Box::new(inner)))
        }
        Expr::Binary(binary) => {
            let comparison = match binary.op {
                BinOp::And(_) | BinOp::Or(_) => {
                    let left = read_condition(&binary.left, diagnostics);
                    let right = read_condition(&binary.right, diagnostics);
                    let (left, right) = (Box::new(left?), Box::new(right?));
                    let both = matches!(binary.op, BinOp::And(_));
                    return Some(if both { Condition::And(left, right) } else { Condition::Or(left, right) });
                }
                BinOp::Lt(_) => Comparison::Less,
                BinOp::Le(_) => Comparison::LessEqual,
                BinOp::Gt(_) => Comparison::Greater,
                BinOp::Ge(_) => Comparison::GreaterEqual,
                BinOp::Eq(_) => Comparison::Equal,
                BinOp::Ne(_) => Comparison::NotEqual,
                _ => return not_a_condition(condition, diagnostics),
            };
            let (left, right) = (read(&binary.left, diagnostics), read(&binary.right, diagnostics));
            Some(Condition::Compare(comparison, left?, right?))
        }
        _ => not_a_condition(condition, diagnostics),
    }
}

fn not_a_condition(condition: &Expr, diagnostics: &mut Diagnostics) -> Option<Condition> {
    diagnostics.error_with_help(
        SourceSpan::of(condition),
        "this is not a condition",
        "compare two scalars with `< <= > >= == !=`, and join with `&& || !`",
    );
    None
}

fn read_indices(index: &Expr, diagnostics: &mut Diagnostics) -> Option<Vec<Index>> {
    let read: Vec<_> = match index {
        Expr::Tuple(tuple) if !tuple.elems.is_empty() => tuple.elems.iter().map(read_index).collect(),
        other => vec![read_index(other)],
    };
    let indices: Option<Vec<_>> = read.into_iter().collect();
    if indices.is_none() {
        diagnostics.error_with_help(
            SourceSpan::of(index),
            "an index is a whole number known here",
            "write `u[0]`, `u[D - 1]`, `F[0][1]` or `F[(0, 1)]`, and for more than one entry `u[0..2]` or `F[(.., 1)]`",
        );
    }
    indices
}

fn read_index(index: &Expr) -> Option<Index> {
    let kind = match index {
        Expr::Range(range) => {
            // `None` inside: a bound that is no number.
            let bound = |bound: &Option<Box<Expr>>| match bound {
                Some(bound) => WholeNumber::read(bound).map(Some),
                None => Some(None),
            };
            let (start, end) = (bound(&range.start)?, bound(&range.end)?);
            let closed = matches!(range.limits, syn::RangeLimits::Closed(_));
            IndexKind::Range { start, end: end.map(|end| if closed { end.successor() } else { end }) }
        }
        other => IndexKind::One(WholeNumber::read(other)?),
    };
    Some(Index { span: SourceSpan::of(index), kind })
}

/// The value of a literal. `None` after a report.
pub(super) fn read_number(literal: &Lit, span: SourceSpan, diagnostics: &mut Diagnostics) -> Option<f64> {
    let (digits, suffix) = match literal {
        Lit::Int(integer) => (integer.base10_digits().to_string(), integer.suffix().to_string()),
        Lit::Float(float) => (float.base10_digits().to_string(), float.suffix().to_string()),
        Lit::Str(text) if matches!(text.value().as_str(), "+" | "-") => {
            let message = "unsupported literal: a weak form has numbers only";
            let help = "the sides of an interior facet are `this(u)` and `other(u)`";
            diagnostics.error_with_help(span, message, help);
            return None;
        }
        _ => {
            diagnostics.error(span, "unsupported literal: a weak form has numbers only");
            return None;
        }
    };
    match (digits.parse::<f64>(), suffix.as_str()) {
        (Ok(value), "" | "f64") if value.is_finite() => Some(value),
        (_, "" | "f64") => {
            diagnostics.error(span, "this number does not fit a 64-bit float");
            None
        }
        _ => {
            diagnostics.error_with_help(
                span,
                format!("the suffix `{suffix}` has no meaning here"),
                "every number is real: leave it out",
            );
            None
        }
    }
}

fn unsupported<T>(
    tokens: &impl ToTokens,
    what: &str,
    help: &str,
    diagnostics: &mut Diagnostics,
) -> Option<T> {
    diagnostics.error_with_help(
        SourceSpan::of(tokens),
        format!("unsupported syntax in a weak form: {what}"),
        help,
    );
    None
}

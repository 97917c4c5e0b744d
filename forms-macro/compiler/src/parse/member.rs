//! A member of the data struct: `#[default(0)] pub traction: Given<Vector>`.

use proc_macro2::Ident;
use quote::{ToTokens, quote};
use syn::{Attribute, Expr, ExprLit, ExprUnary, Field, Meta, UnOp};

use super::attributes;
use super::declared_type::{self, Unread};
use super::expression::read_number;
use super::inclusion::{included_from, of_member};
use super::syntax::{Member, MemberKind, Rank};
use crate::diagnostics::{Diagnostics, SourceSpan};

/// Reads a member. `None` after a report; what is wrong with an included member was reported where that is declared.
pub fn read(field: &Field, diagnostics: &mut Diagnostics) -> Option<Member> {
    let included = included_from(&field.attrs);
    let mut silent = Diagnostics::default();
    let diagnostics = if included.is_some() { &mut silent } else { diagnostics };
    let name = field.ident.clone()?;
    let found = match declared_type::word(&field.ty) {
        Some((outer, inner)) => {
            let kind = match outer.to_string().as_str() {
                "Param" => Some(MemberKind::Param),
                "Given" => Some(MemberKind::Given),
                "Carried" => Some(MemberKind::Carried),
                "Table" => Some(MemberKind::Table),
                "History" => Some(MemberKind::History),
                _ => None,
            };
            match (kind, inner) {
                (Some(MemberKind::Table), None) => Ok((MemberKind::Table, Rank::SCALAR)),
                (Some(MemberKind::Table), Some(_)) => Err(Unread::Unknown),
                (Some(MemberKind::Param), None) => Ok((MemberKind::Param, Rank::SCALAR)),
                (Some(kind), Some(inner)) => declared_type::rank(inner, diagnostics).map(|rank| (kind, rank)),
                _ => Err(Unread::Unknown),
            }
        }
        None => Err(Unread::Unknown),
    };
    let (kind, rank) = match found {
        Ok(found) => found,
        Err(Unread::Reported) => return None,
        Err(Unread::Unknown) => {
            diagnostics.error_with_help(
                SourceSpan::of(&field.ty),
                format!("`{name}` has a type that is not known here"),
                "write `Param`, `Param<Vector>`, `Param<Tensor>`, `Given<Scalar>`, `Given<Vector>`, `Given<Tensor>`, `Table`, or `Carried<..>`, `History<..>` as `Given<..>`",
            );
            return None;
        }
    };
    if let Some((equals, value)) = &field.default {
        let place = SourceSpan::of(&quote! { #equals #value });
        let help = "give the value where the struct is made, or write `#[default(0)]` before the member";
        diagnostics.error_with_help(place, format!("the member `{name}` has no value of its own"), help);
    }
    let is_default = |attribute: &Attribute| attribute.path().is_ident("default");
    let (defaults, others): (Vec<_>, Vec<_>) = field.attrs.iter().cloned().partition(is_default);
    if let Some(second) = defaults.get(1) {
        diagnostics.error(SourceSpan::of(second), format!("the member `{name}` has two defaults"));
    }
    let default =
        defaults.first().and_then(|attribute| read_default(&name, attribute, kind, rank, diagnostics));
    let attributes = attributes::of_declaration(of_member(others), diagnostics);
    Some(Member { attributes, name, kind, rank, included, default })
}

/// The number in `#[default(number)]`. `None` after a report.
fn read_default(
    name: &Ident,
    attribute: &Attribute,
    kind: MemberKind,
    rank: Rank,
    diagnostics: &mut Diagnostics,
) -> Option<f64> {
    if matches!(kind, MemberKind::Table | MemberKind::History) {
        let message = format!("`{name}` has no default: it is made of data points");
        let message = match kind {
            MemberKind::History => format!("`{name}` has no default: the assembler makes it"),
            _ => message,
        };
        diagnostics.error_with_help(SourceSpan::of(attribute), message, "leave `#[default(..)]` out");
        return None;
    }
    let value = match &attribute.meta {
        Meta::List(list) => list.parse_args::<Expr>().ok(),
        _ => None,
    };
    let number = match &value {
        Some(Expr::Lit(ExprLit { lit, .. })) => Some((lit, 1.0)),
        Some(Expr::Unary(ExprUnary { op: UnOp::Neg(_), expr, .. })) => match &**expr {
            Expr::Lit(ExprLit { lit, .. }) => Some((lit, -1.0)),
            _ => None,
        },
        _ => None,
    };
    let Some((literal, sign)) = number else {
        diagnostics.error_with_help(
            SourceSpan::of(attribute),
            format!("the default of `{name}` is not a number"),
            "write `#[default(0)]`; what is no number is given where the struct is made",
        );
        return None;
    };
    let number = sign * read_number(literal, SourceSpan::of(&value), diagnostics)?;
    if rank != Rank::SCALAR && number != 0.0 {
        diagnostics.error_with_help(
            SourceSpan::of(&value),
            format!("`{name}` is a `{rank}`, and its default is a number"),
            "`0` stands for zeros of any shape; what else it may be is given where the struct is made",
        );
        return None;
    }
    Some(number)
}

/// The most likely meaning of a member with a mistaken type.
pub fn likely(name: &Ident, field: &Field) -> Member {
    let text = field.ty.to_token_stream().to_string();
    let kind = match &text {
        text if text.contains("Table") => MemberKind::Table,
        text if text.contains("Hist") => MemberKind::History,
        text if text.contains("Carr") => MemberKind::Carried,
        text if text.contains("Given") => MemberKind::Given,
        _ => MemberKind::Param,
    };
    let rank = match text {
        text if text.contains('V') => Rank::VECTOR,
        text if text.contains(['T', 'M']) => Rank::TENSOR,
        _ => Rank::SCALAR,
    };
    let included = included_from(&field.attrs);
    Member { attributes: vec![], name: name.clone(), kind, rank, included, default: None }
}

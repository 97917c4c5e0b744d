//! Declared types: `Scalar`, `Vector<3>`, `Matrix<2, D>`, alone or inside a word (`Param<Tensor>`).

use proc_macro2::Ident;
use syn::{Expr, GenericArgument, Lit, PathArguments, Type};

use super::syntax::{Extent, Rank};
use crate::diagnostics::{Diagnostics, SourceSpan};

/// Reasons why there is no [`Rank`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unread {
    /// The word is no shape: the caller says what is allowed.
    Unknown,
    /// The word is right and what follows it is not, which has been reported.
    Reported,
}

/// `Param<Vector>` → (`Param`, Some(`Vector`)); `Param` → (`Param`, None).
pub fn word(ty: &Type) -> Option<(&Ident, Option<&Type>)> {
    let Type::Path(path) = ty else { return None };
    let segment = path.path.segments.last()?;
    let inner = match &segment.arguments {
        PathArguments::None => None,
        PathArguments::AngleBracketed(arguments) => match arguments.args.first() {
            Some(GenericArgument::Type(inner)) if arguments.args.len() == 1 => Some(inner),
            _ => return None,
        },
        PathArguments::Parenthesized(_) => return None,
    };
    Some((&segment.ident, inner))
}

/// Reads the extents of a declared shape.
pub fn rank(ty: &Type, diagnostics: &mut Diagnostics) -> Result<Rank, Unread> {
    let Type::Path(path) = ty else { return Err(Unread::Unknown) };
    let segment = path.path.segments.last().ok_or(Unread::Unknown)?;
    let arguments: Vec<&GenericArgument> = match &segment.arguments {
        PathArguments::None => vec![],
        PathArguments::AngleBracketed(arguments) => arguments.args.iter().collect(),
        PathArguments::Parenthesized(_) => return Err(Unread::Unknown),
    };
    let word = segment.ident.to_string();
    // The word alone, and with its extents.
    let (alone, count, usage) = match word.as_str() {
        "Scalar" => (Some(Rank::SCALAR), 0, "`Scalar`"),
        "Vector" => (Some(Rank::VECTOR), 1, "`Vector`, whose length is the dimension, or `Vector<3>`"),
        "Matrix" => (None, 2, "`Matrix<2, 3>` with 2 rows and 3 columns"),
        "Tensor" => {
            (Some(Rank::TENSOR), 0, "`Tensor`, or `Matrix<2, 3>` for other extents than the dimension")
        }
        "Tensor4" => (Some(Rank::TENSOR4), 0, "`Tensor4`, whose four extents are the dimension"),
        _ => return Err(Unread::Unknown),
    };
    match alone {
        Some(rank) if arguments.is_empty() => return Ok(rank),
        _ => {}
    }
    if arguments.len() != count {
        let extents = if count == 1 { "extent" } else { "extents" };
        let message = match count {
            0 => format!("`{word}` has no extents of its own"),
            _ => format!("`{word}` has {count} {extents}, not {}", arguments.len()),
        };
        diagnostics.error_with_help(SourceSpan::of(ty), message, format!("write {usage}"));
        return Err(Unread::Reported);
    }
    let extents: Vec<_> = arguments.iter().map(|argument| extent(argument, diagnostics)).collect();
    let extents = extents.into_iter().collect::<Option<Vec<_>>>().ok_or(Unread::Reported)?;
    Rank::new(&extents).ok_or(Unread::Unknown)
}

/// The largest extent that may be declared.
pub const LARGEST: usize = 16;

/// `None` after a report.
fn extent(argument: &GenericArgument, diagnostics: &mut Diagnostics) -> Option<Extent> {
    match argument {
        GenericArgument::Type(Type::Path(path)) if path.path.is_ident("D") => return Some(Extent::Dimension),
        GenericArgument::Const(Expr::Lit(literal)) => {
            if let Lit::Int(integer) = &literal.lit
                && let Ok(value @ 1..=LARGEST) = integer.base10_parse::<usize>()
            {
                return Some(Extent::Fixed(value));
            }
        }
        _ => {}
    }
    report_extent(SourceSpan::of(argument), diagnostics);
    None
}

/// Reports what is no extent.
pub fn report_extent(span: SourceSpan, diagnostics: &mut Diagnostics) {
    let message = format!("an extent is a whole number from 1 to {LARGEST}, or `D`, the dimension");
    diagnostics.error_with_help(span, message, "write `Vector<3>` or `Matrix<D, 3>`");
}

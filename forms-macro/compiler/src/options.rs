//! The options of `#[forms(..)]` and `form!`: the dimension, products without a matrix, derivatives by a level set function, and the crate that
//! has the contract.

use proc_macro2::TokenStream;
use quote::ToTokens;
use syn::parse::{Parse, ParseStream};
use syn::{Ident, LitInt, Path, Token};

/// Products of a tangent and a vector.
#[derive(Clone, Copy, PartialEq)]
pub enum Products {
    /// By its matrix.
    ByMatrices,
    /// By kernels of their own, without a matrix.
    MatrixFree,
}

/// Kernels for derivatives by the points of integrals.
#[derive(Clone, Copy, PartialEq)]
pub enum Points {
    /// None.
    Held,
    /// Those of a body that is cut by a level set function.
    MovedByLevelSet,
}

/// `#[forms(dimension = 3, matrix_free, level_set_derivatives, crate = my_backend)]`
pub struct Options {
    /// The dimensions for which forms are compiled.
    pub dimensions: Vec<usize>,
    /// The path of the crate that has the contract.
    pub backend: Path,
    /// The way to products of the tangent with a vector.
    pub products: Products,
    /// Derivatives by points.
    pub points: Points,
    written: TokenStream,
}

impl Parse for Options {
    fn parse(input: ParseStream) -> syn::Result<Self> {
        let written = input.fork().parse()?;
        let mut options = Options {
            dimensions: vec![2, 3],
            backend: syn::parse_quote!(::forms_fem),
            products: Products::ByMatrices,
            points: Points::Held,
            written,
        };
        while !input.is_empty() {
            if input.peek(Token![crate]) {
                input.parse::<Token![crate]>()?;
                input.parse::<Token![=]>()?;
                options.backend = rooted(input.call(Path::parse_mod_style)?);
            } else {
                let name: Ident = input.parse()?;
                if name == "matrix_free" || name == "level_set_derivatives" {
                    match name == "matrix_free" {
                        true => options.products = Products::MatrixFree,
                        false => options.points = Points::MovedByLevelSet,
                    }
                    if !input.is_empty() {
                        input.parse::<Token![,]>()?;
                    }
                    continue;
                }
                if name != "dimension" {
                    let message = format!(
                        "unknown option `{name}`\nhelp: the options are `dimension = 2`, `dimension = 3`, `matrix_free`, `level_set_derivatives` and `crate = path`"
                    );
                    return Err(syn::Error::new(name.span(), message));
                }
                input.parse::<Token![=]>()?;
                let value: LitInt = input.parse()?;
                match value.base10_parse::<usize>() {
                    Ok(dimension @ (2 | 3)) => options.dimensions = vec![dimension],
                    _ => return Err(syn::Error::new(value.span(), "the dimension is 2 or 3")),
                }
            }
            if !input.is_empty() {
                input.parse::<Token![,]>()?;
            }
        }
        Ok(options)
    }
}

/// As they were written.
impl ToTokens for Options {
    fn to_tokens(&self, tokens: &mut TokenStream) {
        self.written.to_tokens(tokens);
    }
}

/// A path that begins with a crate's name says so: a function of the module may have that name, too.
fn rooted(mut path: Path) -> Path {
    let relative = |name: &Ident| name == "crate" || name == "self" || name == "super";
    if !path.segments.first().is_some_and(|first| relative(&first.ident)) {
        path.leading_colon.get_or_insert_default();
    }
    path
}

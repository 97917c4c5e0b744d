//! A name that is imported: [`Import`], as a module asks for it, and [`Imported`], with what was found.

use proc_macro2::{Ident, TokenStream};
use syn::{ItemFn, Visibility};

use crate::sorted::SortedMap;

/// One name that is imported.
pub struct Import {
    /// `super::elasticity::stress`, as written.
    pub path: TokenStream,
    /// The name in the other module.
    pub name: Ident,
    /// The name here: the same, unless `as` says otherwise.
    pub local: Ident,
    /// Private: the function is called here. Otherwise it is a function of this module, too.
    pub visibility: Visibility,
    /// Kind of import.
    pub asked: Asked,
}

/// Kinds of imports.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Asked {
    /// A function, a region or the data struct, by a `use`.
    Item,
    /// The members of data that this module's include, by `#[includes(path)]`.
    Members,
}

/// An import that has been found.
pub struct Imported {
    pub local: Ident,
    pub visibility: Visibility,
    /// The name of the function among `functions`: its name and its module's identity. One function that comes on two ways
    /// has one canonical name.
    pub canonical: String,
    /// The function and all that it calls, by their canonical names.
    pub functions: SortedMap<String, ItemFn>,
    /// It has mistakes or lacks data, which has been reported.
    pub silent: bool,
}

//! The syntax tree of a forms module: what `parse` gives and `check` reads.

mod expression;
mod rank;

use proc_macro2::{Ident, Span, TokenStream};
use syn::{Attribute, Visibility};

use super::inclusion::FirstIncluded;

pub use expression::{
    BinaryOperator, Block, Comparison, Condition, Expression, ExpressionKind, Index, IndexKind,
};
pub use rank::{Extent, Rank};

/// A module of weak forms.
pub struct Module {
    pub name: Ident,
    pub data: Option<Data>,
    pub regions: Vec<Region>,
    pub functions: Vec<Function>,
    pub externals: Vec<External>,
    /// Names with a mistake in their declaration: they exist, and their uses are no further mistakes.
    pub mistaken: Vec<Mistaken>,
}

impl Module {
    /// Does it declare contact pairs?
    pub fn has_pairs(&self) -> bool {
        self.regions.iter().any(|region| region.entity == Entity::Pairs)
    }

    /// Was the name declared with a mistake, which has been reported?
    pub fn is_mistaken(&self, name: &Ident) -> bool {
        let mut names = self.mistaken.iter().map(|mistaken| match mistaken {
            Mistaken::Member(Member { name, .. })
            | Mistaken::Region(name)
            | Mistaken::External(name)
            | Mistaken::Import(name)
            | Mistaken::Function { name, .. } => name,
        });
        // What the included data did not bring may be any name.
        let incomplete = self.data.as_ref().is_some_and(|data| data.incomplete);
        let region = || self.regions.iter().any(|region| region.name == *name);
        names.any(|other| other == name) || (incomplete && !region())
    }

    /// The members of the data struct: those of included data first.
    pub fn members(&self) -> impl Iterator<Item = &Member> + Clone {
        self.data.iter().flat_map(|data| &data.members)
    }
}

/// A declaration with a mistake.
pub enum Mistaken {
    /// As it was most likely meant.
    Member(Member),
    /// It is among the module's regions, too.
    Region(Ident),
    /// A function of an `extern` block.
    External(Ident),
    /// The name that an import would have here.
    Import(Ident),
    Function {
        visibility: Visibility,
        name: Ident,
        /// The number of arguments that are neither unknowns nor test functions.
        arguments: usize,
        /// The most likely kind of result.
        output: Output,
    },
}

/// The struct whose members are the data of all forms of the module.
pub struct Data {
    pub attributes: Vec<Attribute>,
    pub visibility: Visibility,
    pub name: Ident,
    /// The first struct that this one includes.
    pub first: Option<FirstIncluded>,
    /// Members of included data are not known, which has been reported.
    pub incomplete: bool,
    pub members: Vec<Member>,
}

impl Data {
    /// The emitted function that begins data.
    pub const BEGIN: &'static str = "data";
    /// The emitted function that begins data with a value of the first included data.
    pub const BEGIN_FROM: &'static str = "data_from";

    /// Is the name that of a function that is emitted next to the struct?
    pub fn emits(&self, name: &str) -> bool {
        name == Data::BEGIN || (name == Data::BEGIN_FROM && self.first.is_some())
    }
}

/// `lambda: Param` or `gap: Given<Scalar>`.
pub struct Member {
    pub attributes: Vec<Attribute>,
    pub name: Ident,
    pub kind: MemberKind,
    pub rank: Rank,
    /// The path of the included data that it comes from, for messages.
    pub included: Option<String>,
    /// Each component, unless another value is given.
    pub default: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MemberKind {
    /// Constant over the mesh.
    Param,
    /// A field, or a function of x, fixed in space.
    Given,
    /// A field, or a function of x, that moves with the body.
    Carried,
    /// A function of one scalar given by data points: it is called.
    Table,
    /// Values at quadrature points.
    History,
}

/// The entities of a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Entity {
    Cells,
    /// Exterior facets.
    Facets,
    InteriorFacets,
    /// Exterior facets, each point with one opposite to it.
    Pairs,
    /// The zeros of a level set function inside cells.
    Interface,
}

impl Entity {
    /// The marker before a region's struct.
    pub const MARKERS: [(&'static str, Entity); 5] = [
        ("cells", Entity::Cells),
        ("facets", Entity::Facets),
        ("interior_facets", Entity::InteriorFacets),
        ("pairs", Entity::Pairs),
        ("interface", Entity::Interface),
    ];

    /// Are there two cells at each of its points?
    pub fn is_two_sided(self) -> bool {
        matches!(self, Entity::InteriorFacets | Entity::Pairs)
    }

    /// For messages.
    pub fn plural(self) -> &'static str {
        match self {
            Entity::Cells => "cells",
            Entity::Facets => "exterior facets",
            Entity::InteriorFacets => "interior facets",
            Entity::Pairs => "contact pairs",
            Entity::Interface => "the points of an interface",
        }
    }
}

/// The points of the integrals over a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RegionRule {
    OfBackend,
    /// `#[facets(vertices)]`
    Vertices,
}

/// `#[cells] struct Omega;`, `#[facets] struct GammaC;`, `#[interior_facets] struct Skeleton;` or `#[pairs] struct Touch;`
pub struct Region {
    pub attributes: Vec<Attribute>,
    pub visibility: Visibility,
    pub name: Ident,
    pub entity: Entity,
    pub rule: RegionRule,
}

/// A function of the module: a form, an energy, a functional, or a local function.
pub struct Function {
    pub attributes: Vec<Attribute>,
    pub visibility: Visibility,
    pub name: Ident,
    pub arguments: Vec<Argument>,
    pub output: Output,
    /// `None` when the body had a syntax error, which has been reported.
    pub body: Option<Block>,
    /// It was imported from another module.
    pub foreign: Option<Foreign>,
}

/// An imported function.
pub struct Foreign {
    /// "`stress` in contact/src/operators/materials.rs:47".
    pub origin: String,
    /// It is a function of this module, too (`pub use`); otherwise it is called, and nothing to assemble by itself.
    pub emitted: bool,
    /// It has mistakes or lacks data, which has been reported: what follows from that is no further mistake.
    pub silent: bool,
}

/// `fn flux(g: Vector, k: Scalar) -> Vector;` in an `extern "Rust"` block: a function written in Rust.
pub struct External {
    pub name: Ident,
    /// Its path from inside the module.
    pub path: TokenStream,
    /// Arguments, all with the role [`ArgumentRole::Plain`].
    pub arguments: Vec<Argument>,
    pub output: Rank,
    /// The place of the output's type.
    pub output_span: Span,
}

pub struct Argument {
    pub name: Ident,
    pub role: ArgumentRole,
    pub rank: Rank,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ArgumentRole {
    /// `w: Vector`: whatever the caller passes.
    Plain,
    Unknown,
    Test,
    State,
}

/// The result of a function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Output {
    Value(Rank),
    Form,
    Energy,
    Functional,
}

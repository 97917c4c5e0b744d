//! Compiled forms, as they hand kernels and the compiler's knowledge to a backend.
//!
//! A form is a value of a type that `#[forms]` emits. The backend walks its integrals with a visitor,
//! so each kernel arrives with its static type and is inlined into the backend's loops.

use crate::degree::Degree;
use crate::dimension::Constants;
use crate::kernel::{BilinearKernel, ExpressionKernel, LinearKernel, Side};
use crate::pairing::Pairing;
use crate::source::{FieldValue, Source};
use crate::table::Table;

/// The entities of a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entity {
    /// Cells: ∫ … dx.
    Cells,
    /// Exterior facets: ∫ … ds.
    Facets,
    /// Interior facets, seen from both of their cells: ∫ … dS.
    InteriorFacets,
    /// Exterior facets, each point of them with a point opposite to it: contact pairs.
    Pairs,
}

/// A region of integration: declared in the module, bound by the user to a name of the mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Region {
    /// Cells, exterior or interior facets.
    pub entity: Entity,
    /// The name declared in the forms module (`GammaC`).
    pub symbol: &'static str,
    /// The name in the mesh (`"contact"`); of pairs, the names of their surfaces, for messages.
    pub name: String,
    /// The surfaces of [`Entity::Pairs`]; `None` for other entities.
    pub pairing: Option<Pairing>,
}

impl Region {
    /// Cells or facets by their name in the mesh.
    pub fn named(entity: Entity, symbol: &'static str, name: impl Into<String>) -> Self {
        Region { entity, symbol, name: name.into(), pairing: None }
    }

    /// Contact pairs.
    pub fn of_pairs(symbol: &'static str, pairing: Pairing) -> Self {
        Region { entity: Entity::Pairs, symbol, name: pairing.to_string(), pairing: Some(pairing) }
    }
}

/// The part that a field plays in a form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// The k-th unknown.
    Unknown(usize),
    /// The k-th test function.
    Test(usize),
    /// A known field that came as an argument.
    State,
    /// A field, function of position or history among the data.
    Given,
    /// The direction for the k-th unknown: only [`Form::action`] reads it. It has no source among the inputs.
    Direction(usize),
}

/// One field of a form, by index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FieldDescription {
    /// The name in the source.
    pub name: &'static str,
    /// Its role.
    pub role: Role,
    /// Shape in this dimension: `[]`, `[D]`, `[D, D]`, or with extents of its own, `[3]`.
    pub shape: &'static [usize],
}

impl FieldDescription {
    /// Number of scalar components.
    pub fn components(&self) -> usize {
        self.shape.iter().product()
    }
}

/// The dependence of an integral on the unknowns; proved by the compiler.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dependence {
    /// Not at all: a load. Its tangent does not exist.
    Constant,
    /// Linearly: its tangent does not depend on the unknowns.
    Linear,
    /// Otherwise.
    Nonlinear,
}

/// The description of one integral. A form has one per region and [`Dependence`], whatever
/// the number of `integral(..)` terms in its source; with one unknown, what is linear and what is nonlinear on the same
/// cells is one nonlinear integral.
#[derive(Clone, Copy, Debug)]
pub struct Integral {
    /// Index into [`Inputs::regions`].
    pub region: usize,
    /// Of pairs of displaced surfaces: the fields (by index) whose sum displaces them. Opposite points lie on rays along the
    /// deformed normal, whatever the region's [`Pairing::projection`](crate::pairing::Pairing). `None` for other regions and
    /// for pairs of the undeformed mesh.
    pub displacement: Option<&'static [usize]>,
    /// Index of the test function (0 in functionals).
    pub test: usize,
    /// Index of the unknown of the trial function (tangents only, else 0).
    pub trial: usize,
    /// The cell on which the test function lives: on an interior facet each side has kernels of its own.
    pub test_side: Side,
    /// The cell on which the trial function lives.
    pub trial_side: Side,
    /// The dependence of the residual's integral on the unknowns.
    pub dependence: Dependence,
    /// The integral is zero where the unknowns are; proved (linear integrals of the residual only, else false).
    pub vanishes: bool,
    /// The tangent's blocks are proved symmetric (tangents only, else false).
    pub symmetric: bool,
    /// Degree of the integrand as a polynomial of the place, from which follows that of a quadrature rule, with the measure's
    /// where that varies ([`Degree::over`]).
    pub degree: Degree,
}

/// The data that a form was built with.
#[derive(Clone, Debug)]
pub struct Inputs<const D: usize> {
    /// The source of each field; `None` for unknowns, test functions and directions.
    pub sources: Vec<Option<Source<D>>>,
    /// The regions, bound.
    pub regions: Vec<Region>,
    /// All parameters, flattened in the order of the `Data` struct.
    pub parameters: Vec<f64>,
    /// Names of the entries of `parameters` (`n_y[1]`), for messages.
    pub parameter_names: Vec<String>,
    /// The tabulated laws of the `Data` struct, in their order.
    pub tables: Vec<Table>,
    /// Was the form's crate compiled with optimisation, as far as the macro could see? Kernels of one that was not are some
    /// hundred times slower.
    pub optimised: bool,
}

impl<const D: usize> Inputs<D> {
    /// No data, no regions.
    pub fn empty() -> Self {
        Inputs {
            sources: Vec::new(),
            regions: Vec::new(),
            parameters: Vec::new(),
            parameter_names: Vec::new(),
            tables: Vec::new(),
            optimised: true,
        }
    }

    /// Parameters and tables, as kernels read them.
    pub fn constants(&self) -> Constants<'_> {
        Constants { parameters: &self.parameters, tables: &self.tables }
    }

    /// Appends a parameter of any rank.
    pub fn push_parameter<V: FieldValue>(&mut self, name: &str, value: &V) {
        let start = self.parameters.len();
        self.parameters.resize(start + V::COMPONENTS, 0.0);
        value.write(&mut self.parameters[start..]);
        for component in 0..V::COMPONENTS {
            self.parameter_names.push(match V::COMPONENTS {
                1 => name.to_string(),
                _ => format!("{name}[{component}]"),
            });
        }
    }
}

/// A receiver of the integrals of a residual, or of a tangent's action.
pub trait LinearVisitor<const D: usize> {
    /// The error that stops the walk.
    type Error;
    /// One integral.
    fn visit<K: LinearKernel<D>>(&mut self, integral: &Integral, kernel: &K) -> Result<(), Self::Error>;
}

/// A receiver of the integrals of a tangent.
pub trait BilinearVisitor<const D: usize> {
    /// The error that stops the walk.
    type Error;
    /// One integral.
    fn visit<K: BilinearKernel<D>>(&mut self, integral: &Integral, kernel: &K) -> Result<(), Self::Error>;
}

/// A receiver of densities and derived fields.
pub trait ExpressionVisitor<const D: usize> {
    /// The error that stops the walk.
    type Error;
    /// One expression; for a derived field, `integral.region` means nothing.
    fn visit<K: ExpressionKernel<D>>(&mut self, integral: &Integral, kernel: &K) -> Result<(), Self::Error>;
}

/// A function of a forms module as mathematics, with its derivatives and the meaning of the names in them.
///
/// It is made from the checked form, so that a wrong sign can be seen; rustdoc shows the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Formula {
    /// Lines of plain text.
    pub unicode: &'static str,
    /// LaTeX for the package amsmath.
    pub latex: &'static str,
}

impl Formula {
    /// That of a form which was not made by `#[forms]`: nothing.
    pub const NONE: Formula = Formula { unicode: "", latex: "" };
}

/// A residual R(u; v), linear in its test functions, and its tangent ∂R/∂u by the compiler.
pub trait Form<const D: usize> {
    /// The form's name in its module.
    fn name(&self) -> &'static str;
    /// Its fields, by index.
    fn fields(&self) -> &'static [FieldDescription];
    /// Data, regions, parameters.
    fn inputs(&self) -> &Inputs<D>;
    /// Itself as mathematics.
    fn formula(&self) -> &'static Formula {
        &Formula::NONE
    }
    /// Walks the integrals of the residual.
    fn residual<V: LinearVisitor<D>>(&self, visitor: &mut V) -> Result<(), V::Error>;
    /// Walks the same residual with one integral for all that [`Dependence`] keeps apart on a region where several
    /// integrals depend on the unknowns: each facet is visited once. Their degree is that of the highest.
    #[inline]
    fn whole_residual<V: LinearVisitor<D>>(&self, visitor: &mut V) -> Result<(), V::Error> {
        self.residual(visitor)
    }
    /// Walks the integrals of the tangent; those of [`Dependence::Constant`] do not appear.
    fn tangent<V: BilinearVisitor<D>>(&self, visitor: &mut V) -> Result<(), V::Error>;
    /// Walks the same tangent with one integral for all of a region, as [`Form::whole_residual`] does the residual.
    #[inline]
    fn whole_tangent<V: BilinearVisitor<D>>(&self, visitor: &mut V) -> Result<(), V::Error> {
        self.tangent(visitor)
    }
    /// Walks the integrals of the tangent applied to a direction, ∂R/∂u (u; v) w: as those of a residual, with kernels that
    /// read the fields of [`Role::Direction`], and the unknowns only where the tangent depends on them. One matrix-free
    /// product costs about as much as a residual.
    fn action<V: LinearVisitor<D>>(&self, visitor: &mut V) -> Result<(), V::Error>;
    /// Walks the switches of each integral that has kinks: a vector that is positive, entry by entry,
    /// where `pos_part`, `neg_part`, `heaviside`, `max`, `min`, `abs`, `sign` or a comparison is "on".
    fn switches<V: ExpressionVisitor<D>>(&self, visitor: &mut V) -> Result<(), V::Error>;
}

/// A number: the integral of a density without test function. Energies are functionals and forms.
pub trait Functional<const D: usize> {
    /// The functional's name in its module.
    fn name(&self) -> &'static str;
    /// Its fields, by index.
    fn fields(&self) -> &'static [FieldDescription];
    /// Data, regions, parameters.
    fn inputs(&self) -> &Inputs<D>;
    /// Itself as mathematics.
    fn formula(&self) -> &'static Formula {
        &Formula::NONE
    }
    /// Walks the densities.
    fn density<V: ExpressionVisitor<D>>(&self, visitor: &mut V) -> Result<(), V::Error>;
}

/// A derived field: a function of the module, evaluated where the user asks.
pub trait Expression<const D: usize> {
    /// The function's name in its module.
    fn name(&self) -> &'static str;
    /// Its fields, by index.
    fn fields(&self) -> &'static [FieldDescription];
    /// Data and parameters; it has no regions.
    fn inputs(&self) -> &Inputs<D>;
    /// Itself as mathematics.
    fn formula(&self) -> &'static Formula {
        &Formula::NONE
    }
    /// Shape of its value.
    fn shape(&self) -> &'static [usize];
    /// Hands the kernel over.
    fn expression<V: ExpressionVisitor<D>>(&self, visitor: &mut V) -> Result<(), V::Error>;
}

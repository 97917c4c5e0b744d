//! Descriptions of compiled functions: regions, fields, data, integrals and formulas. The values themselves are in
//! `function.rs`.

use crate::degree::Degree;
use crate::kernel::Side;
use crate::pairing::{PairQuadrature, Pairing};
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
    /// The zero set of a level set function inside cells: the boundary of a body that is cut from a mesh.
    Interface,
}

/// The points of the integrals over a region.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RegionRule {
    /// Those of the backend's rule.
    #[default]
    OfBackend,
    /// The vertices of each facet, with equal weights (`#[facets(vertices)]`): of a field of degree 1 an integrand reads its values at nodes.
    /// Where fields on facets have coefficients that are no values, it reads these, at all nodes of such a field.
    Vertices,
}

/// A region of integration: declared in the module, bound by the user to a name of the mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Region {
    /// Cells, exterior or interior facets, pairs, or the zeros of a level set function in some cells.
    pub entity: Entity,
    /// The name declared in the forms module (`GammaC`).
    pub symbol: &'static str,
    /// The name in the mesh (`"contact"`); of pairs, the names of their surfaces, for messages.
    pub name: String,
    /// The surfaces of [`Entity::Pairs`]; `None` for other entities.
    pub pairing: Option<Pairing>,
    /// The points of its integrals.
    pub rule: RegionRule,
}

impl Region {
    /// Cells or facets by their name in the mesh.
    pub fn named(entity: Entity, symbol: &'static str, name: impl Into<String>) -> Self {
        Region { entity, symbol, name: name.into(), pairing: None, rule: RegionRule::OfBackend }
    }

    /// Contact pairs.
    pub fn of_pairs(symbol: &'static str, pairing: Pairing) -> Self {
        let name = pairing.to_string();
        Region { entity: Entity::Pairs, symbol, name, pairing: Some(pairing), rule: RegionRule::OfBackend }
    }

    /// The region with its integrals at the vertices of its facets, or the nodes of fields there.
    pub fn at_vertices(self) -> Self {
        Region { rule: RegionRule::Vertices, ..self }
    }

    /// Whether an integral over this region with a displacement of its surfaces has moving segments.
    pub fn is_on_moving_segments(&self, displacement: Option<&[usize]>) -> bool {
        let pieces = |pairing: &Pairing| pairing.quadrature == Some(PairQuadrature::Pieces);
        self.entity == Entity::Pairs && displacement.is_some() && self.pairing.as_ref().is_some_and(pieces)
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
    /// The direction for the k-th unknown: only the action of a tangent reads it. It has no source among the inputs.
    Direction(usize),
    /// Numbers per own facet of contact pairs: the k-th list of means ([`Means`]). The backend makes them; they have no source.
    Mean(usize),
    /// The function with which the k-th list of means is integrated, and the volume of its weight as the last component.
    MeanTest(usize),
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
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
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
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
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
    /// Of `means(..)`: the integral has one term per own facet and weight.
    pub means: Option<Means>,
    /// Degree of the integrand as a polynomial of the place, from which follows that of a quadrature rule, with the measure's
    /// where that varies ([`Degree::over`]).
    pub degree: Degree,
}

/// Means over the own facets of contact pairs, `means(Touch(u), degree, e)`.
///
/// On each own facet there are weights ψ_i, functions of a degree whose sum is 1, and D_i = ∫ ψ_i over its points with an opposite
/// one. `mean(a)` in e is ∫ ψ_i a / D_i, and the integral is Σ D_i e_i over all facets and weights. Here it is written as Σ ∫ ψ_i e_i: in
/// the i-th term the weights of the quadrature points are multiplied by ψ_i, and the fields with [`Role::Mean`] have the values of
/// the i-th means.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Means {
    /// The list of means that the integral makes, or by which it differentiates. No meaning in other integrals.
    pub number: usize,
    /// Degree of the weights: 0, one per facet; 1, one per vertex of the facet.
    pub degree: usize,
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
    /// Inputs without data and regions.
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

    /// One more parameter, of any rank.
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

/// The numbers that a form's kernels read: parameters and tables, in the order of [`Inputs`].
#[derive(Clone, Copy, Debug)]
pub struct Constants<'a> {
    /// All parameters, flattened.
    pub parameters: &'a [f64],
    /// The tabulated laws.
    pub tables: &'a [Table],
}

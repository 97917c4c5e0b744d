//! Scopes: who shares a coefficient of a space.

use std::fmt;

/// The cells or facets that share a coefficient of a space, and where the space lives.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Scope {
    /// The whole body has the coefficients of one cell: one unknown per component, for elements with one node.
    Body,
    /// Cells share the nodes at the vertices, edges and faces that they share.
    Nodes,
    /// Each cell has coefficients of its own.
    Cell,
    /// Traces on the facets of a region, exterior or interior, and nothing elsewhere; facets share the nodes that they share. Of
    /// elements of degree 0, one constant per facet. For multipliers.
    Facets(String),
    /// Traces on the facets of a region, exterior or interior, and nothing elsewhere; each facet has coefficients of its own, which
    /// the two sides of an interior one share. For multipliers.
    EachFacet(String),
    /// Each point of the cells' rule has a coefficient of its own, for [`Elements::Points`](crate::element::Elements::Points).
    Point,
    /// Another scope on the cells of a region only: [`Scope::within`].
    Within(Box<Scope>, String),
}

impl Scope {
    /// This scope on the cells of a cell region only. There is no function elsewhere.
    pub fn within(self, region: &str) -> Scope {
        Scope::Within(Box::new(self), region.to_owned())
    }

    /// The scope without the cells to which it is limited.
    pub(crate) fn sharing(&self) -> &Scope {
        match self {
            Scope::Within(scope, _) => scope.sharing(),
            scope => scope,
        }
    }

    /// The regions of cells to which it is limited.
    pub(crate) fn regions(&self) -> Vec<&str> {
        match self {
            Scope::Within(scope, region) => scope.regions().into_iter().chain([region.as_str()]).collect(),
            _ => vec![],
        }
    }

    /// The region of a scope on facets.
    pub(crate) fn facet_region(&self) -> Option<&str> {
        match self.sharing() {
            Scope::Facets(region) | Scope::EachFacet(region) => Some(region),
            _ => None,
        }
    }
}

impl fmt::Display for Scope {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Scope::Body => write!(f, "with the values of the whole body"),
            Scope::Nodes => write!(f, "with continuous values"),
            Scope::Cell => write!(f, "with discontinuous values"),
            Scope::Point => write!(f, "with a coefficient per point"),
            Scope::Facets(region) => write!(f, "on the facet region \"{region}\""),
            Scope::EachFacet(region) => {
                write!(f, "with discontinuous values on the facet region \"{region}\"")
            }
            Scope::Within(scope, region) => write!(f, "{scope} in the cell region \"{region}\""),
        }
    }
}

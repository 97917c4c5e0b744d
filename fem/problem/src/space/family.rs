//! The families of Lagrange spaces: on cells or facets, continuous or not.

use std::fmt;

/// The places of a space's nodes, and the cells that share them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Family {
    /// Lagrange elements of degree 1 to 4; cells share the nodes on the facets that they share.
    Continuous,
    /// Lagrange elements of degree 0 to 4; each cell has nodes of its own. In degree 0 it is the centre.
    Discontinuous,
    /// Traces of continuous Lagrange elements of degree 1 to 4 on the facets of a region, exterior or
    /// interior, and nothing elsewhere; in degree 0, one constant per facet. For multipliers.
    OnFacets(String),
    /// Lagrange elements of degree 0 to 4 on the facets of a region, exterior or interior, and nothing elsewhere; each
    /// facet has nodes of its own, which the two sides of an interior one share. For multipliers.
    DiscontinuousOnFacets(String),
}

impl fmt::Display for Family {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Family::Continuous => write!(f, "with continuous values"),
            Family::Discontinuous => write!(f, "with discontinuous values"),
            Family::OnFacets(region) => write!(f, "on the facet region \"{region}\""),
            Family::DiscontinuousOnFacets(region) => {
                write!(f, "with discontinuous values on the facet region \"{region}\"")
            }
        }
    }
}

//! Surfaces of contact pairs: which facets look for opposite points, on which, and how.

use std::fmt;

/// A surface whose points look for opposite ones, and the surface on which they look.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Facing {
    /// Name of the facets over which the pairs are integrated.
    pub own: String,
    /// Name of the facets on which opposite points lie; the same name for self contact.
    pub opposite: String,
}

/// The direction in which an opposite point is looked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Projection {
    /// Along the own outward normal: n_y = n(X).
    #[default]
    Ray,
    /// The nearest point of the opposite surface: n_y = −n(Y).
    Nearest,
}

/// The quadrature points of an own facet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PairQuadrature {
    /// A rule on each piece of the facet that faces one opposite facet: exact where both surfaces are flat. What pairs of fixed points
    /// have unless a pairing says otherwise. Of displaced surfaces these are moving segments: they are cut
    /// again at each iterate, at the nodes of opposite facets.
    Pieces,
    /// The rule of the whole facet, whatever lies opposite to it. On meshes that do not match the integrand has kinks inside the facet: a
    /// uniform pressure is not reproduced. What pairs of displaced surfaces have unless a pairing says otherwise.
    WholeFacets,
}

/// The surfaces of a region of contact pairs and the way in which opposite points are found. A user binds the region to it.
///
/// A point for which none is found adds nothing to an integral over the pairs: it is free.
///
/// Pairs of displaced surfaces, `integral(Touch(u), ..)`, always take rays: `projection` holds for fixed pairs. They have the rules of
/// whole facets unless `.at(PairQuadrature::Pieces)` asks for moving segments. On whole facets they violate the patch test on meshes that do
/// not match, by an error of the pressure next to the surface that depends on the rule and on which surface is integrated over, and not on the
/// size of the cells (docs/points_segments_means.md compares the two).
#[derive(Clone, Debug)]
pub struct Pairing {
    /// Pairs of a surface and the one opposite to it; their integrals add up.
    pub surfaces: Vec<Facing>,
    /// The direction of search.
    pub projection: Projection,
    /// The quadrature points; `None` for pieces of fixed pairs and whole facets of sliding ones.
    pub quadrature: Option<PairQuadrature>,
    /// The largest distance |g| at which a point counts as opposite \[length\]; `None` for two diameters of the own facet.
    pub reach: Option<f64>,
}

/// By all members; distances are the same where their bits are.
impl PartialEq for Pairing {
    fn eq(&self, other: &Self) -> bool {
        let Pairing { surfaces, projection, quadrature, reach } = self;
        *surfaces == other.surfaces
            && *projection == other.projection
            && *quadrature == other.quadrature
            && reach.map(f64::to_bits) == other.reach.map(f64::to_bits)
    }
}

impl Eq for Pairing {}

impl Pairing {
    /// Pairs of one surface's points with those of another: a biased (one-pass) formulation.
    pub fn onto(own: impl Into<String>, opposite: impl Into<String>) -> Self {
        let surfaces = vec![Facing { own: own.into(), opposite: opposite.into() }];
        Pairing { surfaces, projection: Projection::default(), quadrature: None, reach: None }
    }

    /// Pairs of each of two surfaces with the other: an unbiased (two-pass) formulation.
    pub fn between(first: impl Into<String>, second: impl Into<String>) -> Self {
        let (first, second) = (first.into(), second.into());
        Pairing::onto(first.clone(), second.clone()).and(Pairing::onto(second, first))
    }

    /// Pairs of a surface with itself: self contact.
    pub fn within(surface: impl Into<String>) -> Self {
        let surface = surface.into();
        Pairing::onto(surface.clone(), surface)
    }

    /// These pairs and the surfaces of others, found as these are.
    pub fn and(mut self, others: Pairing) -> Self {
        self.surfaces.extend(others.surfaces);
        self
    }

    /// This pairing with opposite points found in another way.
    pub fn by(self, projection: Projection) -> Self {
        Pairing { projection, ..self }
    }

    /// This pairing at other quadrature points.
    pub fn at(self, quadrature: PairQuadrature) -> Self {
        Pairing { quadrature: Some(quadrature), ..self }
    }

    /// This pairing up to a distance \[length\].
    pub fn within_reach(self, distance: f64) -> Self {
        Pairing { reach: Some(distance), ..self }
    }
}

/// A surface that may touch itself.
impl From<&str> for Pairing {
    fn from(surface: &str) -> Self {
        Pairing::within(surface)
    }
}

/// A surface that may touch itself.
impl From<String> for Pairing {
    fn from(surface: String) -> Self {
        Pairing::within(surface)
    }
}

/// The surfaces' names, for messages.
impl fmt::Display for Pairing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, Facing { own, opposite }) in self.surfaces.iter().enumerate() {
            let separator = if index > 0 { ", " } else { "" };
            write!(f, "{separator}{own} onto {opposite}")?;
        }
        Ok(())
    }
}

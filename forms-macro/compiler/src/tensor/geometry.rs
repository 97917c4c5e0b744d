//! Geometry that a form may name, of cells, facets and contact pairs.

use super::Shape;

/// Geometry that a form may name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Geometry {
    /// h_T.
    Diameter,
    /// |T|.
    CellVolume,
    /// |F|.
    FacetArea,
    /// n.
    Normal,
    /// x.
    Position,
    /// κ = div n.
    Curvature,
    /// g, the distance of a pair's opposite point.
    Gap,
    /// n_y, the unit vector toward a pair's opposite point.
    Toward,
    /// Y: what `other(x)` is on a pair.
    OppositePosition,
    /// The outward normal at Y: what `other(n)` is on a pair.
    OppositeNormal,
    /// ∇n along the surface, a tensor: how the normal at Y turns as Y moves.
    ShapeOperator,
}

impl Geometry {
    /// Is it a vector? All others are scalars.
    pub fn is_vector(self) -> bool {
        use Geometry::*;
        matches!(self, Normal | Position | Toward | OppositePosition | OppositeNormal)
    }

    /// Its shape.
    pub fn shape(self, dimension: usize) -> Shape {
        match self {
            Geometry::ShapeOperator => vec![dimension; 2],
            _ if self.is_vector() => vec![dimension],
            _ => vec![],
        }
    }

    /// May it differ between the points of a cell or facet?
    pub fn varies(self) -> bool {
        !matches!(self, Geometry::Diameter | Geometry::CellVolume | Geometry::FacetArea)
    }

    /// Does it belong to a contact pair?
    pub fn is_of_pairs(self) -> bool {
        use Geometry::*;
        matches!(self, Gap | Toward | OppositePosition | OppositeNormal)
    }
}

//! The points at which a history has values, on a reference cell or facet of each shape.

use forms_core::contract::Entity;

use crate::element::CellShape;
use crate::mesh::Mesh;
use crate::quadrature::{Quadrature, QuadratureError};

/// Reference points and weights of an entity (of the first local facet).
pub(super) fn rule_points<const D: usize>(
    mesh: &Mesh<D>,
    quadrature: &Quadrature<D>,
    entity: Entity,
    degree: usize,
) -> Result<Vec<(CellShape, RulePoints<D>)>, QuadratureError> {
    let of_shape = |shape| {
        let (points, weights) = match entity {
            Entity::Cells => {
                let rule = quadrature.rule_on_cells(&mesh.shapes(), shape, degree)?;
                (rule.points, rule.weights)
            }
            Entity::Facets | Entity::InteriorFacets | Entity::Pairs | Entity::Interface => {
                let rule = quadrature.facet_rule(shape, 0, degree)?;
                (rule.points, rule.weights)
            }
        };
        Ok((shape, points.into_iter().zip(weights).collect()))
    };
    mesh.shapes().into_iter().map(of_shape).collect()
}

/// Points with their weights.
type RulePoints<const D: usize> = Vec<([f64; D], f64)>;

//! Quantities that exist on a region: the normal on facets and interfaces only, two sides on interior facets and contact pairs only, the
//! opposite point on pairs only; and where there are two sides, what needs one.

use crate::diagnostics::Diagnostics;
use crate::parse::syntax::{Entity, Region};
use crate::tensor::{Arena, FieldInfo, Geometry, Operator, Side, Tensor};

/// Reports what a density holds and its region has not.
pub fn check_existence(arena: &Arena, density: Tensor, region: &Region, diagnostics: &mut Diagnostics) {
    let Region { name, entity, .. } = region;
    for node in arena.reachable(&[density]) {
        let what = match (&arena.node(node).operator, entity) {
            (Operator::Geometry(Geometry::Normal), Entity::Cells) => "the normal",
            (Operator::Geometry(Geometry::FacetArea), Entity::Cells) => "the area of a facet",
            (Operator::Geometry(Geometry::Curvature), Entity::Cells) => "the curvature",
            (Operator::Geometry(geometry), _) if geometry.is_of_pairs() && *entity != Entity::Pairs => {
                let written = if *geometry == Geometry::Gap { "gap" } else { "toward" };
                diagnostics.error_with_help(
                    arena.span(node),
                    format!(
                        "`{written}` belongs to contact pairs, and `{name}` consists of {}",
                        entity.plural()
                    ),
                    format!(
                        "integrate this over a region declared `#[pairs]`, or declare a member `{written}` of the data"
                    ),
                );
                continue;
            }
            (Operator::Geometry(Geometry::FacetArea), Entity::Interface) => {
                diagnostics.error_with_help(
                    arena.span(node),
                    format!("the area of a facet does not exist on an interface, and `{name}` is one"),
                    "write the size of the cell, `h` or `cell_volume`",
                );
                continue;
            }
            (
                Operator::Restrict(..) | Operator::Opposite(..),
                Entity::Cells | Entity::Facets | Entity::Interface,
            ) => {
                diagnostics.error_with_help(
                    arena.span(node),
                    format!(
                        "only interior facets and contact pairs have two sides, and `{name}` consists of {}",
                        entity.plural()
                    ),
                    "integrate this over a region declared `#[interior_facets]` or `#[pairs]`",
                );
                continue;
            }
            _ => continue,
        };
        diagnostics.error_with_help(
            arena.span(node),
            format!("{what} does not exist inside cells, and `{name}` consists of cells"),
            "integrate this over a region declared `#[facets]` or `#[interface]`",
        );
    }
}

/// On interior facets and pairs, reports what has two values and does not say which, and what says it twice. The
/// density holds no derivatives that are still to be taken: their directions get sides as they are.
pub fn check_sides(
    arena: &Arena,
    fields: &[FieldInfo],
    density: Tensor,
    region: Option<&Region>,
    diagnostics: &mut Diagnostics,
) {
    let pairs = region.is_some_and(|region| region.entity == Entity::Pairs);
    let (place, cells) = match region {
        Some(Region { name, .. }) if pairs => (format!("a pair of `{name}`"), "one at each of its points"),
        Some(Region { name, .. }) => (format!("a facet of `{name}`"), "one from each of its cells"),
        None => ("an interior facet".into(), "one from each of its cells"),
    };
    for (node, side) in arena.restrictions(&[density]) {
        let what = match (&arena.node(node).operator, side) {
            (Operator::Restrict(..) | Operator::Opposite(..), Some(_)) => {
                diagnostics.error_with_help(
                    arena.span(node),
                    "this has a side of the facet already, and takes no second one",
                    "restrict it once; a direction of `derivative` gets the sides of the field that it varies",
                );
                continue;
            }
            (
                Operator::Geometry(geometry @ (Geometry::Curvature | Geometry::FacetArea)),
                Some(Side::Other),
            ) if pairs => {
                let what = if *geometry == Geometry::Curvature { "curvature" } else { "facet's area" };
                diagnostics.error_with_help(
                    arena.span(node),
                    format!("the {what} at a pair's opposite point is not available"),
                    "leave it out of `other(..)`, `jump(..)` and `avg(..)`",
                );
                continue;
            }
            (Operator::Field { field, order: 0 }, None) => format!("`{}`", fields[*field].name),
            (Operator::Field { field, order: 1 }, None) => {
                format!("the gradient of `{}`", fields[*field].name)
            }
            (Operator::Field { field, .. }, None) => format!("the Hessian of `{}`", fields[*field].name),
            (Operator::Geometry(Geometry::Diameter), None) => "the diameter of the cell".into(),
            (Operator::Geometry(Geometry::CellVolume), None) => "the volume of the cell".into(),
            _ => continue,
        };
        diagnostics.error_with_help(
            arena.span(node),
            format!("{what} has two values on {place}, {cells}"),
            "say which around it, or around the expression in which it stands: `avg(..)`, `jump(..)`, `this(..)`, `other(..)`",
        );
    }
}

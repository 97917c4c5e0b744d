//! First touch: how far a body goes along a direction until its surface meets the other one, in closed form on flat facets.

use std::sync::Arc;

use forms_core::contract::Pairing;

use super::rays::along_ray;
use super::rest::SurfacesAtRest;
use super::surface::{SurfaceFacet, dot, minus, unit};
use super::surfaces::Surfaces;
use super::{Displacement, DisplacementField, PairError};
use crate::field::Field;
use crate::mesh::{Mesh, TAKE_THE_WHOLE};
use crate::quadrature::Quadrature;
use crate::threads::Threads;

/// A rigid approach of one body to another.
#[derive(Clone, Debug, PartialEq)]
pub struct Approach<const D: usize> {
    /// The cells that move.
    pub moving: String,
    /// The direction, of any length.
    pub direction: [f64; D],
    /// The overlap after the first quadrature point touches \[length\]: contact that just touches holds nothing.
    pub overlap: f64,
}

/// A start in contact.
#[derive(Clone, Debug)]
pub struct FirstTouch<const D: usize> {
    /// The displacement with the moving body in contact.
    pub start: Field<D>,
    /// Distance until the first point touched \[length\].
    pub distance: f64,
    /// The quadrature point that touches, where it was before \[length\].
    pub at: [f64; D],
}

/// The first of some quadrature points to touch: the distance, and the point.
type First<const D: usize> = Option<(f64, [f64; D])>;

/// Which of the two surfaces moves.
#[derive(Clone, Copy, PartialEq)]
enum Mover {
    Own,
    Opposite,
}

fn nearer<const D: usize>(one: First<D>, other: First<D>) -> First<D> {
    match (one, other) {
        (Some(one), Some(other)) => Some(if other.0 < one.0 { other } else { one }),
        (one, other) => one.or(other),
    }
}

/// The distance at which a point of an own facet meets the opposite surface.
fn from_point<const D: usize>(
    (x, normal): (&[f64; D], &[f64; D]),
    opposite: &[SurfaceFacet<D>],
    direction: &[f64; D],
    mover: Mover,
) -> First<D> {
    // Where the opposite surface moves, the point comes to it from in front.
    let ray = if mover == Mover::Own { *direction } else { direction.map(|component| -component) };
    if dot(normal, &ray) <= 0.0 {
        return None;
    }
    let mut first = None;
    for facet in opposite {
        let Some(hit) = along_ray(facet, x, &ray) else { continue };
        let distance = dot(&ray, &minus(&hit.position, x));
        if distance >= 0.0 && dot(&hit.normal, &ray) < 0.0 {
            first = nearer(first, Some((distance, *x)));
        }
    }
    first
}

impl<const D: usize> Approach<D> {
    /// The start in contact from a displacement, by the quadrature points of a pairing.
    pub(crate) fn from(
        &self,
        u: &Field<D>,
        mesh: &Mesh<D>,
        pairing: &Pairing,
        (quadrature, degree): (&Quadrature<D>, usize),
        threads: Threads,
    ) -> Result<FirstTouch<D>, PairError> {
        let size = dot(&self.direction, &self.direction);
        if !(size > 0.0 && size.is_finite() && self.overlap.is_finite()) {
            return Err(PairError::Approach { direction: self.direction.to_vec(), overlap: self.overlap });
        }
        let direction = unit(&self.direction);
        let cells = mesh
            .without_pieces("the way to a first touch", TAKE_THE_WHOLE)
            .and_then(|()| mesh.cell_region(&self.moving))
            .map_err(|source| PairError::Surface { source })?;
        let space = u.space();
        let displacement = Displacement { fields: vec![DisplacementField { space, values: u.values() }] };
        let at_rest = SurfacesAtRest::default();
        let surfaces = Surfaces::new(mesh, pairing, &at_rest, Some(&displacement), threads)?;
        let mut first: First<D> = None;
        for facing in &pairing.surfaces {
            let (own, opposite) = (surfaces.of(&facing.own), surfaces.of(&facing.opposite));
            let moves = |facets: &[SurfaceFacet<D>]| {
                let count = facets.iter().filter(|f| cells.binary_search(&f.facet.cell).is_ok()).count();
                (count == facets.len(), count == 0)
            };
            let mover = match (moves(own), moves(opposite)) {
                ((true, _), (_, true)) => Mover::Own,
                ((_, true), (true, _)) => Mover::Opposite,
                _ => {
                    let (own, opposite) = (facing.own.clone(), facing.opposite.clone());
                    return Err(PairError::Moving { moving: self.moving.clone(), own, opposite });
                }
            };
            let count = threads.count().min(own.len()).max(1);
            let parts = (0..count).map(|part| &own[part * own.len() / count..(part + 1) * own.len() / count]);
            let found = threads.run(parts.collect(), |facets: &[SurfaceFacet<D>]| {
                let mut first: First<D> = None;
                for facet in facets {
                    let shape = mesh.cell_shape(facet.facet.cell as usize);
                    let rule = quadrature.facet_reference_rule(shape, degree);
                    for s in rule.map_err(|source| PairError::Quadrature { source })?.points {
                        let point = facet.at(&s);
                        let from = (&point.position, &point.normal());
                        first = nearer(first, from_point(from, opposite, &direction, mover));
                    }
                }
                Ok(first)
            });
            for part in found {
                first = nearer(first, part?);
            }
        }
        let Some((distance, at)) = first else {
            return Err(PairError::NeverMeet { direction: direction.to_vec(), moving: self.moving.clone() });
        };
        let (mut values, mut moved) = (u.values().to_vec(), vec![false; space.node_count()]);
        for cell in cells {
            for node in space.cell_nodes(*cell as usize) {
                if !std::mem::replace(&mut moved[*node as usize], true) {
                    for axis in 0..D {
                        values[*node as usize * D + axis] += (distance + self.overlap) * direction[axis];
                    }
                }
            }
        }
        Ok(FirstTouch { start: Field::of_known(&Arc::clone(space), values), distance, at })
    }
}

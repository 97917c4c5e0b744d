//! Walls that keep their thickness: places where a boundary must not go.

use std::sync::Arc;

use super::error::ShapeOptimisationError;
use crate::constraints::Constraints;
use crate::dimension::{Dim, Dimension};
use crate::space::Space;

/// The distance at which a node is at the wall, in units of the longest way of a node in a step: a node that slides along a
/// curve leaves it a little.
const AT_THE_WALL: f64 = 0.02;
/// Movements of a node back to the wall; one is enough where the wall is straight.
const RETURNS: usize = 3;

/// The clearance of a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearance<const D: usize> {
    /// The distance from where the boundary must not be, negative where it is \[length\].
    pub distance: f64,
    /// The direction in which it grows, of length 1.
    pub away: [f64; D],
}

/// A part of the boundary and where it may be. Nodes of the geometry stay clear; between them a curved facet may come nearer
/// by as much as it is curved.
#[derive(Clone)]
pub struct Wall<'a, const D: usize> {
    /// The region of facets that moves.
    pub region: String,
    /// The clearance at a place. A pattern that the descent keeps is the clearance's, too.
    pub clearance: &'a (dyn Fn(&[f64; D]) -> Clearance<D> + Sync),
}

impl<const D: usize> Wall<'_, D>
where
    Dim: Dimension<D>,
{
    /// Holds further nodes that are at the wall where a movement takes them into it; they may slide. Their number.
    pub(super) fn hold(
        &self,
        held: &mut Constraints<D>,
        nodes_held: &mut Vec<u32>,
        movement: &[f64],
        longest_move: f64,
    ) -> Result<usize, ShapeOptimisationError> {
        let space = held.space().clone();
        let (mut nodes, mut normals) = (vec![], vec![]);
        for node in space.nodes_on(&self.region)? {
            let first = node as usize * D;
            if nodes_held.contains(&node) || (first..first + D).any(|unknown| held.is_prescribed(unknown)) {
                continue;
            }
            let Clearance { distance, away } = (self.clearance)(&space.positions()[node as usize]);
            let speed: f64 = (0..D).map(|k| away[k] * movement[first + k]).sum();
            if distance <= AT_THE_WALL * longest_move && speed < 0.0 {
                nodes.push(node);
                normals.push(away);
            }
        }
        held.slide_on("the wall", &nodes, normals, |_| 0.0)?;
        nodes_held.extend(&nodes);
        Ok(nodes.len())
    }

    /// Shortens the ways of nodes that a movement takes into the wall; whether there are any.
    pub(super) fn shorten(
        &self,
        movements: &Arc<Space<D>>,
        movement: &mut [f64],
    ) -> Result<bool, ShapeOptimisationError> {
        let mut is_shortened = false;
        for node in movements.nodes_on(&self.region)? {
            let first = node as usize * D;
            for _ in 0..RETURNS {
                let x =
                    std::array::from_fn(|k| movements.positions()[node as usize][k] + movement[first + k]);
                let Clearance { distance, away } = (self.clearance)(&x);
                // What cannot be distinguished from the wall is at it.
                if distance >= -1e-12 * x.iter().fold(0.0_f64, |most, x| most.max(x.abs())) {
                    break;
                }
                (0..D).for_each(|k| movement[first + k] -= distance * away[k]);
                is_shortened = true;
            }
        }
        Ok(is_shortened)
    }
}

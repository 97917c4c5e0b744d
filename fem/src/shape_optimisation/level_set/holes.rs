//! New holes in a body {φ < 0}: their options, and the places where they are.

use serde::{Deserialize, Serialize};

use crate::constraints::Constraints;
use crate::cut::Cut;
use crate::dimension::{Dim, Dimension};
use crate::field::Field;
use crate::shape_optimisation::{Failure, ShapeOptimisationError};
use forms_problem::coincident::distance;

/// New holes of a descent: round, where the topological derivative of the augmented Lagrangian is most negative, and kept if the latter falls.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HoleOptions {
    /// Steps from one attempt to the next. A descent that would stop early makes another attempt.
    pub every: usize,
    /// Radius, at least the largest diameter of a cell \[length\].
    pub radius: f64,
    /// Least width of the material between a new hole and Γ, another new one, the background's boundary and places where φ is held; at
    /// least the largest diameter of a cell \[length\].
    pub distance: f64,
    /// Holes of an attempt, at most. Half of them are tried where these bring nothing, and so on.
    pub most: usize,
}

impl HoleOptions {
    /// For cells of this size \[length\]: up to 20 holes of radius 2h, at a distance of 3h, every 5 steps.
    pub fn new(size: f64) -> Self {
        HoleOptions { every: 5, radius: 2.0 * size, distance: 3.0 * size, most: 20 }
    }
}

/// New holes of a step, with the criterion on bodies without a band before and after them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NewHoles {
    /// Their number.
    pub count: usize,
    /// The criterion without them.
    pub before: f64,
    /// The criterion with them.
    pub after: f64,
    /// The change of the augmented Lagrangian that the topological derivative promises; negative.
    pub promised: f64,
}

/// The places where new holes may be.
pub(super) struct HolePlaces<'a, const D: usize> {
    pub options: &'a HoleOptions,
    /// Whether φ is held at a node.
    held: Vec<bool>,
    /// Positions of these nodes and of vertices on the background's boundary.
    kept: Vec<[f64; D]>,
}

impl<'a, const D: usize> HolePlaces<'a, D>
where
    Dim: Dimension<D>,
{
    /// # Errors
    /// [`ShapeOptimisationError::Option`]: holes or distances that cells do not resolve, no step or no hole.
    pub fn new(options: &'a HoleOptions, changes: &Constraints<D>) -> Result<Self, ShapeOptimisationError> {
        let mesh = changes.space().mesh();
        let largest = mesh.body_cells().map(|cell| mesh.diameter(cell)).fold(0.0, f64::max);
        for (name, value) in [("holes.radius", options.radius), ("holes.distance", options.distance)] {
            if !(value >= largest && value.is_finite()) {
                let why = "it must be finite, and no less than the largest diameter of a cell";
                return Err(ShapeOptimisationError::Option { name, value, why });
            }
        }
        for (name, value) in [("holes.every", options.every), ("holes.most", options.most)] {
            if value == 0 {
                return Err(ShapeOptimisationError::Option { name, value: 0.0, why: "it must be positive" });
            }
        }
        let positions = changes.space().positions();
        let held: Vec<bool> = (0..positions.len()).map(|node| changes.is_prescribed(node)).collect();
        let facets = mesh.facet_region("boundary")?.iter().flat_map(|facet| mesh.facet_vertices(*facet));
        let mut nodes: Vec<u32> = facets.collect();
        nodes.sort_unstable();
        nodes.dedup();
        let mut kept: Vec<[f64; D]> = nodes.iter().map(|node| mesh.nodes()[*node as usize]).collect();
        kept.extend(positions.iter().zip(&held).filter(|(_, held)| **held).map(|(x, _)| *x));
        Ok(HolePlaces { options, held, kept })
    }

    /// The nodes at the centres of holes, the most negative derivative first.
    ///
    /// # Errors
    /// Those of [`Cut::distance`].
    pub fn centres(&self, body: &Cut<D>, phi: &Field<D>, derivative: &[f64]) -> Result<Vec<usize>, Failure> {
        let HoleOptions { radius, distance: least, most, .. } = *self.options;
        let depths = body.distance(phi)?;
        let is_deep = |node: usize| {
            let depth = -depths.values()[node];
            // Without Γ there is no distance to it.
            depth > 0.0 && (body.cut_cells().is_empty() || depth >= radius + least)
        };
        let mut nodes: Vec<usize> =
            (0..derivative.len()).filter(|node| derivative[*node] < 0.0 && is_deep(*node)).collect();
        nodes.sort_by(|a, b| derivative[*a].total_cmp(&derivative[*b]).then(a.cmp(b)));
        let positions = phi.space().positions();
        let mut centres: Vec<usize> = vec![];
        for node in nodes {
            let x = &positions[node];
            let others: Vec<[f64; D]> = centres.iter().map(|other| positions[*other]).collect();
            if distance(&others, x) >= 2.0 * radius + least && distance(&self.kept, x) >= radius + least {
                centres.push(node);
            }
            if centres.len() == most {
                break;
            }
        }
        Ok(centres)
    }

    /// φ raised to max(φ, r − |x − c|) around centres c, but where it is held.
    pub fn raised(&self, phi: &Field<D>, centres: &[usize]) -> Vec<f64> {
        let positions = phi.space().positions();
        let centres: Vec<[f64; D]> = centres.iter().map(|node| positions[*node]).collect();
        let raised = |(node, own): (usize, &f64)| match self.held[node] {
            true => *own,
            false => own.max(self.options.radius - distance(&centres, &positions[node])),
        };
        phi.values().iter().enumerate().map(raised).collect()
    }
}

//! Patterns that are the same all around a ring.

use std::f64::consts::TAU;

use super::error::ShapeOptimisationError;
use crate::space::Space;
use forms_problem::coincident::{Coincident, distance};

/// The rotations by multiples of 1/n of a full circle, in the plane of the first two coordinates, of a mesh that they take
/// to itself. The mean over them is the orthogonal projection onto what is the same in all n sectors: a mesh that moves
/// along such means keeps its pattern.
#[derive(Clone, Debug)]
pub struct Rotations<const D: usize> {
    /// The node to which a turn by one sector takes each node.
    images: Vec<u32>,
    /// Cosine and sine of each multiple.
    turns: Vec<[f64; 2]>,
    centre: [f64; D],
}

impl<const D: usize> Rotations<D> {
    /// The images of the nodes of a space of movements, on the mesh that has the pattern; `count` is n. On the mesh
    /// after it has moved nodes have the same numbers, so the result holds there, too.
    ///
    /// # Errors
    /// [`ShapeOptimisationError::NotPeriodic`] names the node without an image; n = 0.
    pub fn new(movements: &Space<D>, centre: [f64; D], count: usize) -> Result<Self, ShapeOptimisationError> {
        if count == 0 {
            let (name, why) = ("sectors", "there is at least one");
            return Err(ShapeOptimisationError::Option { name, value: 0.0, why });
        }
        let turns: Vec<[f64; 2]> = (0..count)
            .map(|k| {
                let (sine, cosine) = (TAU * k as f64 / count as f64).sin_cos();
                [cosine, sine]
            })
            .collect();
        let nodes = movements.positions();
        let coincident = Coincident::new(nodes);
        let mut images = Vec::with_capacity(nodes.len());
        for x in nodes {
            let mut arm: [f64; D] = std::array::from_fn(|k| x[k] - centre[k]);
            turn(&mut arm, turns[1 % count]);
            let image = std::array::from_fn(|k| centre[k] + arm[k]);
            let found = coincident.find(&image).ok_or_else(|| ShapeOptimisationError::NotPeriodic {
                count,
                centre: centre.to_vec(),
                position: x.to_vec(),
                distance: distance(nodes, &image),
            })?;
            images.push(found as u32);
        }
        Ok(Rotations { images, turns, centre })
    }

    /// These rotations of another mesh.
    ///
    /// # Errors
    /// As [`Rotations::new`].
    pub fn on(&self, movements: &Space<D>) -> Result<Self, ShapeOptimisationError> {
        Rotations::new(movements, self.centre, self.turns.len())
    }

    /// The mean over the rotations, in place of a vector per node (a movement, or a derivative by movements).
    ///
    /// # Errors
    /// [`ShapeOptimisationError::Length`] unless there are D numbers per node.
    pub fn average(&self, vectors: &mut [f64]) -> Result<(), ShapeOptimisationError> {
        let (expected, found) = (self.images.len() * D, vectors.len());
        if expected != found {
            return Err(ShapeOptimisationError::Length { what: "the pattern", expected, found });
        }
        let mut done = vec![false; self.images.len()];
        for first in 0..self.images.len() {
            if done[first] {
                continue;
            }
            let mut mean = [0.0; D];
            self.along_orbit(first, |node, [cosine, sine]| {
                let mut back: [f64; D] = std::array::from_fn(|k| vectors[node * D + k]);
                turn(&mut back, [cosine, -sine]);
                mean.iter_mut().zip(back).for_each(|(mean, back)| *mean += back);
            });
            let mean = mean.map(|sum| sum / self.turns.len() as f64);
            self.along_orbit(first, |node, by| {
                let mut forth = mean;
                turn(&mut forth, by);
                vectors[node * D..(node + 1) * D].copy_from_slice(&forth);
                done[node] = true;
            });
        }
        Ok(())
    }

    /// The mean over the rotations, in place of a number per node (a level set function, or a derivative by one).
    ///
    /// # Errors
    /// [`ShapeOptimisationError::Length`] unless there is one number per node.
    pub fn average_values(&self, values: &mut [f64]) -> Result<(), ShapeOptimisationError> {
        let (expected, found) = (self.images.len(), values.len());
        if expected != found {
            return Err(ShapeOptimisationError::Length { what: "the pattern", expected, found });
        }
        let mut done = vec![false; expected];
        for first in 0..expected {
            if done[first] {
                continue;
            }
            let mut sum = 0.0;
            self.along_orbit(first, |node, _| sum += values[node]);
            let mean = sum / self.turns.len() as f64;
            self.along_orbit(first, |node, _| (values[node], done[node]) = (mean, true));
        }
        Ok(())
    }

    fn along_orbit(&self, first: usize, mut visit: impl FnMut(usize, [f64; 2])) {
        let mut node = first;
        for &by in &self.turns {
            visit(node, by);
            node = self.images[node] as usize;
        }
    }
}

/// A turn in the plane of the first two coordinates; a line has no turns.
fn turn<const D: usize>(x: &mut [f64; D], [cosine, sine]: [f64; 2]) {
    if let [a, b, ..] = x.as_mut_slice() {
        (*a, *b) = (cosine * *a - sine * *b, sine * *a + cosine * *b);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::element::CellShape;
    use crate::mesh::{PerforatedAnnulus, rectangle};

    fn ring() -> Arc<Space<2>> {
        let ring = PerforatedAnnulus {
            inner_radius: 2.0,
            outer_radius: 3.0,
            rows: 1,
            holes_around: 7,
            hole_radius: 0.3,
            cells_per_side: 2,
            layers: 1,
            shape: CellShape::Quadrilateral,
            degree: 2,
        };
        Space::of_geometry(&ring.mesh().unwrap()).unwrap()
    }

    #[test]
    fn means_are_the_same_in_all_sectors_and_leave_nothing_out() {
        let movements = ring();
        let rotations = Rotations::new(&movements, [0.0; 2], 7).unwrap();
        let wild = |x: &[f64; 2]| [x[0] * x[1] + x[1].sin(), (3.0 * x[0]).cos() + 0.2 * x[0]];
        let before: Vec<f64> = movements.positions().iter().flat_map(wild).collect();
        let mut mean = before.clone();
        rotations.average(&mut mean).unwrap();
        let (sine, cosine) = (TAU / 7.0).sin_cos();
        for (node, &image) in rotations.images.iter().enumerate() {
            let (own, other) = (&mean[2 * node..][..2], &mean[2 * image as usize..][..2]);
            assert!((cosine * own[0] - sine * own[1] - other[0]).abs() < 1e-14);
            assert!((sine * own[0] + cosine * own[1] - other[1]).abs() < 1e-14);
        }
        // An orthogonal projection: a second application changes nothing, and the removed part is orthogonal to the rest.
        let mut again = mean.clone();
        rotations.average(&mut again).unwrap();
        assert!(again.iter().zip(&mean).all(|(a, b)| (a - b).abs() < 1e-14));
        let product: f64 = before.iter().zip(&mean).map(|(before, mean)| (before - mean) * mean).sum();
        assert!(product.abs() < 1e-11, "{product:e}");
        assert!(before.iter().zip(&mean).any(|(a, b)| (a - b).abs() > 0.1));
    }

    #[test]
    fn mean_values_are_the_same_in_all_sectors() {
        let space = ring();
        let rotations = Rotations::new(&space, [0.0; 2], 7).unwrap();
        let before: Vec<f64> = space.positions().iter().map(|x| x[0] * x[1] + x[1].sin() + 3.0).collect();
        let mut mean = before.clone();
        rotations.average_values(&mut mean).unwrap();
        assert!(rotations.images.iter().zip(&mean).all(|(image, own)| mean[*image as usize] == *own));
        let [sum, of_means] = [&before, &mean].map(|values| values.iter().sum::<f64>());
        assert!((sum / of_means - 1.0).abs() < 1e-14 && sum > 0.0);
        assert!(before.iter().zip(&mean).any(|(a, b)| (a - b).abs() > 0.1));
        assert!(rotations.average_values(&mut [0.0]).is_err());
    }

    #[test]
    fn a_mesh_without_the_pattern_is_refused() {
        let message = Rotations::new(&ring(), [0.0; 2], 5).unwrap_err().to_string();
        assert!(message.starts_with("turned by 1/5 of a full circle about [0.0, 0.0], the node at ["));
        let square = rectangle([-1.0; 2], [1.0; 2], [4, 4], CellShape::Quadrilateral, 1).unwrap();
        let square = Space::of_geometry(&square).unwrap();
        // The centre is a node that stays, whose mean movement is none.
        let quarters = Rotations::new(&square, [0.0; 2], 4).unwrap();
        let mut shift = vec![1.0; square.unknowns()];
        quarters.average(&mut shift).unwrap();
        assert!(shift.iter().all(|x| x.abs() < 1e-15));
        assert!(quarters.average(&mut [0.0]).is_err());
        assert!(Rotations::new(&square, [0.0; 2], 0).is_err());
    }
}

//! Rigid maps: motions of bodies, and of one region onto another.

use super::ConstraintsError;
use crate::field::Field;
use crate::instantiate::instantiate;
use crate::mesh::small_matrices::{determinant, inverse};

/// Columns of a rotation are of length one and orthogonal to this.
const ORTHOGONAL: f64 = 1e-12;

/// Nodes whose moments have a determinant below this, relative to their size, lie on a line or in a plane.
const FLAT: f64 = 1e-12;

/// Steps to a rotation, at most; they converge quadratically.
const STEPS: usize = 100;

/// x ↦ R x + t with a rotation (or reflection) R.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidMap<const D: usize> {
    /// R, by rows.
    pub rotation: [[f64; D]; D],
    /// t \[length\].
    pub translation: [f64; D],
}

impl<const D: usize> RigidMap<D> {
    /// x ↦ x + t.
    pub fn translation(translation: [f64; D]) -> Self {
        let rotation = std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
        RigidMap { rotation, translation }
    }

    /// x ↦ c + R (x − c).
    pub fn rotation(rotation: [[f64; D]; D], centre: [f64; D]) -> Self {
        let turned = times(&rotation, &centre);
        RigidMap { rotation, translation: std::array::from_fn(|i| centre[i] - turned[i]) }
    }

    /// The image of a point.
    pub fn apply(&self, x: &[f64; D]) -> [f64; D] {
        let turned = times(&self.rotation, x);
        std::array::from_fn(|i| turned[i] + self.translation[i])
    }
}

impl<const D: usize> RigidMap<D> {
    /// This map, and then another one.
    pub fn then(&self, other: &RigidMap<D>) -> Self {
        let column = |j: usize| times(&other.rotation, &self.rotation.map(|row| row[j]));
        let columns: [[f64; D]; D] = std::array::from_fn(column);
        let rotation = std::array::from_fn(|i| std::array::from_fn(|j| columns[j][i]));
        RigidMap { rotation, translation: other.apply(&self.translation) }
    }

    /// The displacement of a point, map(x) − x \[length\].
    pub fn displacement(&self, x: &[f64; D]) -> [f64; D] {
        let image = self.apply(x);
        std::array::from_fn(|k| image[k] - x[k])
    }

    /// Whether all numbers are finite and the rotation is one, no reflection and no stretch, to rounding.
    pub fn is_motion(&self) -> bool {
        let column = |j: usize| self.rotation.map(|row| row[j]);
        let product = |i: usize, j: usize| column(i).iter().zip(column(j)).map(|(a, b)| a * b).sum::<f64>();
        let mut entries = (0..D).flat_map(|i| (0..D).map(move |j| (i, j)));
        let orthogonal =
            entries.all(|(i, j)| (product(i, j) - f64::from(u8::from(i == j))).abs() <= ORTHOGONAL);
        orthogonal && determinant(&self.rotation) > 0.0 && self.translation.iter().all(|t| t.is_finite())
    }

    /// The motion closest to a field at the nodes of a region, by least squares, and the largest distance of a node from where that
    /// motion brings it \[length\].
    ///
    /// # Errors
    /// [`ConstraintsError`]: no vectors of D components, an unknown region, nodes that do not fix a motion or have no finite positions.
    #[inline(never)]
    pub fn nearest(field: &Field<D>, region: &str) -> Result<(Self, f64), ConstraintsError> {
        let (space, place) = (field.space(), format!("region \"{region}\""));
        if space.shape() != [D] {
            return Err(ConstraintsError::Components { place, space: space.components(), value: D });
        }
        space.mesh().without_pieces("the motion of a region", crate::mesh::TAKE_THE_WHOLE)?;
        let nodes = space.nodes_on(region)?;
        let before: Vec<[f64; D]> = nodes.iter().map(|node| space.positions()[*node as usize]).collect();
        let by = nodes.iter().map(|node| field.at_node(*node as usize));
        let after: Vec<[f64; D]> =
            before.iter().zip(by).map(|(x, u)| std::array::from_fn(|k| x[k] + u[k])).collect();
        let mean = |points: &[[f64; D]]| -> [f64; D] {
            std::array::from_fn(|k| points.iter().map(|x| x[k]).sum::<f64>() / points.len() as f64)
        };
        let (x, y) = (mean(&before), mean(&after));
        let mut moment = [[0.0; D]; D];
        for (before, after) in before.iter().zip(&after) {
            for i in 0..D {
                for j in 0..D {
                    moment[i][j] += (after[i] - y[i]) * (before[j] - x[j]);
                }
            }
        }
        let rotation = polar(moment).ok_or(ConstraintsError::NoMotion { place })?;
        let turned = times(&rotation, &x);
        let map = RigidMap { rotation, translation: std::array::from_fn(|k| y[k] - turned[k]) };
        let away = |(x, y): (&[f64; D], &[f64; D])| {
            let image = map.apply(x);
            (0..D).map(|k| (image[k] - y[k]).powi(2)).sum::<f64>().sqrt()
        };
        let furthest = before.iter().zip(&after).map(away).fold(0.0, f64::max);
        Ok((map, furthest))
    }
}

impl RigidMap<2> {
    /// A turn by an angle \[radians, counter-clockwise\] about a point.
    pub fn turn(angle: f64, centre: [f64; 2]) -> Self {
        let (sin, cos) = angle.sin_cos();
        RigidMap::rotation([[cos, -sin], [sin, cos]], centre)
    }
}

impl RigidMap<3> {
    /// A turn about an axis through a point, by the axis' length as an angle \[radians\]: Rodrigues' formula.
    pub fn turn(axis: [f64; 3], centre: [f64; 3]) -> Self {
        let angle = axis.iter().map(|a| a * a).sum::<f64>().sqrt();
        if angle == 0.0 {
            return RigidMap::translation([0.0; 3]);
        }
        let n = axis.map(|a| a / angle);
        let (sin, cos) = angle.sin_cos();
        let cross = [[0.0, -n[2], n[1]], [n[2], 0.0, -n[0]], [-n[1], n[0], 0.0]];
        let entry = |i: usize, j: usize| {
            let straight = if i == j { cos } else { 0.0 };
            straight + (1.0 - cos) * n[i] * n[j] + sin * cross[i][j]
        };
        let row = |i: usize| std::array::from_fn(|j| entry(i, j));
        RigidMap::rotation(std::array::from_fn(row), centre)
    }
}

/// The rotation next to a matrix: half the sum with the inverse of the transpose, again and again (Higham 1986). `None` of one that has none
/// or is next to a reflection.
fn polar<const D: usize>(matrix: [[f64; D]; D]) -> Option<[[f64; D]; D]> {
    let size = matrix.as_flattened().iter().map(|entry| entry.abs()).fold(0.0, f64::max);
    let mut rotation = matrix.map(|row| row.map(|entry| entry / size));
    if !(determinant(&rotation) > FLAT && size.is_finite()) {
        return None;
    }
    for _ in 0..STEPS {
        let inverse = inverse(&rotation)?;
        let mut change = 0.0_f64;
        let next = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let next = 0.5 * (rotation[i][j] + inverse[j][i]);
                change = change.max((next - rotation[i][j]).abs());
                next
            })
        });
        rotation = next;
        if change < 1e-15 {
            break;
        }
    }
    Some(rotation)
}

fn times<const D: usize>(matrix: &[[f64; D]; D], x: &[f64; D]) -> [f64; D] {
    matrix.map(|row| row.iter().zip(x).map(|(a, x)| a * x).sum())
}

instantiate!(rigid_map: RigidMap::<D>::nearest);

//! Rigid motions as vectors of unknowns: the near-null space of elasticity, and what singular matrices are named by.

use super::block_matrix::BlockMatrix;
use super::error::LinearAlgebraError;
use super::vector::{dot, norm};

/// The middle of the nodes' bounding box, and its largest side.
fn frame<const D: usize>(positions: &[[f64; D]]) -> ([f64; D], f64) {
    let (mut low, mut high) = ([f64::INFINITY; D], [f64::NEG_INFINITY; D]);
    for position in positions {
        for k in 0..D {
            low[k] = low[k].min(position[k]);
            high[k] = high[k].max(position[k]);
        }
    }
    let size = (0..D).map(|k| high[k] - low[k]).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    (std::array::from_fn(|k| 0.5 * (low[k] + high[k])), size)
}

/// The translations, then the rotations about the axes through the middle of the nodes, as vectors of unknowns with D
/// components per node: 3 vectors in the plane, 6 in space, 1 on a line. Lengths are measured in the size of the body.
#[inline(never)]
pub fn rigid_motions<const D: usize>(positions: &[[f64; D]]) -> Vec<Vec<f64>> {
    let (centre, size) = frame(positions);
    let mut motions = Vec::new();
    for component in 0..D {
        motions.push(
            (0..positions.len() * D).map(|unknown| f64::from(u8::from(unknown % D == component))).collect(),
        );
    }
    // In space the pairs are ordered so that the axes are x, y, z.
    let pairs: &[(usize, usize)] = match D {
        2 => &[(0, 1)],
        3 => &[(1, 2), (2, 0), (0, 1)],
        _ => &[],
    };
    for &(a, b) in pairs {
        let mut motion = vec![0.0; positions.len() * D];
        for (value, position) in motion.chunks_exact_mut(D).zip(positions) {
            let relative = |k: usize| (position[k] - centre[k]) / size;
            value[a] = -relative(b);
            value[b] = relative(a);
        }
        motions.push(motion);
    }
    motions
}

/// Relative length below which the resistance to a motion is round-off. A body held at one node of 10⁶ has more than 1e-4.
const NOTHING: f64 = 1e-11;

/// A function that makes one vector of a motion and of its forces; see [`free_motions`].
pub type Resistance<'a> = dyn Fn(&[f64], &[f64]) -> Result<Vec<f64>, LinearAlgebraError> + 'a;

/// The rigid motions that a matrix does not resist and that constraints allow, each in words:
/// "translation along x", "rotation about (0, 0, 1) through (0.5, 0.5, 0)". The unknowns of the nodes at `positions`
/// start at `offset` of the matrix, which has all rows and columns. `resistance` makes one vector of a motion and of its forces (relative to the
/// largest entry of the matrix), linear in them and zero if constraints allow the motion and nothing free resists it.
///
/// # Errors
/// If the matrix is smaller than the unknowns, or those of `resistance`.
pub fn free_motions<const D: usize>(
    matrix: &BlockMatrix,
    offset: usize,
    positions: &[[f64; D]],
    resistance: &Resistance<'_>,
) -> Result<Vec<String>, LinearAlgebraError> {
    let nodes: Vec<u32> = (0..positions.len() as u32).collect();
    free_motions_of_body(matrix, offset, positions, &nodes, resistance)
}

/// Free motions of one of several bodies, the one with these nodes: the others stay where they are.
///
/// # Errors
/// As [`free_motions`].
#[inline(never)]
pub fn free_motions_of_body<const D: usize>(
    matrix: &BlockMatrix,
    offset: usize,
    positions: &[[f64; D]],
    nodes: &[u32],
    resistance: &Resistance<'_>,
) -> Result<Vec<String>, LinearAlgebraError> {
    let scale = super::vector::largest(matrix.values());
    if D < 2 || nodes.is_empty() || !scale.is_finite() {
        return Ok(Vec::new());
    }
    let unknowns = offset + positions.len() * D;
    if unknowns > matrix.columns() {
        let (what, expected, found) = ("the set of columns", unknowns, matrix.columns());
        return Err(LinearAlgebraError::SizeMismatch { what, expected, found });
    }
    let own: Vec<[f64; D]> = nodes.iter().map(|node| positions[*node as usize]).collect();
    let mut resistances = Vec::new();
    for motion in rigid_motions(&own) {
        let mut all = vec![0.0; matrix.columns()];
        for (node, value) in nodes.iter().zip(motion.chunks_exact(D)) {
            let start = offset + *node as usize * D;
            all[start..start + D].copy_from_slice(value);
        }
        let mut forces = matrix.multiply(&all)?;
        forces.iter_mut().for_each(|force| *force /= scale.max(f64::MIN_POSITIVE));
        resistances.push(resistance(&all, &forces)?);
    }
    let null = null_combinations(resistances, nodes.len());
    let (centre, size) = frame(&own);
    Ok(simplest(null, D).iter().map(|motion| in_words(motion, &centre, size)).collect())
}

/// Sweeps over all pairs of motions; a few are enough.
const SWEEPS: usize = 30;

/// Combinations of the given number of motions whose resistance vanishes, in coefficients: resistances are turned in pairs until they are orthogonal,
/// and their lengths are the singular values (Hestenes 1958). Not the eigenvalues of a Gram matrix, whose rounding would hide a small
/// resistance; of no dimension, so that it is compiled here and not in every program that solves.
fn null_combinations(mut resistances: Vec<Vec<f64>>, nodes: usize) -> Vec<Vec<f64>> {
    let count = resistances.len();
    let nothing = NOTHING * (nodes as f64).sqrt();
    let unit = |k: usize| (0..count).map(|i| f64::from(u8::from(i == k))).collect();
    let mut combinations: Vec<Vec<f64>> = (0..count).map(unit).collect();
    for _ in 0..SWEEPS {
        let mut are_orthogonal = true;
        for (p, q) in (0..count).flat_map(|p| (p + 1..count).map(move |q| (p, q))) {
            let [one, other] = [p, q].map(|k| norm(&resistances[k]));
            let product = dot(&resistances[p], &resistances[q]);
            if product.abs() > f64::EPSILON * one * other {
                are_orthogonal = false;
                let cotangent = (other - one) * (other + one) / (2.0 * product);
                let tangent = cotangent.signum() / (cotangent.abs() + cotangent.hypot(1.0));
                for vectors in [&mut resistances, &mut combinations] {
                    turn(vectors, [p, q], tangent);
                }
            }
        }
        if are_orthogonal {
            break;
        }
    }
    let is_free = |(resistance, _): &(Vec<f64>, Vec<f64>)| norm(resistance) <= nothing;
    resistances.into_iter().zip(combinations).filter(is_free).map(|(_, combination)| combination).collect()
}

/// Turns two of some vectors in their plane.
fn turn(vectors: &mut [Vec<f64>], [p, q]: [usize; 2], tangent: f64) {
    let cosine = 1.0 / tangent.hypot(1.0);
    let sine = cosine * tangent;
    let (before, from) = vectors.split_at_mut(q);
    for (one, other) in before[p].iter_mut().zip(&mut from[0]) {
        (*one, *other) = (cosine * *one - sine * *other, sine * *one + cosine * *other);
    }
}

/// A basis of the same space whose rotations are about coordinate axes where that is possible, and pure translations
/// apart: reduced by rows, those of the rotations first. Translations come first in the result.
fn simplest(mut basis: Vec<Vec<f64>>, translations: usize) -> Vec<Vec<f64>> {
    let count = basis.first().map_or(0, Vec::len);
    let mut done = 0;
    for row in (translations..count).chain(0..translations) {
        let Some(best) =
            (done..basis.len()).max_by(|&a, &b| basis[a][row].abs().total_cmp(&basis[b][row].abs()))
        else {
            break;
        };
        let pivot = basis[best][row];
        if pivot.abs() < 1e-8 {
            continue;
        }
        basis.swap(done, best);
        basis[done].iter_mut().for_each(|value| *value /= pivot);
        let own = basis[done].clone();
        for (_, other) in basis.iter_mut().enumerate().filter(|(k, _)| *k != done) {
            let factor = other[row];
            other.iter_mut().zip(&own).for_each(|(value, own)| *value -= factor * own);
        }
        done += 1;
    }
    basis.truncate(done);
    let turns = |motion: &Vec<f64>| motion[translations..].iter().any(|value| value.abs() > 1e-8);
    basis.sort_by_key(turns);
    // Rotations lead the reduction and so come last here, but each kind in the order of the axes.
    basis
}

fn in_words<const D: usize>(motion: &[f64], centre: &[f64; D], size: f64) -> String {
    let (translation, rotation) = motion.split_at(D);
    let length = |vector: &[f64]| vector.iter().map(|value| value * value).sum::<f64>().sqrt();
    let numbers = |vector: &[f64]| {
        // Rounding is not shown, and no negative zero.
        let number = |value: &f64| format!("{}", (value * 1e6).round() / 1e6 + 0.0);
        format!("({})", vector.iter().map(number).collect::<Vec<_>>().join(", "))
    };
    let direction = |vector: &[f64]| {
        let unit: Vec<f64> = vector.iter().map(|value| value / length(vector)).collect();
        match unit.iter().position(|value| value.abs() > 1.0 - 1e-9) {
            Some(axis) => ["x", "y", "z"][axis.min(2)].to_owned(),
            None => numbers(&unit),
        }
    };
    if length(rotation) <= 1e-8 {
        return format!("translation along {}", direction(translation));
    }
    // v = t + ω × (x − centre), which vanishes at x = centre + ω × t / |ω|² unless there is a part of t along ω.
    if D == 2 {
        let spin = rotation[0] / size;
        let through = [centre[0] - translation[1] / spin, centre[1] + translation[0] / spin];
        return format!("rotation about {}", numbers(&through));
    }
    let spin: Vec<f64> = rotation.iter().map(|value| value / size).collect();
    let square = length(&spin).powi(2);
    let through: Vec<f64> = (0..3)
        .map(|k| {
            let (a, b) = ((k + 1) % 3, (k + 2) % 3);
            centre[k] + (spin[a] * translation[b] - spin[b] * translation[a]) / square
        })
        .collect();
    let along: f64 = spin.iter().zip(translation).map(|(a, b)| a * b).sum();
    let screw = along.abs() > 1e-6 * length(&spin) * length(rotation);
    let kind = if screw { "screw motion" } else { "rotation" };
    format!("{kind} about {} through {}", direction(&spin), numbers(&through))
}

fn instances<const D: usize>() -> [*const (); 3] {
    [rigid_motions::<D> as *const (), free_motions::<D> as *const (), free_motions_of_body::<D> as *const ()]
}
/// Compiled here for the plane and for space, and not in every program (as `instantiate!` of `forms-mesh` does, which this crate does not know).
#[expect(dead_code, reason = "it is there for the instances that it names")]
static INSTANCES: [fn() -> [*const (); 3]; 2] = [instances::<2>, instances::<3>];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CsrMatrix;

    /// Springs between all nodes of a tetrahedron or triangle: what resists everything but rigid motions.
    fn springs<const D: usize>(nodes: &[[f64; D]]) -> BlockMatrix {
        let mut triplets = Vec::new();
        for (i, a) in nodes.iter().enumerate() {
            for (j, b) in nodes.iter().enumerate().filter(|(j, _)| *j != i) {
                let square: f64 = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
                for k in 0..D {
                    for l in 0..D {
                        let value = (a[k] - b[k]) * (a[l] - b[l]) / square;
                        triplets.extend([(D * i + k, D * i + l, value), (D * i + k, D * j + l, -value)]);
                    }
                }
            }
        }
        let size = D * nodes.len();
        CsrMatrix::from_triplets(size, size, &triplets).unwrap().into()
    }

    const SOLID: [[f64; 3]; 5] =
        [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [2.0, 1.0, 1.0]];

    #[test]
    fn rigid_motions_meet_no_resistance() {
        for motion in rigid_motions(&SOLID) {
            let forces = springs(&SOLID).multiply(&motion).unwrap();
            assert!(forces.iter().all(|force| force.abs() < 1e-14));
        }
        assert_eq!(rigid_motions(&[[0.0, 0.0], [1.0, 0.0]]).len(), 3);
        assert_eq!(rigid_motions(&[[0.0], [1.0]]).len(), 1);
    }

    /// The resistance where some unknowns are prescribed.
    fn prescribing(
        prescribed: impl Fn(usize) -> bool,
    ) -> impl Fn(&[f64], &[f64]) -> Result<Vec<f64>, LinearAlgebraError> {
        move |motion, forces| {
            let one = |unknown| if prescribed(unknown) { motion[unknown] } else { forces[unknown] };
            Ok((0..motion.len()).map(one).collect())
        }
    }

    #[test]
    fn a_floating_body_has_six_motions_and_a_clamped_one_has_none() {
        let matrix = springs(&SOLID);
        let found = free_motions(&matrix, 0, &SOLID, &prescribing(|_| false)).unwrap();
        assert_eq!(found.len(), 6);
        assert!(found[..3].iter().all(|motion| motion.starts_with("translation along ")), "{found:?}");
        assert!(
            found[3..].iter().any(|motion| motion == "rotation about z through (1, 0.5, 0.5)"),
            "{found:?}"
        );
        assert!(free_motions(&matrix, 0, &SOLID, &prescribing(|unknown| unknown < 9)).unwrap().is_empty());
    }

    /// Hindrances with the singular values 1, 1e-9 and 1e-13, turned by known rotations: a Gram matrix would have 1e-18 next to 1.
    #[test]
    fn a_small_resistance_is_not_taken_for_none() {
        let (c, s) = (0.6, 0.8);
        let turned = [[c, s, 0.0], [-s * c, c * c, s], [s * s, -s * c, c]];
        for (values, free) in [([1.0, 1e-9, 1e-13], 1), ([1.0, 1e-9, 1e-10], 0), ([1e-12, 1.0, 0.0], 2)] {
            // Column k of Σ V: entry i is σ_i v_ik.
            let resistances = (0..3).map(|k| (0..3).map(|i| values[i] * turned[i][k]).collect()).collect();
            let found = null_combinations(resistances, 1);
            assert_eq!(found.len(), free, "{values:?}");
            for combination in found {
                for i in (0..3).filter(|i| values[*i] > NOTHING) {
                    let part: f64 = (0..3).map(|k| turned[i][k] * combination[k]).sum();
                    assert!(part.abs() <= NOTHING / values[i], "{values:?}: {part:e} of {i}");
                }
                assert!((norm(&combination) - 1.0).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn what_is_left_by_partial_supports_is_told() {
        let matrix = springs(&SOLID);
        // Held at the origin.
        let hinge = free_motions(&matrix, 0, &SOLID, &prescribing(|unknown| unknown < 3)).unwrap();
        assert_eq!(hinge.len(), 3);
        for (axis, motion) in ["x", "y", "z"].iter().zip(&hinge) {
            assert!(motion.starts_with(&format!("rotation about {axis} through (")), "{hinge:?}");
        }
        // No node may move along z.
        let sliding = free_motions(&matrix, 0, &SOLID, &prescribing(|unknown| unknown % 3 == 2)).unwrap();
        assert_eq!(sliding[..2], ["translation along x", "translation along y"]);
        assert_eq!(sliding[2], "rotation about z through (1, 0.5, 0.5)");
        // Held at two points: the axis through both is left.
        let axis = free_motions(&matrix, 0, &SOLID, &prescribing(|unknown| unknown < 6)).unwrap();
        assert_eq!(axis, ["rotation about x through (1, 0, 0)"]);
        let triangle = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        let pinned =
            free_motions(&springs(&triangle), 0, &triangle, &prescribing(|unknown| unknown < 2)).unwrap();
        assert_eq!(pinned, ["rotation about (0, 0)"]);
    }
}

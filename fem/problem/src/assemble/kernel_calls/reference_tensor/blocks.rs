//! The reference tensor of forms whose block is a matrix: sparse, a list of terms for each pair of nodes.

// Closures and iterator adaptors do not inherit a caller's target features, and copies of slices may become calls:
// loops over lane values are plain.
#![allow(clippy::needless_range_loop, clippy::manual_memcpy)]

use forms_core::contract::{Basis, BilinearKernel, PointGeometry, Requirements};

use crate::assemble::walk::GroupSide;
use crate::lanes::SimdLane;

/// R_ab(i, j) where it is not zero.
pub(in crate::assemble) struct Terms {
    /// Number of directions: D + 1 gradients of barycentric coordinates, and the value.
    directions: usize,
    /// The direction that stands for the value.
    value: Option<usize>,
    /// Number of terms of each pair, pair after pair in rows.
    lengths: Vec<u32>,
    /// a · directions + b, and the coefficient.
    terms: Vec<(u32, f64)>,
}

impl Terms {
    pub fn new<const D: usize>(
        side: &GroupSide<D>,
        elements: [usize; 2],
        weights: &[f64],
        symmetric: bool,
        requirements: &Requirements,
    ) -> Self {
        let gradients = if requirements.basis_gradient { D + 1 } else { 0 };
        let directions = gradients + usize::from(requirements.basis_value);
        // Components of each node in the directions, at `(node * points + q) * directions`.
        let components = |element: usize| -> Vec<f64> {
            let table = &side.elements[element];
            let mut all = Vec::with_capacity(table.nodes * weights.len() * directions);
            for node in 0..table.nodes {
                let slopes: Vec<[f64; D]> =
                    (0..weights.len()).map(|q| table.gradient[q * table.nodes + node]).collect();
                let barycentric = sparse_components(&slopes);
                for q in 0..weights.len() {
                    if gradients > 0 {
                        all.extend(&barycentric[q * (D + 1)..(q + 1) * (D + 1)]);
                    }
                    if requirements.basis_value {
                        all.push(table.value[q * table.nodes + node]);
                    }
                }
            }
            all
        };
        let (tests, trials) = (components(elements[0]), components(elements[1]));
        let per_node = weights.len() * directions;
        let mut tensor = Terms {
            directions,
            value: requirements.basis_value.then_some(gradients),
            lengths: vec![],
            terms: vec![],
        };
        for (i, test) in tests.chunks_exact(per_node).enumerate() {
            for (j, trial) in trials.chunks_exact(per_node).enumerate() {
                if symmetric && j < i {
                    continue;
                }
                let before = tensor.terms.len();
                for a in 0..directions {
                    for b in 0..directions {
                        let (mut sum, mut scale) = (0.0_f64, 0.0_f64);
                        for (q, weight) in weights.iter().enumerate() {
                            let part = weight * test[q * directions + a] * trial[q * directions + b];
                            sum += part;
                            scale += part.abs();
                        }
                        // What is rounding only is zero.
                        if sum.abs() > 1e-14 * scale {
                            tensor.terms.push(((a * directions + b) as u32, sum));
                        }
                    }
                }
                tensor.lengths.push((tensor.terms.len() - before) as u32);
            }
        }
        tensor
    }

    /// Number of directions.
    pub fn directions(&self) -> usize {
        self.directions
    }

    /// Number of terms.
    pub fn count(&self) -> usize {
        self.terms.len()
    }
}

/// Components c_a of a gradient along ∇λ_0 … ∇λ_D at each point. Σ_a ∇λ_a = 0 leaves one of them free at each point:
/// the choice that makes one of them zero everywhere and leaves the most zeros is taken.
fn sparse_components<const D: usize>(slopes: &[[f64; D]]) -> Vec<f64> {
    let largest = slopes.as_flattened().iter().fold(0.0_f64, |largest, slope| largest.max(slope.abs()));
    let negligible = 1e-14 * largest;
    let mut best: Option<(usize, Vec<f64>)> = None;
    for free in 0..=D {
        let mut components = Vec::with_capacity(slopes.len() * (D + 1));
        for slope in slopes {
            let component = |a: usize| if a == 0 { 0.0 } else { slope[a - 1] };
            let shift = component(free);
            components.extend((0..=D).map(|a| {
                let difference = component(a) - shift;
                if difference.abs() <= negligible { 0.0 } else { difference }
            }));
        }
        let directions =
            (0..=D).filter(|a| components.iter().skip(*a).step_by(D + 1).any(|c| *c != 0.0)).count();
        if best.as_ref().is_none_or(|(known, _)| directions < *known) {
            best = Some((directions, components));
        }
    }
    best.map(|(_, components)| components).unwrap_or_default()
}

/// The blocks of all pairs, of at most ENTRIES entries. `directions` is memory that is kept.
#[inline(always)]
pub(super) fn contract<K: BilinearKernel<D>, L: SimdLane, const ENTRIES: usize, const D: usize>(
    kernel: &K,
    cell: &K::Cell<L>,
    tensor: &Terms,
    determinant: L,
    inverse: &[[L; D]; D],
    directions: &mut Vec<L>,
    blocks: &mut [L],
) {
    let zero = L::splat(0.0);
    let entries = (K::TEST_COMPONENTS * K::TRIAL_COMPONENTS).min(ENTRIES);
    let count = tensor.directions;
    let geometry = PointGeometry::of_weight(determinant);
    let point = kernel.point(cell, &geometry, &[]);
    let hessian = [[zero; D]; D];
    directions.resize(count * count * ENTRIES, zero);
    let (directions, _) = directions.as_chunks_mut::<ENTRIES>();
    for a in 0..count {
        let test = kernel.test(&point, &direction(tensor, inverse, a), &hessian);
        for b in if K::SYMMETRIC { a } else { 0 }..count {
            let trial = kernel.trial(&point, &direction(tensor, inverse, b), &hessian);
            let mut accumulator = K::zero::<L>();
            K::pair(&mut accumulator, &test, &trial);
            let block = kernel.finish(cell, &accumulator);
            let block = &block.as_ref()[..entries];
            let target = &mut directions[a * count + b];
            for entry in 0..entries {
                target[entry] = block[entry];
            }
            if K::SYMMETRIC && b != a {
                let target = &mut directions[b * count + a];
                for entry in 0..entries {
                    target[entry % K::TEST_COMPONENTS * K::TEST_COMPONENTS + entry / K::TEST_COMPONENTS] =
                        block[entry];
                }
            }
        }
    }
    let (directions, mut terms) = (&directions[..], &tensor.terms[..]);
    for (length, target) in tensor.lengths.iter().zip(blocks.chunks_exact_mut(entries)) {
        let (own, others) = terms.split_at(*length as usize);
        terms = others;
        let mut sums = [zero; ENTRIES];
        if let Some(((place, coefficient), own)) = own.split_first() {
            let (block, coefficient) = (&directions[*place as usize], L::splat(*coefficient));
            for entry in 0..entries {
                if K::NONZERO[entry] {
                    sums[entry] = block[entry] * coefficient;
                }
            }
            for term in 0..own.len() {
                let (place, coefficient) = own[term];
                let (block, coefficient) = (&directions[place as usize], L::splat(coefficient));
                for entry in 0..entries {
                    if K::NONZERO[entry] {
                        sums[entry] = block[entry].multiply_add(coefficient, sums[entry]);
                    }
                }
            }
        }
        for entry in 0..entries {
            target[entry] = sums[entry];
        }
    }
}

/// A function whose gradient is that of a barycentric coordinate, or whose value is one.
#[inline(always)]
fn direction<L: SimdLane, const D: usize>(tensor: &Terms, inverse: &[[L; D]; D], a: usize) -> Basis<L, D> {
    let zero = L::splat(0.0);
    let mut basis = Basis { value: zero, gradient: [zero; D] };
    if tensor.value == Some(a) {
        basis.value = L::splat(1.0);
    } else if a == 0 {
        for i in 0..D {
            let mut sum = inverse[i][0];
            for j in 1..D {
                sum += inverse[i][j];
            }
            basis.gradient[i] = -sum;
        }
    } else {
        for i in 0..D {
            basis.gradient[i] = inverse[i][a - 1];
        }
    }
    basis
}

#[cfg(test)]
mod tests {
    use super::sparse_components;

    #[test]
    fn a_vertex_function_has_one_direction_and_an_edge_function_two() {
        // P2 on the triangle at three points: φ_0 = λ_0 (2 λ_0 − 1), φ_01 = 4 λ_0 λ_1.
        let points = [[0.2, 0.3], [0.1, 0.6], [0.5, 0.25]];
        let count = |slopes: &[[f64; 2]]| -> usize {
            let components = sparse_components(slopes);
            for (slope, components) in slopes.iter().zip(components.chunks(3)) {
                for k in 0..2 {
                    // ∇λ_0 = (−1, −1), ∇λ_1 = (1, 0), ∇λ_2 = (0, 1).
                    assert!((components[k + 1] - components[0] - slope[k]).abs() < 1e-14);
                }
            }
            (0..3).filter(|a| components.chunks(3).any(|components| components[*a] != 0.0)).count()
        };
        let first = points.map(|[x, y]| [1.0 - 4.0 * (1.0 - x - y); 2]);
        assert_eq!(count(&first), 1);
        let edge = points.map(|[x, y]| [4.0 * (1.0 - x - y) - 4.0 * x, -4.0 * x]);
        assert_eq!(count(&edge), 2);
    }
}

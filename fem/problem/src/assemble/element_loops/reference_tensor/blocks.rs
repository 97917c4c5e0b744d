//! The reference tensor of forms whose block is a matrix: sparse, a list of terms for each pair of nodes.

// Closures and iterator adaptors do not inherit a caller's target features, and copies of slices may become calls:
// loops over lane values are plain.
#![allow(clippy::needless_range_loop, clippy::manual_memcpy)]

use forms_core::contract::{Basis, BilinearKernel, Further, PointGeometry, Requirements};

use crate::assemble::element_loops::block_sink::BlockSink;
use crate::assemble::groups::GroupSide;
use crate::lanes::SimdLane;

/// R_ab(i, j) where it is not zero.
pub(in crate::assemble) struct Terms {
    /// Runs of pairs that have the same number of terms: how many pairs, and how many terms each.
    runs: Vec<[usize; 2]>,
    /// Numbers of the pairs, run after run.
    pairs: Vec<u32>,
    /// a · directions + b, and the coefficient, pair after pair.
    terms: Vec<(u32, f64)>,
}

/// Directions in which a basis function is known: the gradients of D + 1 barycentric coordinates, then the value.
pub(super) const fn direction_count<const D: usize>(requirements: &Requirements) -> usize {
    gradients::<D>(requirements) + requirements.basis_value as usize
}

const fn gradients<const D: usize>(requirements: &Requirements) -> usize {
    if requirements.basis_gradient { D + 1 } else { 0 }
}

/// More than the number of pairs of directions, at most five each: a power of two, so that a place is masked and not checked.
const PLACES: usize = 32;

impl Terms {
    pub fn new<const D: usize>(
        side: &GroupSide<D>,
        elements: [usize; 2],
        weights: &[f64],
        symmetric: bool,
        requirements: &Requirements,
    ) -> Self {
        let (gradients, directions) = (gradients::<D>(requirements), direction_count::<D>(requirements));
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
        let mut of_pairs: Vec<Vec<(u32, f64)>> = vec![];
        for (i, test) in tests.chunks_exact(per_node).enumerate() {
            for (j, trial) in trials.chunks_exact(per_node).enumerate() {
                if symmetric && j < i {
                    continue;
                }
                let mut own = vec![];
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
                            own.push(((a * directions + b) as u32, sum));
                        }
                    }
                }
                of_pairs.push(own);
            }
        }
        Terms::of_pairs(&of_pairs)
    }

    /// The terms of each pair. No dimension in the types: compiled once.
    #[inline(never)]
    fn of_pairs(of_pairs: &[Vec<(u32, f64)>]) -> Self {
        let mut pairs: Vec<u32> = (0..of_pairs.len() as u32).collect();
        pairs.sort_by_key(|pair| of_pairs[*pair as usize].len());
        let lengths: Vec<usize> = pairs.iter().map(|pair| of_pairs[*pair as usize].len()).collect();
        Terms {
            runs: lengths.chunk_by(|a, b| a == b).map(|run| [run.len(), run[0]]).collect(),
            terms: pairs.iter().flat_map(|pair| of_pairs[*pair as usize].iter().copied()).collect(),
            pairs,
        }
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
pub(super) fn contract<K, L, S, const ENTRIES: usize, const D: usize>(
    kernel: &K,
    cell: &K::Cell<L>,
    tensor: &Terms,
    determinant: L,
    inverse: &[[L; D]; D],
    directions: &mut Vec<L>,
    sink: &mut S,
) where
    K: BilinearKernel<D>,
    L: SimdLane,
    S: BlockSink<L> + ?Sized,
{
    let zero = L::splat(0.0);
    let entries = (K::TEST_COMPONENTS * K::TRIAL_COMPONENTS).min(ENTRIES);
    // A constant: the loops over directions are unrolled where blocks are small.
    let count = const { direction_count::<D>(&K::REQUIREMENTS) };
    let geometry = PointGeometry::of_weight(determinant);
    let point = kernel.point(cell, &geometry, &[]);
    let further = Further::none();
    directions.resize(PLACES * ENTRIES, zero);
    let (directions, _) = directions.as_chunks_mut::<ENTRIES>();
    let Some(directions) = directions.first_chunk_mut::<PLACES>() else { return };
    for a in 0..count {
        let test = kernel.test(&point, &direction::<K, L, D>(inverse, a), &further);
        for b in if K::SYMMETRIC { a } else { 0 }..count {
            let trial = kernel.trial(&point, &direction::<K, L, D>(inverse, b), &further);
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
    let (mut pairs, mut terms) = (&tensor.pairs[..], &tensor.terms[..]);
    for [count, length] in &tensor.runs {
        let (own_pairs, others) = pairs.split_at(*count);
        pairs = others;
        for pair in own_pairs {
            let (own, others) = terms.split_at(*length);
            terms = others;
            let mut sums = [zero; ENTRIES];
            if let Some(((place, coefficient), own)) = own.split_first() {
                let (block, coefficient) = (&directions[*place as usize % PLACES], L::splat(*coefficient));
                for entry in 0..entries {
                    if K::NONZERO[entry] {
                        sums[entry] = block[entry] * coefficient;
                    }
                }
                for term in 0..own.len() {
                    let (place, coefficient) = own[term];
                    let (block, coefficient) = (&directions[place as usize % PLACES], L::splat(coefficient));
                    for entry in 0..entries {
                        if K::NONZERO[entry] {
                            sums[entry] = block[entry].multiply_add(coefficient, sums[entry]);
                        }
                    }
                }
            }
            sink.put(*pair as usize, &sums[..entries]);
        }
    }
}

/// A function whose gradient is that of a barycentric coordinate, or whose value is one.
#[inline(always)]
fn direction<K: BilinearKernel<D>, L: SimdLane, const D: usize>(
    inverse: &[[L; D]; D],
    a: usize,
) -> Basis<L, D> {
    let zero = L::splat(0.0);
    let mut basis = Basis { value: zero, gradient: [zero; D] };
    if a == const { gradients::<D>(&K::REQUIREMENTS) } {
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

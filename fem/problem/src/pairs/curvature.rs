//! Second derivatives of moving segments in the plane: of points along the own facet, and of the feet of opposite nodes by displacements.
//!
//! A facet x(s) is a parabola: x″ is a constant. With the tangent τ = x′ and the normal n of the own facet, and y(η) of the opposite one
//!
//! ```text
//! κ = n·x″ / |τ|²,  n′ = −κ τ,  κ′ = (n′·x″ − 2 κ τ·x″) / |τ|²,  n″ = −κ′ τ − κ x″
//! y′ η″ − g″ n = x″ + 2 g′ n′ + g n″ − y″ η′²
//! ```
//!
//! The foot s of a node y is the zero of Φ = (y − x(s))·τ. With a, d and e, the factors of a node's displacement in δy − δx, δx′ and δx″, and M = −1/Φ,ₛ
//!
//! ```text
//! ∂s/∂u = M (a τ + d (y − x)),  Φ,ₛᵤ = a x″ − 2 d τ + e (y − x),  Φ,ₛₛ = −3 τ·x″
//! ∂²s/∂u∂v = M ((aᵤ dᵥ + aᵥ dᵤ) I + Φ,ₛᵤ ⊗ ∂s/∂v + ∂s/∂u ⊗ Φ,ₛᵥ + Φ,ₛₛ ∂s/∂u ⊗ ∂s/∂v)
//! ```

// Closures and iterator adaptors do not inherit a caller's target features: loops over lanes are plain.
#![allow(clippy::needless_range_loop)]

use forms_core::contract::Lane;

use super::surface::dot;

/// Rays from an own facet to an opposite one, with the derivatives of both.
pub(super) struct CurvedRays<const D: usize, L = f64> {
    pub tangent: [L; D],
    pub bend: [L; D],
    pub normal: [L; D],
    pub gap: L,
    pub opposite_tangent: [L; D],
    pub opposite_bend: [L; D],
}

/// Derivatives of a ray along the own coordinate: of its direction, the gap, and the opposite coordinate.
pub(super) struct Along<const D: usize, L = f64> {
    pub normal: [L; D],
    pub gap: L,
    pub met: L,
}

impl<const D: usize, L: Lane> CurvedRays<D, L> {
    /// The derivatives g′ and η′ of the gap and the opposite coordinate from y′ η′ − g′ n.
    #[inline(always)]
    fn meets(&self, side: &[L; D]) -> (L, L) {
        let CurvedRays { normal, opposite_tangent, .. } = self;
        let mut across = *opposite_tangent;
        (across[0], across[D - 1]) = (opposite_tangent[D - 1], -opposite_tangent[0]);
        let gap = -dot(&across, side) / dot(&across, normal);
        let mut passed = *side;
        for k in 0..D {
            passed[k] += gap * normal[k];
        }
        (gap, dot(opposite_tangent, &passed) / dot(opposite_tangent, opposite_tangent))
    }

    #[inline(always)]
    fn first(&self) -> Along<D, L> {
        let CurvedRays { tangent, bend, normal, .. } = self;
        let curvature = dot(normal, bend) / dot(tangent, tangent);
        let (mut turned, mut side) = (*tangent, *tangent);
        for k in 0..D {
            turned[k] = -curvature * tangent[k];
            side[k] += self.gap * turned[k];
        }
        let (gap, met) = self.meets(&side);
        Along { normal: turned, gap, met }
    }

    #[inline(always)]
    pub fn second(&self) -> Along<D, L> {
        let (first, CurvedRays { tangent, bend, normal, .. }) = (self.first(), self);
        let (square, two) = (dot(tangent, tangent), L::splat(2.0));
        let curvature = dot(normal, bend) / square;
        let change = (dot(&first.normal, bend) - two * curvature * dot(tangent, bend)) / square;
        let (mut turned, mut side) = (*bend, *bend);
        for k in 0..D {
            turned[k] = -change * tangent[k] - curvature * bend[k];
            side[k] += two * first.gap * first.normal[k] + self.gap * turned[k]
                - first.met * first.met * self.opposite_bend[k];
        }
        let (gap, met) = self.meets(&side);
        Along { normal: turned, gap, met }
    }
}

/// The second derivatives of a foot in the plane.
#[derive(Clone, Debug)]
pub(crate) struct FootCurve<const D: usize> {
    /// The own coordinate's direction in the own cell's reference coordinates.
    pub along: [f64; D],
    /// x′ and x″ at the foot.
    pub tangent: [f64; D],
    pub bend: [f64; D],
    /// From the foot to the opposite node.
    pub off: [f64; D],
    /// M.
    pub factor: f64,
}

/// The factors of a node's displacement in δy − δx, δx′ and δx″ at a foot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct NodeOfFoot {
    pub apart: f64,
    pub slope: f64,
    pub bend: f64,
}

impl<const D: usize> FootCurve<D> {
    /// The derivative of the foot by a node's displacement.
    pub fn rate(&self, node: &NodeOfFoot) -> [f64; D] {
        std::array::from_fn(|k| self.factor * (node.apart * self.tangent[k] + node.slope * self.off[k]))
    }

    /// The derivative of Φ,ₛ by a node's displacement, with half of that along the foot.
    pub fn turn(&self, node: &NodeOfFoot) -> [f64; D] {
        let (rate, along) = (self.rate(node), -1.5 * dot(&self.tangent, &self.bend));
        std::array::from_fn(|k| {
            node.apart * self.bend[k] - 2.0 * node.slope * self.tangent[k]
                + node.bend * self.off[k]
                + along * rate[k]
        })
    }

    /// The factor of the identity in the second derivative by the displacements of two nodes.
    pub fn of_both(&self, [one, other]: [&NodeOfFoot; 2]) -> f64 {
        self.factor * (one.apart * other.slope + other.apart * one.slope)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Nodes = [[f64; 2]; 3];

    fn shapes(s: f64) -> [[f64; 3]; 3] {
        // Values, first and second derivatives of the functions of the ends and the middle.
        [
            [(1.0 - s) * (1.0 - 2.0 * s), s * (2.0 * s - 1.0), 4.0 * s * (1.0 - s)],
            [4.0 * s - 3.0, 4.0 * s - 1.0, 4.0 - 8.0 * s],
            [4.0, 4.0, -8.0],
        ]
    }

    fn curve(nodes: &Nodes, s: f64) -> [[f64; 2]; 3] {
        shapes(s).map(|row| std::array::from_fn(|k| (0..3).map(|i| row[i] * nodes[i][k]).sum()))
    }

    fn fourth_order(h: f64, at: impl Fn(f64) -> f64) -> f64 {
        (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h)
    }

    const OWN: Nodes = [[0.0, 0.0], [1.1, 0.2], [0.5, 0.3]];
    const OPPOSITE: Nodes = [[1.2, 1.0], [-0.1, 0.8], [0.6, 0.75]];

    fn ray(s: f64) -> (CurvedRays<2>, f64) {
        let [x, tangent, bend] = curve(&OWN, s);
        let length = dot(&tangent, &tangent).sqrt();
        let normal = [-tangent[1] / length, tangent[0] / length];
        let (mut gap, mut met) = (0.5, 1.0 - s);
        for _ in 0..30 {
            let [y, slope, _] = curve(&OPPOSITE, met);
            let off: [f64; 2] = std::array::from_fn(|k| x[k] + gap * normal[k] - y[k]);
            // y′ δη − n δg = off.
            let determinant = -slope[0] * normal[1] + slope[1] * normal[0];
            met += (-off[0] * normal[1] + off[1] * normal[0]) / determinant;
            gap += (slope[0] * off[1] - slope[1] * off[0]) / determinant;
        }
        let [_, opposite_tangent, opposite_bend] = curve(&OPPOSITE, met);
        (CurvedRays { tangent, bend, normal, gap, opposite_tangent, opposite_bend }, met)
    }

    #[test]
    fn rays_have_the_derivatives_of_differences() {
        for s in [0.35, 0.45, 0.6] {
            let (first, second) = (ray(s).0.first(), ray(s).0.second());
            let pairs = [
                (first.gap, fourth_order(1e-3, |t| ray(s + t).0.gap)),
                (first.met, fourth_order(1e-3, |t| ray(s + t).1)),
                (first.normal[0], fourth_order(1e-3, |t| ray(s + t).0.normal[0])),
                (second.gap, fourth_order(1e-3, |t| ray(s + t).0.first().gap)),
                (second.met, fourth_order(1e-3, |t| ray(s + t).0.first().met)),
                (second.normal[0], fourth_order(1e-3, |t| ray(s + t).0.first().normal[0])),
                (second.normal[1], fourth_order(1e-3, |t| ray(s + t).0.first().normal[1])),
            ];
            for (place, (found, difference)) in pairs.into_iter().enumerate() {
                let off = (found - difference).abs() / (1.0 + found.abs());
                assert!(off < 1e-9, "{place} at {s}: {found} {difference}");
            }
        }
    }

    /// The foot of a node on the own curve, and its second derivatives there.
    fn foot(own: &Nodes, node: &[f64; 2]) -> (f64, FootCurve<2>) {
        let mut s = 0.5;
        for _ in 0..60 {
            let [x, tangent, bend] = curve(own, s);
            let off = [node[0] - x[0], node[1] - x[1]];
            s += dot(&off, &tangent) / (dot(&tangent, &tangent) - dot(&off, &bend));
        }
        let [x, tangent, bend] = curve(own, s);
        let off = [node[0] - x[0], node[1] - x[1]];
        let factor = 1.0 / (dot(&tangent, &tangent) - dot(&off, &bend));
        (s, FootCurve { along: [1.0, 0.0], tangent, bend, off, factor })
    }

    /// Derivatives by the displacements of all nodes, those of the own curve and the opposite one.
    #[test]
    fn feet_have_the_derivatives_of_differences() {
        let node = [0.45, 0.55];
        let moved = |by: &[[f64; 2]; 4], t: f64| {
            let own = std::array::from_fn(|i| std::array::from_fn(|k| OWN[i][k] + t * by[i][k]));
            foot(&own, &std::array::from_fn(|k| node[k] + t * by[3][k]))
        };
        let nodes_at = |s: f64| -> [NodeOfFoot; 4] {
            let [value, slope, bend] = shapes(s);
            std::array::from_fn(|i| match i {
                3 => NodeOfFoot { apart: 1.0, slope: 0.0, bend: 0.0 },
                _ => NodeOfFoot { apart: -value[i], slope: slope[i], bend: bend[i] },
            })
        };
        let by = [[0.3, -0.7], [-0.2, 0.5], [0.9, 0.4], [-0.6, 0.8]];
        let rate_along = |t: f64, by: &[[f64; 2]; 4], j: usize| {
            let (s, curve) = moved(by, t);
            curve.rate(&nodes_at(s)[j])
        };
        let (s, curve) = moved(&by, 0.0);
        let nodes = nodes_at(s);
        let along: f64 = (0..4).map(|j| dot(&curve.rate(&nodes[j]), &by[j])).sum();
        assert!((along - fourth_order(1e-3, |t| moved(&by, t).0)).abs() < 1e-9);
        for j in 0..4 {
            let (rate, turn) = (curve.rate(&nodes[j]), curve.turn(&nodes[j]));
            let mut found = [0.0; 2];
            for k in 0..4 {
                let (other, turned) = (curve.rate(&nodes[k]), curve.turn(&nodes[k]));
                let both = curve.of_both([&nodes[j], &nodes[k]]);
                let [of_rate, of_turn] = [dot(&other, &by[k]), dot(&turned, &by[k])];
                for a in 0..2 {
                    found[a] += both * by[k][a] + curve.factor * (turn[a] * of_rate + rate[a] * of_turn);
                }
            }
            for (a, found) in found.into_iter().enumerate() {
                let difference = fourth_order(5e-4, |t| rate_along(t, &by, j)[a]);
                assert!((found - difference).abs() < 1e-9, "{j} {a}: {found} {difference}");
            }
        }
    }
}

//! Deflation: further solutions from the same start, with known ones made repulsive.
//!
//! Newton's method for m(u) R(u) with m(u) = Π_k (σ²/|u − u_k|² + 1) has the direction of the one for R: its step is
//! δ / (1 − ∇m·δ/m) (Farrell, Birkisson and Funke 2015). Tangent, linear solver and criterion stay.

use std::ops::Range;

use super::PerUnknown;
use crate::field::Field;

/// Known solutions of a [`Problem`](super::Problem) with N unknowns, from which Newton's method is kept away:
/// [`Problem::deflated`](super::Problem::deflated).
///
/// Each known solution repels within a distance comparable to that from which the iteration starts. A start other than the known solutions
/// is needed. Whether one more solution exists is not decided by a failure: another start, or another radius, may find it.
///
/// ```
/// use forms_fem::prelude::*;
/// use forms_fem::solve::Deflation;
///
/// // u = u³ at each point: −1, 0 and 1.
/// let mesh = rectangle([0.0; 2], [1.0; 2], [1, 1], CellShape::Quadrilateral, 1)?;
/// let space = Space::of(&mesh, Elements::Lagrange(0), Scope::Cell, &[])?;
/// let form = form!(|u: Unknown<Scalar>, v: Test<Scalar>| integral(cells("all"), (u * u * u - u) * v));
/// let start = Field::interpolate(&space, |_| 0.4)?;
/// let mut known = Deflation::new();
/// let mut values = vec![];
/// while let Ok(solved) = Problem::new(&form, &space).start(&start).deflated(&known).solve() {
///     values.push(solved.field().values()[0]);
///     known.add(solved.field());
/// }
/// values.sort_by(f64::total_cmp);
/// assert!(values.iter().zip([-1.0, 0.0, 1.0]).all(|(found, exact)| (found - exact).abs() < 1e-9));
/// assert_eq!(values.len(), 3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Deflation<const D: usize, const N: usize = 1> {
    known: Vec<[Field<D>; N]>,
    radius: f64,
}

impl<const D: usize, const N: usize> Default for Deflation<D, N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const D: usize, const N: usize> Deflation<D, N> {
    /// No known solution yet.
    pub fn new() -> Self {
        Deflation { known: vec![], radius: 1.0 }
    }

    /// The radius σ within which a solution repels, relative to its distance from the start; one unless it is given.
    pub fn radius(mut self, radius: f64) -> Self {
        self.radius = radius;
        self
    }

    /// One more known solution.
    pub fn add<'f>(&mut self, solution: impl PerUnknown<'f, Field<D>, N>) {
        self.known.push(solution.per_unknown().map(Field::clone));
    }

    /// The known solutions, in the order in which they were added.
    pub fn known(&self) -> &[[Field<D>; N]] {
        &self.known
    }

    /// The repulsion in an iteration from a start.
    pub(super) fn repulsion_at(&self, start: &[f64]) -> Repulsion {
        let centres = self.known.iter().map(|fields| {
            let values: Vec<f64> = fields.iter().flat_map(|field| field.values()).copied().collect();
            let mut weights = vec![];
            let mut begin = 0;
            for field in fields {
                let range = begin..begin + field.values().len();
                let square = square_distance(&values, start, &range);
                if square > 0.0 {
                    weights.push((range.clone(), 1.0 / square));
                }
                begin = range.end;
            }
            // All fields together have the distance one.
            let count = weights.len().max(1) as f64;
            weights.iter_mut().for_each(|(_, weight)| *weight /= count);
            Centre { values, weights }
        });
        Repulsion { centres: centres.collect(), square_radius: self.radius * self.radius }
    }
}

fn square_distance(a: &[f64], b: &[f64], range: &Range<usize>) -> f64 {
    a[range.clone()].iter().zip(&b[range.clone()]).map(|(a, b)| (a - b) * (a - b)).sum()
}

/// A known solution, with a weight per field that makes its distance from the start one.
#[derive(Clone, Debug)]
struct Centre {
    values: Vec<f64>,
    weights: Vec<(Range<usize>, f64)>,
}

impl Centre {
    fn square_distance(&self, u: &[f64]) -> f64 {
        self.weights.iter().map(|(range, weight)| weight * square_distance(&self.values, u, range)).sum()
    }

    /// ⟨u − u_k, δ⟩.
    fn along(&self, u: &[f64], step: &[f64]) -> f64 {
        let of_field = |(range, weight): &(Range<usize>, f64)| {
            let terms = range.clone().map(|k| (u[k] - self.values[k]) * step[k]);
            weight * terms.sum::<f64>()
        };
        self.weights.iter().map(of_field).sum()
    }
}

/// Known solutions as seen from a start.
#[derive(Clone, Debug)]
pub(super) struct Repulsion {
    centres: Vec<Centre>,
    square_radius: f64,
}

/// A step is lengthened at most by this factor.
const LONGEST: f64 = 10.0;

/// A solution nearer to a known one than this part of the start's distance is the same.
const SAME: f64 = 1e-4;

impl Repulsion {
    /// 1 / (1 − ∇m·δ/m).
    pub fn factor(&self, u: &[f64], step: &[f64]) -> f64 {
        let slopes = self.centres.iter().map(|centre| {
            let square = centre.square_distance(u);
            -2.0 * centre.along(u, step) / (square * (1.0 + square / self.square_radius))
        });
        let rest = 1.0 - slopes.filter(|slope| slope.is_finite()).sum::<f64>();
        if rest == 0.0 { LONGEST } else { (1.0 / rest).clamp(-LONGEST, LONGEST) }
    }

    /// The number of the known solution at u.
    pub fn known_at(&self, u: &[f64]) -> Option<usize> {
        self.centres.iter().position(|centre| centre.square_distance(u) <= SAME * SAME)
    }

    /// The number of the known solution from which the iteration starts.
    pub fn starts_at(&self) -> Option<usize> {
        self.centres.iter().position(|centre| centre.weights.is_empty())
    }
}

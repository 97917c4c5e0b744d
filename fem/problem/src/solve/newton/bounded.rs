//! Bounds on unknowns in Newton's method, by a primal-dual active set (Hintermüller, Ito and Kunisch 2002).
//!
//! With bounds l ≤ u ≤ h the solution is where R_i ≥ 0 at a lower bound, R_i ≤ 0 at an upper one, and R_i = 0 in between. At each iterate
//! a set of unknowns is held: those beyond a bound, and those at one that the residual presses on. Newton's step leads them to
//! the bound and solves the other rows. Masks take held rows and columns out of the tangent, so that its pattern and its
//! analysis stay.
//!
//! Without a line search steps are whole and iterates may leave the bounds on the way. If sets repeat, and the tangent is
//! symmetric, the iteration goes on along the potential: iterates then obey the bounds, each step lowers the potential, and bounds are given up only where
//! the others are settled.

mod judging;
mod masks;
mod peeling;
mod steps;
mod update;

use self::peeling::Peeling;
pub(super) use self::steps::Moved;
use super::convergence::Fields;
use super::{LineSearch, NewtonFailure};
use crate::bounds::Side;
use crate::linear_algebra::CsrMatrix;
use crate::solve::elimination::Elimination;

/// Lower and upper bounds of all unknowns, one number per unknown; −∞ and ∞ where there is none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct UnknownBounds {
    /// Lower bounds.
    pub lower: Vec<f64>,
    /// Upper bounds.
    pub upper: Vec<f64>,
}

/// An unknown at its bound in a solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldUnknown {
    /// Its number.
    pub unknown: usize,
    /// The bound.
    pub side: Side,
    /// The residual of its equation, by which the bound acts on it: positive at a lower bound, negative at an upper one \[unit of R\].
    pub reaction: f64,
    /// Whether the reaction is zero up to the tolerance. The solution then has one-sided derivatives only, and an adjoint gives one of them.
    pub is_weak: bool,
}

/// A reason why bounds do not fit an unknown.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs)]
pub enum BoundFailure {
    /// The lower bound is above the upper one.
    #[error("its lower bound {lower} is above its upper bound {upper}")]
    Empty { lower: f64, upper: f64 },
    /// The prescribed value is outside.
    #[error("its value is prescribed as {value}, outside of its bounds {lower} and {upper}")]
    Prescribed { value: f64, lower: f64, upper: f64 },
    /// The unknown is given by several others.
    #[error(
        "it has a bound, but a condition gives it by {others} others, as on a hanging node, a sliding plane or a rigid body: bounds \
         hold for free unknowns; leave it out of the bounds, or the condition out of the constraints"
    )]
    Related { others: usize },
    /// NaN, an infinite number on the wrong side, or another number of bounds than unknowns.
    #[error("its bounds {lower} and {upper} are no bounds")]
    NotANumber { lower: f64, upper: f64 },
}

/// A prescribed value may be beyond a bound by this part of the largest number of either.
const SAME: f64 = 1e-13;

/// Steps of an iteration with bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    /// Whole steps, which may lead beyond bounds.
    Whole,
    /// Along the potential, between the bounds.
    Potential,
    /// By the norm of the residual, between the bounds.
    Residual,
}

/// A free unknown with a bound.
#[derive(Clone, Copy, Debug)]
struct Bounded {
    unknown: usize,
    /// Its number among the free unknowns.
    place: usize,
    /// The component of a field that it belongs to.
    component: usize,
    lower: f64,
    upper: f64,
    held: Option<Side>,
}

impl Bounded {
    fn bound(&self, side: Side) -> f64 {
        match side {
            Side::Lower => self.lower,
            Side::Upper => self.upper,
        }
    }

    /// Whether a residual draws the unknown away from a bound at which it is held.
    fn is_drawn_off(&self, side: Side, residual: f64) -> bool {
        // Equal bounds hold either way.
        self.lower < self.upper
            && match side {
                Side::Lower => residual < 0.0,
                Side::Upper => residual > 0.0,
            }
    }
}

/// An iterate's set of held unknowns, and a sum that tells iterates apart.
#[derive(Clone, Copy, Debug)]
struct Visit {
    set: u64,
    mark: f64,
    iteration: usize,
}

/// The active set of bounds.
#[derive(Debug)]
pub(in crate::solve) struct ActiveSet {
    /// Ascending.
    unknowns: Vec<Bounded>,
    /// Residual of the free unknowns at the last iterate, with the held rows.
    reactions: Vec<f64>,
    way: Way,
    /// Whether the last iterate is no solution, whatever the rows that are not held say: the set changed with it, or a held
    /// unknown is not at its bound, or drawn off it.
    unsettled: bool,
    /// Whether the last step was taken to its end, with no bound in its way.
    unhindered: bool,
    visits: Vec<Visit>,
    peeling: Peeling,
    /// Unknowns that the last iterate holds or frees, ascending.
    pub(super) restless: Vec<usize>,
}

impl ActiveSet {
    /// The bounds on free unknowns, without a set yet.
    ///
    /// # Errors
    /// [`NewtonFailure::Bounds`].
    pub(super) fn new(
        bounds: &UnknownBounds,
        elimination: &Elimination,
        fields: &Fields,
        line_search: LineSearch,
    ) -> Result<Self, NewtonFailure> {
        let free = elimination.bounds_on_free(bounds)?;
        let mut component = vec![0; elimination.size()];
        for (number, of) in fields.components.iter().enumerate() {
            of.unknowns().for_each(|unknown| component[unknown] = number);
        }
        let bounded = |(place, unknown): (usize, &usize)| {
            let (lower, upper) = (free.lower[place], free.upper[place]);
            (lower.is_finite() || upper.is_finite()).then_some(Bounded {
                unknown: *unknown,
                place,
                component: component[*unknown],
                lower,
                upper,
                held: None,
            })
        };
        Ok(ActiveSet {
            unknowns: elimination.free().iter().enumerate().filter_map(bounded).collect(),
            reactions: vec![],
            way: match line_search {
                LineSearch::Off => Way::Whole,
                LineSearch::OnPotential => Way::Potential,
                LineSearch::OnResidual | LineSearch::Watchdog => Way::Residual,
            },
            unsettled: false,
            unhindered: false,
            visits: vec![],
            peeling: Peeling::default(),
            restless: vec![],
        })
    }

    /// Keeps the pattern of a tangent on the free unknowns.
    pub(super) fn keep_pattern(&mut self, matrix: &CsrMatrix) {
        self.peeling.keep_pattern(matrix);
    }

    /// Number of held unknowns.
    pub(super) fn count(&self) -> usize {
        self.unknowns.iter().filter(|one| one.held.is_some()).count()
    }

    /// Moves unknowns onto their bounds where they are beyond them.
    pub(super) fn project(&self, u: &mut [f64]) {
        for one in &self.unknowns {
            u[one.unknown] = u[one.unknown].clamp(one.lower, one.upper);
        }
    }
}

impl Elimination {
    /// The bounds of free unknowns, in their order. Those of an unknown that one free unknown gives, as on a periodic boundary, are passed on to it.
    fn bounds_on_free(&self, bounds: &UnknownBounds) -> Result<UnknownBounds, NewtonFailure> {
        let of = |unknown: usize| {
            let number = |bounds: &[f64]| bounds.get(unknown).copied().unwrap_or(f64::NAN);
            (number(&bounds.lower), number(&bounds.upper))
        };
        let refuse = |unknown: usize, why: BoundFailure| Err(NewtonFailure::Bounds { unknown, why });
        let (mut lower, mut upper) = (bounds.lower.clone(), bounds.upper.clone());
        for unknown in 0..self.size() {
            let (low, high) = of(unknown);
            if low.is_nan() || high.is_nan() || low == f64::INFINITY || high == f64::NEG_INFINITY {
                return refuse(unknown, BoundFailure::NotANumber { lower: low, upper: high });
            }
            if low > high {
                return refuse(unknown, BoundFailure::Empty { lower: low, upper: high });
            }
        }
        // Formulas for a bound and for a prescribed value may differ by their rounding.
        let numbers = bounds.lower.iter().chain(&bounds.upper).chain(self.prescribed().values());
        let scale =
            numbers.filter(|number| number.is_finite()).fold(0.0, |most: f64, one| most.max(one.abs()));
        let rounding = SAME * scale;
        let is_outside =
            |value: f64, (low, high): (f64, f64)| value < low - rounding || value > high + rounding;
        for (&unknown, &value) in self.prescribed() {
            let (low, high) = of(unknown);
            if is_outside(value, (low, high)) {
                return refuse(unknown, BoundFailure::Prescribed { value, lower: low, upper: high });
            }
        }
        for (&unknown, relation) in self.relations() {
            let (low, high) = of(unknown);
            if low == f64::NEG_INFINITY && high == f64::INFINITY {
                continue;
            }
            match relation.terms[..] {
                [] if is_outside(relation.value, (low, high)) => {
                    let value = relation.value;
                    return refuse(unknown, BoundFailure::Prescribed { value, lower: low, upper: high });
                }
                [] => {}
                [(free, factor)] if factor != 0.0 => {
                    let ends = [low, high].map(|bound| (bound - relation.value) / factor);
                    let [low, high] = if factor > 0.0 { ends } else { [ends[1], ends[0]] };
                    (lower[free], upper[free]) = (lower[free].max(low), upper[free].min(high));
                    if lower[free] > upper[free] {
                        let (lower, upper) = (lower[free], upper[free]);
                        return refuse(free, BoundFailure::Empty { lower, upper });
                    }
                }
                _ => return refuse(unknown, BoundFailure::Related { others: relation.terms.len() }),
            }
        }
        let of_free = |all: &[f64]| self.free().iter().map(|unknown| all[*unknown]).collect();
        Ok(UnknownBounds { lower: of_free(&lower), upper: of_free(&upper) })
    }
}

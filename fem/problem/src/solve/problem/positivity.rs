//! Quantities that a problem keeps positive: the step of Newton's method ends before one of them does not.

use super::Problem;
use crate::assemble::AssemblyError;
use crate::contract::Functional;
use crate::field::Field;

/// A value may fall to this part of itself in one step.
const KEPT: f64 = 0.1;

/// The part aimed at where a step is shortened.
const AIM: f64 = 0.2;

/// A step is shortened to this part at most, and at least to the other, before values are computed again.
const SHORTENING: [f64; 2] = [0.05, 0.9];

/// The shortest part of a step.
const SHORTEST: f64 = 1e-10;

/// The error of a quantity that does not stay positive.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs)]
pub enum PositivityError {
    /// It is not positive where a step begins.
    #[error(
        "`{functional}`, which was to be kept positive, is {value} at {position:?} where Newton's method begins: begin nearer to the \
         solution (`Problem::start`), or come there in smaller steps (`LoadSteps`)"
    )]
    NotPositive { functional: &'static str, value: f64, position: Vec<f64> },
    /// It does not stay positive along any part of a step.
    #[error(
        "no part of a step of Newton's method keeps `{functional}` positive; it is {value} at {position:?}"
    )]
    NoStep { functional: &'static str, value: f64, position: Vec<f64> },
}

/// Values of a quantity at points, with their positions.
type Values<const D: usize> = Vec<(f64, [f64; D])>;

impl<const D: usize, const N: usize> Problem<'_, D, N> {
    /// A functional of the problem's unknowns whose integrand is kept positive at the points of its quadrature, as the determinant of a
    /// deformation gradient or the gap under a barrier. Each step of Newton's method is shortened so that no value falls below a tenth of
    /// itself, before any line search. Of pairs that slide, values need only stay positive. The value of the integral is not used.
    ///
    /// Give the problem's own [`Problem::quadrature`], so that the points are those of the form. A solver that condenses gets the whole tangent.
    ///
    /// ```
    /// use forms_fem::prelude::*;
    ///
    /// let mesh = rectangle([0.0; 2], [1.0; 2], [4, 4], CellShape::Quadrilateral, 1)?;
    /// let space = Space::vector(&mesh, 1)?;
    /// let mut held = Constraints::new(&space);
    /// held.fix("bottom", |_| [0.0; 2])?;
    /// // A neo-Hookean block under a load that turns cells inside out in whole steps.
    /// let block = form!(|u: Unknown<Vector>, v: Test<Vector>| {
    ///     let F = I + grad(u);
    ///     let P = F - inv(transpose(F)) + ln(det(F)) * inv(transpose(F));
    ///     integral(cells("all"), inner(P, grad(v))) + integral(facets("top"), 4 * v[1])
    /// });
    /// let volume = form!(|u: Unknown<Vector>| -> Functional { integral(cells("all"), det(I + grad(u))) });
    /// let problem = Problem::new(&block, &space).constrained(&held).quadrature(Quadrature::Degree(4));
    /// let solved = problem.keep_positive(&volume).solve()?;
    /// assert!(solved.history.iter().any(|step| step.damping.is_some_and(|part| part < 1.0)));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn keep_positive(mut self, functional: &Functional<D>) -> Self {
        self.positive.push(functional.clone());
        self
    }

    /// The part of a step with which all quantities stay positive.
    ///
    /// # Errors
    /// [`PositivityError`], and those of the assembler.
    pub(super) fn positive_part_of_step(&self, u: &[f64], step: &[f64]) -> Result<f64, AssemblyError> {
        let mut part = 1.0;
        for functional in &self.positive {
            part = self.part_for(functional, u, step, part)?;
        }
        Ok(part)
    }

    fn part_for(
        &self,
        functional: &Functional<D>,
        u: &[f64],
        step: &[f64],
        longest: f64,
    ) -> Result<f64, AssemblyError> {
        let before = self.values_at(functional, u)?;
        let name = functional.name();
        if let Some((value, position)) = least(&before).filter(|(value, _)| value.is_nan() || *value <= 0.0) {
            let position = position.to_vec();
            return Err(AssemblyError::other(PositivityError::NotPositive {
                functional: name,
                value,
                position,
            }));
        }
        if step.iter().all(|value| *value == 0.0) {
            return Ok(longest);
        }
        let mut part = longest;
        while part >= SHORTEST {
            let at: Vec<f64> = u.iter().zip(step).map(|(u, step)| u + part * step).collect();
            let after = self.values_at(functional, &at)?;
            match shorter(&before, &after) {
                None => return Ok(part),
                Some(shorter) => part *= shorter,
            }
        }
        let (value, position) = least(&before).map_or((0.0, vec![]), |(value, x)| (value, x.to_vec()));
        Err(AssemblyError::other(PositivityError::NoStep { functional: name, value, position }))
    }

    /// The values of a functional's integrand at its points, with the unknowns at u.
    fn values_at(&self, functional: &Functional<D>, u: &[f64]) -> Result<Values<D>, AssemblyError> {
        let fields = self.system.fields(u);
        let fields: Vec<&Field<D>> = fields.iter().collect();
        match self.communicator {
            // All processes come to the same step.
            Some(_) => self.system.assembler.on_all_cells().values_of(functional, &fields),
            None => self.system.assembler.values_of(functional, &fields),
        }
    }
}

fn least<const D: usize>(values: &Values<D>) -> Option<(f64, [f64; D])> {
    // NaN is the least of all.
    let key = |value: f64| if value.is_nan() { f64::NEG_INFINITY } else { value };
    values.iter().copied().min_by(|a, b| key(a.0).total_cmp(&key(b.0)))
}

/// The part of a step to try next; none where values stay positive on all of it.
fn shorter<const D: usize>(before: &Values<D>, after: &Values<D>) -> Option<f64> {
    if before.len() != after.len() {
        // Other points: those of pairs that slide.
        return after.iter().any(|(value, _)| value.is_nan() || *value <= 0.0).then_some(0.5);
    }
    let falls =
        before.iter().zip(after).filter(|((before, _), (after, _))| after.is_nan() || *after < KEPT * before);
    let parts = falls.map(|((before, _), (after, _))| {
        let part = (1.0 - AIM) * before / (before - after);
        if part.is_finite() { part } else { 0.5 }
    });
    let [least, most] = SHORTENING;
    parts.reduce(f64::min).map(|part| part.clamp(least, most))
}

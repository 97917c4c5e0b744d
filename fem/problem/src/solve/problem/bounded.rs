//! Bounds of a problem: what was given, by unknown of the whole, and what a solution says of them.

use super::Problem;
use crate::assemble::AssemblyError;
use crate::bounds::Bounds;
use crate::constraints::Constraints;
use crate::solve::solved::AtBounds;
use crate::solve::{HeldUnknown, NewtonError, NewtonFailure, UnknownBounds};

/// Unknowns that a remark names.
const NAMED: usize = 3;

impl<'a, const D: usize, const N: usize> Problem<'a, D, N> {
    /// Bounds on one unknown: the first one on the bounds' space that has none yet.
    ///
    /// The solution obeys the Karush-Kuhn-Tucker conditions: the residual is zero where no bound holds, and presses on the bound where one does.
    /// Newton's method finds the unknowns at bounds by a primal-dual active set, of affine forms as well. Reactions are in
    /// [`Solved::held`](crate::solve::Solved::held), constraints for adjoint states in
    /// [`Solved::held_at_bounds`](crate::solve::Solved::held_at_bounds). Iterates may leave the bounds on the way, unless there is a
    /// line search ([`LineSearch`](crate::solve::LineSearch)).
    ///
    /// Bounds act on free unknowns. They are refused, by name, if they exclude a prescribed value or each other, on unknowns that several others
    /// give, and on several processes. A condensing solver gets the whole tangent.
    ///
    /// ```
    /// # use forms_fem::prelude::*;
    /// # let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 2], CellShape::Triangle, 1)?;
    /// # let space = Space::scalar(&mesh, 1)?;
    /// # let mut held = Constraints::new(&space);
    /// # held.fix("boundary", |_| 0.0)?;
    /// let form = form!(|u: Unknown<Scalar>, v: Test<Scalar>| integral(cells("all"), dot(grad(u), grad(v)) - v));
    /// let mut bounds = Bounds::new(&space);
    /// bounds.at_most("all", |_| 0.05)?;
    /// let solved = Problem::new(&form, &space).constrained(&held).bounded(&bounds).solve()?;
    /// assert!(solved.held().iter().all(|one| one.reaction < 0.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn bounded(mut self, bounds: &'a Bounds<D>) -> Self {
        self.bounds.push(bounds);
        self
    }

    /// The bounds of all unknowns, of those that are given; none if there are none.
    ///
    /// # Errors
    /// Bounds on a space on which no unknown is left without, or several processes.
    pub(super) fn all_bounds(&self) -> Result<Option<UnknownBounds>, AssemblyError> {
        if self.bounds.is_empty() {
            return Ok(None);
        }
        if self.communicator.is_some_and(|communicator| communicator.size() > 1) {
            return Err(AssemblyError::other(BoundedOnProcesses { form: self.system.form.name() }));
        }
        let count = self.system.unknowns();
        let mut all =
            UnknownBounds { lower: vec![f64::NEG_INFINITY; count], upper: vec![f64::INFINITY; count] };
        let mut given = [false; N];
        for bounds in &self.bounds {
            let fits =
                |number: &usize| !given[*number] && self.system.spaces[*number].numbers_as(bounds.space());
            let Some(number) = (0..N).find(fits) else {
                let (form, field) = (self.system.form.name(), self.system.unknown_name(0));
                return Err(AssemblyError::OtherSpace { form, field, what: "bounds" });
            };
            given[number] = true;
            let offset = self.offset(number);
            for unknown in bounds.unknowns() {
                (all.lower[offset + unknown], all.upper[offset + unknown]) = bounds.of(unknown);
            }
        }
        Ok(Some(all))
    }

    fn offset(&self, number: usize) -> usize {
        self.system.spaces[..number].iter().map(|space| space.unknowns()).sum()
    }

    /// Field, component and place of an unknown among all.
    fn name_of(&self, unknown: usize) -> String {
        let number = (0..N).rev().find(|number| self.offset(*number) <= unknown).unwrap_or(0);
        let (space, index) = (&self.system.spaces[number], unknown - self.offset(number));
        let (components, field) = (space.components(), self.system.unknown_name(number));
        let of = match components {
            1 => String::new(),
            _ => format!("component {} of ", index % components),
        };
        format!("{of}`{field}` at {:?}", space.positions()[index / components])
    }

    fn names_of(&self, unknowns: &[usize]) -> String {
        let named: Vec<String> = unknowns.iter().take(NAMED).map(|unknown| self.name_of(*unknown)).collect();
        let more = if unknowns.len() > NAMED { ", ..." } else { "" };
        format!("{}{more}", named.join(", "))
    }

    /// Remarks on a failure of bounds: the unknowns that it is about.
    pub(super) fn bounds_in_words(&self, error: &NewtonError) -> Option<String> {
        match &error.why {
            NewtonFailure::Bounds { unknown, .. } => {
                Some(format!("unknown {unknown} is {}", self.name_of(*unknown)))
            }
            NewtonFailure::BoundsCycle { unknowns, .. } => Some(format!(
                "{} unknowns come to a bound and leave it again, as {}",
                unknowns.len(),
                self.names_of(unknowns)
            )),
            _ => None,
        }
    }

    /// The unknowns of a solution at bounds, with a remark on weak ones.
    pub(super) fn at_bounds(&self, held: &[HeldUnknown], constraints: [Constraints<D>; N]) -> AtBounds<D, N> {
        let own = |number: usize| {
            let begin = self.offset(number);
            let range = begin..begin + self.system.spaces[number].unknowns();
            let own = held.iter().filter(|one| range.contains(&one.unknown));
            own.map(|one| HeldUnknown { unknown: one.unknown - begin, ..*one }).collect()
        };
        let weak: Vec<usize> = held.iter().filter(|one| one.is_weak).map(|one| one.unknown).collect();
        let remark = (!weak.is_empty()).then(|| {
            format!(
                "{} unknowns are at a bound that does not act on them, as {}: derivatives of the solution are one-sided there, \
                 and an adjoint gives those without the bound",
                weak.len(),
                self.names_of(&weak)
            )
        });
        AtBounds { constraints, held: std::array::from_fn(own), remark }
    }
}

/// Bounds on several processes.
#[derive(Clone, Copy, Debug, thiserror::Error)]
#[error("form `{form}`: bounds on unknowns are not kept on several processes; solve on one")]
struct BoundedOnProcesses {
    form: &'static str,
}

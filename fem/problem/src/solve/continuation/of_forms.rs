//! A form with a parameter as a family of equations, and the caller's measurements at its points.

use super::branch::BranchPoint;
use super::family::{Family, Next, Reached, Refusal};
use crate::assemble::{AssemblyError, Parts};
use crate::contract::Form;
use crate::solve::problem::Problem;
use crate::solve::{NonlinearProblem, Solved};

/// Makes the balance and its derivative with respect to the parameter.
pub(super) type Forms<'a, const D: usize> = Box<dyn Fn(f64) -> [Form<D>; 2] + 'a>;

/// Reads off what is wanted of a solution at a parameter, and says whether to go on.
pub(super) type Measure<'m, M, const D: usize, const N: usize> =
    &'m mut dyn FnMut(f64, &Solved<D, N>) -> Result<(M, Next), Refusal>;

/// The family of a form.
pub(super) struct FamilyOfForms<'p, 'a, 'm, M, const D: usize, const N: usize> {
    pub problem: &'p mut Problem<'a, D, N>,
    pub forms: &'p Forms<'a, D>,
    /// The derivative of the form at the parameter.
    rate: Form<D>,
    parameter: f64,
    /// Λ.
    scale: f64,
    measure: Measure<'m, M, D, N>,
    pub points: Vec<BranchPoint<M>>,
}

impl<'p, 'a, 'm, M, const D: usize, const N: usize> FamilyOfForms<'p, 'a, 'm, M, D, N> {
    /// The family at a first parameter.
    pub fn new(
        problem: &'p mut Problem<'a, D, N>,
        forms: &'p Forms<'a, D>,
        parameter: f64,
        scale: f64,
        measure: Measure<'m, M, D, N>,
    ) -> Self {
        let [form, rate] = forms(parameter);
        problem.replace_form(form);
        FamilyOfForms { problem, forms, rate, parameter, scale, measure, points: vec![] }
    }
}

impl<M, const D: usize, const N: usize> Family for FamilyOfForms<'_, '_, '_, M, D, N> {
    fn set_parameter(&mut self, parameter: f64) -> Result<(), AssemblyError> {
        if parameter != self.parameter {
            let [form, rate] = (self.forms)(parameter);
            self.problem.replace_form(form);
            (self.rate, self.parameter) = (rate, parameter);
        }
        Ok(())
    }

    fn equations(&mut self) -> &mut dyn NonlinearProblem {
        self.problem
    }

    fn rate(&mut self, u: &[f64]) -> Result<Vec<f64>, AssemblyError> {
        let system = &self.problem.system;
        let (views, spaces) = (system.views(u)?, system.spaces.each_ref());
        system.assembler.residual_of(&self.rate, &views, &spaces, Parts::ALL)
    }

    fn reached(&mut self, point: &Reached) -> Result<Next, Refusal> {
        let Reached { at, residual, direction, inertia, arc_length, iterations } = point;
        self.set_parameter(at.parameter)?;
        let solved = self.problem.solved_at(&at.u, residual.clone())?;
        let (measured, next) = (self.measure)(at.parameter, &solved)?;
        self.points.push(BranchPoint {
            parameter: at.parameter,
            arc_length: *arc_length,
            slope: direction.parameter / self.scale,
            inertia: *inertia,
            iterations: *iterations,
            measured,
        });
        Ok(next)
    }
}

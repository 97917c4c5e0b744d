//! Load steps of the cylinder: without friction, or with Tresca's or Coulomb's law on Γ_C by Nitsche's method, where the slip
//! of a step is counted from the solution of the step before.

use std::sync::Arc;

use forms_fem::prelude::*;

use super::{CylinderError, Progress, Settings};
use crate::contact_problem::ContactProblem;
use crate::forms;
use crate::frictional_nitsche as frictional;
use crate::paper_law::Adjoint;

/// Friction between the cylinder and the obstacle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Friction {
    /// None: the paper's problem (14).
    #[default]
    None,
    /// Tresca's law with this bound \[MPa\], which acts on all of Γ_C.
    Tresca(f64),
    /// Coulomb's law with this coefficient.
    Coulomb(f64),
}

/// The results of friction. Forces in MPa·cm, lengths in cm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionResults {
    /// ∫ of the tangential traction on the body, positive to the right.
    pub tangential_force: f64,
    /// Length of the part of the contact zone that sticks.
    pub stick_length: f64,
    /// Length of the part of the contact zone that slips.
    pub slip_length: f64,
}

/// A load step that has converged.
#[derive(Clone, Debug, PartialEq)]
pub struct CylinderStep {
    /// u_D on the inner circle \[cm\].
    pub push: [f64; 2],
    /// Newton steps; with friction those of the state in which all sticks are not among them.
    pub newton_iterations: usize,
    /// ∫ \[σ_n − γ(u_n − g)\]₋ \[MPa·cm\].
    pub contact_force: f64,
    /// |Γ^h_C,a| \[cm\].
    pub contact_length: f64,
    /// None without friction.
    pub friction: Option<FrictionResults>,
}

/// A problem of the last step with its law.
pub(super) enum Law {
    Frictionless(Box<ContactProblem<2>>),
    Frictional(Box<ContactProblem<2, frictional::Model<2>>>),
}

impl Law {
    /// The settings' law with the mesh, the data and the regions of the frictionless problem.
    ///
    /// # Errors
    /// Those of [`ContactProblem::new`].
    pub fn of(settings: &Settings, problem: &ContactProblem<2>) -> Result<Law, CylinderError> {
        let (slip_stress, friction) = match settings.friction {
            Friction::None => return Ok(Law::Frictionless(Box::new(problem.clone()))),
            Friction::Tresca(bound) => (bound, 0.0),
            Friction::Coulomb(coefficient) => (0.0, coefficient),
        };
        let data = frictional::data_from(problem.law.data.clone())
            .slip_stress(slip_stress)
            .friction(friction)
            .force_direction([1.0, 0.0]);
        let forms::Regions { gamma_n, gamma_c, .. } = problem.law.regions.clone();
        let regions = frictional::Regions::default().gamma_n(gamma_n.0.name).gamma_c(gamma_c.0.name);
        let (assembler, model) = (problem.assembler.clone(), frictional::Model { data, regions });
        let constraints = problem.constraints.clone();
        Ok(Law::Frictional(Box::new(
            ContactProblem::new(&problem.space, model, constraints).assembler(assembler),
        )))
    }

    /// Solution of the direct problem from the state before, with u_D on the inner circle.
    ///
    /// # Errors
    /// [`CylinderError`]: those of the constraints and of the solution.
    pub fn step(
        &mut self,
        push: [f64; 2],
        before: &Field<2>,
        solver: &mut CondensedSolver,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<Solved<2>, CylinderError> {
        let constraints = pushed(before.space(), push)?;
        let told = |step: &NewtonStep| progress(Progress::Newton(step));
        Ok(match self {
            Law::Frictionless(problem) => {
                problem.constraints = constraints;
                problem.direct()?.start(before).solver(solver).each_step(told).solve()?
            }
            Law::Frictional(problem) => {
                problem.constraints = constraints;
                problem.law.data.displacement_before = Given::field(before);
                problem.from_stick()?.start(before).solver(solver).each_step(told).solve()?
            }
        })
    }

    /// Adjoint states at the displacement of the last step.
    ///
    /// # Errors
    /// [`CylinderError`]: those of the solution.
    pub fn adjoints(
        &self,
        which: &[Adjoint],
        u: &Field<2>,
        solver: &mut CondensedSolver,
    ) -> Result<Vec<Solved<2>>, CylinderError> {
        let problem = |which: &Adjoint| match self {
            Law::Frictionless(problem) => problem.adjoint_state(*which, u),
            Law::Frictional(problem) => match which {
                Adjoint::Discrete => problem.adjoint(u),
                Adjoint::Consistent => problem.state(problem.law.consistent_adjoint(u), u),
                Adjoint::Extended => problem.state(problem.law.extended_adjoint(u), u),
            },
        };
        let problems = which.iter().map(problem).collect::<Result<Vec<_>, _>>()?;
        Ok(LinearProblems::of(problems).solver(solver).solve()?)
    }

    /// Force and lengths of friction at the displacement of the last step.
    ///
    /// # Errors
    /// [`CylinderError`]: those of the assembly.
    pub fn friction(&self, u: &Field<2>) -> Result<Option<FrictionResults>, CylinderError> {
        let Law::Frictional(problem) = self else { return Ok(None) };
        let (assembler, law) = (&problem.assembler, &problem.law);
        Ok(Some(FrictionResults {
            tangential_force: assembler.functional(&law.tangential_force(u))?,
            stick_length: assembler.functional(&law.stick_length(u))?,
            slip_length: assembler.functional(&law.slip_length(u))?,
        }))
    }
}

/// u = u_D on the inner circle.
pub(super) fn pushed(space: &Arc<Space<2>>, push: [f64; 2]) -> Result<Constraints<2>, CylinderError> {
    let mut constraints = Constraints::new(space);
    constraints.fix("inner", |_| push)?;
    Ok(constraints)
}

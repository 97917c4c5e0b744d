//! The displacement and the adjoint states on one mesh.

use forms_contact::hollow_cylinder::{CylinderError, Settings, hollow_cylinder};
use forms_contact::{Adjoint, ContactProblem};
use forms_fem::prelude::*;

use crate::contact_zone::ContactZone;

/// A problem with its displacement.
pub struct Direct {
    /// The problem.
    pub problem: ContactProblem<2>,
    /// u_h of (14).
    pub u: Field<2>,
    /// The contact zone, β_h > 0.
    pub zone: ContactZone,
    /// Newton steps.
    pub steps: usize,
    solver: CondensedSolver,
}

impl Direct {
    /// Solves (14), with the facets of Γ_C split at the zeros of β_h or whole.
    pub fn solve(settings: &Settings, split: bool) -> Result<Direct, CylinderError> {
        let problem = hollow_cylinder(settings)?;
        let problem = if split { problem.with_split_facets() } else { problem };
        let options = TangentSolverOptions { threads: settings.threads, ..TangentSolverOptions::default() };
        let mut solver = CondensedSolver::new(options);
        let found = problem.direct()?.solver(&mut solver).solve()?;
        let (steps, u) = (found.iterations(), found.into_field());
        let zone = ContactZone::of(&problem, &u)?;
        Ok(Direct { problem, u, zone, steps, solver })
    }

    /// Solves for an adjoint state.
    pub fn adjoint(&mut self, which: Adjoint) -> Result<Field<2>, CylinderError> {
        Ok(self.problem.solve_adjoint(which, &self.u, &mut self.solver)?.into_field())
    }

    /// p_h of (41) with ξ = C √h_T.
    pub fn extended(&mut self, extension: f64) -> Result<Field<2>, CylinderError> {
        self.problem.law.data.extension = extension;
        self.adjoint(Adjoint::Extended)
    }
}

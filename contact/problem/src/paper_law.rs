//! The paper's law and its three adjoint states.

use forms_fem::prelude::*;

use crate::contact_law;
use crate::contact_problem::{ContactProblem, RESOLUTION};
use crate::forms;

contact_law!(forms {
    direct: direct,
    region: gamma_c,
    indicator: contact_indicator,
    criterion: criterion,
    adjoint: discrete_adjoint,
    shape_gradient: shape_gradient,
    diameter_gradient: diameter_gradient,
    theta: theta,
    threshold: normal_stress_product(elasticity, gamma0),
    positive: gamma0,
    unit: obstacle_normal,
    line_search_by: shortened_where_nearly_incompressible,
});

/// λ/μ above which a material is nearly incompressible: ν = 0.476.
const NEARLY_INCOMPRESSIBLE: f64 = 20.0;

/// Whole steps find the zone of contact in a few iterations. Where λ is far above μ a node that enters the obstacle turns the signs of its
/// neighbours' stresses, and whole steps may go back and forth between two zones.
fn shortened_where_nearly_incompressible<const D: usize>(law: &forms::Model<D>) -> LineSearch
where
    Dim: Dimension<D>,
{
    match law.data.lambda > NEARLY_INCOMPRESSIBLE * law.data.mu {
        true => LineSearch::OnResidual,
        false => LineSearch::Off,
    }
}

/// The paper's three adjoint states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Adjoint {
    /// p̃_h of (21): the adjoint of the discrete problem.
    Discrete,
    /// p_h of (22): Nitsche's method for the continuous adjoint.
    Consistent,
    /// p_h of (41): (22) with an extended Neumann zone.
    Extended,
}

impl<const D: usize> ContactProblem<D>
where
    Dim: Dimension<D>,
{
    /// One of the paper's adjoint states at the displacement u; it vanishes on Γ_D. A solver that has solved the
    /// direct problem reuses its analysis and, where it can, its factor.
    ///
    /// # Errors
    /// [`SolveError`], also for data that do not fit.
    pub fn solve_adjoint(
        &self,
        adjoint: Adjoint,
        u: &Field<D>,
        solver: &mut dyn LinearSolver,
    ) -> Result<Solved<D>, SolveError> {
        self.adjoint_state(adjoint, u)?.solver(solver).solve()
    }

    /// The problem of one of the paper's adjoint states at the displacement u, for [`LinearProblems`] with others.
    ///
    /// # Errors
    /// [`AssemblyError`]: data that do not fit.
    pub fn adjoint_state(&self, adjoint: Adjoint, u: &Field<D>) -> Result<Problem<'_, D>, AssemblyError> {
        match adjoint {
            Adjoint::Discrete => self.adjoint(u),
            Adjoint::Consistent => self.state(self.law.consistent_adjoint(u), u),
            Adjoint::Extended => {
                // Its zone is that of β_h > ξ.
                let assembler = match self.splits_facets() {
                    false => self.assembler.clone(),
                    true => {
                        let (indicator, region) =
                            (self.law.extended_indicator(u), &self.law.regions.gamma_c.0.name);
                        self.assembler.split_at_zeros(&indicator, region, RESOLUTION)?
                    }
                };
                self.state_by(self.law.extended_adjoint(u), assembler)
            }
        }
    }
}

//! Shape optimisation with any contact law, by its own criterion and adjoint.

use forms_fem::prelude::*;
use forms_fem::shape_optimisation::{Derivatives, Failure, ShapeProblem, Values};

use super::VolumeRule;
use super::costs::{Costs, fix_regions};
use crate::contact_problem::ContactProblem;
use crate::law::WithShapeGradient;
use crate::shape_gradient::Diameters;

/// A problem with a contact law on a shape that may change; its objective is the law's criterion.
pub struct LawShape<F> {
    /// The problem on a mesh: the same for all shapes.
    pub problem: F,
    /// The volume's rule.
    pub volume: VolumeRule,
    /// Γ_m, the boundary whose length or area is penalised.
    pub moving: String,
    /// Penalty per length (area) of Γ_m, added to the criterion.
    pub perimeter_penalty: f64,
    /// Boundaries that stay.
    pub fixed: Vec<String>,
}

/// A problem that was solved on a shape.
pub struct LawState<const D: usize, L> {
    /// The problem on the shape's mesh.
    pub problem: ContactProblem<D, L>,
    /// The displacement.
    pub u: Field<D>,
    /// The law's criterion alone, without penalties.
    pub criterion: f64,
    solver: CondensedSolver,
}

impl<F> LawShape<F> {
    fn costs(&self) -> Costs<'_> {
        Costs { volume: self.volume, moving: &self.moving, perimeter_penalty: self.perimeter_penalty }
    }
}

impl<F, L, const D: usize> ShapeProblem<D> for LawShape<F>
where
    F: Fn(&Mesh<D>) -> Result<ContactProblem<D, L>, Failure>,
    L: WithShapeGradient<D>,
    Dim: Dimension<D>,
{
    type State = LawState<D, L>;

    fn solve(&self, mesh: &Mesh<D>) -> Result<Values<LawState<D, L>>, Failure> {
        let problem = (self.problem)(mesh)?;
        let mut solver = CondensedSolver::default();
        let u = problem.direct()?.solver(&mut solver).solve()?.into_field();
        let alone = problem.criterion(&u)?;
        let (costs, constraint) = self.costs().values(mesh)?;
        let state = LawState { problem, u, criterion: alone, solver };
        Ok(Values { criterion: alone + costs, constraint, state })
    }

    fn derivatives(
        &self,
        movements: &Arc<Space<D>>,
        state: &mut LawState<D, L>,
    ) -> Result<Derivatives, Failure> {
        let LawState { problem, u, solver, .. } = state;
        let p = problem.adjoint(u)?.solver(solver).solve()?.into_field();
        let mut criterion = problem.shape_gradient(u, &p, Diameters::Moving, None)?.values;
        let constraint = self.costs().add_derivatives(movements, &mut criterion)?;
        Ok(Derivatives { criterion, constraint })
    }

    fn fix(&self, movements: &mut Constraints<D>) -> Result<(), Failure> {
        fix_regions(&self.fixed, movements)
    }
}

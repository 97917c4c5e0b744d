//! Contact problems on several processes: the states of `forms_contact`, from the same forms.

use forms_contact::forms;
use forms_contact::states::{Adjoint, ContactProblem};
use forms_fem::mesh::MeshError;
use forms_fem::prelude::*;
use forms_fem::solve::{NewtonFailure, Solved};

use crate::error::DistributedError;
use crate::problem::{
    DistributedAffineError, DistributedAssemblyError, DistributedProblem, distributed_functional,
};
use crate::world::World;

/// A contact problem of which each process assembles the integrals over its own cells and their facets. Facets are not split
/// at the edge of contact.
#[derive(Debug)]
pub struct DistributedContact<'w, const D: usize> {
    world: &'w World,
    problem: ContactProblem<D>,
}

impl<'w, const D: usize> DistributedContact<'w, D>
where
    Dim: Dimension<D>,
{
    /// The same problem on all processes.
    ///
    /// # Errors
    /// None for cells that are the mesh's own.
    pub fn new(world: &'w World, mut problem: ContactProblem<D>) -> Result<Self, MeshError> {
        let mesh = problem.space.mesh().clone();
        problem.assembler = problem.assembler.on_owned_cells(world.own_cells(&mesh))?;
        Ok(DistributedContact { world, problem })
    }

    /// The problem, with this process's part of its integrals.
    pub fn problem(&self) -> &ContactProblem<D> {
        &self.problem
    }

    /// Solves (14) by semismooth Newton from u = 0 with u_D imposed.
    ///
    /// # Errors
    /// The reason with Newton's history.
    pub fn solve_direct(
        &self,
        solver: &mut dyn LinearSolver,
        options: &NewtonOptions,
        progress: &mut dyn FnMut(&NewtonStep),
    ) -> Result<Solved<D>, NewtonError<DistributedAssemblyError>> {
        let ContactProblem { assembler, space, constraints, .. } = &self.problem;
        let form = self.problem.law.direct();
        let start = Field::zero(space);
        let checked = self.problem.check_gamma0("direct").map_err(DistributedError::Here);
        match checked.and_then(|()| DistributedProblem::new(self.world, &form, assembler, space)) {
            Ok(mut problem) => problem.solve(&start, constraints, solver, options, progress),
            Err(error) => {
                Err(NewtonError { why: NewtonFailure::Assembly(error), history: vec![], u: vec![] })
            }
        }
    }

    /// Solves for an adjoint state at the displacement u; it vanishes on Γ_D.
    ///
    /// # Errors
    /// The mismatch, or why the system was not solved.
    pub fn solve_adjoint(
        &self,
        adjoint: Adjoint,
        u: &Field<D>,
        solver: &mut dyn LinearSolver,
    ) -> Result<Field<D>, DistributedAffineError> {
        let (data, regions) = (&self.problem.data, &self.problem.regions);
        let (omega, gamma_c, boundary) = (&regions.omega, &regions.gamma_c, &regions.boundary);
        match adjoint {
            Adjoint::Discrete => self.solve_affine(
                &forms::discrete_adjoint(data, omega, &regions.gamma_n, gamma_c, boundary, u),
                solver,
            ),
            Adjoint::Consistent => {
                self.solve_affine(&forms::consistent_adjoint(data, omega, gamma_c, boundary, u), solver)
            }
            Adjoint::Extended => {
                self.solve_affine(&forms::extended_adjoint(data, omega, gamma_c, boundary, u), solver)
            }
        }
    }

    fn solve_affine<F: Form<D>>(
        &self,
        form: &F,
        solver: &mut dyn LinearSolver,
    ) -> Result<Field<D>, DistributedAffineError> {
        let ContactProblem { assembler, space, constraints, .. } = &self.problem;
        self.problem.check_gamma0(form.name()).map_err(DistributedError::Here)?;
        let mut problem = DistributedProblem::new(self.world, form, assembler, space)?;
        problem.solve_affine(&constraints.homogeneous(), solver)
    }

    /// The criterion (3).
    ///
    /// # Errors
    /// Data that do not fit.
    pub fn criterion(&self, u: &Field<D>) -> Result<f64, DistributedAssemblyError> {
        let regions = &self.problem.regions;
        self.functional(&forms::criterion(&self.problem.data, &regions.omega, &regions.boundary, u))
    }

    /// ∫ \[σ_n − γ(u_n − g)\]₋, the resultant of the contact pressure.
    ///
    /// # Errors
    /// Data that do not fit.
    pub fn contact_force(&self, u: &Field<D>) -> Result<f64, DistributedAssemblyError> {
        self.functional(&forms::contact_force(&self.problem.data, &self.problem.regions.gamma_c, u))
    }

    fn functional<G: Functional<D>>(&self, functional: &G) -> Result<f64, DistributedAssemblyError> {
        distributed_functional(self.world, &self.problem.assembler, functional)
    }
}

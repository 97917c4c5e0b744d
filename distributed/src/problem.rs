//! Problems whose residuals and tangents are sums over the processes, solved by the same Newton's method as on one.

use std::hash::{DefaultHasher, Hash, Hasher};

use forms_fem::linear_algebra::LinearAlgebraError;
use forms_fem::prelude::*;
use forms_fem::solve::{
    ActivePoints, Elimination, NewtonFailure, NonlinearProblem, Solved, SolverError, Start, Tangent,
    newton_eliminating,
};

use crate::error::{DistributedError, PetscError};
use crate::rows::Rows;
use crate::vector::DistributedVector;
use crate::world::World;

/// Errors of assembly, on all processes.
pub type DistributedAssemblyError = DistributedError<AssemblyError>;

/// A form with one unknown, of which each process assembles its own cells: a [`FormProblem`] made with
/// [`Assembler::on_owned_cells`]. Residuals are added up and whole on every process; tangents remain local contributions, as
/// [`crate::PetscSolver`] takes them.
pub struct DistributedProblem<'w, 'a, F, const D: usize> {
    world: &'w World,
    local: FormProblem<'a, F, D>,
    space: Arc<Space<D>>,
    sum: DistributedVector<'w>,
}

/// Errors of solving an affine problem.
#[derive(Debug, thiserror::Error)]
pub enum DistributedAffineError {
    /// Assembly failed, here or elsewhere.
    #[error(transparent)]
    Assembly(#[from] DistributedAssemblyError),
    /// The system was not solved.
    #[error(transparent)]
    Solver(#[from] SolverError),
}

impl From<LinearAlgebraError> for DistributedAffineError {
    fn from(error: LinearAlgebraError) -> Self {
        DistributedAffineError::Solver(error.into())
    }
}

impl<'w, 'a, F: Form<D>, const D: usize> DistributedProblem<'w, 'a, F, D> {
    /// Prepares the positions of this process's part of the matrix.
    ///
    /// # Errors
    /// As [`FormProblem::new`], on any process.
    pub fn new(
        world: &'w World,
        form: &'a F,
        local: &'a Assembler<D>,
        space: &Arc<Space<D>>,
    ) -> Result<Self, DistributedAssemblyError> {
        let local = world.agree(FormProblem::new(form, local, space))?;
        let sum =
            DistributedVector::new(world, Rows::of_nodes(world, space.node_count(), space.components())?)?;
        Ok(DistributedProblem { world, local, space: space.clone(), sum })
    }

    /// Solves R(u) = 0 by semismooth Newton from u = `start` with the constraints imposed on it.
    ///
    /// # Errors
    /// [`NewtonError`] with the reason, the history and the last iterate; the same kind on all processes.
    pub fn solve(
        &mut self,
        start: &Field<D>,
        constraints: &Constraints<D>,
        solver: &mut dyn LinearSolver,
        options: &NewtonOptions,
        progress: &mut dyn FnMut(&NewtonStep),
    ) -> Result<Solved<D>, NewtonError<DistributedAssemblyError>> {
        let u = start.values().to_vec();
        let elimination = match Elimination::of(&[constraints]) {
            Ok(elimination) => elimination,
            Err(why) => return Err(NewtonError { why: NewtonFailure::Mismatch(why), history: vec![], u }),
        };
        let found = newton_eliminating(self, elimination, Start::at(u), solver, options, progress)?;
        match Field::from_values(&self.space, found.u) {
            Ok(field) => Ok(Solved { field, history: found.history, residual: found.residual }),
            Err(_) => Err(NewtonError { why: NewtonFailure::NotFinite, history: found.history, u: vec![] }),
        }
    }

    /// Solves a form that is affine in its unknown: one assembly, one linear system.
    ///
    /// # Errors
    /// The mismatch, or why the system was not solved.
    pub fn solve_affine(
        &mut self,
        constraints: &Constraints<D>,
        solver: &mut dyn LinearSolver,
    ) -> Result<Field<D>, DistributedAffineError> {
        let mut elimination = Elimination::of(&[constraints])?;
        let mut lifted = elimination.lifted()?;
        let rest = self.residual(&lifted)?;
        let rest: Vec<f64> = elimination.reduce(&rest)?.iter().map(|value| -value).collect();
        let tangent = self.tangent(&lifted)?;
        solver.set_matrix(elimination.reduce_matrix(&tangent.matrix)?)?;
        let found = solver.solve(&rest, 0.0)?.solution;
        for (value, change) in lifted.iter_mut().zip(elimination.extend_by_zero(&found)?) {
            *value += change;
        }
        let not_finite = |_| LinearAlgebraError::Inaccurate { row: 0, backward_error: f64::NAN };
        Ok(Field::from_values(&self.space, lifted).map_err(not_finite)?)
    }
}

/// A functional of which each process integrates its own cells.
///
/// # Errors
/// The mismatch, on any process.
pub fn distributed_functional<G: Functional<D>, const D: usize>(
    world: &World,
    local: &Assembler<D>,
    functional: &G,
) -> Result<f64, DistributedAssemblyError> {
    let own = world.agree(local.functional(functional))?;
    Ok(world.sum(&[own])?[0])
}

impl<F: Form<D>, const D: usize> NonlinearProblem for DistributedProblem<'_, '_, F, D> {
    type Error = DistributedAssemblyError;

    fn residual(&mut self, u: &[f64]) -> Result<Vec<f64>, DistributedAssemblyError> {
        let own = self.world.agree(self.local.residual(u))?;
        Ok(self.sum.sum(&own)?)
    }

    fn tangent(&mut self, u: &[f64]) -> Result<Tangent<'_>, DistributedAssemblyError> {
        let own = self.world.agree(self.local.tangent(u))?;
        // Which places change is known of this process's cells alone.
        Ok(Tangent { changed: None, ..own })
    }

    fn active_points(&mut self, u: &[f64]) -> Result<Option<ActivePoints>, DistributedAssemblyError> {
        let own = self.world.agree(self.local.active_points(u))?;
        own.map(|own| Ok(self.all_active(own)?)).transpose()
    }

    fn balancing_forces(
        &mut self,
        u: &[f64],
        amplitudes: &[f64],
    ) -> Result<Vec<f64>, DistributedAssemblyError> {
        // All processes must come to the same judgement of convergence.
        let own = self.world.agree(self.local.balancing_forces(u, amplitudes))?;
        Ok(self.sum.sum(&own)?)
    }
}

impl<F, const D: usize> DistributedProblem<'_, '_, F, D> {
    /// The set of all processes' active points: sums of integers below 2⁵³ are exact in any order.
    fn all_active(&self, own: ActivePoints) -> Result<ActivePoints, PetscError> {
        let mut hasher = DefaultHasher::new();
        (self.world.rank(), own.fingerprint).hash(&mut hasher);
        let hash = hasher.finish();
        let parts = (0..4).map(|part| ((hash >> (16 * part)) & 0xffff) as f64);
        let sums = self.world.sum(&[own.count as f64].into_iter().chain(parts).collect::<Vec<_>>())?;
        let fingerprint = (1..5).fold(0_u64, |all, part| all.rotate_left(16).wrapping_add(sums[part] as u64));
        Ok(ActivePoints { count: sums[0] as usize, fingerprint })
    }
}

//! Contact problems as shape optimisation problems, for `forms_fem::shape_optimisation`.

mod costs;
mod law_shape;

use forms_fem::movement::diameters_to_movements;
use forms_fem::prelude::*;
use forms_fem::shape_optimisation::{Derivatives, Failure, ShapeProblem, Values};

pub use costs::VolumeRule;
use costs::{Costs, add, fix_regions};
pub use law_shape::{LawShape, LawState};

use crate::boundary_form::boundary_form;
use crate::contact_problem::ContactProblem;
use crate::forms::Regions;
use crate::load_and_pressure::load_and_pressure;
use crate::paper_law::Adjoint;
use crate::shape_gradient::Diameters;
use crate::theta_path::ThetaPath;

/// Objective functionals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Criterion {
    /// (3), with the data's M and N.
    Paper,
    /// ∫f·u + ∫g_N·u, the work of the loads.
    Compliance,
    /// L ∫p²/(∫p)² of the contact pressure p: 1 where it is constant over a length (or area) L, less where it is spread
    /// over more. It does not depend on the force.
    PressureVariation {
        /// L.
        over: f64,
    },
}

/// The formula of the derivative by the shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GradientForm {
    /// The volume form of the whole discrete problem; with (21) the exact derivative of J_h.
    Volume,
    /// The paper's boundary form (11), (20) on a free boundary.
    Boundary,
}

/// A contact problem on a shape that may change.
pub struct ContactShape<F> {
    /// The problem on a mesh: the same for all shapes.
    pub problem: F,
    /// The objective.
    pub criterion: Criterion,
    /// The adjoint state: (21) for all criteria; (22) or (41) for the paper's.
    pub adjoint: Adjoint,
    /// The formula of the derivative: on the boundary for the paper's criterion alone.
    pub gradient: GradientForm,
    /// The volume's rule.
    pub volume: VolumeRule,
    /// Γ_m, without load and contact.
    pub moving: String,
    /// Penalty per length (area) of Γ_m, added to the criterion: it regularises the boundary.
    pub perimeter_penalty: f64,
    /// Boundaries that stay.
    pub fixed: Vec<String>,
}

/// A contact problem that was solved on a shape.
pub struct ContactState<const D: usize> {
    /// The problem on the shape's mesh.
    pub problem: ContactProblem<D>,
    /// u_h of (14).
    pub u: Field<D>,
    /// The criterion alone, without the penalties of volume and perimeter.
    pub criterion: f64,
    /// ∫p, the resultant of the contact pressure, and ∫p²; none for criteria that do not ask for them.
    pub pressure: Option<[f64; 2]>,
    solver: CondensedSolver,
}

impl<F> ContactShape<F> {
    fn costs(&self) -> Costs<'_> {
        Costs { volume: self.volume, moving: &self.moving, perimeter_penalty: self.perimeter_penalty }
    }

    /// Whether criterion, adjoint state and formula go together.
    ///
    /// # Errors
    /// The pair that does not, and why.
    pub fn check(&self) -> Result<(), Failure> {
        if self.criterion == Criterion::Paper {
            return match (self.adjoint, self.gradient) {
                (Adjoint::Consistent | Adjoint::Extended, GradientForm::Volume) => Err(
                    "the volume form is the derivative of the discrete problem: it needs the adjoint (21)"
                        .into(),
                ),
                _ => Ok(()),
            };
        }
        match (self.adjoint, self.gradient) {
            (Adjoint::Discrete, GradientForm::Volume) => Ok(()),
            _ => Err("(22), (41) and the boundary form cover the paper's criterion (3) alone: this one needs the volume form with (21)".into()),
        }
    }

    /// load ℓ(u) + ∫ (square p² + linear p).
    fn functional<const D: usize>(
        &self,
        problem: &ContactProblem<D>,
        u: &Field<D>,
        [load, square, linear]: [f64; 3],
    ) -> Result<f64, AssemblyError>
    where
        Dim: Dimension<D>,
    {
        let Regions { omega, gamma_n, gamma_c, .. } = &problem.law.regions;
        let data =
            load_and_pressure::data_from(problem.law.data.clone()).load(load).square(square).linear(linear);
        problem.assembler_at(u)?.functional(&load_and_pressure::criterion(&data, omega, gamma_n, gamma_c, u))
    }

    /// The derivative of load ℓ(u) + ∫ (square p² + linear p), with its adjoint state solved for.
    fn gradient_of<const D: usize>(
        &self,
        movements: &Arc<Space<D>>,
        state: &mut ContactState<D>,
        [load, square, linear]: [f64; 3],
    ) -> Result<Vec<f64>, Failure>
    where
        Dim: Dimension<D>,
    {
        let ContactState { problem, u, solver, .. } = state;
        let u: &Field<D> = u;
        let Regions { omega, gamma_n, gamma_c, .. } = &problem.law.regions;
        let data =
            load_and_pressure::data_from(problem.law.data.clone()).load(load).square(square).linear(linear);
        let assembler = problem.assembler_at(u)?;
        let form = load_and_pressure::adjoint(&data, omega, gamma_n, gamma_c, u);
        let p = problem.state(form, u)?.solver(solver).solve()?.into_field();
        let form = load_and_pressure::shape_gradient(&data, omega, gamma_n, gamma_c, u, &p);
        let mut gradient = assembler.linear_form(&form, movements)?;
        let form = load_and_pressure::diameter_gradient(&data, omega, gamma_n, gamma_c, u, &p);
        let cells = Space::discontinuous_scalar(movements.mesh(), 0)?;
        let per_cell = assembler.linear_form(&form, &cells)?;
        add(&mut gradient, 1.0, &diameters_to_movements(movements, &per_cell)?);
        Ok(gradient)
    }

    /// The derivative of the paper's criterion, by the form and the adjoint that are asked for.
    fn gradient_of_papers<const D: usize>(
        &self,
        movements: &Arc<Space<D>>,
        state: &mut ContactState<D>,
    ) -> Result<Vec<f64>, Failure>
    where
        Dim: Dimension<D>,
    {
        let ContactState { problem, u, solver, .. } = state;
        let u: &Field<D> = u;
        let p = problem.solve_adjoint(self.adjoint, u, solver)?.into_field();
        if self.gradient == GradientForm::Volume {
            return Ok(problem.shape_gradient(u, &p, Diameters::Moving, None)?.values);
        }
        // A free boundary asks for no imposed displacement.
        let data = boundary_form::data_from(problem.law.data.clone()).imposed([0.0; D]);
        let free = boundary_form::Free::on(self.moving.clone());
        let form = boundary_form::gradient_on_free(&data, &free, u, &p);
        Ok(problem.assembler.linear_form(&form, movements)?)
    }
}

impl<F, const D: usize> ShapeProblem<D> for ContactShape<F>
where
    F: Fn(&Mesh<D>) -> Result<ContactProblem<D>, Failure>,
    Dim: Dimension<D>,
{
    type State = ContactState<D>;

    fn solve(&self, mesh: &Mesh<D>) -> Result<Values<ContactState<D>>, Failure> {
        self.check()?;
        let problem = (self.problem)(mesh)?;
        let mut solver = CondensedSolver::default();
        let solved = problem.direct()?.solver(&mut solver).solve();
        let u = match solved {
            Ok(solved) => solved.into_field(),
            // A hard start: by way of the variant that has a potential.
            Err(_) => {
                let path = ThetaPath::default();
                let options = NewtonOptions::default();
                problem.solve_through(path, &mut solver, &options, |_, _| ())?.state
            }
        };
        let (mut criterion, mut pressure) = (0.0, None);
        match self.criterion {
            Criterion::Paper => {
                criterion += problem.assembler.functional(&problem.law.criterion(&u))?;
            }
            Criterion::Compliance => criterion += self.functional(&problem, &u, [1.0, 0.0, 0.0])?,
            Criterion::PressureVariation { over } => {
                let force = self.functional(&problem, &u, [0.0, 0.0, 1.0])?;
                let square = self.functional(&problem, &u, [0.0, 1.0, 0.0])?;
                if force <= 0.0 {
                    return Err(
                        "nothing touches the obstacle: there is no contact pressure to even out".into()
                    );
                }
                pressure = Some([force, square]);
                criterion += over * square / (force * force);
            }
        }
        let alone = criterion;
        let (costs, constraint) = self.costs().values(mesh)?;
        criterion += costs;
        let state = ContactState { problem, u, criterion: alone, pressure, solver };
        Ok(Values { criterion, constraint, state })
    }

    fn derivatives(
        &self,
        movements: &Arc<Space<D>>,
        state: &mut ContactState<D>,
    ) -> Result<Derivatives, Failure> {
        let mut criterion = match (self.criterion, state.pressure) {
            (Criterion::Paper, _) => self.gradient_of_papers(movements, state)?,
            (Criterion::PressureVariation { over }, Some([force, square])) => {
                // The chain rule: L ∫p²/(∫p)² by ∫p² and by ∫p.
                let by_square = over / (force * force);
                let by_force = -2.0 * over * square / (force * force * force);
                self.gradient_of(movements, state, [0.0, by_square, by_force])?
            }
            _ => self.gradient_of(movements, state, [1.0, 0.0, 0.0])?,
        };
        let constraint = self.costs().add_derivatives(movements, &mut criterion)?;
        Ok(Derivatives { criterion, constraint })
    }

    fn fix(&self, movements: &mut Constraints<D>) -> Result<(), Failure> {
        fix_regions(&self.fixed, movements)
    }
}

//! The equations of one step after the other: solution, adjoint, and products with transposed tangents, on one pattern.

use std::rc::Rc;
use std::sync::Arc;

use super::control_vectors::ControlVectors;
use super::controls::Controls;
use super::error::HistoryFailure;
use crate::assemble::{Assembler, AssemblyError, BlockPattern, Outline, Parts, ValuesBefore};
use crate::constraints::Constraints;
use crate::contract::{Form, Function, Functional, Source};
use crate::field::{Field, FieldView, fields_on};
use crate::instantiate::instantiate;
use crate::linear_algebra::BlockMatrix;
use crate::solve::divided::check_ghost_values;
use crate::solve::{
    Communicator, Elimination, LentSolver, LinearSolver, NewtonOptions, OwnedForm, Processes, SolverReport,
    StepMemory, Transpose, solve_linear, solve_linear_transposed, solve_owned,
};
use crate::space::Space;

/// Who assembles and solves the steps of a history.
pub(super) struct StepEquations<'a, const D: usize> {
    pub assembler: Assembler<D>,
    pub options: NewtonOptions,
    /// Functionals whose integrands the next solution keeps positive.
    pub positive: Vec<Functional<D>>,
    /// The processes that solve each step together, if there are several.
    pub communicator: Option<&'a dyn Communicator>,
    /// The same with the division of vectors over all unknowns, and over each.
    processes: Processes<'a>,
    of_unknowns: Vec<Processes<'a>>,
    /// The same over each control that is a field, with its space.
    of_controls: Vec<(Arc<Space<D>>, Processes<'a>)>,
    spaces: Vec<Arc<Space<D>>>,
    solver: LentSolver<'a>,
    pattern: Option<Arc<BlockPattern<D>>>,
    memory: StepMemory,
    /// Constants, to test rates by numbers with.
    constants: Option<Arc<Space<D>>>,
    /// The step whose tangent at its solution is the solver's matrix.
    tangent_of: Option<Solution>,
}

/// Name of a history in errors of exchanges.
const HISTORY: &str = "a history";

/// The number of a solution, by which its adjoint finds it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Solution {
    /// That of the start's second rate.
    Start,
    /// That of a step.
    Step(usize),
}

impl<'a, const D: usize> StepEquations<'a, D> {
    #[inline(never)]
    pub fn new(spaces: &[&Arc<Space<D>>]) -> Self {
        StepEquations {
            assembler: Assembler::new(spaces[0].mesh()),
            options: NewtonOptions::default(),
            positive: vec![],
            communicator: None,
            processes: Processes::default(),
            of_unknowns: vec![],
            of_controls: vec![],
            spaces: spaces.iter().map(|space| Arc::clone(space)).collect(),
            solver: LentSolver::default(),
            pattern: None,
            memory: StepMemory::default(),
            constants: None,
            tangent_of: None,
        }
    }

    /// The spaces of the unknowns.
    fn unknowns_on(&self) -> Vec<&Arc<Space<D>>> {
        self.spaces.iter().collect()
    }

    pub fn assemble_by(&mut self, assembler: &Assembler<D>) {
        self.solver.set_threads(assembler.threads());
        self.assembler = assembler.clone();
    }

    pub fn lend(&mut self, solver: &'a mut dyn LinearSolver) {
        self.solver = LentSolver::Lent(solver);
    }

    pub fn solver_report(&mut self) -> Option<SolverReport> {
        self.solver.get().report()
    }

    /// The start with other data, after which the solver's tangent is out of date. It refuses what histories on pieces of a mesh do not have.
    ///
    /// # Errors
    /// [`crate::solve::CommunicationError::Divided`]; a failed exchange.
    pub fn begin(
        &mut self,
        controls: &Controls<D>,
        refused: impl IntoIterator<Item = (bool, &'static str)>,
    ) -> Result<(), HistoryFailure> {
        self.tangent_of = None;
        let spaces: Vec<_> = self.spaces.iter().collect();
        self.processes = Processes::on(self.communicator, &spaces, HISTORY)?;
        self.of_unknowns = vec![];
        self.of_controls = vec![];
        if self.processes.divided().is_none() {
            return Ok(());
        }
        self.processes.refuse(HISTORY, refused)?;
        for space in &spaces {
            self.of_unknowns.push(Processes::on(self.communicator, &[*space], HISTORY)?);
        }
        for (space, _) in controls.fields() {
            self.of_controls.push((Arc::clone(space), Processes::on(self.communicator, &[space], HISTORY)?));
        }
        // Vectors and functionals are of this process's piece, too, and are added up.
        self.assembler = self.processes.assembler(&self.assembler, spaces[0].mesh(), HISTORY)?;
        Ok(())
    }

    /// The processes.
    pub fn processes(&self) -> &Processes<'a> {
        &self.processes
    }

    /// The processes with the division of vectors over the first unknown whose space fits.
    pub fn processes_of(&self, fits: impl Fn(&Arc<Space<D>>) -> bool) -> &Processes<'a> {
        let place = self.spaces.iter().position(fits);
        place.and_then(|place| self.of_unknowns.get(place)).unwrap_or(&self.processes)
    }

    /// Products of vectors of control values.
    pub fn control_vectors(&self, controls: &Controls<D>) -> ControlVectors {
        let (Some(divided), Some(all)) = (self.processes.divided(), self.communicator) else {
            return ControlVectors::default();
        };
        let mut counted = vec![all.rank() == 0; controls.values().len()];
        for ((_, places), (_, processes)) in controls.fields().zip(&self.of_controls) {
            if let Some(vectors) = processes.divided() {
                places.enumerate().for_each(|(own, place)| counted[place] = vectors.owns(own));
            }
        }
        ControlVectors::on_parts(Rc::clone(divided), counted)
    }

    /// An error for a given field that has other values on copies of cells than their owners give it; on all processes.
    ///
    /// # Errors
    /// As [`check_ghost_values`].
    pub fn check_given(&self, function: &Function<D>) -> Result<(), AssemblyError> {
        self.processes.communicator().map_or(Ok(()), |all| check_ghost_values(all, function))
    }

    /// A vector over the unknowns, or those on the space of one or of a control, that was assembled by [`Self::assembler`].
    ///
    /// # Errors
    /// A failed exchange.
    pub fn completed(&self, on: Option<&Arc<Space<D>>>, own: Vec<f64>) -> Result<Vec<f64>, AssemblyError> {
        let processes = match on {
            None => &self.processes,
            Some(space) => {
                let is_one = |(known, _): &&(Arc<Space<D>>, Processes<'a>)| Arc::ptr_eq(known, space);
                let of_control = self.of_controls.iter().find(is_one);
                of_control.map_or_else(|| self.processes_of(|own| Arc::ptr_eq(own, space)), |known| &known.1)
            }
        };
        processes.completed(HISTORY, Ok(own))
    }

    /// Numbers that were integrated by [`Self::assembler`].
    ///
    /// # Errors
    /// A failed exchange.
    pub fn totals(&self, own: Vec<f64>) -> Result<Vec<f64>, AssemblyError> {
        self.processes.totals(HISTORY, Ok(own))
    }

    /// The space of constants per cell.
    ///
    /// # Errors
    /// Those of the space.
    pub fn constants(&mut self) -> Result<Arc<Space<D>>, HistoryFailure> {
        if let Some(known) = &self.constants {
            return Ok(Arc::clone(known));
        }
        Ok(Arc::clone(self.constants.insert(Space::discontinuous_scalar(self.spaces[0].mesh(), 0)?)))
    }

    /// The assembler of tangents: on several processes of this one's part of the cells. Vectors and functionals are assembled whole on each.
    fn of_tangents(&self) -> Result<Assembler<D>, HistoryFailure> {
        Ok(self.processes.assembler(&self.assembler, self.spaces[0].mesh(), HISTORY)?)
    }

    /// The places of a tangent's entries at a state: those that are known, unless pairs of displaced surfaces have left them.
    fn pattern(&mut self, form: &Form<D>, at: &[Field<D>]) -> Result<Arc<BlockPattern<D>>, HistoryFailure> {
        let (outline, at) = (Outline::of(form, Parts::ALL), views(at));
        if let Some(known) = &self.pattern
            && known.covers(&outline, &at)?
        {
            return Ok(Arc::clone(known));
        }
        let assembler = self.of_tangents()?;
        let pattern = BlockPattern::at_iterate(&outline, &self.unknowns_on(), &at, &assembler)?;
        Ok(Arc::clone(self.pattern.insert(Arc::new(pattern))))
    }

    /// The solution of a form from a start, a field for each unknown.
    ///
    /// # Errors
    /// A form that reads a history, and those of the solution.
    #[inline(never)]
    pub fn solve(
        &mut self,
        number: Solution,
        form: Form<D>,
        constraints: &[Constraints<D>],
        start: &[Field<D>],
    ) -> Result<Vec<Field<D>>, HistoryFailure> {
        reads_no_history(&form)?;
        let (affine, pattern) = (form.is_affine(), self.pattern(&form, start)?);
        let (assembler, options) = (&self.of_tangents()?, self.options.clone());
        let constraints = &constraints.iter().collect::<Vec<_>>();
        let start = &start.iter().collect::<Vec<_>>();
        let (pattern, communicator, positive) = (Some(&pattern), self.communicator, self.positive.clone());
        let owned =
            OwnedForm { form, assembler, pattern, communicator, constraints, start, positive, options };
        self.tangent_of = None;
        let solution = solve_owned(owned, self.solver.get(), &mut self.memory)?.fields;
        // Of an affine form it is the tangent wherever; Newton's method has that of an iterate.
        self.tangent_of = affine.then_some(number);
        Ok(solution)
    }

    /// The tangent of a form at fields, on several processes this one's part of it.
    ///
    /// # Errors
    /// Those of the assembly.
    pub fn tangent(&mut self, form: &Form<D>, at: &[Field<D>]) -> Result<BlockMatrix, HistoryFailure> {
        let (pattern, assembler) = (self.pattern(form, at)?, self.of_tangents()?);
        let mut matrix = BlockMatrix::zero(pattern.sparsity());
        let (at, spaces) = (views(at), self.unknowns_on());
        let arguments = (&at[..], &spaces[..]);
        let vanish = ValuesBefore::Vanish;
        assembler.write_tangent(form, arguments, Parts::ALL, &pattern, &mut matrix, vanish)?;
        Ok(matrix)
    }

    /// p with R_uᵀ p = −slope, zero where the solution is prescribed.
    ///
    /// # Errors
    /// Those of [`Self::linearised`].
    #[inline(never)]
    pub fn adjoint(
        &mut self,
        number: Solution,
        form: &Form<D>,
        constraints: &[Constraints<D>],
        solution: &[Field<D>],
        slope: &[f64],
    ) -> Result<Vec<Field<D>>, HistoryFailure> {
        if !self.processes.any(form.name(), slope.iter().any(|rate| *rate != 0.0))? {
            // Nothing depends on this step, as on one that only leads to the next.
            return Ok(self.spaces.iter().map(Field::zero).collect());
        }
        self.linearised(number, form, constraints, solution, slope, Transpose::Yes)
    }

    /// x with R_u x = −load, or R_uᵀ x = −load, zero where the solution is prescribed. The factor stays for further ones.
    ///
    /// # Errors
    /// Those of the assembly and of the solution.
    #[inline(never)]
    pub fn linearised(
        &mut self,
        number: Solution,
        form: &Form<D>,
        constraints: &[Constraints<D>],
        solution: &[Field<D>],
        load: &[f64],
        transpose: Transpose,
    ) -> Result<Vec<Field<D>>, HistoryFailure> {
        let Some(communicator) = self.communicator else {
            return self.solve_linearised(number, form, constraints, solution, load, transpose);
        };
        self.solver.get().set_processes(communicator.size())?;
        let found = self.solve_linearised(number, form, constraints, solution, load, transpose);
        // A solver that takes no whole matrix says so at the next one.
        let _ = self.solver.get().set_processes(1);
        found
    }

    fn solve_linearised(
        &mut self,
        number: Solution,
        form: &Form<D>,
        constraints: &[Constraints<D>],
        solution: &[Field<D>],
        load: &[f64],
        transpose: Transpose,
    ) -> Result<Vec<Field<D>>, HistoryFailure> {
        let load: Vec<f64> = load.iter().map(|load| -load).collect();
        let constraints: Vec<_> = constraints.iter().map(Constraints::homogeneous).collect();
        let own = Elimination::of(&constraints.iter().collect::<Vec<_>>())?;
        let mut elimination = self.processes.elimination(form.name(), own)?;
        let found = if self.tangent_of == Some(number) && self.solver.get().judges_equations() {
            let found = self.solver.get().solve_with(&elimination.reduce(&load)?, 0.0, transpose)?;
            elimination.extend_by_zero(&found.solution)?
        } else {
            let matrix = self.tangent(form, solution)?;
            self.tangent_of = None;
            let solve = match transpose {
                Transpose::No => solve_linear,
                Transpose::Yes => solve_linear_transposed,
            };
            let found = solve(&matrix, &load, &mut elimination, self.solver.get())?.solution;
            self.tangent_of = Some(number);
            found
        };
        Ok(fields_on(&self.unknowns_on(), &found)?)
    }

    /// Kᵀ p with the tangent K of a form at a solution, p with the coefficients of all unknowns.
    ///
    /// # Errors
    /// Those of the assembly.
    #[inline(never)]
    pub fn transposed(
        &mut self,
        form: &Form<D>,
        at: &[Field<D>],
        p: &[f64],
    ) -> Result<Vec<f64>, HistoryFailure> {
        let own = self.tangent(form, at)?.multiply_transposed(p)?;
        Ok(self.summed(form, own)?)
    }

    /// The sum over the processes of what each has of its part.
    ///
    /// # Errors
    /// A failed exchange.
    pub fn summed(&self, form: &Form<D>, own: Vec<f64>) -> Result<Vec<f64>, AssemblyError> {
        self.processes.added_up(form.name(), Ok(own))
    }
}

pub(super) fn views<const D: usize>(fields: &[Field<D>]) -> Vec<FieldView<'_, D>> {
    fields.iter().map(Field::view).collect()
}

/// Refuses forms of values at quadrature points that steps would write.
pub(super) fn reads_no_history<const D: usize>(form: &Form<D>) -> Result<(), HistoryFailure> {
    let mut sources = form.inputs().sources.iter().zip(form.fields());
    match sources.find(|(source, _)| matches!(source, Some(Source::History(_)))) {
        Some((_, field)) => Err(HistoryFailure::QuadratureValues { form: form.name(), field: field.name }),
        None => Ok(()),
    }
}

instantiate!(
    step_equations:
    StepEquations::<D>::new,
    StepEquations::<D>::solve,
    StepEquations::<D>::adjoint,
    StepEquations::<D>::linearised,
    StepEquations::<D>::transposed,
);

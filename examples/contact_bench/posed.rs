//! A problem of any kind as a table shows it: contact on surfaces here, and others in files of their own.

use forms_fem::output::Failure;

use crate::balance::balance;
use crate::case::Case;
use crate::formulation::{Formulation, Meshing};
use crate::gradient::{Gradient, gradient};
use crate::outcome::{Outcome, Refusal, not_defined};
use crate::problem::Problem;
use crate::rows::{Answer, Measured};

/// A problem of any kind, as a table shows it.
pub trait Posed: Sync {
    /// Its name on the command line.
    fn name(&self) -> String;

    /// One line on it, with the source of the known answer.
    fn statement(&self) -> &'static str;

    /// The answer of a formulation on the mesh of a level, from 0, with a degree, and the number of unknowns of the displacement.
    ///
    /// # Errors
    /// A mesh or conditions that cannot be made.
    fn answer(
        &self,
        formulation: &dyn Formulation,
        level: usize,
        degree: usize,
    ) -> Result<(usize, Answer), Failure>;
}

impl<P: Problem> Posed for P {
    fn name(&self) -> String {
        Problem::name(self)
    }

    fn statement(&self) -> &'static str {
        Problem::statement(self)
    }

    fn answer(
        &self,
        formulation: &dyn Formulation,
        level: usize,
        degree: usize,
    ) -> Result<(usize, Answer), Failure> {
        let (case, further) = match formulation.meshing() {
            Meshing::Fitted => (self.case(level, degree)?, self.further_cases(level, degree)?),
            Meshing::Cut => match self.cut_case(level, degree)? {
                Some(case) => (case, vec![]),
                None => {
                    return Ok((0, Answer::NotDefined("no cut body is given for the problem".to_owned())));
                }
            },
        };
        let answer = Answer::timed(
            || solve_all(formulation, &case, &further),
            |found, seconds| {
                let gradient = match level {
                    0 => gradient(formulation, &case, &found[0]),
                    _ => Err(not_defined("first mesh")),
                };
                measured(self, &case, &found, gradient, seconds)
            },
        )?;
        Ok((case.space.unknowns(), answer))
    }
}

/// The solutions of a case and of the further ones, with all Newton steps at the first.
fn solve_all(formulation: &dyn Formulation, case: &Case, further: &[Case]) -> Result<Vec<Outcome>, Refusal> {
    let all = std::iter::once(case).chain(further).map(|case| formulation.solve(case));
    let mut found = all.collect::<Result<Vec<Outcome>, _>>()?;
    found[0].newton = found.iter().flat_map(|one| &one.newton).copied().collect();
    Ok(found)
}

fn measured(
    problem: &dyn Problem,
    case: &Case,
    found: &[Outcome],
    gradient: Result<Gradient, Refusal>,
    seconds: f64,
) -> Result<Measured, Failure> {
    let first = &found[0];
    let force = first.pressures.force();
    let sums = balance(case, &first.forces);
    let mut quantities = problem.quantities(case, first)?;
    quantities.extend(problem.quantities_of_all(found)?);
    let measured = Measured {
        seconds,
        force_balance: sums.map(|sums| sums.force),
        moment_balance: sums.map(|sums| sums.moment),
        no_gradient: gradient.as_ref().err().map(|why| why.to_string()),
        gradient: gradient.ok(),
        penetration: case.penetration(&first.u)? / case.approach,
        quantities,
        ..Measured::of(first)
    };
    Ok(measured.compared(&first.pressures, |x| problem.along(x), |x| problem.exact_pressure(x, force)))
}

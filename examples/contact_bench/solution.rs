//! The outcome of a case from the solution of its form.

use forms_fem::prelude::*;

use crate::case::Case;
use crate::outcome::{Outcome, Pressures, Refusal};

impl Case {
    /// The solution of a contact form in the displacement, with its pressure on the own surface.
    ///
    /// # Errors
    /// Newton's method fails.
    pub fn newton(
        &self,
        contact: &Form<2>,
        pressure: impl Fn(&Field<2>) -> Expression<2>,
    ) -> Result<Outcome, Refusal> {
        let solved = self.problem(contact).solve()?;
        let pressures = self.pressures(&pressure(solved.field()))?;
        Ok(Outcome::of(self, &solved, pressures)?.of_form(&self.balance() + contact))
    }
}

impl Outcome {
    /// The outcome of one solve.
    ///
    /// # Errors
    /// Data that do not fit.
    pub fn of<const N: usize>(
        case: &Case,
        solved: &Solved<2, N>,
        pressures: Pressures,
    ) -> Result<Self, Refusal> {
        let u = solved.fields[0].clone();
        let forces = contact_forces(case, solved)?;
        let residual = solved.residual[..case.space.unknowns()].to_vec();
        let fields = solved.fields.to_vec();
        let newton = vec![solved.iterations()];
        Ok(Outcome { u, pressures, forces, residual, form: None, fields, newton, outer: None })
    }
}

/// The forces of contact of any form: a(u,v) − ℓ(v) less the whole residual.
///
/// # Errors
/// Data that do not fit.
pub fn contact_forces<const N: usize>(case: &Case, solved: &Solved<2, N>) -> Result<Vec<f64>, Refusal> {
    let elastic = solved.assembler().residual(&case.balance(), &[&solved.fields[0]], &[&case.space])?;
    Ok(elastic.iter().zip(&solved.residual).map(|(elastic, residual)| elastic - residual).collect())
}

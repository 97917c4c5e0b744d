//! Problems: meshes, loads and known answers, without a formulation.

use forms_fem::output::Failure;

use crate::case::Case;
use crate::outcome::Outcome;

/// A measured number, with the one that is known.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Quantity {
    /// Its name, with its unit where it has one.
    pub name: &'static str,
    /// The number.
    pub value: f64,
    /// The known one.
    pub exact: Option<f64>,
}

/// A problem of contact on surfaces.
pub trait Problem: Sync {
    /// Its name on the command line.
    fn name(&self) -> String;

    /// One line on it, with the source of the known answer.
    fn statement(&self) -> &'static str;

    /// The problem on the mesh of a level, from 0, with displacements of a degree.
    ///
    /// # Errors
    /// A mesh or conditions that cannot be made.
    fn case(&self, level: usize, degree: usize) -> Result<Case, Failure>;

    /// The same problem of a body that is cut from a mesh by a level set function, if there is one.
    ///
    /// # Errors
    /// As [`Problem::case`].
    fn cut_case(&self, _level: usize, _degree: usize) -> Result<Option<Case>, Failure> {
        Ok(None)
    }

    /// The known pressure at a place of the own surface, for a resultant of the pressure.
    fn exact_pressure(&self, _place: [f64; 2], _force: f64) -> Option<f64> {
        None
    }

    /// The coordinate along the contact by which pressures are drawn.
    fn along(&self, place: [f64; 2]) -> f64 {
        place[0]
    }

    /// Further cases of the same problem, as other places of a tool, which are solved after the first.
    ///
    /// # Errors
    /// As [`Problem::case`].
    fn further_cases(&self, _level: usize, _degree: usize) -> Result<Vec<Case>, Failure> {
        Ok(vec![])
    }

    /// Numbers of the solutions of all cases, the first one in front.
    ///
    /// # Errors
    /// Data that do not fit.
    fn quantities_of_all(&self, _found: &[Outcome]) -> Result<Vec<Quantity>, Failure> {
        Ok(vec![])
    }

    /// Numbers of a solution that are known, or asked for.
    ///
    /// # Errors
    /// Data that do not fit.
    fn quantities(&self, _case: &Case, _found: &Outcome) -> Result<Vec<Quantity>, Failure> {
        Ok(vec![])
    }
}

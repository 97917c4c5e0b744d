//! The criterion of a reduced problem as a map of one output.

use super::differentiable_map::{DifferentiableMap, MapError, Part, check, finite};
use super::reduced_problem::ReducedProblem;

/// J as a map with the output `criterion`, of any reduced problem. Products with its Jacobian are those with the gradient.
pub struct CriterionMap<P> {
    problem: P,
    /// The last controls.
    last: Option<Last>,
}

struct Last {
    m: Vec<f64>,
    value: f64,
    gradient: Option<Vec<f64>>,
}

impl<P: ReducedProblem> CriterionMap<P> {
    /// The map of a problem.
    pub fn new(problem: P) -> Self {
        CriterionMap { problem, last: None }
    }

    fn last(&self, m: &[f64]) -> Option<&Last> {
        // By bits: a function of m alone, of zeros with their signs as well.
        let same =
            |last: &&Last| last.m.iter().map(|value| value.to_bits()).eq(m.iter().map(|m| m.to_bits()));
        self.last.as_ref().filter(same)
    }

    fn gradient(&mut self, m: &[f64]) -> Result<Vec<f64>, MapError> {
        check("vector of controls", &self.inputs(), m)?;
        if let Some(gradient) = self.last(m).and_then(|last| last.gradient.clone()) {
            return Ok(gradient);
        }
        let found = self.problem.value_and_gradient(m);
        let (value, gradient) = found.map_err(|why| MapError::Problem(Box::new(why)))?;
        finite("value", vec![value])?;
        let gradient = finite("gradient", gradient)?;
        self.last = Some(Last { m: m.to_vec(), value, gradient: Some(gradient.clone()) });
        Ok(gradient)
    }
}

impl<P: ReducedProblem> DifferentiableMap for CriterionMap<P> {
    fn inputs(&self) -> Vec<Part> {
        self.problem.parts()
    }

    fn outputs(&self) -> Vec<Part> {
        vec![Part::new("criterion", 1)]
    }

    fn start(&self) -> Vec<f64> {
        self.problem.start()
    }

    fn value(&mut self, m: &[f64]) -> Result<Vec<f64>, MapError> {
        check("vector of controls", &self.inputs(), m)?;
        if let Some(last) = self.last(m) {
            return Ok(vec![last.value]);
        }
        let value = self.problem.value(m).map_err(|why| MapError::Problem(Box::new(why)))?;
        let found = finite("value", vec![value])?;
        self.last = Some(Last { m: m.to_vec(), value, gradient: None });
        Ok(found)
    }

    fn vjp(&mut self, m: &[f64], cotangent: &[f64]) -> Result<Vec<f64>, MapError> {
        check("cotangent", &self.outputs(), cotangent)?;
        let gradient = self.gradient(m)?;
        Ok(gradient.into_iter().map(|slope| cotangent[0] * slope).collect())
    }
}

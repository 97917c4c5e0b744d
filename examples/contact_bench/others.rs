//! Rows of other programs, which the scripts in bench/peers/contact write.

use std::collections::BTreeMap;
use std::path::Path;

use forms_fem::output::Failure;
use serde::Deserialize;

use crate::problem::Quantity;
use crate::rows::{Answer, Measured, Row};

/// A row of another program: a line of JSON.
#[derive(Clone, Debug, Deserialize)]
pub struct Other {
    problem: String,
    formulation: String,
    degree: usize,
    /// `None` for a reference, which no mesh is as fine as.
    level: Option<usize>,
    unknowns: usize,
    seconds: f64,
    newton: Vec<usize>,
    outer: Option<usize>,
    numbers: BTreeMap<String, f64>,
}

/// The rows of a file.
///
/// # Errors
/// A file that cannot be read, and a line that is no row.
pub fn read(path: &Path) -> Result<Vec<Other>, Failure> {
    let text = std::fs::read_to_string(path)?;
    let lines = text.lines().filter(|line| !line.trim().is_empty());
    let rows = lines.map(|line| serde_json::from_str(line).map_err(Failure::from));
    rows.collect()
}

impl Other {
    /// Its row in the table of these rows, if it belongs there: a reference does, other rows where their degree and level were asked for.
    pub fn row(&self, rows: &[Row]) -> Option<Row> {
        let is_asked = |row: &Row| match self.level {
            None => true,
            Some(level) => row.degree == self.degree && row.level >= level,
        };
        let alike = || rows.iter().filter(|row| row.problem == self.problem);
        if !alike().any(is_asked) {
            return None;
        }
        let first = alike().find_map(Row::measured)?;
        let number = |quantity: &Quantity| Quantity {
            value: self.numbers.get(quantity.name).copied().unwrap_or(f64::NAN),
            ..quantity.clone()
        };
        Some(Row {
            problem: self.problem.clone(),
            formulation: self.formulation.clone(),
            degree: self.degree,
            level: self.level.unwrap_or_default(),
            unknowns: self.unknowns,
            answer: Answer::Solved(Measured {
                outer: self.outer,
                seconds: self.seconds,
                no_gradient: Some("not measured".to_owned()),
                penetration: f64::NAN,
                quantities: first.quantities.iter().map(number).collect(),
                ..Measured::of_newton(self.newton.iter().copied())
            }),
        })
    }
}

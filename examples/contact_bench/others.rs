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
    level: usize,
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
    /// Its row in the table of these rows, if it belongs there.
    pub fn row(&self, rows: &[Row]) -> Option<Row> {
        let alike = |row: &&Row| row.problem == self.problem && row.degree == self.degree;
        let first = rows.iter().filter(alike).find_map(Row::measured)?;
        if rows.iter().all(|row| row.level < self.level) {
            return None;
        }
        let number = |quantity: &Quantity| Quantity {
            value: self.numbers.get(quantity.name).copied().unwrap_or(f64::NAN),
            ..quantity.clone()
        };
        Some(Row {
            problem: self.problem.clone(),
            formulation: self.formulation.clone(),
            degree: self.degree,
            level: self.level,
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

//! The derivative of the supports' work rate by their way: by the transposed tangent, and by central differences of solutions.
//!
//! Prescribed values are t d. J(t) = dᵀR(u(t)) is the force of the supports along their way. With u = C y + t d the tangent K gives
//! (CᵀKC)ᵀ p = −CᵀKᵀd and dJ/dt = dᵀKd + pᵀCᵀKd.

use forms_fem::linear_algebra::CsrMatrix;
use forms_fem::prelude::*;
use forms_fem::solve::Elimination;

use crate::case::Case;
use crate::formulation::Formulation;
use crate::outcome::{Outcome, Refusal, not_defined};

/// Steps of the differences, as parts of the way. Solutions are known up to rounding, which a small step magnifies, and a kink or a third derivative
/// shows with a large one.
const STEPS: [f64; 4] = [1e-2, 1e-3, 1e-4, 1e-5];

/// Both derivatives.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Gradient {
    /// By the transposed tangent.
    pub adjoint: f64,
    /// By central differences.
    pub difference: f64,
}

impl Gradient {
    /// Their difference, relative to the second.
    pub fn error(&self) -> f64 {
        (self.adjoint / self.difference - 1.0).abs()
    }
}

/// The gradient of a formulation at its solution.
///
/// # Errors
/// A problem without a way of its supports, a solution without a tangent, and a solution next to this one that fails.
pub fn gradient(formulation: &dyn Formulation, case: &Case, found: &Outcome) -> Result<Gradient, Refusal> {
    let way = Elimination::of(&[&case.constraints])?.lifted()?;
    if way.iter().all(|value| *value == 0.0) {
        return Err(not_defined("no way"));
    }
    let Some(form) = &found.form else { return Err(not_defined("no tangent")) };
    let adjoint = by_transposed_tangent(case, form, &found.fields, &way)?;
    let mut differences = [0.0; STEPS.len()];
    for (difference, step) in differences.iter_mut().zip(STEPS) {
        let mut ends = [0.0; 2];
        for (end, sign) in ends.iter_mut().zip([1.0, -1.0]) {
            let moved =
                formulation.solve(&Case { constraints: scaled(case, 1.0 + sign * step)?, ..case.clone() })?;
            *end = moved.residual.iter().zip(&way).map(|(residual, way)| residual * way).sum();
        }
        *difference = (ends[0] - ends[1]) / (2.0 * step);
    }
    Ok(Gradient { adjoint, difference: settled(differences) })
}

/// The difference that changes least from the larger step before to the smaller one after it: it does not know the adjoint.
///
/// From one step to the next the error of a kink or of a third derivative falls by ten or more, and that of rounding rises by ten.
fn settled(differences: [f64; STEPS.len()]) -> f64 {
    let change = |k: usize| (differences[k] - differences[k + 1]).abs();
    let last = differences.len() - 1;
    let error = |k: usize| match k {
        0 => 1.1 * change(0),
        k if k == last => 1.1 * change(k - 1),
        k => 0.1 * (change(k - 1) + change(k)),
    };
    let best = (0..differences.len()).min_by(|a, b| error(*a).total_cmp(&error(*b)));
    differences[best.unwrap_or(last)]
}

/// The conditions with all prescribed values times a factor.
fn scaled(case: &Case, factor: f64) -> Result<Constraints<2>, Refusal> {
    let mut scaled = Constraints::new(&case.space);
    for (unknown, value) in case.constraints.prescribed() {
        scaled.fix_node(unknown / 2, unknown % 2, factor * value)?;
    }
    for (unknown, relation) in case.constraints.relations() {
        match relation.terms.is_empty() {
            true => scaled.fix_node(unknown / 2, unknown % 2, factor * relation.value)?,
            false => scaled.relate("a relation", *unknown, &relation.terms, factor * relation.value)?,
        }
    }
    Ok(scaled)
}

fn by_transposed_tangent(
    case: &Case,
    form: &Form<2>,
    fields: &[Field<2>],
    way: &[f64],
) -> Result<f64, Refusal> {
    let spaces: Vec<&Arc<Space<2>>> = fields.iter().map(Field::space).collect();
    let tangent = case.assembler().tangent(form, &fields.iter().collect::<Vec<_>>(), &spaces)?;
    let others: Vec<Constraints<2>> = spaces[1..].iter().map(|space| Constraints::new(space)).collect();
    let all: Vec<&Constraints<2>> = std::iter::once(&case.constraints).chain(&others).collect();
    let elimination = Elimination::of(&all)?;
    // The row of C of each unknown.
    let mut rows: Vec<Vec<(usize, f64)>> = vec![vec![]; tangent.rows()];
    let mut number = vec![usize::MAX; tangent.rows()];
    for (place, unknown) in elimination.free().iter().enumerate() {
        number[*unknown] = place;
        rows[*unknown].push((place, 1.0));
    }
    for (unknown, relation) in case.constraints.relations() {
        rows[*unknown] = relation.terms.iter().map(|(free, a)| (number[*free], *a)).collect();
    }
    let mut triplets = vec![];
    for i in 0..tangent.rows() {
        let (columns, values) = tangent.row(i);
        for (column, value) in columns.iter().zip(values) {
            for (a, of_row) in &rows[i] {
                let products =
                    rows[*column as usize].iter().map(|(b, of_column)| (*a, *b, of_row * value * of_column));
                triplets.extend(products);
            }
        }
    }
    let size = elimination.free().len();
    let mut solver = LuSolver::default();
    solver.set_matrix(CsrMatrix::from_triplets(size, size, &triplets)?)?;
    let mut direction = way.to_vec();
    direction.resize(tangent.rows(), 0.0);
    let (forward, backward) = (tangent.multiply(&direction)?, tangent.multiply_transposed(&direction)?);
    let load: Vec<f64> = elimination.reduce(&backward)?.iter().map(|value| -value).collect();
    let p = solver.solve_transposed(&load, 0.0)?.solution;
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    Ok(dot(&direction, &forward) + dot(&p, &elimination.reduce(&forward)?))
}

//! The derivative of the supports' work rate by their way: by the transposed tangent, and by central differences of solutions.
//!
//! Prescribed values are t d. J(t) = dᵀR(u(t)) is the force of the supports along their way. With u = C y + t d the tangent K gives
//! (CᵀKC)ᵀ p = −CᵀKᵀd and dJ/dt = dᵀKd + pᵀCᵀKd.

use forms_fem::linear_algebra::CsrMatrix;
use forms_fem::prelude::*;
use forms_fem::solve::Elimination;

use crate::case::Case;
use crate::formulation::Formulation;
use crate::outcome::{Outcome, Refusal};

/// The step of the differences, as a part of the way.
const STEP: f64 = 1e-5;

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

/// The gradient of a formulation at its solution; none where no value is prescribed other than zero, or the solution has no tangent.
///
/// # Errors
/// A solution next to this one that fails.
pub fn gradient(
    formulation: &dyn Formulation,
    case: &Case,
    found: &Outcome,
) -> Result<Option<Gradient>, Refusal> {
    let way = Elimination::of(&[&case.constraints])?.lifted()?;
    let (Some(form), true) = (&found.form, way.iter().any(|value| *value != 0.0)) else { return Ok(None) };
    let adjoint = by_transposed_tangent(case, form, &found.fields, &way)?;
    let mut ends = [0.0; 2];
    for (end, sign) in ends.iter_mut().zip([1.0, -1.0]) {
        let moved =
            formulation.solve(&Case { constraints: scaled(case, 1.0 + sign * STEP)?, ..case.clone() })?;
        *end = moved.residual.iter().zip(&way).map(|(residual, way)| residual * way).sum();
    }
    Ok(Some(Gradient { adjoint, difference: (ends[0] - ends[1]) / (2.0 * STEP) }))
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

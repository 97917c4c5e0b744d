//! Refinement of the solutions of several systems side by side: each solve and each residual is one call for all that go on.

use super::{Refinement, Residual};
use crate::equations::{Side, residual_each};
use crate::error::LinearAlgebraError;
use crate::threads::Threads;

/// The end of a refinement: after a number of steps, where the error of a system is small enough, or where a step has not halved it.
pub struct Rule<'r> {
    /// Most steps.
    pub steps: usize,
    /// The error of a solution of a system, by its residual.
    pub error: &'r dyn Fn(usize, &[f64], &Residual) -> f64,
    /// Whether an error of a system needs no further step.
    pub is_enough: &'r dyn Fn(usize, f64) -> bool,
}

/// Solutions of several systems A x = b, refined by a rule, with the numbers of steps that improved them. `solve` gets numbers of systems and a
/// vector for each, which it replaces by A⁻¹ times it. A system has the bits that it has by itself, if `solve` sees to that.
///
/// # Errors
/// Those of `solve`; wrong sizes.
pub fn refine_each<'a, F: From<LinearAlgebraError>>(
    threads: Threads,
    systems: &[(&'a Side<'a>, &'a [f64])],
    rule: &Rule<'_>,
    mut solve: impl FnMut(&[usize], Vec<Vec<f64>>) -> Result<Vec<Vec<f64>>, F>,
) -> Result<Vec<(Refinement<'a, Side<'a>>, usize)>, F> {
    let mut open: Vec<usize> = (0..systems.len()).collect();
    let first = solve(&open, systems.iter().map(|(_, b)| b.to_vec()).collect())?;
    let begun = |((equations, b), x): (&(&'a Side<'a>, &'a [f64]), Vec<f64>)| Refinement {
        equations: *equations,
        threads,
        b,
        x: vec![],
        residual: Residual::default(),
        candidate: x,
        next: Residual::default(),
    };
    let mut found: Vec<_> = systems.iter().zip(first).map(begun).collect();
    judge(threads, &mut found, &open)?;
    found.iter_mut().for_each(Refinement::accept);
    let first_error = |(k, one): (usize, &Refinement<'_, _>)| (rule.error)(k, &one.x, &one.residual);
    let mut errors: Vec<f64> = found.iter().enumerate().map(first_error).collect();
    let mut steps = vec![0; systems.len()];
    for _ in 0..rule.steps {
        open.retain(|k| !(rule.is_enough)(*k, errors[*k]));
        if open.is_empty() {
            break;
        }
        // Memory for the solves of all.
        open.iter().for_each(|k| found[*k].candidate = vec![]);
        let rests = open.iter().map(|k| found[*k].residual.rest.clone()).collect();
        for (k, change) in open.iter().zip(solve(&open, rests)?) {
            let one = &mut found[*k];
            one.candidate = change;
            one.candidate.iter_mut().zip(&one.x).for_each(|(change, x)| *change += x);
        }
        judge(threads, &mut found, &open)?;
        open.retain(|k| {
            let (one, before) = (&mut found[*k], errors[*k]);
            let next = (rule.error)(*k, &one.candidate, &one.next);
            if next < before {
                one.accept();
                errors[*k] = next;
                steps[*k] += 1;
                return next <= 0.5 * before;
            }
            false
        });
    }
    Ok(found.into_iter().zip(steps).collect())
}

/// Computes the residuals of the candidates of some systems, given by ascending numbers.
fn judge(
    threads: Threads,
    found: &mut [Refinement<'_, Side<'_>>],
    numbers: &[usize],
) -> Result<(), LinearAlgebraError> {
    let (mut systems, mut rests, mut worst) = (vec![], vec![], vec![]);
    for (_, one) in found.iter_mut().enumerate().filter(|(k, _)| numbers.binary_search(k).is_ok()) {
        let Refinement { equations, b, candidate, next, .. } = one;
        systems.push((*equations, &candidate[..], *b));
        rests.push(&mut next.rest);
        worst.push(&mut next.worst);
    }
    let judged = residual_each(threads, &systems, rests)?;
    worst.into_iter().zip(judged).for_each(|(worst, judged)| *worst = judged);
    Ok(())
}

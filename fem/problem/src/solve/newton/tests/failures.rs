//! Reports of failures of Newton's method.

use super::*;

#[test]
fn a_failure_prints_as_a_short_table() {
    let options = NewtonOptions::default();
    let error = system(&[1.0; 40], &options, |u| {
        let n = u.len();
        let mut matrix = vec![0.0; n * n];
        (0..n).for_each(|i| matrix[i * n + i] = 2.0 * u[i]);
        (u.iter().map(|u| u * u + 1e-30).collect(), matrix)
    });
    let shown = format!("{:?}", error.unwrap_err());
    let lines: Vec<&str> = shown.lines().collect();
    assert_eq!(lines[0], "Newton's method failed at iteration 50: no convergence within 50 iterations");
    assert!(lines[1].trim_start().starts_with("iteration     residual") && lines[2].ends_with("(45 before)"));
    assert!(lines[8].trim_start().starts_with("50 ") && lines[9..] == ["40 unknowns"], "{shown}");
    assert!(lines.iter().all(|line| line.len() < 160), "{shown}");
}

/// Its tangent is never known.
struct WithoutTangent;

impl NonlinearProblem for WithoutTangent {
    fn residual(&mut self, u: &[f64]) -> Result<Vec<f64>, AssemblyError> {
        Ok(u.iter().map(|u| u + 1.0).collect())
    }

    fn tangent(&mut self, _: &[f64]) -> Result<Tangent<'_>, AssemblyError> {
        Err(AssemblyError::other(std::fmt::Error))
    }
}

#[test]
fn an_error_of_any_type_is_returned() {
    let (options, mut solver) = (NewtonOptions::default(), TangentSolver::default());
    let start = vec![2.0, 0.0];
    let found =
        newton(&mut WithoutTangent, &BTreeMap::new(), start.clone(), &mut solver, &options, &mut |_| ());
    let error = found.unwrap_err();
    let message = format!("Newton's method failed at iteration 0: assembly failed: {}", std::fmt::Error);
    assert_eq!((error.to_string(), &error.u), (message, &start));
    let NewtonFailure::Assembly(AssemblyError::Other(other)) = error.why else { panic!("{error}") };
    assert!(other.get().is::<std::fmt::Error>());
    assert!(other == other.clone() && AssemblyError::Other(other) != AssemblyError::other(std::fmt::Error));
}

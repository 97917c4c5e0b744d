//! Orders, affine functions and kinks of numbers.

use super::*;

fn test(derivative: f64, value: impl Fn(f64) -> Sample) -> TaylorReport {
    taylor(0.5, &[derivative], |step| Ok::<_, AssemblyError>(value(step)))
        .unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn right_and_wrong_derivatives_are_told_apart() {
    let exponential = |step: f64| step.exp().into();
    assert!(test(1.0, exponential).second_order().is_ok_and(|order| (order - 2.0).abs() < 0.05));
    let wrong = test(1.5, exponential).second_order();
    assert!(
        matches!(wrong, Err(TaylorFailure::Order { lowest, .. }) if (lowest - 1.0).abs() < 0.2),
        "{wrong:?}"
    );
    let message = test(1.0, |step| (1.0 / step.min(0.3 - step)).sqrt().into()).second_order();
    assert!(matches!(message, Err(TaylorFailure::NotFinite { .. })));
    // A vector of another length than the derivative.
    assert!(test(1.0, |_| vec![1.0, 2.0].into()).second_order().is_err());
}

#[test]
fn affine_functions_pass_with_the_right_derivative_only() {
    let line = |step: f64| (2.0 + 3.0 * step).into();
    let affine = test(3.0, line);
    assert!(affine.is_affine() && affine.second_order() == Ok(f64::INFINITY), "{affine}");
    assert!(affine.to_string().ends_with("affine along this direction: no remainder but rounding\n"));
    for wrong in [3.000_01, 0.0, -3.0] {
        let report = test(wrong, line);
        let failure = report.second_order();
        assert!(!report.is_affine() && matches!(failure, Err(TaylorFailure::Order { .. })), "{failure:?}");
    }
    // A law with a kink beyond the first steps: affine where it is tested.
    let law = |step: f64| Sample {
        value: vec![(step - 0.2).max(0.0), 1.0 - step],
        active_set: Some(vec![u32::from(step > 0.2)]),
    };
    let along = |derivative: [f64; 2]| {
        let report = taylor(0.5, &derivative, |step| Ok::<_, AssemblyError>(law(step)));
        report.unwrap_or_else(|error| panic!("{error}"))
    };
    assert_eq!(along([0.0, -1.0]).second_order(), Ok(f64::INFINITY));
    assert!(matches!(along([1.0, -1.0]).second_order(), Err(TaylorFailure::Order { .. })));
    assert_eq!(test(0.0, |_| 7.0.into()).second_order(), Ok(f64::INFINITY));
    // Steps so small that a wrong derivative is rounding, too.
    for derivative in [2e-9, 4e-9] {
        let value = |step: f64| Ok::<_, AssemblyError>(Sample::from(1e5 + 2e-9 * step));
        let blind = taylor(1.0, &[derivative], value).unwrap_or_else(|error| panic!("{error}"));
        assert!(matches!(blind.second_order(), Err(TaylorFailure::Rounding { .. })));
    }
}

#[test]
fn steps_across_a_kink_are_named_and_left_out() {
    // f = x² + [x − 0.2]₊ at x = 0: right below the kink, wrong for who does not know of it.
    let kinked = |step: f64| step * step + (step - 0.2).max(0.0);
    let told =
        |step: f64| Sample { value: vec![kinked(step)], active_set: Some(vec![u32::from(step > 0.2)]) };
    let report = test(0.0, told);
    let same: Vec<bool> = report.steps.iter().map(|step| step.same_active_set).collect();
    assert_eq!(same[..3], [false, false, true]);
    assert_eq!(report.steps[2].order, None);
    assert!(report.second_order().is_ok_and(|order| (order - 2.0).abs() < 1e-9));
    assert!(report.to_string().lines().nth(1).is_some_and(|line| line.ends_with("another active set")));
    // On the kink every step has another set.
    let on_it = |step: f64| Sample { value: vec![step.abs()], active_set: Some(vec![u32::from(step > 0.0)]) };
    let failure = test(0.0, on_it).second_order();
    assert!(matches!(failure, Err(TaylorFailure::ActiveSet { .. })), "{failure:?}");
}

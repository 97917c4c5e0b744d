//! Refusals of continuation, by name.

use forms_fem::prelude::*;
use forms_fem::solve::ContinuationFailure;

use crate::limit_points::{Outcome, model, strip};

#[test]
fn what_does_not_fit_is_named() -> Outcome {
    let (space, ends) = strip(4)?;
    let forms = |rate: f64| [model(rate).balance(), model(rate).by_rate()];
    let nothing = |_: f64, _: &Solved<2>| Ok(());

    let failed = Continuation::new(&space, forms).constrained(&ends).step(0.0).run(nothing);
    let why = failed.err().ok_or("it is no step")?.why;
    assert!(matches!(why, ContinuationFailure::FirstStep { .. }), "{why}");

    let wrong = |rate: f64| [model(rate).balance(), model(rate).wrong_rate()];
    let failed = Continuation::new(&space, wrong).constrained(&ends).run(nothing);
    let why = failed.err().ok_or("it is another form's rate")?.why;
    assert!(matches!(why, ContinuationFailure::NotTheRate { form: "balance", .. }), "{why}");

    // Nothing determines a constant.
    let failed = Continuation::new(&space, forms).run(nothing);
    let error = failed.err().ok_or("nothing holds it")?;
    assert!(matches!(error.why, ContinuationFailure::Singular { .. }), "{error}");

    // A measurement that fails ends the branch, which is handed back.
    let mut count = 0;
    let failed = Continuation::new(&space, forms).constrained(&ends).step(0.1).run(|_, _| {
        count += 1;
        if count == 3 { Err("enough".into()) } else { Ok(count) }
    });
    let error = failed.err().ok_or("the measurement fails")?;
    assert!(matches!(error.why, ContinuationFailure::Measurement(_)), "{error}");
    assert_eq!(error.branch.points.iter().map(|point| point.measured).collect::<Vec<_>>(), [1, 2]);

    let branch = Continuation::new(&space, forms).constrained(&ends).points(12).run(nothing)?;
    let limit = branch.limit_points().next().ok_or("no limit point")?;
    let failed = Continuation::new(&space, forms).constrained(&ends).switched(limit, 0, 0.1).run(nothing);
    let why = failed.err().ok_or("a limit point has no other branch")?.why;
    assert!(matches!(why, ContinuationFailure::NoMode { number: 0, known: 0 }), "{why}");
    Ok(())
}

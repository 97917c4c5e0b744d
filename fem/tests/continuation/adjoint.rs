//! Adjoint states on the unstable part of a branch, after continuation.

use forms_fem::prelude::*;

use crate::limit_points::{Outcome, model, strip};

#[test]
fn the_derivative_of_a_total_beyond_the_limit_point() -> Outcome {
    let (space, ends) = strip(8)?;
    let forms = |rate: f64| [model(rate).balance(), model(rate).by_rate()];
    let mut found = None;
    Continuation::new(&space, forms)
        .constrained(&ends)
        .points(30)
        .until(|_, solved| solved.field().values().iter().any(|u| *u > 3.0))
        .run(|rate, solved| {
            found = Some((rate, solved.field().clone()));
            Ok(())
        })?;
    let (rate, u) = found.ok_or("no point")?;
    assert!(rate < 3.0, "{rate}");
    let total = |rate: f64| -> Result<f64, Box<dyn std::error::Error>> {
        let solved = Problem::new(&model(rate).balance(), &space)
            .constrained(&ends)
            .start(&u)
            .options(NewtonOptions { relative_tolerance: 1e-13, ..NewtonOptions::default() })
            .solve()?;
        Ok(solved.functional(&model(rate).total(solved.field()))?)
    };
    // K p = −∂J/∂u, dJ/dλ = p · ∂R/∂λ.
    let p = Problem::new(&model(rate).adjoint(&u), &space).homogeneous(&ends).solve()?;
    let by_adjoint = p.functional(&model(rate).by_rate_of_total(&u, p.field()))?;
    let step = 1e-3;
    let differences = [1.0, 2.0].map(|k| -> Result<f64, Box<dyn std::error::Error>> {
        Ok((total(rate + k * step)? - total(rate - k * step)?) / (2.0 * k * step))
    });
    let [near, far] = differences;
    let (near, far) = (near?, far?);
    let extrapolated = near + (near - far) / 3.0;
    println!("by the adjoint {by_adjoint}, by differences {extrapolated}");
    // The total grows as λ falls.
    assert!(by_adjoint < 0.0 && (by_adjoint - extrapolated).abs() < 1e-8 * by_adjoint.abs());
    Ok(())
}

//! Sums whose parts do not fit.

use forms_fem::assemble::BlockPattern;
use forms_fem::prelude::*;

use super::*;

#[test]
fn what_does_not_fit_is_an_error_with_both_names() -> Outcome {
    let (assembler, space) = setting()?;
    let scalars = Space::scalar(assembler.mesh(), 1)?;
    let heat = form!(|t: Unknown<Scalar>, s: Test<Scalar>| integral(cells("all"), dot(grad(t), grad(s))));
    let flow = viscous::flow(&viscous::data().viscosity(0.7), &viscous::Omega::on("all"));
    let elasticity = solid().elasticity();
    let (u, t) = (Field::zero(&space), Field::zero(&scalars));
    let shape = "`elasticity` and `form` cannot be added: one has `u` of shape [2] where the other has `t` of shape []";
    let count = "`flow` and `elasticity` cannot be added: the unknowns are `u`, `p` and `u`";
    let scalar_load = form!(|s: Test<Scalar>| -> Form { integral(cells("all"), s) });
    let tests = "`elasticity` and `form` cannot be added: one has `v` of shape [2] where the other has `s` of shape []";
    for (sum, expected) in [
        (&elasticity + &heat, shape),
        (2.0 * (&elasticity - &heat), shape),
        (load(Side::Top, 1.0) + (&elasticity + &heat), shape),
        (&flow + &elasticity, count),
        (&elasticity + &scalar_load, tests),
        (f64::NAN * &elasticity + &elasticity, "the factor of `elasticity` is NaN"),
        (&elasticity * f64::INFINITY, "the factor of `elasticity` is inf"),
        (
            std::iter::empty::<Form<2>>().sum(),
            "a sum of no forms has no unknowns and test functions; add it to a form",
        ),
    ] {
        let mut messages = vec![
            assembler.residual(&sum, &[&u], &[&space]).unwrap_err().to_string(),
            assembler.tangent(&sum, &[&u], &[&space]).unwrap_err().to_string(),
            assembler.action(&sum, &[&u], &[&u], &[&space]).unwrap_err().to_string(),
            assembler.active_set(&sum, &[&u]).unwrap_err().to_string(),
            BlockPattern::for_form(&sum, &[&space], &[&space]).unwrap_err().to_string(),
            assembler.residual(&sum, &[&u, &t], &[&space, &scalars]).unwrap_err().to_string(),
        ];
        messages.push(Problem::new(&sum, &space).solve().unwrap_err().to_string());
        messages.push(Problem::new(&sum, [&space, &scalars]).solve().unwrap_err().to_string());
        for message in messages {
            assert!(message.contains(expected), "{message}\n{expected}");
        }
    }
    // An empty list of loads adds nothing.
    let sum = std::iter::empty::<Form<2>>().sum::<Form<2>>() + &elasticity;
    assert_eq!(sum.name(), "elasticity");
    assembler.residual(&sum, &[&u], &[&space])?;
    // Errors of data name the sum and the field.
    let sum = &elasticity + touch("nowhere", 0.1);
    let message = assembler.residual(&sum, &[&u], &[&space]).unwrap_err().to_string();
    assert!(message.contains("`elasticity + nitsche`") && message.contains("nowhere"), "{message}");
    Ok(())
}

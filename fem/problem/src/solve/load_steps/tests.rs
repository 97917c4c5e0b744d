//! Load steps of toy states, and secants of fields.

use super::*;

type Outcome = Result<(), Box<dyn Error>>;

/// Fails for steps above a size.
fn limited(largest: f64) -> impl FnMut(f64, &f64) -> Result<f64, std::num::ParseFloatError> {
    move |factor, before| match (factor - before).abs() > largest {
        true => "too large".parse(),
        false => Ok(factor),
    }
}

#[test]
fn steps_that_succeed_are_those_asked_for() -> Outcome {
    let mut committed = vec![];
    let steps = LoadSteps::through([0.5, 1.0, -0.25]);
    let path = steps.committing(|state: &f64| committed.push(*state)).run(0.0, limited(2.0))?;
    assert_eq!((path.state, &committed[..]), (-0.25, &[0.5, 1.0, -0.25][..]));
    assert_eq!(path.steps.len(), 3);
    let uniform = LoadSteps::uniform(4, 2.0);
    assert_eq!(uniform.factors, [0.5, 1.0, 1.5, 2.0]);
    assert_eq!(uniform.starting_at(1.0).start, 1.0);
    Ok(())
}

#[test]
fn a_failed_step_is_halved_and_grows_again() -> Outcome {
    let mut committed = vec![];
    let mut told = vec![];
    let steps = LoadSteps::through([1.0]);
    // Hard only at the beginning.
    let solve = |factor: f64, before: &f64| limited(if *before < 0.2 { 0.15 } else { 0.5 })(factor, before);
    let path = steps
        .committing(|state: &f64| committed.push(*state))
        .each_attempt(|step| told.push((step.factor, step.failure.is_none())))
        .run(0.0, solve)?;
    assert_eq!(committed, [0.125, 0.25, 0.5, 0.75, 1.0]);
    let expected = [
        (1.0, false),
        (0.5, false),
        (0.25, false),
        (0.125, true),
        (0.25, true),
        (0.5, true),
        (0.75, true),
        (1.0, true),
    ];
    assert_eq!(told, expected);
    assert_eq!(path.steps.len(), expected.len());
    Ok(())
}

#[test]
fn a_limit_load_hands_back_the_last_state() -> Outcome {
    let mut committed = 0.0;
    let limit = |factor: f64, _: &f64| match factor > 0.7 {
        true => "beyond the limit".parse(),
        false => Ok(factor),
    };
    let steps = LoadSteps::through([0.5, 1.0]);
    let error = steps.committing(|state: &f64| committed = *state).run(0.0, limit);
    let error = error.err().ok_or("it has a limit")?;
    assert!((0.7 - 2.0 / 1024.0..=0.7).contains(&error.factor), "{}", error.factor);
    assert_eq!((error.state, committed), (error.factor, error.factor));
    assert!(error.steps.len() < 40);
    let message = error.to_string();
    assert!(message.contains("could not be reached from 0.69") && message.contains("invalid float"));
    assert!(error.source().is_some());
    // What `main` shows of it stays readable: a few attempts, one a line.
    let shown = format!("{error:?}");
    assert!(shown.lines().count() < 12 && shown.lines().all(|line| line.len() < 120), "{shown}");
    assert!(shown.contains("attempts before)") && shown.ends_with(&format!("{:?}", error.why)), "{shown}");
    Ok(())
}

/// The start of each step, and the states at which a step fails from its secant.
fn starts(start_of_steps: StepStart, factors: &[f64]) -> Result<Vec<f64>, String> {
    let mut starts = vec![];
    let steps = LoadSteps::through(factors.iter().copied()).starting_steps_from(start_of_steps);
    let solve = |step: &Increment<'_, f64>| -> Result<f64, String> {
        assert_eq!(step.predicted().is_some(), !starts.is_empty() && start_of_steps == StepStart::Secant);
        assert_eq!(*step.before, 2.0 * step.from);
        starts.push(*step.start());
        Ok(2.0 * step.factor)
    };
    steps.advance(0.0, solve).map_err(|error| error.to_string())?;
    Ok(starts)
}

#[test]
fn steps_begin_on_the_secant_through_the_last_two_states() -> Outcome {
    // States are proportional to factors: a secant ends where the step does, whatever their increments, also backwards.
    let factors = [0.25, 0.5, 1.5, 1.0, -0.25];
    assert_eq!(starts(StepStart::Secant, &factors)?, [0.0, 1.0, 3.0, 2.0, -0.5]);
    assert_eq!(starts(StepStart::LastState, &factors)?, [0.0, 0.5, 1.0, 3.0, 2.0]);
    Ok(())
}

#[test]
fn what_does_not_belong_together_has_no_secant() -> Outcome {
    use crate::mesh::rectangle;
    let mesh = rectangle([0.0; 2], [1.0; 2], [1, 1], crate::element::CellShape::Triangle, 1)?;
    let [linear, quadratic] = [1, 2]
        .map(|degree| crate::space::Space::scalar(&mesh, degree))
        .map(|space| space.map(|s| crate::field::Field::zero(&s)));
    let (linear, quadratic) = (linear?, quadratic?);
    assert!(linear.beyond(&quadratic, 1.0).is_none());
    assert!([linear.clone(), quadratic.clone()].beyond(&[linear.clone(), quadratic], 1.0).is_some());
    assert!(1.0_f64.beyond(&0.0, f64::NAN).is_none());
    Ok(())
}

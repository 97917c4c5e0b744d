//! The hollow cylinder with friction: load steps converge, forces and lengths are what they must be.

use forms_contact::hollow_cylinder::{Friction, Settings, solve};

/// All load steps of all settings converge, and friction stays in its bounds. FORMS_SWEEPS=1: three meshes, two γ₀, more
/// coefficients and paths, 360 runs.
#[test]
fn load_steps_converge_and_friction_stays_in_its_bounds() {
    let all = std::env::var_os("FORMS_SWEEPS").is_some();
    let radials = if all { vec![2, 4, 8] } else { vec![2] };
    let gammas = if all { vec![10.0, 20.0] } else { vec![10.0] };
    let laws = match all {
        true => vec![
            Friction::Coulomb(0.1),
            Friction::Coulomb(0.3),
            Friction::Coulomb(0.6),
            Friction::Tresca(0.2),
            Friction::Tresca(1.0),
        ],
        false => vec![Friction::Coulomb(0.3), Friction::Tresca(0.2)],
    };
    let mut paths = vec![vec![[0.0, -1.0], [0.5, -1.0]], vec![[0.0, -2.0], [0.3, -1.5], [1.0, -1.0]]];
    if all {
        paths.extend([vec![[0.0, -1.0]], vec![[0.5, -1.0]]]);
    }
    for radial in radials {
        for theta in [-1.0, 0.0, 1.0] {
            for &gamma0_over_young in &gammas {
                for &friction in &laws {
                    for pushes in paths.clone() {
                        let settings = Settings {
                            radial,
                            theta,
                            friction,
                            gamma0_over_young,
                            pushes,
                            ..Settings::default()
                        };
                        check(&settings);
                    }
                }
            }
        }
    }
}

fn check(settings: &Settings) {
    let solution = solve(settings).unwrap_or_else(|error| panic!("{settings:?}: {error}"));
    assert_eq!(solution.steps.len(), settings.pushes.len());
    for step in &solution.steps {
        let results = step.friction.expect("friction");
        let lengths = results.stick_length + results.slip_length;
        assert!((lengths - step.contact_length).abs() < 1e-9 * step.contact_length, "{settings:?}");
        // Tresca's bound acts on all of Γ_C, half a circle of radius 30.
        let most = match settings.friction {
            Friction::Coulomb(coefficient) => coefficient * step.contact_force,
            Friction::Tresca(bound) => bound * 30.0 * std::f64::consts::PI,
            Friction::None => 0.0,
        };
        assert!(results.tangential_force.abs() <= most * (1.0 + 1e-6), "{settings:?}: {results:?}");
    }
}

/// Without a horizontal push the force of friction vanishes by symmetry; dragged far it is −κ times the contact force, and
/// against the push to either side.
#[test]
fn friction_opposes_the_push() {
    let run = |pushes: Vec<[f64; 2]>| {
        let settings =
            Settings { radial: 2, friction: Friction::Coulomb(0.2), pushes, ..Settings::default() };
        let solution = solve(&settings).unwrap();
        (solution.contact_force, solution.friction.unwrap())
    };
    let (pressed, still) = run(vec![[0.0, -1.0]]);
    assert!(still.tangential_force.abs() < 1e-9 * pressed, "{still:?}");
    let (right, dragged) = run(vec![[0.0, -1.0], [3.0, -1.0]]);
    assert!((dragged.tangential_force + 0.2 * right).abs() < 1e-9 * right, "{dragged:?}, {right}");
    assert_eq!(dragged.stick_length, 0.0);
    let (left, back) = run(vec![[0.0, -1.0], [-3.0, -1.0]]);
    assert!((left / right - 1.0).abs() < 1e-9 && (back.tangential_force - 0.2 * left).abs() < 1e-9 * left);
}

#[test]
fn settings_without_meaning_are_named() {
    let error = |settings: Settings| solve(&settings).expect_err("an error").to_string();
    let coulomb = Settings { friction: Friction::Coulomb(-0.1), ..Settings::default() };
    assert_eq!(
        error(coulomb),
        "coulomb = -0.1 is not possible: friction must be a finite number, zero or positive"
    );
    let tresca = Settings { friction: Friction::Tresca(f64::NAN), ..Settings::default() };
    assert!(error(tresca).starts_with("tresca = NaN is not possible"));
    let none = Settings { pushes: vec![], ..Settings::default() };
    assert_eq!(error(none), "push = 0 is not possible: the number of load steps is at least 1");
    let far = Settings { pushes: vec![[f64::INFINITY, 0.0]], ..Settings::default() };
    assert_eq!(error(far), "push = inf is not possible: the displacement must be finite");
}

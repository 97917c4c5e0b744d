//! The hollow cylinder with friction: load steps converge, forces and lengths are what they must be.

use forms_contact::hollow_cylinder::{CylinderSolution, Friction, Settings, solve};
use forms_contact::law::ContactLaw;
use forms_contact::laws::frictional_nitsche;
use forms_fem::prelude::*;

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

/// The force of the inner circle on the body after the last load step, with that of the step before as the start of the slip.
fn held(settings: &Settings, solution: &CylinderSolution) -> [f64; 2] {
    let problem = &solution.problem;
    let (slip_stress, friction) = match settings.friction {
        Friction::Tresca(bound) => (bound, 0.0),
        Friction::Coulomb(coefficient) => (0.0, coefficient),
        Friction::None => (0.0, 0.0),
    };
    let earlier = settings.pushes[..settings.pushes.len() - 1].to_vec();
    let before = match earlier.is_empty() {
        true => Field::zero(&problem.space),
        false => {
            let earlier = solve(&Settings { pushes: earlier, ..settings.clone() }).unwrap();
            Field::from_values(&problem.space, earlier.u.values().to_vec()).unwrap()
        }
    };
    let residual = if settings.friction == Friction::None {
        problem.assembler.residual(&problem.law.direct(), &[&solution.u], &[&problem.space])
    } else {
        let data = frictional_nitsche::data_from(problem.law.data.clone())
            .slip_stress(slip_stress)
            .friction(friction)
            .displacement_before(&before);
        let regions =
            frictional_nitsche::Regions::default().gamma_n("outer").gamma_c(problem.law.contact_region());
        let law = frictional_nitsche::Model { data, regions };
        problem.assembler.residual(&law.direct(), &[&solution.u], &[&problem.space])
    };
    let residual = residual.unwrap();
    let inner = problem.space.nodes_on("inner").unwrap();
    [0, 1].map(|axis| inner.iter().map(|node| residual[2 * *node as usize + axis]).sum())
}

/// Balance of the reactions that hold the body with the obstacle's forces; Coulomb's bound holds for the whole force. Without a bound, by either law, θ = 0
/// is the problem without friction. Lifted off, nothing touches, sticks or slips.
#[test]
fn forces_balance_by_odd_combinations() {
    let paths = [
        vec![[0.0, -1.0]],
        vec![[0.3, -1.0]],
        vec![[0.0, -1.0], [0.2, -1.0], [-0.4, -1.2]],
        vec![[0.0, -1.0], [0.5, -1.0], [0.5, 0.4]],
        vec![[0.5, 0.0]],
    ];
    let laws = [Friction::Coulomb(0.3), Friction::Coulomb(0.0), Friction::Tresca(0.5), Friction::Tresca(0.0)];
    for pushes in paths {
        let run = |friction: Friction, theta: f64| {
            let settings =
                Settings { radial: 2, theta, friction, pushes: pushes.clone(), ..Settings::default() };
            let solution = solve(&settings).unwrap_or_else(|error| panic!("{settings:?}: {error}"));
            (settings, solution)
        };
        let (settings, free) = run(Friction::None, 0.0);
        let scale = free.contact_force.max(1.0);
        let [_, up] = held(&settings, &free);
        assert!((up + free.contact_force).abs() < 1e-9 * scale, "{up}, {}", free.contact_force);
        let lifted = pushes.last().is_some_and(|push| push[1] > 0.0);
        assert!(!lifted || free.contact_force == 0.0, "{pushes:?}: {}", free.contact_force);
        for friction in laws {
            let (settings, solution) = run(friction, 0.0);
            let found = solution.friction.unwrap();
            let (label, [along, up]) = (format!("{friction:?}, {pushes:?}"), held(&settings, &solution));
            println!("{label}: {along:.3e} {up:.6} and {found:?}, {}", solution.contact_force);
            assert!((along + found.tangential_force).abs() < 1e-9 * scale, "{label}: {along}, {found:?}");
            assert!((up + solution.contact_force).abs() < 1e-9 * scale, "{label}: {up}");
            let lengths = found.stick_length + found.slip_length;
            assert!((lengths - solution.contact_length).abs() < 1e-9, "{label}: {found:?}");
            match friction {
                Friction::Coulomb(0.0) | Friction::Tresca(0.0) => {
                    assert_eq!(found.tangential_force, 0.0, "{label}");
                    let apart = solution.u.values().iter().zip(free.u.values());
                    let apart = apart.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                    assert!(apart < 1e-9, "{label}: {apart:e} from the problem without friction");
                }
                Friction::Coulomb(coefficient) => {
                    let most = coefficient * solution.contact_force;
                    assert!(found.tangential_force.abs() <= most * (1.0 + 1e-9), "{label}: {found:?}");
                }
                _ => {}
            }
            if lifted {
                assert_eq!((solution.contact_force, lengths), (0.0, 0.0), "{label}");
            }
        }
    }
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

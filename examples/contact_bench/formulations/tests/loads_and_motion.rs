//! A falling bar, friction that turns round, boxes in space and a die that is drawn, compared with closed forms and other programs.

mod rows;

use rows::{quantity, rows};
use serde_json::Value;

/// The rows of a formulation that were solved, by level.
fn solved(all: &[Value], problem: &str, formulation: &str) -> Vec<Value> {
    let is_it = |row: &&Value| row["problem"] == problem && row["formulation"] == formulation;
    let found: Vec<Value> = all.iter().filter(is_it).cloned().collect();
    assert!(!found.is_empty(), "no {formulation} on {problem}");
    found
}

#[test]
fn a_bar_bounces_as_its_waves_say() {
    let problems = "bar_mid_point,bar_massless,bar_backward";
    let formulations = "nitsche θ = 0,augmented,dual";
    let asked = ["--problems", problems, "--formulations", formulations, "--degrees", "1", "--levels", "2"];
    let all = rows(&asked);
    for formulation in ["nitsche θ = 0", "augmented Lagrangian", "dual multipliers (bounds at nodes)"] {
        for problem in problems.split(',') {
            let rows = solved(&all, problem, formulation);
            let off = |level: usize, name: &str, exact: f64| (quantity(&rows[level], name) - exact).abs();
            assert!(off(1, "impulse", 800.0 / 3.0) < 3.0, "{formulation}, {problem}");
            assert!(off(1, "end at t = 2", 5.0 / 3.0) < 0.2, "{formulation}, {problem}");
            assert!(off(1, "end at t = 7/3", 40.0 / 9.0) < 0.3, "{formulation}, {problem}");
        }
        // Without mass at the end, and with damping, the pressure follows 300 t.
        for (problem, most) in [("bar_massless", 30.0), ("bar_backward", 6.5)] {
            let worst = [0, 1].map(|level| {
                quantity(&solved(&all, problem, formulation)[level], "worst error of p for 1.1 < t < 1.6")
            });
            assert!(worst[1] < most && worst[1] < 0.6 * worst[0], "{formulation}, {problem}: {worst:?}");
        }
    }
    // A step begins when the bar touches, so that the gap is zero at both of its ends and the force of exact conditions does no work.
    for formulation in ["augmented Lagrangian", "dual multipliers (bounds at nodes)"] {
        for row in solved(&all, "bar_mid_point", formulation) {
            let change = quantity(&row, "change of the energy/500");
            assert!(change.abs() < 1e-8, "{formulation}: {change:e}");
        }
    }
}

#[test]
fn friction_sticks_and_slips_as_cattaneo_says() {
    let formulations = "nitsche θ = 0,augmented";
    let asked = ["--problems", "cattaneo", "--formulations", formulations, "--degrees", "2", "--levels", "2"];
    let all = rows(&asked);
    for formulation in ["nitsche θ = 0", "augmented Lagrangian"] {
        let rows = solved(&all, "cattaneo", formulation);
        for (level, row) in rows.iter().enumerate() {
            assert!((quantity(row, "P") / 0.1 - 1.0).abs() < 5e-4, "{formulation}");
            assert!((quantity(row, "Q/κP") / 0.6 - 1.0).abs() < 4e-3, "{formulation}");
            let cell = [0.25, 0.125][level];
            assert!(
                (quantity(row, "c/a") - 0.632456).abs() < cell,
                "{formulation}: {}",
                quantity(row, "c/a")
            );
        }
        for name in ["error of τ, Q = 0.6 κP", "error of τ, Q = 0", "error of τ, Q = −0.6 κP"] {
            let errors = [0, 1].map(|level| quantity(&rows[level], name));
            let most = if name.ends_with("Q = 0") { 0.3 } else { 0.035 };
            assert!(errors[1] < most && errors[1] < 0.7 * errors[0], "{formulation}, {name}: {errors:?}");
        }
    }
}

/// Multipliers have larger errors of the traction; those of degree 1 take the least Newton steps, those of degree 2 have half of their errors.
#[test]
fn mortar_friction_sticks_and_slips_as_cattaneo_says() {
    let asked = ["--problems", "cattaneo", "--formulations", "mortar", "--degrees", "2", "--levels", "2"];
    let all = rows(&asked);
    for (formulation, part, steps) in [("mortar, degree 1", 0.8, 20), ("mortar, degree 2", 0.4, 32)] {
        let rows = solved(&all, "cattaneo", formulation);
        assert!((quantity(&rows[1], "P") / 0.1 - 1.0).abs() < 1e-3);
        assert!((quantity(&rows[1], "Q/κP") / 0.6 - 1.0).abs() < 2e-3);
        for (row, cell) in rows.iter().zip([0.25, 0.125]) {
            assert!((quantity(row, "c/a") - 0.632456).abs() < cell);
            // The way back is the way there.
            let [there, back] =
                ["error of τ, Q = 0.6 κP", "error of τ, Q = −0.6 κP"].map(|name| quantity(row, name));
            assert!(
                (there / back - 1.0).abs() < 1e-5 && there < part * cell,
                "{formulation}: {there} {back}"
            );
            assert!(row["answer"]["solved"]["newton"].as_u64() <= Some(steps), "{row}");
        }
    }
}

/// NGSolve's energy with degree 3, ± 0.2 %.
#[test]
fn boxes_in_space_have_the_energy_of_another_program() {
    let formulations = "nitsche θ = 0,mortar";
    let asked = ["--problems", "boxes", "--formulations", formulations, "--degrees", "2", "--levels", "1"];
    let all = rows(&asked);
    for formulation in ["nitsche θ = 0", "nitsche θ = 0, unbiased", "mortar, degree 1", "mortar, degree 2"]
    {
        let row = &solved(&all, "boxes", formulation)[0];
        assert!((quantity(row, "energy 4") / 4.81e-3 - 1.0).abs() < 2e-3, "{row}");
        // From the first touch on the force is proportional to the way.
        let forces =
            [1, 2, 3, 4].map(|k| quantity(row, &format!("reaction {k}")) / (0.025 * k as f64 - 1e-4));
        assert!(forces.iter().all(|force| (force / forces[3] - 1.0).abs() < 1e-6), "{forces:?}");
    }
}

/// On the first mesh with degree 1 the force and the energy of Nitsche's method are met by all that converge to the same solution; a gap that is held open, or
/// pressed, changes both by a part of it.
#[test]
fn boxes_are_pressed_by_each_formulation_alike() {
    let formulations = "nitsche θ = 0,mean gaps,proximal Galerkin,log barrier,exponential,uzawa";
    let asked = ["--problems", "boxes", "--formulations", formulations, "--degrees", "1", "--levels", "1"];
    let all = rows(&asked);
    let of = |formulation: &str| {
        let row = &solved(&all, "boxes", formulation)[0];
        ["reaction 4", "energy 4"].map(|name| quantity(row, name))
    };
    let expected = of("nitsche θ = 0");
    for (formulation, tolerance) in [
        ("mean gaps, nitsche θ = 0", 1e-3),
        ("proximal Galerkin", 1.5e-3),
        ("uzawa", 3e-3),
        ("log barrier, ĝ/d = 0.1", 1e-2),
        ("log barrier, ĝ/d = 0.01", 4e-3),
        ("exponential, c/d = 0.01", 5e-3),
    ] {
        for (found, expected) in of(formulation).into_iter().zip(expected) {
            assert!((found / expected - 1.0).abs() < tolerance, "{formulation}: {found} {expected}");
        }
    }
}

/// GetFEM's numbers at the points of whole facets, with E over the diameter of the same cells.
#[test]
fn the_force_of_a_drawn_die_varies_as_in_another_program() {
    let formulations = "nitsche θ = 0,mortar";
    let asked =
        ["--problems", "drawn_die", "--formulations", formulations, "--degrees", "1", "--levels", "1"];
    let all = rows(&asked);
    let names = ["mean F_y", "(max − min)/mean of F_y", "largest |F_x|/F_y"];
    let of = |formulation: &str| {
        let row = &solved(&all, "drawn_die", formulation)[0];
        names.map(|name| quantity(row, name))
    };
    let getfem = [6.115492241502821, 0.005082883290701795, 0.008086375543280523];
    for (found, expected) in of("nitsche θ = 0, points of whole facets").into_iter().zip(getfem) {
        assert!((found / expected - 1.0).abs() < 1e-8, "{found} {expected}");
    }
    for formulation in ["nitsche θ = 0", "nitsche θ = 0, unbiased"] {
        let [_, across, along] = of(formulation);
        assert!((4e-3..9e-3).contains(&across) && (5e-3..1e-2).contains(&along), "{across} {along}");
    }
    let [_, across, along] = of("mortar, degree 1");
    assert!(across < 6e-3 && along < 4e-3, "{across} {along}");
}

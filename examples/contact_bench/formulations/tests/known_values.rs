//! Known numbers to the digits that are stated for them, on meshes that are fine enough: those that pages name next to a command.

mod rows;

use rows::{quantity, rows};
use serde_json::Value;

/// The rows of a formulation, and not those of its variants.
fn of<'a>(all: &'a [Value], formulation: &str) -> Vec<&'a Value> {
    let found: Vec<&Value> = all.iter().filter(|row| row["formulation"] == formulation).collect();
    assert!(!found.is_empty(), "no {formulation}");
    found
}

/// 277.4 ± 0.1, by NGSolve with degree 4.
#[test]
fn a_half_ball_has_the_known_reaction() {
    let asked = ["--problems", "half_ball", "--formulations", "nitsche", "--degrees", "4", "--levels", "3"];
    let all = rows(&asked);
    for formulation in ["nitsche θ = -1", "nitsche θ = 0", "nitsche θ = 1"] {
        let finest = of(&all, formulation)[2];
        assert!((quantity(finest, "reaction") - 277.4).abs() < 0.1, "{formulation}");
        assert!((quantity(finest, "energy") - 5.274).abs() < 5e-4, "{formulation}");
        assert!((quantity(finest, "contact radius") - 0.150).abs() < 1e-3, "{formulation}");
    }
    let asked = ["--problems", "half_ball", "--formulations", "proximal", "--degrees", "3", "--levels", "2"];
    let all = rows(&asked);
    for formulation in ["proximal Galerkin", "proximal Galerkin, one step each"] {
        let finest = of(&all, formulation)[1];
        assert!((quantity(finest, "reaction") - 277.4).abs() < 0.1, "{formulation}");
        assert!((quantity(finest, "energy") - 5.274).abs() < 5e-4, "{formulation}");
    }
}

/// Westergaard's largest pressures to 10⁻⁵, from small to full contact.
#[test]
fn wavy_surfaces_have_the_largest_pressures_of_their_closed_form() {
    let problems = "wavy_0.05,wavy_0.2,wavy,wavy_0.8,wavy_1.2";
    let formulations = "nitsche θ = 0";
    let asked = ["--problems", problems, "--formulations", formulations, "--degrees", "3", "--levels", "2"];
    let all = rows(&asked);
    for problem in problems.split(',') {
        let is_it = |row: &&Value| row["problem"] == problem && row["level"] == 1;
        let row = all.iter().find(is_it).expect("a row");
        let quantities = row["answer"]["solved"]["quantities"].as_array().expect("quantities");
        for number in quantities {
            let [value, exact] = ["value", "exact"].map(|name| number[name].as_f64().expect("a number"));
            assert!((value / exact - 1.0).abs() < 1e-5, "{problem}: {number}");
        }
    }
}

/// CalculiX 2.20 with dual mortar, on as many cells.
#[test]
fn two_squares_have_the_displacements_of_another_program() {
    let formulations = "nitsche θ = 0";
    let asked = ["--problems", "squares", "--formulations", formulations, "--degrees", "1", "--levels", "3"];
    let all = rows(&asked);
    let finest = of(&all, "nitsche θ = 0")[2];
    assert_eq!(finest["unknowns"], 17_524);
    for (name, known, tolerance) in [
        ("u_x(9.6667)", 4.735e-4, 1e-4),
        ("u_y(9.6667)", -1.0478e-3, 1e-4),
        ("u_x(5.5)", 4.983e-5, 5e-4),
        ("u_y(5.5)", -4.6762e-4, 5e-4),
    ] {
        assert!((quantity(finest, name) / known - 1.0).abs() < tolerance, "{name}: {finest}");
    }
}

/// 4.589 ± 0.001 by felupe and NGSolve; on the third mesh it is 0.003 off. With FORMS_SWEEPS on the fourth.
#[test]
fn a_fine_half_ring_has_the_known_force() {
    let [levels, tolerance] = match std::env::var_os("FORMS_SWEEPS") {
        Some(_) => ["4", "0.001"],
        None => ["3", "0.003"],
    };
    let asked = ["--problems", "half_ring", "--formulations", "dual", "--degrees", "2", "--levels", levels];
    let force = quantity(rows(&asked).last().expect("a row"), "F(2)");
    assert!((force - 4.589).abs() < tolerance.parse().expect("a number"), "{force}");
}

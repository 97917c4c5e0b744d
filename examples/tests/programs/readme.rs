//! The programs of README and of the page on contact: what they show is what is compiled and run here, and its numbers are right.

use std::process::Command;

const README: &str = include_str!("../../../README.md");
const CONTACT: &str = include_str!("../../../docs/contact_with_adjoint.md");

/// Runs a program that a page shows.
fn run(page: &str, program: &str, text: &str) -> String {
    let block = format!("```rust\n{text}```\n");
    assert!(page.contains(&block), "the page does not show this program:\n{text}");
    let output = Command::new(program).output().expect("the program starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn numbers(printed: &str) -> Vec<f64> {
    let words = printed.split(|character: char| !character.is_ascii_digit() && !".-e".contains(character));
    words.filter_map(|word| word.parse().ok()).collect()
}

#[test]
fn contact_with_its_adjoint() {
    let printed = run(CONTACT, env!("CARGO_BIN_EXE_readme_contact"), include_str!("../../readme/contact.rs"));
    let numbers = numbers(&printed);
    let [energy, steps, across, up] = numbers[..] else { panic!("{printed}") };
    // Energy is stored, Newton's method ends in a few steps, and p is as symmetric as the block and its obstacle.
    assert!(energy > 0.0 && steps < 12.0, "{printed}");
    assert!(up < -1e-3 && across.abs() < 1e-11 * up.abs(), "{printed}");
}

#[test]
fn a_stretched_bar_of_rubber() {
    let text = include_str!("../../readme/rubber.rs");
    assert!(text.lines().count() <= 35);
    let stress = numbers(&run(README, env!("CARGO_BIN_EXE_readme_rubber"), text));
    // Between a bar that is free across (0.5 to 0.6) and one that is held all along: F = diag(1.25, 1, 1).
    let held = 1.25 - 1.0 / 1.25 + 3.0 * 1.25_f64.ln() / 1.25;
    assert!(stress.len() == 9 && stress[0] > 0.4 && stress[0] < held, "{stress:?}, held {held}");
    // In the middle of a symmetric bar there is no shear, and both directions across are alike.
    assert!([1, 2, 3, 5, 6, 7].iter().all(|k| stress[*k].abs() < 1e-12 * stress[0]), "{stress:?}");
    assert!(
        (stress[4] - stress[8]).abs() < 1e-12 * stress[0] && stress[4].abs() < 0.05 * stress[0],
        "{stress:?}"
    );
}

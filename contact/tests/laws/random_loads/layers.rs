//! Random runs of layers on a flat, whose answer is known whatever the start: wear, and Uzawa's iteration.

use forms_contact::laws::uzawa;
use forms_contact::laws::wear;
use forms_contact::uzawa::{UzawaError, UzawaOptions, solve_by_uzawa};
use forms_fem::prelude::*;

use super::{Case, all, bound, case};
use crate::layer::{Inside, Layer, WIDTH, plane_layers};
use crate::setting::{LAMBDA, MU, YOUNG, data};

/// Of the layer of height 1 against compression.
pub const STIFFNESS: f64 = LAMBDA + 2.0 * MU;

/// Tractions are right to this \[stress\]: 10⁻⁹ of those of a strain of 0.01.
pub const TOLERANCE: f64 = 1e-11 * YOUNG;

/// The tractions (τ, −p) at the top of a layer that is compressed by δ, and sheared by U unless it slips.
pub fn answer(case: &Case, down: f64, aside: f64) -> [f64; 2] {
    let pressure = STIFFNESS * down.max(0.0);
    let most = bound(case.friction, pressure);
    [(MU * aside).clamp(-most, most), -pressure]
}

/// The top's traction is the answer.
pub fn compare(case: &Case, reaction: &[f64], expected: [f64; 2]) {
    for (found, expected) in reaction.iter().map(|force| force / WIDTH).zip(expected) {
        assert!((found - expected).abs() < TOLERANCE, "{case:?}: {found} is not {expected}");
    }
}

/// Newton's method that continues down to rounding: a start that is noise has a large residual.
pub fn to_rounding() -> NewtonOptions {
    NewtonOptions {
        relative_tolerance: 1e-12,
        line_search: LineSearch::OnResidual,
        ..NewtonOptions::default()
    }
}

fn layer() -> Layer<2> {
    plane_layers(Inside::Distorted).remove(0)
}

#[test]
fn a_layer_that_wears() {
    let layer = layer();
    let assembler = Assembler::new(&layer.mesh).with_quadrature(Quadrature::Degree(4));
    all(7, |random| {
        let case = case(random);
        let depth = random.between(0.0, 0.01);
        let sliding = random.between(-0.02, 0.02);
        let worn = assembler.history(Entity::Facets, "bottom", 4, depth).unwrap();
        let base = data(case.friction, case.theta, case.gamma0);
        let data = wear::data_from(base).wear_rate(1e-3).worn(worn).sliding([sliding, 0.0]);
        let regions = wear::Regions::default().gamma_n("right").gamma_c("bottom");
        let problem = layer.problem(wear::Model { data, regions }, case.aside, case.down);
        let start = random.start(&layer.space, 0.02);
        let solved = match problem.direct().unwrap().options(to_rounding()).start(&start).solve() {
            Ok(solved) => solved,
            Err(error) => {
                assert!(error.to_string().contains("failed at iteration"), "{case:?}: {error}");
                println!("{case:?}: {error}");
                return false;
            }
        };
        // A flat that moves by S is a top that moves by −S.
        let expected = answer(&case, case.down - depth, case.aside - sliding);
        compare(&case, &solved.reaction("top").unwrap(), expected);
        true
    });
}

#[test]
fn uzawas_iteration() {
    let layer = layer();
    let assembler = Assembler::new(&layer.mesh).with_quadrature(Quadrature::Degree(4));
    all(8, |random| {
        let case = case(random);
        // Any multiplier to begin with, also one that pulls.
        let first = [3.0 * random.next(), 3.0 * random.next()];
        let multiplier = assembler.history(Entity::Facets, "bottom", 4, first).unwrap();
        let data = uzawa::data_from(data(case.friction, case.theta, case.gamma0)).multiplier(multiplier);
        let regions = uzawa::Regions::default().gamma_n("right").gamma_c("bottom");
        let problem = layer.problem(uzawa::Model { data, regions }, case.aside, case.down);
        let start = random.start(&layer.space, 0.02);
        let options = UzawaOptions { tolerance: 1e-13, ..UzawaOptions::default() };
        match solve_by_uzawa(&problem, &start, options, |_| ()) {
            Ok(found) => {
                let expected = answer(&case, case.down, case.aside);
                compare(&case, &found.solved.reaction("top").unwrap(), expected);
                true
            }
            Err(error) => {
                assert!(!matches!(error, UzawaError::Assembly { .. }), "{case:?}: {error}");
                println!("{case:?}: {error}");
                false
            }
        }
    });
}

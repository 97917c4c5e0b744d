//! Random forms: the compiler accepts them, and what it emits agrees with the reference.

use std::collections::BTreeSet;

use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use super::comparison::{Tally, compare};
use super::data::Random;
use super::generator;
use super::source::Source;
use crate::check::builtins::{BUILTINS, CONSTANTS};

/// The same forms in every run; FORMS_SWEEPS=1: all `cases`, else two fifths of them. `PROPTEST_CASES` gives another number of cases,
/// and `PROPTEST_RNG_SEED` others.
fn configuration(cases: u32) -> ProptestConfig {
    // A failure is made simpler for two minutes, in ms.
    let mut configuration =
        ProptestConfig { max_shrink_iters: 2048, max_shrink_time: 120_000, ..ProptestConfig::default() };
    if std::env::var_os("PROPTEST_CASES").is_none() {
        let all = std::env::var_os("FORMS_SWEEPS").is_some();
        configuration.cases = if all { cases } else { cases * 2 / 5 };
    }
    if std::env::var_os("PROPTEST_RNG_SEED").is_none() {
        configuration.rng_seed = RngSeed::Fixed(2026);
    }
    configuration
}

fn check(list: &[u32], dimension: usize, seed: u64) -> Result<Tally, TestCaseError> {
    let text = generator::module(list, dimension);
    let source = Source::new(dimension, &text);
    compare(&source, seed).map_err(|difference| TestCaseError::fail(format!("{difference}\n{text}")))
}

proptest! {
    #![proptest_config(configuration(100))]

    #[test]
    fn in_2d(list in prop::collection::vec(any::<u32>(), 0..200), seed in any::<u64>()) {
        check(&list, 2, seed)?;
    }
}

proptest! {
    #![proptest_config(configuration(40))]

    #[test]
    fn in_3d(list in prop::collection::vec(any::<u32>(), 0..150), seed in any::<u64>()) {
        check(&list, 3, seed)?;
    }
}

/// Choices that do not change from run to run.
fn fixed(seed: u64) -> Vec<u32> {
    let mut random = Random(seed);
    (0..200).map(|_| random.bits() as u32).collect()
}

/// Large forms, whose every integral could be planned in many ways, are planned in bounded work; without an end these took half
/// a minute to a minute.
#[test]
fn no_form_is_planned_for_long() {
    for seed in [559, 1_000_171] {
        let mut random = Random(u64::wrapping_mul(seed, 0x9e37_79b9_7f4a_7c15));
        let length = random.bits() as usize % 150;
        let list: Vec<u32> = (0..length).map(|_| random.bits() as u32).collect();
        let work = Source::new(3, &generator::module(&list, 3)).work();
        assert!((1_000_000..60_000_000).contains(&work), "seed {seed}: {work} nodes were looked at");
    }
}

/// Operators that random forms do not hold, with the test that compares them with outside values instead.
const TESTED_ELSEWHERE: &[(&str, &str)] = &[
    ("tensor_exp", "forms-core/tests/externals/spectral.rs: outside the compiled code, with no dual numbers"),
    ("tensor_ln", "forms-core/tests/externals/spectral.rs"),
    ("tensor_sqrt", "forms-core/tests/externals/spectral.rs"),
    ("means", "fem/tests/facet_means.rs: values by hand, differences; random forms have no contact pairs"),
];

#[test]
fn every_operator_is_generated() {
    let mut words = BTreeSet::new();
    for seed in 0..2000 {
        for dimension in [2, 3] {
            let text = generator::module(&fixed(seed), dimension);
            let split = text.split(|character: char| !character.is_alphanumeric() && character != '_');
            words.extend(split.map(ToString::to_string));
        }
    }
    let names = BUILTINS.iter().map(|entry| entry.0).chain(CONSTANTS.iter().map(|entry| entry.0));
    let elsewhere = |name: &&str| TESTED_ELSEWHERE.iter().any(|(known, _)| known == name);
    let missing: Vec<_> =
        names.filter(|name| !words.contains(*name)).filter(|name| !elsewhere(name)).collect();
    assert!(
        missing.is_empty(),
        "operators that no random form holds: {missing:?}; add a template to proof/generator/templates.rs, \
         and their meaning to reference/evaluator.rs"
    );
}

/// Random data are mostly regular points: what is left out as badly conditioned is the smaller part.
#[test]
fn most_numbers_are_compared() {
    let mut all = Tally::default();
    for seed in 0..20 {
        let tally = check(&fixed(seed), 2, seed).unwrap_or_else(|difference| panic!("{difference}"));
        all.compared += tally.compared;
        all.skipped += tally.skipped;
    }
    assert!(all.compared > 4 * all.skipped, "{all:?}");
}

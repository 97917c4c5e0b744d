//! Random problems: none is answered wrongly, and none is refused that LU solves.

use super::kinds::{self, Kind};
use super::reference::Outcome;

/// Numbers that look random, the same for each seed (xorshift).
pub struct Numbers(u64);

impl Numbers {
    /// The numbers of a seed.
    pub fn new(seed: u64) -> Self {
        let mut numbers = Numbers(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
        (0..4).for_each(|_| {
            numbers.next();
        });
        numbers
    }

    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    /// One from 0 to 1.
    pub fn part(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// One in a range.
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.part()
    }

    /// One of several.
    pub fn choice(&mut self, count: usize) -> usize {
        (self.next() >> 20) as usize % count
    }

    /// A power of ten with an exponent in a range.
    pub fn power(&mut self, low: f64, high: f64) -> f64 {
        10_f64.powf(self.within(low, high))
    }
}

/// Problems of each kind: two thousand in all, or as many times as `FORMS_SWEEPS` asks for.
fn seeds() -> u64 {
    let all = (2000 / kinds::ALL.len() as u64) + 1;
    if std::env::var_os("FORMS_SWEEPS").is_some() { 5 * all } else { all }
}

fn run(kinds: &[(&str, Kind)]) {
    let mut failures = Vec::new();
    println!("{:<14} {:>6} {:>7} {:>6} {:>8}", "kind", "right", "refused", "wrong", "refusals");
    let only = std::env::var("FORMS_KIND").ok();
    for (name, kind) in kinds.iter().filter(|(name, _)| only.as_deref().is_none_or(|only| only == *name)) {
        let (mut right, mut refused, mut wrong, mut wrongly) = (0, 0, 0, 0);
        for seed in 0..seeds() {
            let (described, outcome) = kind(&mut Numbers::new(seed + 1));
            match outcome {
                Outcome::Right => right += 1,
                Outcome::Refused { why } => {
                    refused += 1;
                    if std::env::var_os("FORMS_SHOW").is_some() {
                        println!("{name} {seed}: {described}: {why}");
                    }
                }
                Outcome::Wrong { error } => {
                    wrong += 1;
                    failures.push(format!("{name} {seed}: {described}: off by {error:.1e}"));
                }
                Outcome::WronglyRefused { why } => {
                    wrongly += 1;
                    failures.push(format!("{name} {seed}: {described}: refused though LU solves it: {why}"));
                }
            }
        }
        println!("{name:<14} {right:>6} {refused:>7} {wrong:>6} {wrongly:>8}");
    }
    assert!(failures.is_empty(), "{} of them:\n{}", failures.len(), failures.join("\n"));
}

#[test]
fn no_answer_is_wrong_and_no_right_one_is_refused() {
    run(&kinds::ALL);
}

/// Conduction with an offset of 10⁵ to 10⁷ next to a contrast of 10⁷ to 10¹⁵: corrections below 10⁻⁶ of the offset are as large as the
/// variation of the solution.
#[test]
fn an_offset_is_no_scale_of_rounding() {
    let (_, conduction) = kinds::ALL.iter().find(|(name, _)| *name == "conduction").unwrap();
    for seed in [2461, 7033, 9513, 9842, 10045] {
        let (described, outcome) = conduction(&mut Numbers::new(seed + 1));
        assert!(
            !matches!(outcome, Outcome::Wrong { .. } | Outcome::WronglyRefused { .. }),
            "{described}: {outcome:?}"
        );
    }
}

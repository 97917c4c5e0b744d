//! The forms of the paper, as they stand in the repository.

use super::comparison::compare;
use super::source::Source;
use crate::reuse::flatten::flatten;

#[test]
fn the_forms_of_the_paper() {
    let text = flatten(
        include_str!("../../../../contact/src/nitsche.rs"),
        "nitsche",
        include_str!("../../../../contact/src/operators.rs"),
    );
    for dimension in [2, 3] {
        let source = Source::new(dimension, &text);
        let mut compared = 0;
        for seed in 0..4 {
            compared += compare(&source, seed).unwrap_or_else(|difference| panic!("{difference}")).compared;
        }
        assert!(compared > 1000, "{compared} numbers compared");
    }
}

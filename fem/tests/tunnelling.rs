//! Motions on which points would pass through the opposite body: what is refused, and what is not, on two squares.

use forms_fem::pairs::{FollowedMotion, PairError};
use forms_fem::prelude::*;

use crate::sliding_pairs::boxes;

/// The initial gap.
const GAP: f64 = 0.1;
/// The longest facet of the squares, which are 1 thick; the reach is twice that.
const FACET: f64 = 0.25;

struct Squares {
    space: Arc<Space<2>>,
    assembler: Assembler<2>,
}

impl Squares {
    fn new() -> Squares {
        let mesh = boxes([4, 4], [0.0, GAP]);
        Squares { space: Space::vector(&mesh, 1).unwrap(), assembler: Assembler::new(&mesh) }
    }

    /// The upper square goes from where it is by one way to the end of another.
    fn follow(
        &self,
        pairing: &Pairing,
        from: [f64; 2],
        to: [f64; 2],
    ) -> Result<FollowedMotion<2>, PairError> {
        let [from, to] = [from, to].map(|way| {
            let upper = |x: &[f64; 2]| if x[1] > 1.0 + 0.5 * GAP { way } else { [0.0, 0.0] };
            Field::interpolate(&self.space, upper).unwrap()
        });
        self.assembler.follow(pairing, 3, &from, &to)
    }
}

#[test]
fn what_contact_sees_is_no_tunnelling() {
    let squares = Squares::new();
    for pairing in [Pairing::onto("below", "above"), Pairing::between("below", "above")] {
        let pressed = squares.follow(&pairing, [0.0; 2], [0.0, -GAP - 0.2]).unwrap();
        assert!((pressed.deepest_overlap - 0.2).abs() < 1e-14, "{pressed:?}");
        assert!((pressed.relative_motion - GAP - 0.2).abs() < 1e-14, "{pressed:?}");
        assert!((pressed.visible_depth - 2.0 * FACET).abs() < 1e-14, "{pressed:?}");
        // Along the surface, off its end, and away.
        for to in [[0.7, -GAP - 0.01], [3.0, -GAP - 0.01], [0.0, 9.0]] {
            squares.follow(&pairing, [0.0; 2], to).unwrap();
        }
    }
}

#[test]
fn deeper_than_half_of_what_contact_sees() {
    let squares = Squares::new();
    let near = Pairing::onto("below", "above");
    // A reach of more than a thickness lets the thickness decide.
    let wide = Pairing::onto("below", "above").within_reach(3.0);
    for (pairing, visible) in [(&near, 2.0 * FACET), (&wide, 1.0)] {
        let sinks = |depth: f64| squares.follow(pairing, [0.0; 2], [0.0, -GAP - depth]);
        assert!(sinks(0.49 * visible).is_ok());
        for depth in [0.51 * visible, 2.0 * visible, 5.0 * visible] {
            let error = sinks(depth).unwrap_err();
            let PairError::Tunnelling { position, depth: found, visible: seen, part } = &error else {
                panic!("{error}");
            };
            assert!((seen - visible).abs() < 1e-14 && position[1] == 1.0, "{error}");
            // The first place where it is too deep, which the motion tells.
            assert!((found - (part * (GAP + depth) - GAP)).abs() < 1e-13, "{error}");
            assert!(*found > 0.5 * visible && *found < 0.65 * visible, "{error}");
        }
    }
}

/// The end is above the lower square again, or next to it, and all that is wrong lies on the way.
#[test]
fn the_way_counts_and_not_the_end() {
    let squares = Squares::new();
    let pairing = Pairing::between("below", "above");
    // From the left and above to the right and below: at both ends nothing faces anything.
    let beside = squares.follow(&pairing, [-2.0, 2.0], [2.0, -2.5]);
    assert!(matches!(beside, Err(PairError::Tunnelling { .. })), "{beside:?}");
    // The same ends around the square.
    for ends in [[-2.0, 2.0], [2.0, 2.0], [2.0, -2.5]].windows(2) {
        squares.follow(&pairing, ends[0], ends[1]).unwrap();
    }
    let far = squares.follow(&pairing, [0.0; 2], [0.0, 100.0]);
    assert!(matches!(far, Err(PairError::TooFar { .. })), "{far:?}");
}

#[test]
fn bodies_that_move_together_have_not_moved() {
    let squares = Squares::new();
    let zero = Field::zero(&squares.space);
    let away = Field::interpolate(&squares.space, |_: &[f64; 2]| [300.0, -40.0]).unwrap();
    let followed = squares.assembler.follow(&Pairing::between("below", "above"), 3, &zero, &away).unwrap();
    assert_eq!((followed.places, followed.deepest_overlap), (1, 0.0));
    let elsewhere = Field::zero(&Space::vector(squares.space.mesh(), 2).unwrap());
    let error = squares.assembler.follow(&Pairing::onto("below", "above"), 3, &zero, &elsewhere);
    assert_eq!(error, Err(PairError::TwoSpaces));
}

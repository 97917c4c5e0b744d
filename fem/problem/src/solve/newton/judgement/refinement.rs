//! Iterative refinement of iterates whose rows hold: the corrections that were made, and whether they become shorter.

use crate::solve::newton::Origin;

/// Corrections that become shorter by less than this factor do not converge any more.
const SHORTER: f64 = 0.5;

/// Most times that components are made zero.
const ZEROINGS: usize = 3;

/// Most corrections of iterates that switched.
const SWITCHES: usize = 20;

/// The last change of all unknowns.
pub(in crate::solve::newton) struct LastChange {
    pub values: Vec<f64>,
    pub origin: Origin,
}

/// Reasons for a correction, whatever its size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reason {
    /// The tolerance is below the rounding of rows: it asks for what one more solve can give.
    ToleranceBelowRounding,
    /// The rows hold only up to the rounding of a long step.
    LongStep,
    /// Components are zero but for rounding.
    VanishingComponents,
    /// Points switched with the last step, so that the correction is a step of Newton's method.
    Switch,
}

impl Reason {
    /// Most corrections for this reason.
    fn most(self) -> usize {
        match self {
            Reason::ToleranceBelowRounding | Reason::LongStep => 1,
            Reason::VanishingComponents => ZEROINGS,
            Reason::Switch => SWITCHES,
        }
    }
}

/// The smallest correction so far, as a part of what is allowed, and how many corrections after it were no shorter.
#[derive(Clone, Copy, Debug)]
struct Contraction {
    least: f64,
    stalls: usize,
}

/// State of the refinement.
#[derive(Clone, Debug, Default)]
pub(in crate::solve::newton) struct Refinement {
    /// The reasons of corrections that were made whatever their size.
    made: Vec<Reason>,
    contraction: Option<Contraction>,
}

impl Refinement {
    /// Whether another correction may be made for a reason.
    pub(super) fn allows(&self, reason: Reason) -> bool {
        self.made.iter().filter(|made| **made == reason).count() < reason.most()
    }

    /// Takes down that a correction is made for a reason.
    pub(super) fn enter(&mut self, reason: Reason) {
        self.made.push(reason);
    }

    /// Takes down the size of a correction. Number of those before it, and with it, that did not become shorter.
    pub(super) fn stalls(&mut self, size: f64) -> usize {
        let contraction = match self.contraction {
            Some(Contraction { least, stalls }) if size > SHORTER * least => {
                Contraction { least: least.min(size), stalls: stalls + 1 }
            }
            _ => Contraction { least: size, stalls: 0 },
        };
        self.contraction = Some(contraction);
        contraction.stalls
    }
}

#[cfg(test)]
mod tests {
    use super::{Reason, Refinement};

    #[test]
    fn corrections_are_counted_by_reason_and_by_size() {
        let mut refinement = Refinement::default();
        refinement.enter(Reason::LongStep);
        assert!(!refinement.allows(Reason::LongStep) && refinement.allows(Reason::ToleranceBelowRounding));
        for _ in 0..3 {
            assert!(refinement.allows(Reason::VanishingComponents));
            refinement.enter(Reason::VanishingComponents);
        }
        assert!(!refinement.allows(Reason::VanishingComponents));
        // One that is shorter than half of the shortest begins anew.
        let stalls = [8.0, 5.0, 3.0, 9.0, 1.0, 1.0].map(|size| refinement.stalls(size));
        assert_eq!(stalls, [0, 1, 2, 3, 0, 1]);
    }
}

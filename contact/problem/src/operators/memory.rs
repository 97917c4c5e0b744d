//! Friction that remembers: what an own point of a pair that slides keeps from step to step is a history.

use forms_fem::forms;

/// Coulomb's law regularised by tangential springs that remember, as perfect elastoplasticity with radial return (Simo and Laursen 1992):
/// the elastic slip e adds up over the steps, friction is −ε F e up to its bound, and what is beyond the bound slides.
///
/// e is a vector of the undeformed own surface, so that it turns and stretches with the own body. The slip of a step is added as
/// [`reference_slip`](fn@super::sliding::reference_slip). Turning both bodies together changes e not at all.
#[forms]
pub mod elastic_slip {
    use super::super::friction::ball_projection;

    /// Friction with its springs.
    #[includes(super::super::friction::Data)]
    pub struct Data {
        /// ε, stiffness of the tangential springs \[stress/length\].
        #[doc(alias = "ε")]
        pub stick_stiffness: Given<Scalar>,
        /// e, the elastic slip after the last step \[length\], zero at the start: made by
        /// [`history_on_sliding_pairs`](forms_fem::prelude::Assembler::history_on_sliding_pairs).
        #[doc(alias = "e")]
        pub elastic_slip: History<Vector>,
    }

    /// Π_s(−ε F e), the traction of friction on the own body for the elastic slip e if nothing slides in the step, with the bound s.
    pub fn spring_traction(F: Tensor, trial: Vector, stiffness: Scalar, bound: Scalar) -> Vector {
        ball_projection(-stiffness * (F * trial), bound)
    }

    /// The elastic slip of springs that bear a traction. Zero where nothing presses.
    pub fn slip_of(F: Tensor, traction: Vector, stiffness: Scalar) -> Vector {
        -(inv(F) * traction) / stiffness
    }
}

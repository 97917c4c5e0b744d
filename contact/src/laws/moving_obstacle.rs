//! The motion of a rigid obstacle between two steps, for laws that know the obstacle by its signed distance φ.

use forms_fem::forms;

#[doc(inline)]
pub use self::moving_obstacle::*;

/// An obstacle whose own point ŷ is at y = c + Q ŷ, and was at c₀ + Q₀ ŷ at the last step. A law with an obstacle of its own shape includes these
/// data, imports these operators and brings φ(ŷ): [`capsule`](super::capsule) in Rust,
/// [`analytic_obstacle`](super::analytic_obstacle) in the language.
#[forms]
pub mod moving_obstacle {
    /// Data of the body, the method and the obstacle's motion.
    #[includes(
        crate::operators::linear_elastic::Data,
        crate::operators::penalty::Data,
        crate::operators::friction::Data,
        crate::operators::linear_criterion::Data
    )]
    pub struct Data {
        /// c, the obstacle's centre \[length\].
        #[doc(alias = "c")]
        pub centre: Param<Vector>,
        /// Q, the obstacle's rotation.
        #[doc(alias = "Q")]
        pub rotation: Param<Tensor>,
        /// c₀, the centre at the last step \[length\].
        #[doc(alias = "c₀")]
        pub centre_before: Param<Vector>,
        /// Q₀, the rotation at the last step.
        #[doc(alias = "Q₀")]
        pub rotation_before: Param<Tensor>,
    }

    /// ŷ = Qᵀ(y − c), a point of space in the obstacle's own axes.
    pub fn in_own_axes(y: Vector) -> Vector {
        transpose(rotation) * (y - centre)
    }

    /// The slip of the displaced point x + w against the obstacle's own points since the last step:
    /// (x + w − c) − Q Q₀ᵀ (x + u₀ − c₀) \[length\].
    pub fn slip(w: Vector) -> Vector {
        x + w - centre - rotation * (transpose(rotation_before) * (x + displacement_before - centre_before))
    }
}

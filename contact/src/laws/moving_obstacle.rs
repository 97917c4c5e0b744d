//! The motion of a rigid obstacle between two steps, for laws that know the obstacle by its signed distance φ.

use forms_fem::forms;

/// An obstacle whose own point ŷ is at y = c + Q ŷ, and was at c₀ + Q₀ ŷ at the last step. A law with an obstacle of its own shape extends this
/// data, imports these operators and brings φ(ŷ): [`capsule`](super::capsule) in Rust,
/// [`analytic_obstacle`](super::analytic_obstacle) in the language.
#[forms]
pub mod moving_obstacle {
    /// Data of the body, the method and the obstacle's motion.
    pub struct Data {
        /// λ \[stress\].
        pub lambda: Param,
        /// μ \[stress\].
        pub mu: Param,
        /// γ₀ \[stress\]; γ = γ₀/h_T.
        pub gamma0: Param,
        /// s₀, the bound of Tresca's law \[stress\].
        #[doc(alias = "s₀")]
        #[default(0)]
        pub slip_stress: Param,
        /// κ, the coefficient of Coulomb's law.
        #[doc(alias = "κ")]
        #[default(0)]
        pub friction: Param,
        /// u₀, the displacement of the last step that converged \[length\].
        #[doc(alias = "u₀")]
        #[default(0)]
        pub displacement_before: Given<Vector>,
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
        /// F of the criterion J = ∫ F·u.
        #[doc(alias = "F")]
        #[default(0)]
        pub criterion_force: Given<Vector>,
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

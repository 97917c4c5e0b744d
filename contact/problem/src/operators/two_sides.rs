//! Forms of deformable bodies that meet at contact pairs: what each of the two sides brings.

use forms_fem::forms;

/// Materials of bodies that touch, and the parameters of the method; each surface takes its own body's σ, h and γ.
#[forms]
pub mod bodies {
    use super::super::linear_elastic::stress;

    /// Materials may differ from cell to cell.
    pub struct Data {
        /// λ, first Lamé parameter \[stress\].
        pub lambda: Given<Scalar>,
        /// μ, shear modulus \[stress\].
        pub mu: Given<Scalar>,
        /// γ₀ \[stress\]; γ = γ₀ / h_T: ten times λ + 2μ of the own body as a rule
        /// (`forms_contact::threshold::usual_gamma0`).
        pub gamma0: Given<Scalar>,
        /// Part of each surface's integral: ½ where both surfaces are integrated over, 1 where one of them is.
        #[default(0.5)]
        pub share: Param,
    }

    /// The surfaces that may touch.
    #[pairs]
    pub struct Touch;

    /// γ = γ₀ / h_T of the own side.
    pub fn own_gamma() -> Scalar {
        this(gamma0) / this(h)
    }

    /// σ(w)n at X.
    pub fn own_traction(w: Vector) -> Vector {
        this(stress(w) * n)
    }

    /// g − ⟦w⟧·n_y, the gap of the displaced surfaces.
    pub fn present_gap(w: Vector) -> Scalar {
        gap - dot(jump(w), toward)
    }
}

/// Contact with friction at pairs that slide, for any material: the traction of the own body at X is an argument,
/// `first_piola(w) * n`. Imported functions are for integrals over `Touch(u)`.
#[forms]
pub mod sliding {
    use super::super::friction::{
        augmented_traction, contact_traction, deformed_normal, slip_limit, tangential,
    };

    /// Friction, and the parameters of the method; each surface takes its own body's h and γ.
    #[includes(super::super::friction::Data)]
    pub struct Data {
        /// γ₀ \[stress\]; γ = γ₀ / h_T.
        pub gamma0: Given<Scalar>,
        /// Part of each surface's integral: ½ where both surfaces are integrated over, 1 where one of them is.
        #[default(0.5)]
        pub share: Param,
    }

    /// The surfaces that may touch.
    #[pairs]
    pub struct Touch;

    /// The slip since the last step: it counts the rotation of the deformed normal, so that turning both bodies together is no slip, whatever
    /// the gap. A vector of the configuration of the last step.
    pub fn slip(w: Vector) -> Vector {
        let turned = toward - this(deformed_normal(displacement_before));
        jump(w - displacement_before) + gap * turned
    }

    /// F₀⁻¹ s_t, the tangential slip since the last step as a vector of the undeformed own surface, with F₀ of the last step.
    pub fn reference_slip(w: Vector) -> Vector {
        let normal_before = this(deformed_normal(displacement_before));
        this(inv(I + grad(displacement_before))) * tangential(slip(w), normal_before)
    }

    /// P, with the slip since the last step.
    #[doc(alias = "P")]
    pub fn augmented(own_traction: Vector, w: Vector) -> Vector {
        augmented_traction(this(own_traction), gap, slip(w), this(gamma0) / this(h), toward)
    }

    /// \[P_n\]₋, the contact pressure per reference area.
    pub fn pressure(own_traction: Vector, w: Vector) -> Scalar {
        neg_part(dot(augmented(own_traction, w), toward))
    }

    /// T, the traction of the opposite body on this one, per reference area.
    #[doc(alias = "T")]
    pub fn traction(own_traction: Vector, w: Vector) -> Vector {
        contact_traction(augmented(own_traction, w), slip_limit(pressure(own_traction, w)), toward)
    }
}

//! Contact between bodies by means over own facets: one pressure and one traction of friction per facet, or per vertex of a facet.

use forms_fem::forms;

/// Contact with friction at pairs that slide, for any material: the mean of the augmented normal stress decides whether a facet presses, the
/// mean of the tangential one whether it sticks. The traction of the own body at X is an argument, `first_piola(w) * n`.
#[forms]
pub mod mean_sliding {
    use super::super::friction::{ball_projection, slip_limit, tangential};
    use super::super::sliding::augmented;

    /// Friction, and the parameters of the method; each surface takes its own body's h and γ.
    #[includes(super::super::sliding::Data)]
    pub struct Data {}

    /// The surfaces that may touch.
    #[pairs]
    pub struct Touch;

    /// \[⟨P_n⟩\]₋, the pressure of the facet.
    fn mean_pressure(own_traction: Vector, w: Vector) -> Scalar {
        neg_part(mean(dot(augmented(own_traction, w), toward)))
    }

    /// ⟨T⟩·⟨e⟩ of a vector with sides, where T has the friction Π_s(⟨P_t⟩) with s by the facet's pressure.
    fn mean_power(own_traction: Vector, w: Vector, e: Vector) -> Scalar {
        let pressure = mean_pressure(own_traction, w);
        let P_t = mean(tangential(augmented(own_traction, w), toward));
        dot(ball_projection(P_t, slip_limit(pressure)), mean(tangential(e, toward)))
            - pressure * mean(dot(toward, e))
    }

    /// −Σ D ⟨T⟩·⟨⟦v⟧⟩ with one mean per own facet: for displacements of degree 1.
    pub fn contact_of_facets(own_traction: Vector, w: Vector, v: Vector) -> Form {
        -means(Touch(w), 0, share * mean_power(own_traction, w, jump(v)))
    }

    /// −Σ D ⟨T⟩·⟨⟦v⟧⟩ with one mean per vertex of an own facet: for displacements of degree 2.
    pub fn contact_of_vertices(own_traction: Vector, w: Vector, v: Vector) -> Form {
        -means(Touch(w), 1, share * mean_power(own_traction, w, jump(v)))
    }

    /// Σ D ⟨T⟩·⟨e⟩ with one mean per own facet: the force along e.
    pub fn force_of_facets(own_traction: Vector, w: Vector, e: Vector) -> Functional {
        means(Touch(w), 0, mean_power(own_traction, w, this(e)))
    }

    /// Σ D ⟨T⟩·⟨e⟩ with one mean per vertex of an own facet: the force along e.
    pub fn force_of_vertices(own_traction: Vector, w: Vector, e: Vector) -> Functional {
        means(Touch(w), 1, mean_power(own_traction, w, this(e)))
    }
}

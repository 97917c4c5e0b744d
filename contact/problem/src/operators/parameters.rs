//! Parameters of methods that impose contact weakly.

use forms_fem::forms;

/// The penalty parameter, on the boundary of one body.
#[forms]
pub mod penalty {
    /// The parameter without the cell's size.
    pub struct Data {
        /// γ₀ \[stress\]; γ = γ₀ / h_T. For Nitsche's method ten times λ + 2μ as a rule
        /// (`forms_contact::threshold::usual_gamma0`); penalty methods take it as stiff as they can.
        pub gamma0: Param,
    }

    /// γ = γ₀ / h_T.
    pub fn gamma() -> Scalar {
        gamma0 / h
    }
}

/// The variant of Nitsche's method.
#[forms]
pub mod variant {
    /// θ = 0 unless it is given.
    pub struct Data {
        /// θ: −1 skew-symmetric, 0 incomplete, 1 symmetric variant.
        #[default(0)]
        pub theta: Param,
    }
}

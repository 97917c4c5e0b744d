//! Discontinuous elements: terms on the facets between cells.

use forms_fem::prelude::*;

/// Poisson's equation by the symmetric interior penalty method, boundary values by Nitsche's.
#[forms]
pub mod diffusion {
    /// The stabilisation, the load and the boundary values.
    pub struct Data {
        /// s, about 10 times the square of the degree.
        pub penalty: Param,
        /// f.
        pub source: Given<Scalar>,
        /// g, the values on the boundary.
        pub boundary_values: Given<Scalar>,
    }

    /// Ω.
    #[cells]
    pub struct Omega;
    /// The facets between cells.
    #[interior_facets]
    pub struct Inner;
    /// ∂Ω.
    #[facets]
    pub struct Boundary;

    /// ∂w/∂n.
    fn slope(w: Scalar) -> Scalar {
        dot(grad(w), n)
    }

    /// {∂w/∂n}.
    fn flux(w: Scalar) -> Scalar {
        dot(avg(grad(w)), n)
    }

    /// ∫ ∇u·∇v − f v + ∫_inner s/{h} ⟦u⟧⟦v⟧ − {∂u/∂n}⟦v⟧ − {∂v/∂n}⟦u⟧ + ∫_∂Ω s/h (u − g) v − ∂u/∂n v − ∂v/∂n (u − g).
    pub fn balance(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        let rest = u - boundary_values;
        integral(Omega, dot(grad(u), grad(v)) - source * v)
            + integral(Inner, penalty / avg(h) * jump(u) * jump(v) - flux(u) * jump(v) - flux(v) * jump(u))
            + integral(Boundary, penalty / h * rest * v - slope(u) * v - slope(v) * rest)
    }
}

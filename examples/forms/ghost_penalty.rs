//! Jumps of derivatives over the facets between cells.

use forms_fem::prelude::*;

/// The ghost penalty of cut elements; with one of its terms the continuous interior penalty of transport.
#[forms]
pub mod stabilisation {
    /// The weights.
    pub struct Data {
        /// g₁, of the first derivatives.
        pub g1: Param,
        /// g₂, of the second ones; elements of degree 1 have none.
        pub g2: Param,
    }

    /// The facets between cells.
    #[interior_facets]
    pub struct Inner;

    /// ⟦∂w/∂n⟧.
    fn kink(w: Scalar) -> Scalar {
        dot(jump(grad(w)), n)
    }

    /// ⟦∂²w/∂n²⟧.
    fn bend(w: Scalar) -> Scalar {
        dot(jump(hess(w)) * n, n)
    }

    /// ∫ g₁ {h} ⟦∂u/∂n⟧⟦∂v/∂n⟧ + g₂ {h}³ ⟦∂²u/∂n²⟧⟦∂²v/∂n²⟧.
    pub fn penalty(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        let size = avg(h);
        integral(Inner, g1 * size * kink(u) * kink(v) + g2 * pow(size, 3) * bend(u) * bend(v))
    }

    /// Its first term alone, for where there are no second derivatives.
    pub fn penalty_of_slopes(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Inner, g1 * avg(h) * kink(u) * kink(v))
    }
}

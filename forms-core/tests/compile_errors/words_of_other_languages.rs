//! Names that UFL, GetFEM, FreeFEM and scikit-fem have for things, and values that are called like functions.

use forms_core::forms;

#[forms(crate = forms_core)]
pub mod words {
    pub struct Data {
        pub gap: Given<Scalar>,
        pub k: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Gamma;

    pub fn called_data(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Gamma, gap(x + u) * dot(v, n)) + integral(Omega, k(u[0] + 1) * u(0) * v[0] + Omega(dot(u, v)))
    }
    pub fn strong(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, (dt(u) - laplace(u) + Grad_u + interpolate(u)) * v)
    }
    pub fn measures(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)) * dx) + integral(Gamma, u * v * dS)
    }
    pub fn tensors(A: State<Tensor>, u: State<Vector>) -> Scalar {
        trace(A) + inner(symgrad(u), A.T) + Det(A) + log(u("+")) + u.dx(0) + conditional(u[0], 1, 2)
    }
    pub fn own_names_come_first(strain_: State<Scalar>) -> Scalar {
        strain + strans(strain_) + y
    }
    fn strain(u: Scalar) -> Scalar {
        u
    }
}

#[forms(crate = forms_core)]
pub mod whole_numbers {
    pub fn last(u: State<Vector>, A: State<Matrix<4, D>>) -> Scalar {
        u[D] + u[D / 2] + A[2 * D - 1][D - 1] + u[D - 3] + tr(identity(D - 3)) + dot(u, [0; D + 14]) + u[D % 2]
    }
}

fn main() {}

//! Both adjoint problems for a criterion ∫_∂Ω N(u) with N(u) = s(x)·u: any load on the boundary. Shows that a
//! user states a criterion that `forms_contact` does not have in a module of their own.

use forms_fem::forms;

/// (14), (21) and (22) for N(u) = s·u.
#[forms]
pub mod adjoint {
    pub use forms_contact::forms::{Boundary, GammaC, Omega};

    /// s, in addition to the data of `forms_contact`.
    #[includes(forms_contact::forms::Data)]
    pub struct Data {
        /// s = N′.
        pub slope: Given<Vector>,
    }

    fn stress(w: Vector) -> Tensor {
        2 * mu * eps(w) + lambda * tr(eps(w)) * I
    }

    fn normal_stress(w: Vector) -> Scalar {
        dot(stress(w) * n, obstacle_normal)
    }

    fn gamma() -> Scalar {
        gamma0 / h
    }

    fn pressure(w: Vector) -> Scalar {
        normal_stress(w) - gamma() * (dot(w, obstacle_normal) - gap)
    }

    fn tested(w: Vector) -> Scalar {
        theta * normal_stress(w) - gamma() * dot(w, obstacle_normal)
    }

    fn elasticity(u: Vector, v: Vector) -> Form {
        integral(Omega, inner(stress(u), eps(v)))
    }

    /// (14) without loads.
    fn direct(u: Vector, v: Vector) -> Form {
        elasticity(u, v)
            - integral(GammaC, theta / gamma() * normal_stress(u) * normal_stress(v))
            - integral(GammaC, neg_part(pressure(u)) / gamma() * tested(v))
    }

    fn criterion(u: Vector) -> Functional {
        integral(Boundary, dot(slope, u))
    }

    /// (21).
    pub fn discrete(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        derivative(direct(u, p), u, q) + derivative(criterion(u), u, q)
    }

    /// (22).
    pub fn consistent(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        let stress_n = normal_stress(p) + dot(slope, obstacle_normal);
        let contact = heaviside(-pressure(u));
        elasticity(p, q) - integral(GammaC, theta / gamma() * stress_n * normal_stress(q))
            + integral(GammaC, contact / gamma() * (stress_n - gamma() * dot(p, obstacle_normal)) * tested(q))
            + derivative(criterion(u), u, q)
    }
}

//! The forms of the problems.

use forms_fem::prelude::*;

#[forms(dimension = 2)]
pub mod scalar {
    pub struct Data {
        pub k: Given<Scalar>,
        pub c: Given<Scalar>,
        pub f: Given<Scalar>,
        pub wall: Given<Scalar>,
        pub penalty: Param,
        pub power: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Wall;

    /// Cells that know nothing of each other: k (u − 1) + c (u³ + u − 2) = 0, whose solution is 1.
    pub fn apart(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, (k * (u - 1) + c * (pow(u, 3) + u - 2)) * v)
    }
    /// Far guesses: u + k [u − f]₊ + 0.1 tanh u − c.
    pub fn kinked(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, (u + k * pos_part(u - f) + tanh(u) / 10 - c) * v)
    }
    /// u + k u³ + 0.1 tanh u − c.
    pub fn hardening(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, (u + k * pow(u, 3) + tanh(u) / 10 - c) * v)
    }
    /// Conduction (k + c |∇u|²) ∇u with a source.
    pub fn conduction(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, (k + c * dot(grad(u), grad(u))) * dot(grad(u), grad(v)) - f * v)
    }
    /// Conduction between walls that a penalty holds.
    pub fn walled(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        conduction(u, v) + integral(Wall, penalty * (u - wall) * v)
    }
    /// The p-Laplacian between such walls.
    pub fn p_laplace(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, pow(1e-4 + dot(grad(u), grad(u)), power) * dot(grad(u), grad(v)) - f * v)
            + integral(Wall, penalty * (u - wall) * v)
    }
    /// A membrane above a penalised obstacle.
    pub fn membrane(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, k * dot(grad(u), grad(v)) - f * v - penalty * neg_part(u - wall) * v)
    }
}

#[forms(dimension = 2)]
pub mod coupled {
    pub struct Data {
        pub first: Param,
        pub second: Param,
        pub third: Param,
        pub coupling: Param,
        pub load: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;

    /// A vector whose first component is linear and whose second is not, with scales of their own.
    pub fn components(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, first * (dot(grad(u[0]), grad(v[0])) - load * v[0]))
            + integral(
                Omega,
                second
                    * (dot(grad(u[1]), grad(v[1])) + (pow(u[1], 3) + u[1] - load - coupling * u[0]) * v[1]),
            )
    }
    /// Three fields, each with a scale of its own; the first drives the second, the second the third.
    pub fn three(
        u: Unknown<Vector>,
        c: Unknown<Scalar>,
        t: Unknown<Scalar>,
        v: Test<Vector>,
        q: Test<Scalar>,
        w: Test<Scalar>,
    ) -> Form {
        integral(Omega, first * (inner(eps(u), eps(v)) + div(u) * div(v) - load * v[1]))
            + integral(
                Omega,
                second * (dot(grad(c), grad(q)) + (pow(c, 3) + c - load - coupling * div(u)) * q),
            )
            + integral(Omega, third * ((1 + c * c) * dot(grad(t), grad(w)) - (1 + coupling * c) * w))
    }
}

#[forms(dimension = 2)]
pub mod solid {
    pub struct Data {
        pub mu: Given<Scalar>,
        pub gap: Param,
        pub penalty: Param,
        pub theta: Param,
        pub gamma0: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Contact;

    fn stress(u: Vector) -> Tensor {
        mu * (2 * eps(u) + 1.5 * div(u) * I)
    }
    /// Distance of a point below the flat, whose normal (0, −1) points into it.
    fn below(u: Vector) -> Scalar {
        -u[1] - gap
    }
    /// σ_n.
    fn normal_stress(u: Vector) -> Scalar {
        -(stress(u) * n)[1]
    }
    /// Nitsche's method on a flat obstacle below.
    pub fn nitsche(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let gamma = gamma0 / h;
        let pressure = neg_part(normal_stress(u) - gamma * below(u));
        integral(Omega, inner(stress(u), eps(v)))
            - integral(Contact, theta / gamma * normal_stress(u) * normal_stress(v))
            - integral(Contact, pressure / gamma * (theta * normal_stress(v) + gamma * v[1]))
    }
    /// Neo-Hooke, pressed onto a penalised flat.
    pub fn rubber(u: Unknown<Vector>) -> Energy {
        let F = I + grad(u);
        let J = det(F);
        integral(Omega, mu / 2 * (inner(F, F) - 2) - mu * ln(J) + 0.75 * mu * pow(ln(J), 2))
            + integral(Contact, penalty / 2 * pow(pos_part(below(u)), 2))
    }
}

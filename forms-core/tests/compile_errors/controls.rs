//! Mistakes in `#[controls(..)]`.

use forms_core::forms;

#[forms(crate = forms_core)]
pub mod heat {
    pub struct Data {
        pub conductivity: Param,
    }
    #[cells]
    pub struct Omega;

    // No member of the data.
    #[controls(capacity)]
    pub fn step(u: Unknown<Scalar>, v: Test<Scalar>, before: State<Scalar>) -> Form {
        integral(Omega, (u - before) * v + conductivity * dot(grad(u), grad(v)))
    }
    // No control.
    #[controls]
    pub fn idle(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, u * v)
    }
    // An option that does not exist.
    #[controls(conductivity, energy = misfit)]
    pub fn named(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, conductivity * u * v)
    }
    // No energy of this name.
    #[controls(conductivity, criterion = misfit)]
    pub fn judged(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, conductivity * u * v)
    }
    #[controls(conductivity, order = 3)]
    pub fn thrice(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, conductivity * u * v)
    }
    #[controls(conductivity, motion(speed))]
    pub fn moving(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, conductivity * u * v)
    }
    #[controls(conductivity, motion(w(value)))]
    pub fn unnamed(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        integral(Omega, conductivity * dot(u, v) + p * q)
    }
    #[controls(conductivity, motion(value))]
    pub fn shared(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        integral(Omega, conductivity * dot(u, v) + p * q)
    }
    // Two unknowns, and one state before.
    #[controls(conductivity)]
    pub fn both(u: Unknown<Scalar>, p: Unknown<Scalar>, v: Test<Scalar>, q: Test<Scalar>, u0: State<Scalar>) -> Form {
        integral(Omega, conductivity * (u - u0) * v + p * q)
    }
    // No form of a step.
    #[controls(conductivity)]
    pub fn energy(u: Unknown<Scalar>) -> Energy {
        integral(Omega, conductivity * sqr(u))
    }
}

fn main() {}

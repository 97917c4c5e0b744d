use forms_core::contract::Real;
use forms_core::forms;

/// k g.
pub fn flux<R: Real, const D: usize>(g: [R; D], k: R) -> [R; D] {
    g.map(|component| component * k)
}

#[forms(crate = forms_core)]
pub mod outside {
    pub struct Data {
        k: Param,
    }
    #[cells]
    pub struct Omega;

    extern "Rust" {
        fn flux(g: Vector, k: Scalar) -> Vector;
    }

    pub fn right(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(flux(grad(u), k), grad(v)))
    }
    pub fn rank(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(flux(u, k), grad(v)))
    }
    pub fn count(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(flux(grad(u)), grad(v)))
    }
    pub fn linear(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(flux(grad(v), k), grad(u)))
    }
    pub fn value(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(flux, grad(v)) * u)
    }
    pub fn spelled(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(flx(grad(u), k), grad(v)))
    }
    pub fn spectral(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, tr(tensor_ln(grad(u))) * v)
    }
}

fn main() {
    let (data, omega) = (outside::Data::<2> { k: 1.0 }, outside::Omega::on("all"));
    let right: forms_core::contract::Form<2> = outside::right(&data, &omega);
    drop(right);
}

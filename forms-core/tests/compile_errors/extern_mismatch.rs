use forms_core::contract::Real;
use forms_core::forms;

/// Declared with a vector.
pub fn flux<R: Real>(g: R) -> R {
    g
}
/// Declared to give a scalar.
pub fn square<R: Real, const D: usize>(g: [R; D]) -> [R; D] {
    g.map(|component| component * component)
}
/// Declared with one argument.
pub fn two<R: Real>(a: R, b: R) -> R {
    a * b
}
/// It is not generic.
pub fn plain(a: f64) -> f64 {
    a
}

#[forms(crate = forms_core, dimension = 2)]
pub mod outside {
    #[cells]
    pub struct Omega;

    extern "Rust" {
        fn flux(g: Vector) -> Scalar;
        fn square(g: Vector) -> Scalar;
        fn two(a: Scalar) -> Scalar;
        fn plain(a: Scalar) -> Scalar;
        fn missing(a: Scalar) -> Scalar;
    }

    pub fn right(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, u * v)
    }
}

fn main() {
    let right: forms_core::contract::Form<2> = outside::right(&outside::Omega::on("all"));
    drop(right);
}

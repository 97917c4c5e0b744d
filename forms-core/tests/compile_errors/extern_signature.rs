use forms_core::forms;

pub fn flux(g: [f64; 2]) -> [f64; 2] {
    g
}

#[forms(crate = forms_core, dimension = 2)]
pub mod outside {
    #[cells]
    pub struct Omega;

    extern "C" {
        fn foreign(s: Scalar) -> Scalar;
    }
    extern "Rust" {
        fn unknown(s: f64) -> Scalar;
        fn silent(s: Scalar);
        fn role(s: State<Scalar>) -> Scalar;
        fn generic<T>(s: Scalar) -> Scalar;
        #[at = "crate::laws"]
        fn path(s: Scalar) -> Scalar;
        static ZERO: Scalar;
    }

    pub fn right(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, u * v)
    }
    pub fn uses(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, unknown(u) * silent(u) * v)
    }
}

/// A use of the module: it gives no further errors.
fn main() {
    let omega = outside::Omega::on("all");
    let right = outside::right(&omega);
    let uses = outside::uses(&omega);
    let both: (forms_core::contract::Form<2>, forms_core::contract::Form<2>) = (right, uses);
    drop(both);
}

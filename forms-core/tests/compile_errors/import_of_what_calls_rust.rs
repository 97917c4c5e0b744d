use forms_core::forms;

pub fn law<R: forms_core::contract::Real>(s: R) -> R {
    s * s
}

#[forms(crate = forms_core)]
pub mod material {
    extern "Rust" {
        fn law(s: Scalar) -> Scalar;
    }
    pub fn flux(u: Scalar) -> Vector {
        law(u) * grad(u)
    }
}

#[forms(crate = forms_core)]
pub mod contact {
    use super::material::flux;

    #[cells]
    pub struct Omega;

    pub fn balance(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(flux(u), grad(v)))
    }
}

fn main() {
    let form: forms_core::contract::Form<2> = contact::balance(&contact::Omega::on("all"));
    drop(form);
}

use forms_core::forms;

#[forms(crate = forms_core)]
pub mod elasticity {
    pub struct Data {
        mu: Param,
    }
    pub fn stress(w: Vector) -> Tensor {
        2 * mu * eps(w)
    }
}

#[forms(crate = forms_core)]
pub mod contact {
    use super::elasticity::{Data, stress};
    pub struct Constants {
        mu: Param,
    }
    #[cells]
    pub struct Omega;

    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), grad(v)))
    }
}

fn main() {
    let form = contact::direct(&contact::Constants::<2> { mu: 1.0 }, &contact::Omega::on("all"));
    drop(form);
}

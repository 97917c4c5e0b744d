use forms_core::forms;

#[forms(crate = forms_core)]
pub mod elasticity {
    pub struct Data {
        lambda: Param,
        mu: Param,
        load: Given<Vector>,
    }
    #[cells]
    pub struct Omega;

    fn strain(w: Vector) -> Tensor {
        sym(grad(w))
    }
    pub fn stress(w: Vector) -> Tensor {
        2 * mu * strain(w) + lambda * tr(strain(w)) * I
    }
    pub fn normal_stress(w: Vector) -> Scalar {
        dot(stress(w) * n, n)
    }
    pub fn work(w: Vector) -> Scalar {
        dot(load, w)
    }
    pub fn bilinear(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), strain(v)))
    }
    pub fn squared(w: Vector) -> Scalar {
        dot(w, w)
    }
}

#[forms(crate = forms_core)]
pub mod contact {
    use super::elasticity::stress;

    #[cells]
    pub struct Omega;

    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), grad(v)))
    }
}

fn main() {
    let form: forms_core::contract::Form<2> = contact::direct(&contact::Omega::on("all"));
    drop(form);
}

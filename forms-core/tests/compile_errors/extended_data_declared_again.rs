use forms_core::forms;

#[forms(crate = forms_core)]
pub mod elasticity {
    pub struct Data {
        pub lambda: Param,
        pub mu: Param,
    }
    pub fn stress(w: Vector) -> Tensor {
        2 * mu * eps(w) + lambda * tr(eps(w)) * I
    }
}

#[forms(crate = forms_core)]
pub mod contact {
    use super::elasticity::stress;

    #[extends(super::elasticity::Data)]
    pub struct Data {
        pub mu: Given<Scalar>,
        pub base: Param,
        pub gap: Param,
    }
    #[cells]
    pub struct Omega;

    fn lambda(w: Vector) -> Scalar {
        tr(eps(w))
    }
    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, gap * inner(stress(u), grad(v)))
    }
}

#[forms(crate = forms_core)]
pub mod thick {
    #[extends(super::contact::Data)]
    pub struct Data {
        pub lambda: Param,
        pub gap: Param,
    }
}

fn main() {
    let base = elasticity::Data::<2> { lambda: 1.0, mu: 1.0 };
    let data = contact::Data { base, mu: forms_core::contract::Given::constant(1.0), gap: 1.0 };
    let form = contact::direct(&data, &contact::Omega::on("all"));
    drop(form);
}

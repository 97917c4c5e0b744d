use forms_core::forms;

#[forms(crate = forms_core)]
pub mod elasticity {
    pub struct Data {
        pub mu: Param,
    }
    #[cells]
    pub struct Omega;

    pub fn stress(w: Vector) -> Tensor {
        2 * mu * eps(w)
    }
}

/// Names that the missing data would have defined give no further errors, here and in modules that include this one.
#[forms(crate = forms_core)]
pub mod contact {
    use super::elasticity::{Omega, stress};

    #[extends(super::elasticity::Data)]
    pub struct Data {
        pub gap: Param,
    }

    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, gap * mu * inner(stress(u), grad(v)))
    }
}

#[forms(crate = forms_core)]
pub mod loaded {
    #[includes(super::contact::Data)]
    pub struct Data {
        pub load: Param,
    }
    pub fn work(u: State<Scalar>) -> Scalar {
        load * gap * mu * u
    }
}

#[forms(crate = forms_core)]
pub mod of_no_path {
    #[extends]
    pub struct Data {
        gap: Param,
    }
    pub fn twice(s: Scalar) -> Scalar {
        mu * s * gap
    }
}

#[forms(crate = forms_core)]
pub mod a_region {
    #[extends(super::elasticity::Data)]
    #[cells]
    pub struct Omega;
}

fn main() {
    let data = contact::Data::<2> { gap: 1.0 };
    let form = contact::direct(&data, &elasticity::Omega::on("all"));
    drop(form);
}

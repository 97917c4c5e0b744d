use forms_core::forms;

#[forms(crate = forms_core)]
pub mod elasticity {
    struct Data {
        pub mu: Param,
    }
}

#[forms(crate = forms_core)]
pub mod contact {
    #[extends(super::elasticity::Data)]
    pub struct Data {
        pub gap: Param,
    }
    pub fn stress(w: Vector) -> Tensor {
        2 * mu * gap * eps(w)
    }
}

fn main() {}

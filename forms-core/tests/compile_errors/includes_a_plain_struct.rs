use forms_core::forms;

mod plain {
    pub struct Data {
        pub mu: f64,
    }
}

#[forms(crate = forms_core)]
pub mod contact {
    #[includes(super::plain::Data)]
    pub struct Data {
        pub gap: Param,
    }
    pub fn stress(w: Vector) -> Tensor {
        2 * mu * gap * eps(w)
    }
}

fn main() {
    drop(plain::Data { mu: 1.0 });
}

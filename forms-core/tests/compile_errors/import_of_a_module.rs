use forms_core::forms;

#[forms(crate = forms_core)]
pub mod material {
    pub fn pressure(u: Vector) -> Scalar {
        div(u)
    }
}

#[forms(crate = forms_core)]
pub mod solid {
    use super::material::{self, pressure};
    pub fn twice(u: Vector) -> Scalar {
        2 * pressure(u)
    }
}

fn main() {}

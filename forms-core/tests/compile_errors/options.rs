use forms_core::forms;

#[forms(crate = forms_core, dimensions = 2)]
pub mod misspelt {
    fn f(u: Scalar) -> Scalar {
        u
    }
}

#[forms(crate = forms_core, dimension = 4)]
pub mod four {
    fn f(u: Scalar) -> Scalar {
        u
    }
}

fn main() {}

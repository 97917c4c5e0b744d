use forms_core::forms;

#[forms(crate = forms_core)]
pub mod heat {
    pub struct Data {
        k: Param = 2.0,
    }
    #[cells]
    pub struct Omega;

    pub fn stiffness(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, k * dot(grad(u), grad(v)))
    }
}

fn main() {}

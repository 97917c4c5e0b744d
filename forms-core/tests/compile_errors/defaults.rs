use forms_core::forms;

#[forms(crate = forms_core)]
pub mod heat {
    pub struct Data {
        #[default]
        k: Param,
        #[default(conductivity)]
        l: Param,
        #[default(2 * 3)]
        m: Given<Scalar>,
        #[default(1)]
        f: Given<Vector>,
        #[default(1e999)]
        g: Param,
        #[default("1")]
        i: Param,
        #[default(1f32)]
        j: Param,
        #[default(0)]
        law: Table,
        #[default(0)]
        old: History<Scalar>,
        #[default(0)]
        #[default(1)]
        twice: Param,
    }
    #[cells]
    pub struct Omega;

    pub fn data(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, k * l * m * g * dot(grad(u), grad(v)) - dot(f, grad(v)))
    }
}

/// Without data the name is free.
#[forms(crate = forms_core)]
pub mod free {
    #[cells]
    pub struct Omega;

    pub fn data() -> Functional {
        integral(Omega, 1)
    }
}

fn main() {
    drop(free::data::<2>(&free::Omega::on("all")));
}

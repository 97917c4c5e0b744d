use forms_core::contract::History;
use forms_core::forms;

#[forms(crate = forms_core)]
pub mod plastic {
    pub struct Data {
        strain: History<Tensor>,
        heat: History<Scalar>,
        rate: History,
    }
    #[cells]
    pub struct Omega;

    pub fn right(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(eps(u) - strain, eps(v)))
    }
    pub fn gradient(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, dot(grad(heat), v) + dot(div(strain * heat), v) + dot(u, v))
    }
}

/// A use of the module: it gives no further errors.
pub fn form(strain: History<[[f64; 2]; 2], 2>, heat: History<f64, 2>) -> forms_core::contract::Form<2> {
    let data = plastic::Data::<2> { rate: heat.clone(), strain, heat };
    plastic::right(&data, &plastic::Omega::on("all"))
}

fn main() {}

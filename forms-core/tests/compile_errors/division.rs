use forms_core::forms;

#[forms(crate = forms_core)]
pub mod elastic {
    pub struct Data {
        mu: Param,
        gap: Given<Scalar>,
        f: Given<Vector>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct GammaC;

    fn sigma(w: Vector) -> Tensor {
        2 * mu * eps(w)
    }

    pub fn right(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(sigma(u), eps(v)))
    }
    pub fn wrong(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, dot(u, v) / 0 + div(v) / u - div(v) / (1 - 1))
    }
}

/// A use of the module: it gives no further errors.
fn main() {
    let data = elastic::data::<2>().mu(1.0).gap(0.0).f([0.0; 2]);
    let omega = elastic::Omega::on("all");
    let right = elastic::right(&data, &omega);
    let wrong = elastic::wrong(&data, &omega);
    drop((right, wrong));
}

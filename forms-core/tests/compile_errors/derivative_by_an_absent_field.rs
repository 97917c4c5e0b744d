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

    fn energy(w: Vector) -> Scalar {
        mu * inner(eps(w), eps(w))
    }
    fn dead_load(w: Vector, v: Vector) -> Form {
        integral(Omega, dot(f, v))
    }

    /// A form that is called with the field need not depend on it.
    pub fn right(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, derivative(energy(u), u, v)) + derivative(dead_load(u, v), u, u)
    }
    pub fn wrong(u: Unknown<Vector>, z: State<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, derivative(energy(u), z, v))
            + derivative(integral(Omega, energy(u)), f, v)
            + derivative(integral(Omega, energy(u) * div(v)), gap, 1)
    }
}

/// A use of the module: it gives no further errors.
fn main() {
    let data = elastic::data::<2>().mu(1.0).gap(0.0).f([0.0; 2]);
    let omega = elastic::Omega::on("all");
    let right = elastic::right(&data, &omega);
    let wrong = elastic::wrong(&data, &omega, forms_core::contract::Source::Constant(vec![0.0; 2]));
    drop((right, wrong));
}

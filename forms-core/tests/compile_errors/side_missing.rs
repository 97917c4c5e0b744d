use forms_core::forms;

#[forms(crate = forms_core)]
pub mod poisson {
    pub struct Data {
        gamma: Param,
        k: Given<Scalar>,
    }
    #[interior_facets]
    pub struct Skeleton;

    pub fn right(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Skeleton, dot(x, n) * facet_area / avg(h) * jump(u) * jump(v))
    }
    fn flux(w: Scalar) -> Scalar {
        dot(grad(w), n)
    }
    pub fn field(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Skeleton, avg(flux(u)) * v + flux(u) * jump(v))
    }
    pub fn geometry_and_data(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Skeleton, k * gamma / h * jump(u) * jump(v) + avg(u) * avg(v) / cell_volume)
    }
    pub fn energy(u: Unknown<Scalar>) -> Energy {
        integral(Skeleton, div(grad(u)) * jump(u))
    }
}

/// A use of the module: it gives no further errors.
fn main() {
    let data = poisson::data::<2>().gamma(1.0).k(1.0);
    let skeleton = poisson::Skeleton::on("all");
    let right = poisson::right(&data, &skeleton);
    let wrong = poisson::field(&data, &skeleton);
    drop((right, wrong));
}

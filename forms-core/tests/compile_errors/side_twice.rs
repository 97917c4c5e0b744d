use forms_core::forms;

#[forms(crate = forms_core)]
pub mod poisson {
    #[interior_facets]
    pub struct Skeleton;

    fn mean_flux(w: Scalar) -> Scalar {
        dot(avg(grad(w)), n)
    }
    pub fn wrong(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Skeleton, this(jump(u)) * jump(v) + jump(mean_flux(u) * v))
    }
    pub fn wrong_by_direction(u: State<Scalar>, v: Test<Scalar>) -> Form {
        derivative(integral(Skeleton, jump(u) * jump(u)), u, this(v))
    }
    pub fn wrong_jump(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Skeleton, jump(u, v) * jump(v) + dot(jump(u, n, n), jump(v, n)))
    }
}

/// A use of the module: it gives no further errors.
fn main() {
    let wrong = poisson::wrong::<2>(&poisson::Skeleton::on("all"));
    drop(wrong);
}

use forms_core::forms;

#[forms(crate = forms_core)]
pub mod poisson {
    #[facets]
    #[interior_facets]
    pub struct Skeleton;

    pub fn energy(u: Unknown<Scalar>) -> Energy {
        integral(Skeleton, pow(jump(u), 2))
    }
}

/// A use of the module: it gives no further errors.
fn main() {
    let energy = poisson::energy::<2>(&poisson::Skeleton::on("all"));
    drop(energy);
}

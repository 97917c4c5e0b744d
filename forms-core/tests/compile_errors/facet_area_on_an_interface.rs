use forms_core::forms;

#[forms(crate = forms_core)]
pub mod cut {
    #[interface]
    pub struct Gamma;

    pub fn right(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Gamma, u * v / h + dot(grad(u), n) * v / cell_volume)
    }
    pub fn wrong(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Gamma, u * v / facet_area)
    }
}

/// A use of the module: it gives no further errors.
fn main() {
    let gamma = cut::Gamma::on("all");
    let right = cut::right::<2>(&gamma);
    let wrong = cut::wrong::<2>(&gamma);
    drop((right, wrong));
}

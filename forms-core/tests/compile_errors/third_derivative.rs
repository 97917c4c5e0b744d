use forms_core::forms;

#[forms(crate = forms_core)]
pub mod plates {
    #[cells]
    pub struct Omega;

    pub fn right(u: Unknown<Scalar>) -> Energy {
        integral(Omega, inner(hess(u), grad(grad(u))) + pow(div(grad(u)), 2))
    }
    pub fn wrong(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(div(grad(u))), grad(v)))
    }
    /// The direction holds a gradient, and its second derivatives are asked for.
    pub fn wrong_by_direction(u: State<Scalar>, w: State<Vector>) -> Functional {
        derivative(integral(Omega, inner(hess(u), hess(u))), u, div(w))
    }
}

/// A use of the module: it gives no further errors.
fn main() {
    let omega = plates::Omega::on("all");
    drop((plates::right::<2>(&omega), plates::wrong::<2>(&omega)));
}

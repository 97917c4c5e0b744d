use forms_core::form;

fn main() {
    // A name that is not known; a region of facets where cells are meant.
    let laplace = form!(
        |u: Unknown<Scalar>, v: Test<Scalar>| integral(cells("all"), kappa * dot(grad(u), grad(v)) - dot(n, grad(v))),
        kapa: Param = 2.0,
        crate = forms_core,
    );
    let criterion = form!(
        |u: State<Vector>| -> Functional { integral(cells("all"), u) },
        crate = forms_core,
    );
    let value: f64 = 1.0;
    let number = criterion(forms_core::contract::Source::<2>::Constant(vec![value]));
    assemble(&laplace);
    drop(number);
}

/// A use of the form: it gives no further errors.
fn assemble(_: &forms_core::contract::Form<2>) {}

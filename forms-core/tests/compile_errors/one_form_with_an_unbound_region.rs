use forms_core::form;

fn main() {
    let laplace = form!(
        |u: Unknown<Scalar>, v: Test<Scalar>| integral(Omega, dot(grad(u), grad(v))),
        Omega: Cells,
        crate = forms_core,
    );
    drop(laplace);
}

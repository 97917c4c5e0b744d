use forms_core::form;

fn main() {
    let laplace = form!(|u, v: Test<Scalar>| integral(cells("all"), dot(grad(u), grad(v))), crate = forms_core);
    drop(laplace);
}

use forms_core::contract::Given;
use forms_core::form;

fn main() {
    let laplace = form!(
        |u: Unknown<Scalar>, v: Test<Scalar>| integral(cells("all"), conductivity * dot(grad(u), grad(v)) - f * v),
        conductivity: Param,
        f: Given<Scalar> = "one",
        crate = forms_core,
        dimension = 2,
    );
    drop(laplace);
    let _: Given<f64, 2> = Given::constant(1.0);
}

use forms_core::contract::Table;
use forms_core::forms;

#[forms(crate = forms_core)]
pub mod tabulated {
    pub struct Data {
        law: Table,
        k: Table<Scalar>,
    }
    #[cells]
    pub struct Omega;

    pub fn right(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, law(u) * v)
    }
    pub fn vector(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, law(grad(u)) * v)
    }
    pub fn count(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, law(u, u) * v)
    }
    pub fn value(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, law * u * v)
    }
    pub fn linear(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, law(v) * u)
    }
}

fn main() -> Result<(), forms_core::contract::TableError> {
    let law = Table::linear(&[[0.0, 1.0], [1.0, 2.0]])?;
    let data = tabulated::Data::<2> { law: law.clone(), k: law };
    let right: forms_core::contract::Form<2> = tabulated::right(&data, &tabulated::Omega::on("all"));
    drop(right);
    Ok(())
}

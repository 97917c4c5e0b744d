use forms_core::contract::{Energy, Expression, Form, Functional, Source};
use forms_core::{form, forms};

#[forms(crate = forms_core)]
pub mod mistaken {
    #[cells]
    pub struct Omega;

    pub fn stored(u: Unknown<Scalar>) -> Energy {
        integral(Omega, u * k)
    }
    pub fn work(u: State<Scalar>) -> Functional {
        integral(Omega, grad(u))
    }
    pub fn flux(u: Scalar) -> Vector {
        u
    }
    pub fn unread_energy(u: Unknown<Scaler>) -> Energy {
        integral(Omega, u * u)
    }
    pub fn unread_functional(u: State<Scaler>) -> Functional {
        integral(Omega, u)
    }
    pub fn unread_value(u: Scaler) -> Vector {
        grad(u)
    }
}

/// Uses of the values: they give no further errors.
fn main() {
    let omega = mistaken::Omega::on("all");
    let one = || Source::<2>::Constant(vec![1.0]);
    energy(&mistaken::stored(&omega));
    energy(&mistaken::unread_energy(&omega));
    assemble(&mistaken::stored(&omega));
    functional(&mistaken::work(&omega, one()));
    functional(&mistaken::unread_functional(&omega, one()));
    expression(&mistaken::flux(one()));
    expression(&mistaken::unread_value(one()));
    energy(&form!(|u: Unknown<Scalar>| -> Energy { integral(cells("all"), grad(u)) }, crate = forms_core));
    let mean = form!(|u: State<Scalar>| -> Functional { integral(cells("all"), grad(u)) }, crate = forms_core);
    functional(&mean(one()));
    let square = form!(|s: Scalar| -> Scalar { grad(s) }, crate = forms_core);
    expression(&square(one()));
}

fn assemble(_: &Form<2>) {}
fn energy(_: &Energy<2>) {}
fn functional(_: &Functional<2>) {}
fn expression(_: &Expression<2>) {}

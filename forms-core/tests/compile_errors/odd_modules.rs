//! None of these makes the compiler panic.

use forms_core::forms;

#[forms(crate = forms_core)]
pub mod generics {
    pub struct Data<T> {
        mu: Param<T>,
        r#in: Given<Given<Scalar>>,
    }
    pub struct Tuple(f64);
    pub struct Data2 {
        mu: Param,
    }
    #[cells]
    #[facets]
    pub struct Both;
    #[cells]
    pub struct WithMembers {
        mu: Param,
    }
    pub enum Choice {
        One,
    }
    impl Data {
        fn new() -> Self {
            Data
        }
    }
    pub trait Energy {}
    macro_rules! nothing {
        () => {};
    }
    pub mod inner {}
}

#[forms(crate = forms_core)]
pub mod functions {
    #[cells]
    pub struct Omega;
    pub fn empty() -> Scalar {}
    pub fn only_let() -> Scalar {
        let a = 1;
    }
    pub fn semicolon(s: Scalar) -> Scalar {
        s;
    }
    pub fn tuple((a, b): Scalar, _: Vector) -> Scalar {
        a
    }
    pub fn receiver(self) -> Scalar {
        1
    }
    pub async unsafe fn qualified<'a>() -> Scalar {
        1
    }
    pub fn returns() -> Scalar {
        return 1;
    }
    pub fn literals() -> Scalar {
        "text" + 'c' + true + 1e999 + 99999999999999999999999999999999999999999999999 + 1f32
    }
    pub fn arrays() -> Vector {
        [] + [1, [2]] + [0; 2]
    }
    pub fn indices(u: Vector) -> Scalar {
        u[()] + u[1.5] + u[99999999999999999999999]
    }
    pub fn calls() -> Scalar {
        (sqrt)(2) + sqrt::<f64>(2) + sqrt(2)(3) + integral() + derivative(1) + Omega + integral
    }
    pub fn doubled(s: Scalar, s: Vector) -> Scalar {
        det(outer(s, outer(s, outer(s, s)))) + tr(outer(s, outer(s, s)))
    }
    pub fn doubled() -> Energy {
        if true { integral(Omega, 1) } else { integral(Omega, 2) }
    }
    pub fn third(u: Unknown<Scalar>) -> Functional {
        integral(Omega, tr(hess(div(grad(u)))) + div(hess(sin(u)))[0])
    }
    pub fn contract(s: Scalar) -> Scalar {
        if s < (s < s) { !s } else { s % 2 + (s == s) + *s }
    }
}

#[forms(crate = forms_core, dimension = 4)]
pub mod dimension {}

#[forms(crates = forms_core)]
pub mod option {}

#[forms(crate = forms_core)]
pub fn not_a_module() {}

fn main() {}

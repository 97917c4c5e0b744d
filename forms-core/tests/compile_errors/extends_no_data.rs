use forms_core::forms;

#[forms(crate = forms_core)]
pub mod elasticity {
    pub struct Data {
        pub mu: Param,
    }
    #[cells]
    pub struct Omega;

    pub fn stress(w: Vector) -> Tensor {
        2 * mu * eps(w)
    }
}

pub mod other_name {
    pub use super::elasticity::Data as Material;
}

#[forms(crate = forms_core)]
pub mod no_data {
    pub fn twice(s: Scalar) -> Scalar {
        2 * s
    }
}

/// Names that a base would have brought are no further mistakes, here and in modules that extend this one.
#[forms(crate = forms_core)]
pub mod of_a_function {
    use super::elasticity::stress;

    #[extends(super::elasticity::stress)]
    pub struct Data {
        pub gap: Param,
    }
    #[cells]
    pub struct Omega;

    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, gap * mu * law(tr(eps(u))) * inner(stress(u), grad(v)))
    }
}

#[forms(crate = forms_core)]
pub mod of_what_extends_a_function {
    #[extends(super::of_a_function::Data)]
    pub struct Data {
        pub load: Param,
    }
    pub fn work(u: State<Scalar>) -> Scalar {
        load * gap * mu * u
    }
}

#[forms(crate = forms_core)]
pub mod of_a_region {
    #[extends(super::elasticity::Omega)]
    pub struct Data {}
}

#[forms(crate = forms_core)]
pub mod of_another_name {
    #[extends(super::other_name::Material)]
    pub struct Data {}
}

#[forms(crate = forms_core)]
pub mod of_a_module_without_data {
    #[extends(super::no_data::twice)]
    pub struct Data {}
}

#[forms(crate = forms_core)]
pub mod a_region {
    #[extends(super::elasticity::Data)]
    #[cells]
    pub struct Omega;
}

#[forms(crate = forms_core)]
pub mod of_no_path {
    #[extends]
    pub struct Data {
        gap: Param,
    }
    pub fn twice(s: Scalar) -> Scalar {
        mu * s * gap
    }
}

#[forms(crate = forms_core)]
pub mod of_a_name_alone {
    #[extends(Data)]
    pub struct Data {}
}

#[forms(crate = forms_core)]
pub mod of_a_generic_path {
    #[extends(super::elasticity::Data<2>)]
    pub struct Data {}
}

#[forms(crate = forms_core)]
pub mod of_two {
    #[extends(super::elasticity::Data)]
    #[extends(super::of_no_path::Data)]
    pub struct Data {}
}

fn main() {
    let data = of_a_function::Data::<2> { gap: 1.0 };
    let form = of_a_function::direct(&data, &of_a_function::Omega::on("all"));
    drop(form);
}

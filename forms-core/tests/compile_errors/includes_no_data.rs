use forms_core::forms;

#[forms(crate = forms_core)]
pub mod elasticity {
    pub struct Data {
        pub mu: Param,
        pub gap: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;

    pub fn stress(w: Vector) -> Tensor {
        2 * mu * eps(w)
    }
}

#[forms(crate = forms_core)]
pub mod friction {
    pub struct Data {
        #[default(0)]
        pub mu: Param,
    }
    pub fn bound(s: Scalar) -> Scalar {
        mu * s
    }
}

/// One name, with a default and without.
#[forms(crate = forms_core)]
pub mod in_two_ways {
    #[includes(super::elasticity::Data, super::friction::Data)]
    pub struct Data {}
}

/// Names that the missing data would have defined give no further errors.
#[forms(crate = forms_core)]
pub mod of_a_function {
    use super::elasticity::stress;

    #[includes(super::elasticity::stress, super::elasticity::Data)]
    pub struct Data {
        pub load: Param,
    }
    #[cells]
    pub struct Omega;

    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, load * gap * unheard * inner(stress(u), grad(v)))
    }
}

#[forms(crate = forms_core)]
pub mod of_a_region {
    #[includes(super::elasticity::Omega)]
    pub struct Data {}
}

/// Nor are they in modules that include these.
#[forms(crate = forms_core)]
pub mod of_what_includes_a_function {
    #[includes(super::of_a_function::Data)]
    pub struct Data {
        pub strength: Param,
    }
    pub fn work(u: State<Scalar>) -> Scalar {
        load * gap * strength * unheard * u
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

#[forms(crate = forms_core)]
pub mod of_another_name {
    #[includes(super::other_name::Material)]
    pub struct Data {}
}

#[forms(crate = forms_core)]
pub mod of_a_module_without_data {
    #[includes(super::no_data::twice)]
    pub struct Data {}
}

#[forms(crate = forms_core)]
pub mod of_a_generic_path {
    #[includes(super::elasticity::Data<2>)]
    pub struct Data {}
}

#[forms(crate = forms_core)]
pub mod a_region {
    #[includes(super::elasticity::Data)]
    #[cells]
    pub struct Omega;
}

#[forms(crate = forms_core)]
pub mod of_no_path {
    #[includes(Data, super::elasticity::Data)]
    pub struct Data {}
}

/// Of another shape than what an imported function reads.
#[forms(crate = forms_core)]
pub mod declared_itself {
    use super::elasticity::stress;

    #[includes(super::elasticity::Data)]
    pub struct Data {
        pub mu: Given<Vector>,
    }
    #[cells]
    pub struct Omega;

    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, gap * inner(stress(u), grad(v)))
    }
}

fn main() {}

use forms_core::forms;

#[forms(crate = forms_core)]
pub mod elasticity {
    pub struct Data {
        pub lambda: Param,
        pub mu: Param,
    }
    pub fn stress(w: Vector) -> Tensor {
        2 * mu * eps(w) + lambda * tr(eps(w)) * I
    }
}

/// A member may be declared again, a function may not have its name.
#[forms(crate = forms_core)]
pub mod contact {
    use super::elasticity::stress;

    #[includes(super::elasticity::Data)]
    pub struct Data {
        pub mu: Given<Scalar>,
        pub gap: Param,
    }
    #[cells]
    pub struct Omega;

    fn lambda(w: Vector) -> Scalar {
        tr(eps(w))
    }
    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, gap * inner(stress(u), grad(v)))
    }
}

/// As that of the function that takes the members from a value.
#[forms(crate = forms_core)]
pub mod thick {
    #[includes(super::elasticity::Data)]
    pub struct Data {
        pub thickness: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct mu;

    pub fn data_from() -> Functional {
        integral(Omega, thickness)
    }
}

fn main() {
    let elastic = elasticity::data::<2>().lambda(1.0).mu(1.0);
    let data = contact::data_from(elastic).mu(forms_core::contract::Given::constant(1.0)).gap(1.0);
    let form = contact::direct(&data, &contact::Omega::on("all"));
    drop(form);
}

use forms_core::forms;

#[forms(crate = forms_core)]
pub mod elasticity {
    pub struct Data {
        pub lambda: Param,
        pub shear: Param,
        /// It is reported here, and nowhere else.
        pub density: Parm,
    }
}

#[forms(crate = forms_core)]
pub mod contact {
    #[includes(super::elasticity::Data)]
    pub struct Data {
        pub gap: Param,
    }
    #[cells]
    pub struct Omega;

    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, shera * inner(grad(u), grad(v)) - density * u[0] * v[0])
    }
    pub fn volume(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        derivative(integral(Omega, lambda * div(u) * div(v)), stiffness, 1)
    }
    pub fn twice(u: State<Scalar>) -> Scalar {
        lambda(u)
    }
}

#[forms(crate = forms_core)]
pub mod importing {
    use super::contact::twice;

    #[includes(super::elasticity::Data)]
    pub struct Data {
        pub bulk: Param,
    }
    pub fn four_times(u: State<Scalar>) -> Scalar {
        bulk * twice(u)
    }
}

fn main() {
    let elastic = elasticity::data::<2>().lambda(1.0).shear(1.0).density(1.0);
    let data: contact::Data<2> = contact::data_from(elastic.clone()).gap(1.0);
    drop(contact::direct(&data, &contact::Omega::on("all")));
    let _: importing::Data<2> = importing::data_from(elastic).bulk(1.0);
}

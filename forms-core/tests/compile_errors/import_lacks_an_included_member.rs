use forms_core::forms;

#[forms(crate = forms_core)]
pub mod elasticity {
    pub struct Data {
        pub mu: Param,
    }
    pub fn stress(w: Vector) -> Tensor {
        2 * mu * eps(w)
    }
}

#[forms(crate = forms_core)]
pub mod contact {
    use super::elasticity::stress;

    #[includes(super::elasticity::Data)]
    pub struct Data {
        pub gap: Param,
    }
    pub fn pressure(w: Vector) -> Scalar {
        dot(stress(w) * n, n) - gap
    }
}

#[forms(crate = forms_core)]
pub mod importing {
    use super::contact::pressure;

    pub struct Data {
        pub gap: Param,
    }
    #[facets]
    pub struct Wall;

    pub fn force(u: State<Vector>) -> Functional {
        integral(Wall, pressure(u))
    }
}

fn main() {
    let data = importing::Data::<2> { gap: 1.0 };
    drop(importing::Model::new(data));
}

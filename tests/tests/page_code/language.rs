//! `docs/language.md`.

use forms_fem::contract::{Entity, Form, Functional};
use forms_fem::prelude::*;

#[forms]
pub mod poisson {
    pub struct Data { k: Param, f: Given<Scalar> }
    #[cells]  pub struct Omega;
    #[facets] pub struct Wall;

    fn flux(t: Scalar) -> Vector { -k * grad(t) }

    pub fn balance(t: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, -dot(flux(t), grad(v)) - f * v) + integral(Wall, 2 * t * v)
    }
}

#[forms]
pub mod metal {
    pub struct Data {
        plastic: History<Tensor>,
    }
    pub fn new_plastic(u: State<Vector>) -> Tensor {
        plastic + eps(u) / 2
    }
}

pub fn after_a_step(assembler: &Assembler<2>, u: Field<2>) -> Result<(), Failure> {
    let data = metal::data().plastic(assembler.history(Entity::Cells, "all", 2, [[0.0; 2]; 2])?);
    assembler.update_history(&metal::new_plastic(&data, &u), &data.plastic)?;
    data.plastic.commit();
    Ok(())
}

#[forms]
pub mod touching {
    pub struct Data {
        lambda: Param,
        mu: Param,
        gamma0: Param,
    }
    #[cells]
    pub struct Omega;
    #[pairs]
    pub struct Touch;
    fn stress(u: Vector) -> Tensor {
        lambda * div(u) * I + 2 * mu * eps(u)
    }
    fn contact(u: Vector) -> Vector {
        -neg_part(dot(this(stress(u) * n), toward) - gamma0 / this(h) * (dot(jump(u), toward) - gap)) * toward
    }
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v))) - integral(Touch, dot(contact(u), jump(v)) / 2)
    }
}

pub fn in_place(k: f64, u: &Field<2>) -> (Form<2>, Functional<2>) {
    let poisson = form!(|u: Unknown<Scalar>, v: Test<Scalar>| integral(cells("all"), k * dot(grad(u), grad(v)) - f * v), k: Param, f: Given<Scalar> = |x| x[0]);
    let mean = form!(|u: State<Scalar>| -> Functional { integral(Omega, u) }, Omega: Cells = "all");
    (poisson, mean(u))
}

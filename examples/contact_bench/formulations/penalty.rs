//! The penalty method: springs of 10, 100 and 10⁴ E/h.

use contact_bench::{
    AfterLoad, Case, Contact, Formulation, Membrane, Outcome, Pressed, Refusal, Rubber, Sides, Slid, Sliding,
    TwoBodies,
};
use forms_fem::prelude::*;

#[forms(dimension = 2)]
mod law {
    pub use contact_bench::body::{Surface, Touch};
    use contact_bench::body::{distance, obstacle_distance, own_stiffness, own_weight, weight};
    #[includes(contact_bench::body::Data)]
    pub struct Data {
        factor: Param,
    }
    pub fn pressure(u: Vector) -> Scalar {
        factor * young / h * neg_part(obstacle_distance(u))
    }
    pub fn on_obstacle(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Surface, weight() * pressure(u) * dot(v, obstacle_normal))
    }
    pub fn pair_pressure(u: Vector) -> Scalar {
        factor * own_stiffness() * neg_part(distance(u))
    }
    pub fn between(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Touch, own_weight() * pair_pressure(u) * dot(toward, jump(v)))
    }
}

#[forms(dimension = 2)]
mod volume {
    pub use contact_bench::volume::Omega;
    use contact_bench::volume::height;
    #[includes(contact_bench::volume::Data)]
    pub struct Data {
        factor: Param,
    }
    pub fn force(u: Scalar) -> Scalar {
        factor / (h * h) * neg_part(height(u))
    }
    pub fn above(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, -force(u) * v)
    }
}

#[forms(dimension = 2)]
mod rubber {
    pub use contact_bench::rubber::{Omega, Surface};
    use contact_bench::rubber::{body, distance, stiffness};
    #[includes(contact_bench::rubber::Data)]
    pub struct Data {
        factor: Param,
    }
    pub fn on_flat(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        body(u, p, v, q)
            + integral(Surface, factor * stiffness() * neg_part(distance(u)) * dot(v, obstacle_normal))
    }
}

#[forms]
mod rough {
    pub use contact_bench::two_bodies::bodies::{Omega, Touch};
    use contact_bench::two_bodies::bodies::{allowed, balance};
    #[includes(contact_bench::two_bodies::bodies::Data)]
    pub struct Data {}
    pub fn traction(u: Vector) -> Vector {
        allowed(0 * u, u)
    }
    pub fn between(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        balance(u, v) - integral(Touch, dot(traction(u), jump(v)))
    }
}

#[forms(dimension = 2)]
mod drawn {
    pub use contact_bench::sliding::{Omega, Touch};
    use contact_bench::sliding::{balance, own_stiffness};
    #[includes(contact_bench::sliding::Data)]
    pub struct Data {
        factor: Param,
    }
    pub fn between(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let pressure = factor * own_stiffness() * neg_part(gap);
        balance(u, v) + integral(Touch(u), pressure * dot(toward, jump(v)))
    }
}

/// Springs whose stiffness is a multiple of E/h.
pub struct Penalty {
    factor: f64,
}

/// Springs of 10, 100 and 10⁴ E/h.
pub fn all() -> Vec<Penalty> {
    [10.0, 100.0, 1e4].map(|factor| Penalty { factor }).into()
}

impl Penalty {
    fn between<const D: usize>(&self, bodies: &TwoBodies<D>) -> Result<Vec<AfterLoad<D>>, Refusal>
    where
        Dim: Dimension<D>,
    {
        let (omega, touch) = (bodies.omega(), bodies.touch(Sides::Own));
        let form = |data| rough::between(&rough::data_from(data), &omega, &touch);
        bodies.follow(self.factor, form, |data, u| rough::traction(&rough::data_from(data), u))
    }
}

impl Formulation for Penalty {
    fn name(&self) -> String {
        format!("penalty {} E/h", self.factor)
    }

    fn solve(&self, case: &Case) -> Result<Outcome, Refusal> {
        let data = law::data_from(case.data.clone()).factor(self.factor);
        match case.contact {
            Contact::Obstacle(_) => {
                case.newton(&law::on_obstacle(&data, &case.surface()), |u| law::pressure(&data, u))
            }
            Contact::Bodies(_) => {
                case.newton(&law::between(&data, &case.touch(Sides::Own)), |u| law::pair_pressure(&data, u))
            }
        }
    }

    fn cover(&self, membrane: &Membrane) -> Result<Outcome, Refusal> {
        let data = volume::data_from(membrane.data.clone()).factor(self.factor);
        membrane.newton(&volume::above(&data, &membrane.omega()), |u| volume::force(&data, u))
    }

    fn press(&self, ring: &Rubber) -> Result<Pressed, Refusal> {
        let data = |way: f64| rubber::data_from(ring.data(way)).factor(self.factor);
        ring.follow(|way| rubber::on_flat(&data(way), &ring.omega(), &ring.surface()))
    }

    fn rub(&self, bodies: &TwoBodies<2>) -> Result<Vec<AfterLoad<2>>, Refusal> {
        self.between(bodies)
    }

    fn stack(&self, bodies: &TwoBodies<3>) -> Result<Vec<AfterLoad<3>>, Refusal> {
        self.between(bodies)
    }

    fn slide(&self, bodies: &Sliding) -> Result<Vec<Slid>, Refusal> {
        let data = drawn::data_from(bodies.data.clone()).factor(self.factor);
        bodies.follow(&drawn::between(&data, &bodies.omega(), &bodies.touch(Sides::Own)))
    }
}

//! A pressure that falls exponentially with the gap: p₀ exp(−g/c).

use contact_bench::{
    AfterLoad, Case, Contact, Formulation, Membrane, Outcome, Pressed, Refusal, Rubber, Sides, Slid, Sliding,
    TwoBodies,
};
use forms_fem::prelude::*;

#[forms(dimension = 2)]
mod law {
    pub use contact_bench::body::{Surface, Touch};
    use contact_bench::body::{distance, obstacle_distance, own_weight, weight};
    use forms_contact::operators::exponential_closure::exponential_pressure;
    #[includes(contact_bench::body::Data, forms_contact::operators::exponential_closure::Data)]
    pub struct Data {}
    pub fn pressure(u: Vector) -> Scalar {
        exponential_pressure(obstacle_distance(u))
    }
    pub fn on_obstacle(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Surface, weight() * pressure(u) * dot(v, obstacle_normal))
    }
    pub fn pair_pressure(u: Vector) -> Scalar {
        exponential_pressure(distance(u))
    }
    pub fn between(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Touch, own_weight() * pair_pressure(u) * dot(toward, jump(v)))
    }
}

#[forms(dimension = 2)]
mod volume {
    pub use contact_bench::volume::Omega;
    use contact_bench::volume::height;
    use forms_contact::operators::exponential_closure::exponential_pressure;
    #[includes(contact_bench::volume::Data, forms_contact::operators::exponential_closure::Data)]
    pub struct Data {}
    pub fn force(u: Scalar) -> Scalar {
        exponential_pressure(height(u))
    }
    pub fn above(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, -force(u) * v)
    }
}

#[forms(dimension = 2)]
mod rubber {
    pub use contact_bench::rubber::{Omega, Surface};
    use contact_bench::rubber::{body, distance};
    use forms_contact::operators::exponential_closure::exponential_pressure;
    #[includes(contact_bench::rubber::Data, forms_contact::operators::exponential_closure::Data)]
    pub struct Data {}
    pub fn on_flat(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        body(u, p, v, q) + integral(Surface, exponential_pressure(distance(u)) * dot(v, obstacle_normal))
    }
}

#[forms(dimension = 2)]
mod drawn {
    use contact_bench::sliding::balance;
    pub use contact_bench::sliding::{Omega, Touch};
    use forms_contact::operators::exponential_closure::exponential_pressure;
    #[includes(contact_bench::sliding::Data, forms_contact::operators::exponential_closure::Data)]
    pub struct Data {}
    pub fn between(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        balance(u, v) + integral(Touch(u), exponential_pressure(gap) * dot(toward, jump(v)))
    }
}

#[forms]
mod rough {
    pub use contact_bench::two_bodies::bodies::{Omega, Touch};
    use contact_bench::two_bodies::bodies::{balance, separation};
    use forms_contact::operators::bodies::own_gamma;
    use forms_contact::operators::exponential_closure::exponential_pressure;
    use forms_contact::operators::friction::{ball_projection, slip_limit, tangential};
    #[includes(contact_bench::two_bodies::bodies::Data, forms_contact::operators::exponential_closure::Data)]
    pub struct Data {}
    pub fn traction(u: Vector) -> Vector {
        let p = exponential_pressure(separation(u));
        let held = -own_gamma() * tangential(jump(u - displacement_before), toward);
        ball_projection(held, slip_limit(p)) - p * toward
    }
    pub fn between(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        balance(u, v) - integral(Touch, dot(traction(u), jump(v)))
    }
}

/// The length over which the pressure falls by e, as a part of the problem's change of the gap.
pub struct Exponential {
    part: f64,
}

/// The one variant.
pub fn all() -> Vec<Exponential> {
    vec![Exponential { part: 0.01 }]
}

impl Exponential {
    /// Springs of 10 E/h hold what sticks.
    fn between<const D: usize>(&self, bodies: &TwoBodies<D>) -> Result<Vec<AfterLoad<D>>, Refusal>
    where
        Dim: Dimension<D>,
    {
        let (omega, touch) = (bodies.omega(), bodies.touch(Sides::Own));
        let data = |given| {
            let data = rough::data_from(given).closed_pressure(bodies.pressure);
            data.closure_length(self.part * bodies.approach)
        };
        let form = |given| rough::between(&data(given), &omega, &touch);
        bodies.follow(10.0, form, |given, u| rough::traction(&data(given), u))
    }
}

impl Formulation for Exponential {
    fn name(&self) -> String {
        format!("exponential, c/d = {}", self.part)
    }

    fn solve(&self, case: &Case) -> Result<Outcome, Refusal> {
        let data = law::data_from(case.data.clone()).closed_pressure(case.pressure);
        let data = data.closure_length(self.part * case.approach);
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
        let data = volume::data_from(membrane.data.clone()).closed_pressure(membrane.pressure);
        let data = data.closure_length(self.part * membrane.approach);
        membrane.newton(&volume::above(&data, &membrane.omega()), |u| volume::force(&data, u))
    }

    fn press(&self, ring: &Rubber) -> Result<Pressed, Refusal> {
        let length = self.part * ring.end as f64;
        let data = |way: f64| {
            rubber::data_from(ring.data(way)).closed_pressure(ring.pressure).closure_length(length)
        };
        ring.follow(|way| rubber::on_flat(&data(way), &ring.omega(), &ring.surface()))
    }

    fn rub(&self, bodies: &TwoBodies<2>) -> Result<Vec<AfterLoad<2>>, Refusal> {
        self.between(bodies)
    }

    fn stack(&self, bodies: &TwoBodies<3>) -> Result<Vec<AfterLoad<3>>, Refusal> {
        self.between(bodies)
    }

    fn slide(&self, bodies: &Sliding) -> Result<Vec<Slid>, Refusal> {
        let data = drawn::data_from(bodies.data.clone()).closed_pressure(bodies.pressure);
        let data = data.closure_length(self.part * bodies.approach);
        bodies.follow(&drawn::between(&data, &bodies.omega(), &bodies.touch(Sides::Own)))
    }
}

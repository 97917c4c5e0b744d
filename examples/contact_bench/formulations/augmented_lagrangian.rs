//! The augmented Lagrangian with semismooth Newton steps: a multiplier on the own surface, of the displacement's degree.

use contact_bench::two_bodies::known;
use contact_bench::{
    AfterLoad, Case, Contact, Formulation, Membrane, Outcome, Pressed, Refusal, Rubber, Sides, Slid, Sliding,
    TwoBodies,
};
use forms_fem::prelude::*;

#[forms(dimension = 2)]
mod law {
    pub use contact_bench::body::{Loaded, Omega, Surface, Touch};
    use contact_bench::body::{balance, distance, obstacle_distance, own_stiffness, own_weight, weight};
    #[includes(contact_bench::body::Data)]
    pub struct Data {}
    pub fn on_obstacle(u: Unknown<Vector>, l: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        let gamma = 10 * young / h;
        let update = pos_part(l - gamma * obstacle_distance(u));
        let terms = l * dot(v, obstacle_normal) - (l - update) / gamma * q;
        balance(u, v) + integral(Surface, weight() * terms)
    }
    pub fn between(u: Unknown<Vector>, l: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        let gamma = 10 * own_stiffness();
        let update = pos_part(this(l) - gamma * distance(u));
        let terms = this(l) * dot(toward, jump(v)) - (this(l) - update) / gamma * this(q);
        balance(u, v) + integral(Touch, own_weight() * terms)
    }
}

#[forms(dimension = 2)]
mod volume {
    pub use contact_bench::volume::Omega;
    use contact_bench::volume::{balance, height};
    #[includes(contact_bench::volume::Data)]
    pub struct Data {}
    pub fn above(u: Unknown<Scalar>, l: Unknown<Scalar>, v: Test<Scalar>, q: Test<Scalar>) -> Form {
        let gamma = 10 / (h * h);
        let update = pos_part(l - gamma * height(u));
        balance(u, v) - integral(Omega, l * v + (l - update) / gamma * q)
    }
}

#[forms(dimension = 2)]
mod rubber {
    pub use contact_bench::rubber::{Omega, Surface};
    use contact_bench::rubber::{body, distance, stiffness};
    #[includes(contact_bench::rubber::Data)]
    pub struct Data {}
    pub fn on_flat(
        u: Unknown<Vector>,
        p: Unknown<Scalar>,
        l: Unknown<Scalar>,
        v: Test<Vector>,
        q: Test<Scalar>,
        m: Test<Scalar>,
    ) -> Form {
        let gamma = 10 * stiffness();
        let update = pos_part(l - gamma * distance(u));
        body(u, p, v, q) + integral(Surface, l * dot(v, obstacle_normal) - (l - update) / gamma * m)
    }
}

#[forms]
mod rough {
    pub use contact_bench::two_bodies::bodies::{Omega, Touch};
    use contact_bench::two_bodies::bodies::{allowed, balance};
    use forms_contact::operators::bodies::own_gamma;
    #[includes(contact_bench::two_bodies::bodies::Data)]
    pub struct Data {}
    pub fn between(u: Unknown<Vector>, l: Unknown<Vector>, v: Test<Vector>, q: Test<Vector>) -> Form {
        let error = (this(l) - allowed(l, u)) / own_gamma();
        balance(u, v) - integral(Touch, dot(this(l), jump(v)) + dot(error, this(q)))
    }
}

#[forms(dimension = 2)]
mod drawn {
    pub use contact_bench::sliding::{Omega, Touch};
    use contact_bench::sliding::{balance, own_stiffness};
    #[includes(contact_bench::sliding::Data)]
    pub struct Data {}
    pub fn between(u: Unknown<Vector>, l: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        let gamma = 10 * own_stiffness();
        let error = (this(l) - pos_part(this(l) - gamma * gap)) / gamma;
        balance(u, v) + integral(Touch(u), this(l) * dot(toward, jump(v)) - error * this(q))
    }
}

/// A multiplier on the own surface, with semismooth steps.
pub struct AugmentedLagrangian;

/// The one variant.
pub fn all() -> Vec<AugmentedLagrangian> {
    vec![AugmentedLagrangian]
}

impl AugmentedLagrangian {
    fn between<const D: usize>(&self, bodies: &TwoBodies<D>) -> Result<Vec<AfterLoad<D>>, Refusal>
    where
        Dim: Dimension<D>,
    {
        let (omega, touch, space) = (bodies.omega(), bodies.touch(Sides::Own), &bodies.space);
        let traces = Space::vector_on_facets(space.mesh(), &bodies.surfaces[0], space.degree())?;
        let form = |data| rough::between(&rough::data_from(data), &omega, &touch);
        let start = [Field::zero(space), Field::zero(&traces)];
        bodies.follow_fields((10.0, Case::options()), start, form, |data, [_, l]| known(&data, l))
    }
}

impl Formulation for AugmentedLagrangian {
    fn name(&self) -> String {
        "augmented Lagrangian".to_owned()
    }

    fn solve(&self, case: &Case) -> Result<Outcome, Refusal> {
        let (data, bodies, load) = (law::data_from(case.data.clone()), case.bodies(), case.load());
        let form = match case.contact {
            Contact::Obstacle(_) => law::on_obstacle(&data, &bodies, &load, &case.surface()),
            Contact::Bodies(_) => law::between(&data, &bodies, &load, &case.touch(Sides::Own)),
        };
        let (scalars, u) = (case.scalars()?, case.first());
        let guess = Field::zero(&scalars);
        let solved = case.mixed_problem(&form, [&case.space, &scalars]).start([&u, &guess]).solve()?;
        let pressures = case.known_pressures(&solved.fields[1])?;
        Ok(Outcome::of(case, &solved, pressures)?.of_form(form))
    }

    fn cover(&self, membrane: &Membrane) -> Result<Outcome, Refusal> {
        let data = volume::data_from(membrane.data.clone());
        let form = volume::above(&data, &membrane.omega());
        let solved = membrane.mixed_problem(&form, &membrane.space).solve()?;
        Ok(membrane.outcome(&solved, membrane.known_pressures(&solved.fields[1])?))
    }

    fn press(&self, ring: &Rubber) -> Result<Pressed, Refusal> {
        let ([u, p], scalars) = (&ring.spaces, ring.scalars()?);
        let data = |way: f64| rubber::data_from(ring.data(way));
        let form = |way: f64| rubber::on_flat(&data(way), &ring.omega(), &ring.surface());
        ring.follow_all([u, p, &scalars], form, |_| Ok(None))
    }

    fn rub(&self, bodies: &TwoBodies<2>) -> Result<Vec<AfterLoad<2>>, Refusal> {
        self.between(bodies)
    }

    fn stack(&self, bodies: &TwoBodies<3>) -> Result<Vec<AfterLoad<3>>, Refusal> {
        self.between(bodies)
    }

    fn slide(&self, bodies: &Sliding) -> Result<Vec<Slid>, Refusal> {
        let data = drawn::data_from(bodies.data.clone());
        let form = drawn::between(&data, &bodies.omega(), &bodies.touch(Sides::OwnWholeFacets));
        bodies.follow_pressure(&form, &bodies.scalars(bodies.space.degree())?)
    }
}

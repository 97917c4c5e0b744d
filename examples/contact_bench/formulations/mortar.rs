//! Mortar: multipliers of degree 1, or 2 with Bernstein's polynomials, on the own facets with a condition per function, as in `forms_contact::laws::mortar_bodies`.

use contact_bench::outcome::not_defined;
use contact_bench::{
    AfterLoad, Case, Contact, Formulation, Outcome, Pressed, Refusal, Rubber, Sides, Slid, Sliding, TwoBodies,
};
use forms_fem::prelude::*;

#[forms(dimension = 2)]
mod law {
    pub use contact_bench::body::{Loaded, Omega, Touch};
    use contact_bench::body::{balance, distance, own_weight};
    pub use forms_contact::operators::multipliers::Own;
    use forms_contact::operators::multipliers::conditions;
    #[includes(contact_bench::body::Data, forms_contact::operators::multipliers::Data)]
    pub struct Data {}
    pub fn between(
        u: Unknown<Vector>,
        p: Unknown<Scalar>,
        g: Unknown<Scalar>,
        v: Test<Vector>,
        q: Test<Scalar>,
        r: Test<Scalar>,
    ) -> Form {
        balance(u, v)
            + conditions(p, g, q, r, 10 * young / h)
            + integral(Touch, own_weight() * (this(p) * dot(toward, jump(v)) + distance(u) * this(r - q)))
    }
}

#[forms(dimension = 2)]
mod drawn {
    use contact_bench::sliding::balance;
    pub use contact_bench::sliding::{Omega, Touch};
    pub use forms_contact::operators::multipliers::Own;
    use forms_contact::operators::multipliers::conditions;
    #[includes(contact_bench::sliding::Data, forms_contact::operators::multipliers::Data)]
    pub struct Data {}
    pub fn between(
        u: Unknown<Vector>,
        p: Unknown<Scalar>,
        g: Unknown<Scalar>,
        v: Test<Vector>,
        q: Test<Scalar>,
        r: Test<Scalar>,
    ) -> Form {
        balance(u, v)
            + conditions(p, g, q, r, 10 * young / h)
            + integral(Touch(u), this(p) * dot(toward, jump(v)) + gap * this(r - q))
    }
}

#[forms(dimension = 2)]
mod rough {
    pub use contact_bench::two_bodies::bodies::{Omega, Touch};
    use contact_bench::two_bodies::bodies::{balance, separation};
    pub use forms_contact::laws::mortar_bodies::mortar_bodies_with_friction::traction_of;
    pub use forms_contact::operators::multipliers::Own;
    use forms_contact::operators::multipliers::{frictional_conditions, moved};
    #[includes(contact_bench::two_bodies::bodies::Data, forms_contact::operators::multipliers::Data)]
    pub struct Data {}
    pub fn between(
        u: Unknown<Vector>,
        m: Unknown<Vector>,
        d: Unknown<Vector>,
        v: Test<Vector>,
        q: Test<Vector>,
        r: Test<Vector>,
    ) -> Form {
        let slip = jump(u - displacement_before);
        balance(u, v)
            + frictional_conditions(m, d, q, r, gamma0 / h)
            + integral(Touch, moved(separation(u), slip, this(r - q), toward) - dot(traction_of(m), jump(v)))
    }
}

#[forms(dimension = 3)]
mod stacked {
    pub use contact_bench::two_bodies::bodies::{Omega, Touch};
    use contact_bench::two_bodies::bodies::{balance, separation};
    pub use forms_contact::operators::multipliers::Own;
    use forms_contact::operators::multipliers::conditions;
    #[includes(contact_bench::two_bodies::bodies::Data, forms_contact::operators::multipliers::Data)]
    pub struct Data {}
    pub fn between(
        u: Unknown<Vector>,
        p: Unknown<Scalar>,
        g: Unknown<Scalar>,
        v: Test<Vector>,
        q: Test<Scalar>,
        r: Test<Scalar>,
    ) -> Form {
        balance(u, v)
            + conditions(p, g, q, r, gamma0 / h)
            + integral(Touch, this(p) * dot(toward, jump(v)) + separation(u) * this(r - q))
    }
    pub fn traction(p: State<Scalar>) -> Vector {
        -this(p) * toward
    }
}

const RIGID: &str = "a rigid obstacle has no mesh: this is the augmented Lagrangian";

/// Multipliers with a condition per function.
pub struct Mortar {
    /// Of the multipliers.
    degree: usize,
}

/// Multipliers of degree 1 and 2.
pub fn all() -> Vec<Mortar> {
    vec![Mortar { degree: 1 }, Mortar { degree: 2 }]
}

impl Mortar {
    fn multipliers<const D: usize>(
        &self,
        displacements: &Space<D>,
        own: &str,
        shape: &[usize],
    ) -> Result<Arc<Space<D>>, Refusal> {
        if displacements.degree() < self.degree {
            return Err(not_defined("the displacements have a lower degree than the multipliers"));
        }
        let scope = Scope::Facets(own.to_owned());
        Ok(Space::of(displacements.mesh(), Elements::Bernstein(self.degree), scope, shape)?)
    }
}

impl Formulation for Mortar {
    fn name(&self) -> String {
        format!("mortar, degree {}", self.degree)
    }

    fn solve(&self, case: &Case) -> Result<Outcome, Refusal> {
        if let Contact::Obstacle(_) = case.contact {
            return Err(not_defined(RIGID));
        }
        let (data, own) = (law::data_from(case.data.clone()), law::Own::on(case.own()));
        let form = law::between(&data, &case.bodies(), &case.load(), &case.touch(Sides::Own), &own);
        let scalars = self.multipliers(&case.space, case.own(), &[])?;
        let guess = Field::from_values(&scalars, vec![case.pressure; scalars.unknowns()])?;
        let start = [case.first(), guess, Field::zero(&scalars)];
        let problem = case.mixed_problem(&form, [&case.space, &scalars, &scalars]);
        let solved = problem.options(NewtonOptions::default()).start(&start).solve()?;
        let pressures = case.known_pressures(&solved.fields[1])?;
        Ok(Outcome::of(case, &solved, pressures)?.of_form(form))
    }

    fn press(&self, _ring: &Rubber) -> Result<Pressed, Refusal> {
        Err(not_defined(RIGID))
    }

    fn slide(&self, bodies: &Sliding) -> Result<Vec<Slid>, Refusal> {
        let (data, own) = (drawn::data_from(bodies.data.clone()), drawn::Own::on(bodies.surfaces[0]));
        let form = drawn::between(&data, &bodies.omega(), &bodies.touch(Sides::Own), &own);
        let scalars = self.multipliers(&bodies.space, bodies.surfaces[0], &[])?;
        let guess = Field::from_values(&scalars, vec![bodies.pressure; scalars.unknowns()])?;
        let start = [bodies.start.clone(), guess, Field::zero(&scalars)];
        bodies.follow_all(&form, start, NewtonOptions::default())
    }

    fn rub(&self, bodies: &TwoBodies<2>) -> Result<Vec<AfterLoad<2>>, Refusal> {
        let own = bodies.surfaces[0].as_str();
        let (omega, touch) = (bodies.omega(), bodies.touch(Sides::Own));
        let traces = self.multipliers(&bodies.space, own, &[2])?;
        let form = |data| rough::between(&rough::data_from(data), &omega, &touch, &rough::Own::on(own));
        let start = [&bodies.space, &traces, &traces].map(Field::zero);
        bodies.follow_fields((10.0, Case::options()), start, form, |data, [_, m, _]| {
            rough::traction_of(&rough::data_from(data), m)
        })
    }

    fn stack(&self, bodies: &TwoBodies<3>) -> Result<Vec<AfterLoad<3>>, Refusal> {
        let own = bodies.surfaces[0].as_str();
        let (omega, touch) = (bodies.omega(), bodies.touch(Sides::Own));
        let scalars = self.multipliers(&bodies.space, own, &[])?;
        let form = |data| stacked::between(&stacked::data_from(data), &omega, &touch, &stacked::Own::on(own));
        let start = [&bodies.space, &scalars, &scalars].map(Field::zero);
        bodies.follow_fields((10.0, NewtonOptions::default()), start, form, |data, [_, p, _]| {
            stacked::traction(&stacked::data_from(data), p)
        })
    }
}

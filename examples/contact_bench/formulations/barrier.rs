//! A log barrier on the gap, −(g − ĝ)² ln(g/ĝ): ĝ from the size of the change of the gap down by tenths.

use contact_bench::two_bodies::SolvedLoad;
use contact_bench::{
    AfterLoad, Case, Contact, Formulation, Membrane, Outcome, Pressed, Refusal, Rubber, Sides, Slid, Sliding,
    TwoBodies,
};
use forms_contact::laws::barrier_obstacle::stiffness;
use forms_fem::prelude::*;

#[forms(dimension = 2)]
mod law {
    pub use contact_bench::body::{Surface, Touch};
    use contact_bench::body::{distance, obstacle_distance, own_weight, weight};
    use forms_contact::operators::barrier::{barrier, barrier_pressure};
    #[includes(contact_bench::body::Data, forms_contact::operators::barrier::Data)]
    pub struct Data {}
    pub fn pressure(u: Vector) -> Scalar {
        barrier_pressure(obstacle_distance(u) + clearance)
    }
    pub fn on_obstacle(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Surface, weight() * pressure(u) * dot(v, obstacle_normal))
    }
    pub fn obstacle_gaps(u: Unknown<Vector>) -> Functional {
        integral(Surface, obstacle_distance(u) + clearance)
    }
    pub fn pair_pressure(u: Vector) -> Scalar {
        barrier_pressure(distance(u) + clearance)
    }
    pub fn between(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Touch, own_weight() * pair_pressure(u) * dot(toward, jump(v)))
    }
    pub fn gaps(u: Unknown<Vector>) -> Functional {
        integral(Touch, distance(u) + clearance)
    }
}

#[forms(dimension = 2)]
mod volume {
    pub use contact_bench::volume::Omega;
    use contact_bench::volume::height;
    use forms_contact::operators::barrier::barrier_pressure;
    #[includes(contact_bench::volume::Data, forms_contact::operators::barrier::Data)]
    pub struct Data {}
    pub fn force(u: Scalar) -> Scalar {
        barrier_pressure(height(u))
    }
    pub fn above(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        -integral(Omega, force(u) * v)
    }
    pub fn heights(u: Unknown<Scalar>) -> Functional {
        integral(Omega, height(u))
    }
}

#[forms(dimension = 2)]
mod rubber {
    pub use contact_bench::rubber::{Omega, Surface};
    use contact_bench::rubber::{body, distance};
    use forms_contact::operators::barrier::barrier_pressure;
    #[includes(contact_bench::rubber::Data, forms_contact::operators::barrier::Data)]
    pub struct Data {}
    pub fn on_flat(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        body(u, p, v, q)
            + integral(Surface, barrier_pressure(distance(u) + clearance) * dot(v, obstacle_normal))
    }
    pub fn gaps(u: Unknown<Vector>, p: Unknown<Scalar>) -> Functional {
        integral(Surface, distance(u) + clearance + 0 * p)
    }
}

#[forms]
mod rough {
    pub use contact_bench::two_bodies::bodies::{Omega, Touch};
    use contact_bench::two_bodies::bodies::{balance, separation};
    use forms_contact::operators::barrier::barrier_pressure;
    use forms_contact::operators::bodies::own_gamma;
    use forms_contact::operators::friction::{ball_projection, slip_limit, tangential};
    #[includes(contact_bench::two_bodies::bodies::Data, forms_contact::operators::barrier::Data)]
    pub struct Data {}
    pub fn traction(u: Vector) -> Vector {
        let p = barrier_pressure(separation(u) + clearance);
        let held = -own_gamma() * tangential(jump(u - displacement_before), toward);
        ball_projection(held, slip_limit(p)) - p * toward
    }
    pub fn between(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        balance(u, v) - integral(Touch, dot(traction(u), jump(v)))
    }
    pub fn gaps(u: Unknown<Vector>) -> Functional {
        integral(Touch, separation(u) + clearance)
    }
}

#[forms(dimension = 2)]
mod drawn {
    use contact_bench::sliding::balance;
    pub use contact_bench::sliding::{Omega, Touch};
    use forms_contact::operators::barrier::barrier_pressure;
    #[includes(contact_bench::sliding::Data, forms_contact::operators::barrier::Data)]
    pub struct Data {}
    pub fn between(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        balance(u, v) + integral(Touch(u), barrier_pressure(gap + clearance) * dot(toward, jump(v)))
    }
    pub fn gaps(u: Unknown<Vector>) -> Functional {
        integral(Touch(u), gap + clearance)
    }
}

/// The last ĝ, as a part of the problem's change of the gap.
pub struct Barrier {
    tenths: i32,
}

/// ĝ at the end of a tenth and a hundredth of the change of the gap.
pub fn all() -> Vec<Barrier> {
    [1, 2].map(|tenths| Barrier { tenths }).into()
}

impl Barrier {
    /// The solutions for ĝ from the size of the change of the gap down by tenths; the last one is the outcome.
    fn descend(
        &self,
        (start, approach): (&Field<2>, f64),
        step: impl Fn(f64, &Field<2>) -> Result<Outcome, Refusal>,
    ) -> Result<Outcome, Refusal> {
        let mut found = step(approach, start)?;
        let mut newton = found.newton.clone();
        for tenths in 1..=self.tenths {
            found = step(approach * 0.1_f64.powi(tenths), &found.u)?;
            newton.extend(&found.newton);
        }
        Ok(found.after(newton))
    }

    /// The last ĝ, which paths take at once: the state before is near. Their clearance is half of it.
    fn last(&self, approach: f64) -> f64 {
        approach * 0.1_f64.powi(self.tenths)
    }

    fn between<const D: usize>(&self, bodies: &TwoBodies<D>) -> Result<Vec<AfterLoad<D>>, Refusal>
    where
        Dim: Dimension<D>,
    {
        let (omega, touch, reach) = (bodies.omega(), bodies.touch(Sides::Own), self.last(bodies.approach));
        bodies.follow_by(10.0, [Field::zero(&bodies.space)], |given, load, [u]| {
            let data = rough::data_from(given).barrier_stiffness(stiffness(bodies.pressure, reach));
            let data = data.activation_gap(reach).clearance(0.5 * reach);
            let problem = bodies.problem(&rough::between(&data, &omega, &touch), load).options(options());
            let solved = problem.keep_positive(&rough::gaps(&data, &touch)).start(u).solve()?;
            let traction = rough::traction(&data, solved.field());
            Ok(SolvedLoad::of(solved, traction))
        })
    }
}

/// Gaps stay positive where values are prescribed in the tangent's steps, too.
fn options() -> NewtonOptions {
    let prescribed_values = PrescribedValues::ByTangent;
    NewtonOptions { prescribed_values, max_iterations: 100, ..Case::options() }
}

/// The solution of contact terms in u whose gaps stay positive.
fn guarded(
    case: &Case,
    start: &Field<2>,
    (form, gaps): (Form<2>, Functional<2>),
    pressure: impl Fn(&Field<2>) -> Expression<2>,
) -> Result<Outcome, Refusal> {
    let solved = case.problem(&form).start(start).options(options()).keep_positive(&gaps).solve()?;
    let pressures = case.pressures(&pressure(solved.field()))?;
    Ok(Outcome::of(case, &solved, pressures)?.of_form(&case.balance() + &form))
}

impl Formulation for Barrier {
    fn name(&self) -> String {
        format!("log barrier, ĝ/d = {}", 1.0 / 10_f64.powi(self.tenths))
    }

    fn solve(&self, case: &Case) -> Result<Outcome, Refusal> {
        let (surface, touch) = (case.surface(), case.touch(Sides::Own));
        let step = |reach: f64, u: &Field<2>| {
            let data = law::data_from(case.data.clone()).barrier_stiffness(stiffness(case.pressure, reach));
            let data = data.activation_gap(reach);
            if let Contact::Obstacle(_) = case.contact {
                let forms = (law::on_obstacle(&data, &surface), law::obstacle_gaps(&data, &surface));
                return guarded(case, u, forms, |u| law::pressure(&data, u));
            }
            // Bodies touch at first: the clearance is what they may overlap by.
            let data = data.clearance(0.5 * reach);
            let forms = (law::between(&data, &touch), law::gaps(&data, &touch));
            guarded(case, u, forms, |u| law::pair_pressure(&data, u))
        };
        self.descend((&Field::zero(&case.space), case.approach), step)
    }

    fn cover(&self, membrane: &Membrane) -> Result<Outcome, Refusal> {
        let omega = membrane.omega();
        let step = |reach: f64, u: &Field<2>| {
            let stiffness = stiffness(membrane.pressure, reach);
            let data = volume::data_from(membrane.data.clone()).barrier_stiffness(stiffness);
            let data = data.activation_gap(reach);
            let problem = membrane.problem(&volume::above(&data, &omega)).start(u);
            let solved = problem.keep_positive(&volume::heights(&data, &omega)).solve()?;
            let pressures = membrane.pressures(&volume::force(&data, solved.field()))?;
            Ok(membrane.outcome(&solved, pressures))
        };
        self.descend((&membrane.above, membrane.approach), step)
    }

    fn press(&self, ring: &Rubber) -> Result<Pressed, Refusal> {
        let reach = self.last(ring.end as f64);
        let data = rubber::data_from(ring.data(0.0)).barrier_stiffness(stiffness(ring.pressure, reach));
        let data = data.activation_gap(reach).clearance(0.5 * reach);
        let form = rubber::on_flat(&data, &ring.omega(), &ring.surface());
        let gaps = rubber::gaps(&data, &ring.surface());
        // The body is moved in steps that the gaps allow, and not the flat.
        ring.follow_moved(|attempt, held, start| {
            let problem = attempt.problem(&form).constrained(held).options(options()).keep_positive(&gaps);
            attempt.solved(problem.start(start))
        })
    }

    fn rub(&self, bodies: &TwoBodies<2>) -> Result<Vec<AfterLoad<2>>, Refusal> {
        self.between(bodies)
    }

    fn stack(&self, bodies: &TwoBodies<3>) -> Result<Vec<AfterLoad<3>>, Refusal> {
        self.between(bodies)
    }

    fn slide(&self, bodies: &Sliding) -> Result<Vec<Slid>, Refusal> {
        let (omega, touch, reach) = (bodies.omega(), bodies.touch(Sides::Own), self.last(bodies.approach));
        let data = drawn::data_from(bodies.data.clone());
        let data = data.barrier_stiffness(stiffness(bodies.pressure, reach));
        let data = data.activation_gap(reach).clearance(0.5 * reach);
        let (form, gaps) = (drawn::between(&data, &omega, &touch), drawn::gaps(&data, &touch));
        // The bodies touch at one point at first.
        bodies.follow_by([Field::zero(&bodies.space)], |supports, [u]| {
            let problem = bodies.problem(&form, supports).options(options()).keep_positive(&gaps);
            let solved = problem.start(u).solve()?;
            let newton = vec![solved.iterations()];
            Ok((solved, newton))
        })
    }
}

//! A log barrier on the gap, −(g − ĝ)² ln(g/ĝ): ĝ from the size of the change of the gap down by tenths.

use contact_bench::{Case, Contact, Formulation, Membrane, Outcome, Refusal, Sides};
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
}

/// The solution of contact terms in u whose gaps stay positive.
fn guarded(
    case: &Case,
    start: &Field<2>,
    (form, gaps): (Form<2>, Functional<2>),
    pressure: impl Fn(&Field<2>) -> Expression<2>,
) -> Result<Outcome, Refusal> {
    let prescribed_values = PrescribedValues::ByTangent;
    let options = NewtonOptions { prescribed_values, max_iterations: 100, ..Case::options() };
    let solved = case.problem(&form).start(start).options(options).keep_positive(&gaps).solve()?;
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
}

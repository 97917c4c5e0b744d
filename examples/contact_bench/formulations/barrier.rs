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

pub fn all() -> Vec<Barrier> {
    [1, 2].map(|tenths| Barrier { tenths }).into()
}

impl Formulation for Barrier {
    fn name(&self) -> String {
        format!("log barrier, ĝ/d = {}", 1.0 / 10_f64.powi(self.tenths))
    }

    fn solve(&self, case: &Case) -> Result<Outcome, Refusal> {
        let (mut u, mut newton, mut found) = (Field::zero(&case.space), vec![], None);
        for tenths in 0..=self.tenths {
            let reach = case.approach * 0.1_f64.powi(tenths);
            // Bodies touch at first: the clearance is what they may overlap by.
            let clearance = if matches!(case.contact, Contact::Bodies(_)) { 0.5 * reach } else { 0.0 };
            let data = law::data_from(case.data.clone()).barrier_stiffness(stiffness(case.pressure, reach));
            let data = data.activation_gap(reach).clearance(clearance);
            let (form, gaps) = match case.contact {
                Contact::Obstacle(_) => {
                    (law::on_obstacle(&data, &case.surface()), law::obstacle_gaps(&data, &case.surface()))
                }
                Contact::Bodies(_) => {
                    (law::between(&data, &case.touch(Sides::Own)), law::gaps(&data, &case.touch(Sides::Own)))
                }
            };
            let options = NewtonOptions {
                prescribed_values: PrescribedValues::ByTangent,
                max_iterations: 100,
                ..Case::options()
            };
            let solved = case.problem(&form).start(&u).options(options).keep_positive(&gaps).solve()?;
            newton.push(solved.iterations());
            let pressure = match case.contact {
                Contact::Obstacle(_) => law::pressure(&data, solved.field()),
                Contact::Bodies(_) => law::pair_pressure(&data, solved.field()),
            };
            found = Some(
                Outcome::of(case, &solved, case.pressures(&pressure)?)?.of_form(&case.balance() + &form),
            );
            u = solved.into_field();
        }
        found.map(|found| found.after(newton)).ok_or_else(|| Refusal::Failed("no step".to_owned()))
    }

    fn cover(&self, membrane: &Membrane) -> Result<Outcome, Refusal> {
        let (mut u, mut newton, mut found) = (membrane.above.clone(), vec![], None);
        for tenths in 0..=self.tenths {
            let reach = membrane.approach * 0.1_f64.powi(tenths);
            let stiffness = stiffness(membrane.pressure, reach);
            let data = volume::data_from(membrane.data.clone()).barrier_stiffness(stiffness);
            let data = data.activation_gap(reach);
            let problem = membrane.problem(&volume::above(&data, &membrane.omega()));
            let heights = volume::heights(&data, &membrane.omega());
            let solved = problem.start(&u).keep_positive(&heights).solve()?;
            newton.push(solved.iterations());
            let pressures = membrane.pressures(&volume::force(&data, solved.field()))?;
            found = Some(membrane.outcome(&solved, pressures));
            u = solved.into_field();
        }
        found.map(|found| found.after(newton)).ok_or_else(|| Refusal::Failed("no step".to_owned()))
    }
}

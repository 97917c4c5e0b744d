//! Proximal Galerkin: the gap is e^ψ with ψ on the own surface, and the pressure is (ψ before − ψ)/α.

use contact_bench::{Case, Contact, Formulation, Outcome, Refusal, Sides};
use forms_contact::proximal::{Proximal, ProximalOptions, solve_by_proximal_points};
use forms_fem::prelude::*;

#[forms(dimension = 2)]
mod law {
    pub use contact_bench::body::{Loaded, Omega, Surface, Touch};
    use contact_bench::body::{balance, distance, obstacle_distance, own_weight, weight};
    #[includes(contact_bench::body::Data)]
    pub struct Data {
        alpha: Param,
    }
    pub fn on_obstacle(
        u: Unknown<Vector>,
        psi: Unknown<Scalar>,
        v: Test<Vector>,
        w: Test<Scalar>,
        before: State<Scalar>,
    ) -> Form {
        let pressed = (before - psi) / alpha * dot(v, obstacle_normal);
        balance(u, v) + integral(Surface, weight() * (pressed + (obstacle_distance(u) - exp(psi)) * w))
    }
    pub fn between(
        u: Unknown<Vector>,
        psi: Unknown<Scalar>,
        v: Test<Vector>,
        w: Test<Scalar>,
        before: State<Scalar>,
    ) -> Form {
        let pressed = this(before - psi) / alpha * dot(toward, jump(v));
        balance(u, v) + integral(Touch, own_weight() * (pressed + (distance(u) - exp(this(psi))) * this(w)))
    }
}

pub struct ProximalGalerkin;

pub fn all() -> Vec<ProximalGalerkin> {
    vec![ProximalGalerkin]
}

impl Formulation for ProximalGalerkin {
    fn name(&self) -> String {
        "proximal Galerkin".to_owned()
    }

    fn solve(&self, case: &Case) -> Result<Outcome, Refusal> {
        let (scalars, bodies, load) = (case.scalars()?, case.bodies(), case.load());
        let step = |Proximal { alpha, before }: Proximal<'_, 2>| {
            let data = law::data_from(case.data.clone()).alpha(alpha);
            let form = match case.contact {
                Contact::Obstacle(_) => law::on_obstacle(&data, &bodies, &load, &case.surface(), &before[1]),
                Contact::Bodies(_) => {
                    law::between(&data, &bodies, &load, &case.touch(Sides::Own), &before[1])
                }
            };
            // Undamped: a line search on the residual stalls where e^ψ is far off.
            let problem = case.mixed_problem(&form, &scalars).options(NewtonOptions::default());
            problem.start([&before[0], &before[1]]).solve()
        };
        let options = ProximalOptions { first_step: 10.0 / case.pressure, ..ProximalOptions::default() };
        let start = [case.first(), Field::zero(&scalars)];
        let found = solve_by_proximal_points(start, options, step, |_| ())?;
        let pressures = case.known_pressures(&found.multiplier)?;
        let newton = found.history.steps.iter().map(|step| step.newton_steps).collect();
        Ok(Outcome::of(case, &found.solved, pressures)?.after(newton))
    }
}

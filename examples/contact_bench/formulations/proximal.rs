//! Proximal Galerkin: the gap is e^ψ with ψ on the own surface, and the pressure is (ψ before − ψ)/α.

use contact_bench::{Case, Contact, Formulation, Outcome, Refusal, Sides};
use forms_contact::proximal::{Proximal, ProximalOptions, solve_by_proximal_points};
use forms_fem::prelude::*;

#[forms(dimension = 2)]
mod law {
    pub use contact_bench::body::{Surface, Touch};
    use contact_bench::body::{distance, obstacle_distance, own_weight, weight};
    #[includes(contact_bench::body::Data)]
    pub struct Data {}
    pub fn on_obstacle(
        u: Unknown<Vector>,
        psi: Unknown<Scalar>,
        v: Test<Vector>,
        w: Test<Scalar>,
        before: State<Scalar>,
    ) -> Form {
        let pressed = (before - psi) * dot(v, obstacle_normal);
        integral(Surface, weight() * (pressed + (obstacle_distance(u) - exp(psi)) * w))
    }
    pub fn between(
        u: Unknown<Vector>,
        psi: Unknown<Scalar>,
        v: Test<Vector>,
        w: Test<Scalar>,
        before: State<Scalar>,
    ) -> Form {
        let pressed = this(before - psi) * dot(toward, jump(v));
        integral(Touch, own_weight() * (pressed + (distance(u) - exp(this(psi))) * this(w)))
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
        let (data, scalars) = (law::data_from(case.data.clone()), case.scalars()?);
        let step = |Proximal { alpha, before }: Proximal<'_, 2>| {
            let contact = match case.contact {
                Contact::Obstacle(_) => law::on_obstacle(&data, &case.surface(), &before[1]),
                Contact::Bodies(_) => law::between(&data, &case.touch(Sides::Own), &before[1]),
            };
            let scaled = (1.0 / alpha) * &contact;
            case.mixed_problem(&scaled, &scalars).start([&before[0], &before[1]]).solve()
        };
        let options = ProximalOptions { first_step: 10.0 / case.pressure, ..ProximalOptions::default() };
        let start = [case.first(), Field::zero(&scalars)];
        let found = solve_by_proximal_points(start, options, step, |_| ())?;
        let pressures = case.known_pressures(&found.multiplier)?;
        let newton = found.history.steps.iter().map(|step| step.newton_steps).collect();
        Ok(Outcome::of(case, &found.solved, pressures)?.after(newton))
    }
}

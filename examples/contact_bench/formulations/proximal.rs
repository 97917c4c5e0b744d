//! Proximal Galerkin: the gap is e^ψ with ψ on the own surface, and the pressure is (ψ before − ψ)/α.

use contact_bench::outcome::not_defined;
use contact_bench::{Case, Contact, Formulation, Membrane, Outcome, Refusal, Sides};
use forms_contact::proximal::{Proximal, ProximalOptions, solve_by_proximal_points};
use forms_fem::prelude::*;

#[forms(dimension = 2)]
mod law {
    pub use contact_bench::body::{Loaded, Omega, Surface, Touch};
    use contact_bench::body::{balance, distance, obstacle_distance, own_weight, weight};
    #[includes(contact_bench::body::Data)]
    pub struct Data {
        alpha: Param,
        /// 1, or 0 for the line that touches e^ψ at the ψ before: one step of Newton's method.
        whole: Param,
    }
    pub fn slack(psi: Scalar, before: Scalar) -> Scalar {
        exp(before + whole * (psi - before)) * (1 + (1 - whole) * (psi - before))
    }
    pub fn on_obstacle(
        u: Unknown<Vector>,
        psi: Unknown<Scalar>,
        v: Test<Vector>,
        w: Test<Scalar>,
        before: State<Scalar>,
    ) -> Form {
        let pressed = (before - psi) / alpha * dot(v, obstacle_normal);
        balance(u, v)
            + integral(Surface, weight() * (pressed + (obstacle_distance(u) - slack(psi, before)) * w))
    }
    pub fn between(
        u: Unknown<Vector>,
        psi: Unknown<Scalar>,
        v: Test<Vector>,
        w: Test<Scalar>,
        before: State<Scalar>,
    ) -> Form {
        let pressed = this(before - psi) / alpha * dot(toward, jump(v));
        balance(u, v)
            + integral(Touch, own_weight() * (pressed + (distance(u) - this(slack(psi, before))) * this(w)))
    }
}

#[forms(dimension = 2)]
mod volume {
    pub use contact_bench::volume::Omega;
    use contact_bench::volume::{balance, height};
    #[includes(contact_bench::volume::Data)]
    pub struct Data {
        alpha: Param,
        whole: Param,
    }
    use super::law::slack;
    pub fn above(
        u: Unknown<Scalar>,
        psi: Unknown<Scalar>,
        v: Test<Scalar>,
        w: Test<Scalar>,
        before: State<Scalar>,
    ) -> Form {
        balance(u, v) + integral(Omega, (psi - before) / alpha * v + (height(u) - slack(psi, before)) * w)
    }
}

/// The space of ψ.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Latent {
    /// Continuous, of the displacement's degree.
    Equal,
    /// Two degrees less, cell by cell.
    Cells,
}

/// Steps of Newton's method for each α.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Inner {
    /// Until the equations hold, for α that double.
    Whole,
    /// One, for α that double.
    One,
    /// One, for a constant α, as in MFEM's example 36, until the change is below 10⁻⁴.
    OneOfConstant,
}

#[derive(Clone, Copy)]
pub struct ProximalGalerkin {
    latent: Latent,
    inner: Inner,
    /// α times the typical pressure at the start.
    first: f64,
}

pub fn all() -> Vec<ProximalGalerkin> {
    let inner = [(Inner::Whole, 10.0), (Inner::Whole, 1.0), (Inner::One, 4.0), (Inner::OneOfConstant, 4.0)];
    let of = |latent| inner.map(|(inner, first)| ProximalGalerkin { latent, inner, first });
    [of(Latent::Equal), of(Latent::Cells)].concat()
}

impl ProximalGalerkin {
    fn whole(&self) -> f64 {
        if self.inner == Inner::Whole { 1.0 } else { 0.0 }
    }

    fn options(&self, pressure: f64) -> ProximalOptions {
        let usual = ProximalOptions { first_step: self.first / pressure, ..ProximalOptions::default() };
        match self.inner {
            Inner::OneOfConstant => ProximalOptions { growth: 1.0, tolerance: 1e-4, ..usual },
            Inner::Whole | Inner::One => usual,
        }
    }
}

impl Formulation for ProximalGalerkin {
    fn name(&self) -> String {
        let of_latent = if self.latent == Latent::Cells { " (ψ in cells)" } else { "" };
        let of_steps = match (self.inner, self.first == 10.0) {
            (Inner::Whole, true) => String::new(),
            (Inner::Whole, false) => format!(", α p = {}", self.first),
            (Inner::One, _) => ", one step each".to_owned(),
            (Inner::OneOfConstant, _) => ", one step each, α constant".to_owned(),
        };
        format!("proximal Galerkin{of_latent}{of_steps}")
    }

    fn solve(&self, case: &Case) -> Result<Outcome, Refusal> {
        if self.latent == Latent::Cells {
            return Err(not_defined("ψ is on a surface, which has no cells of its own"));
        }
        let (scalars, bodies, load) = (case.scalars()?, case.bodies(), case.load());
        let step = |Proximal { alpha, before }: Proximal<'_, 2>| {
            let data = law::data_from(case.data.clone()).alpha(alpha).whole(self.whole());
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
        let options = self.options(case.pressure);
        let start = [case.first(), Field::zero(&scalars)];
        let found = solve_by_proximal_points(start, options, step, |_| ())?;
        let pressures = case.known_pressures(&found.multiplier)?;
        let newton = found.history.steps.iter().map(|step| step.newton_steps).collect();
        Ok(Outcome::of(case, &found.solved, pressures)?.after(newton))
    }

    fn cover(&self, membrane: &Membrane) -> Result<Outcome, Refusal> {
        let (space, degree) = (&membrane.space, membrane.space.degree());
        let scalars = match self.latent {
            Latent::Equal => Arc::clone(space),
            Latent::Cells if degree < 2 => return Err(not_defined("degree 2 or more")),
            Latent::Cells => Space::of(space.mesh(), Elements::Lagrange(degree - 2), Scope::Cell, &[])?,
        };
        let step = |Proximal { alpha, before }: Proximal<'_, 2>| {
            let data = volume::data_from(membrane.data.clone()).alpha(alpha).whole(self.whole());
            let form = volume::above(&data, &membrane.omega(), &before[1]);
            membrane.mixed_problem(&form, &scalars).start([&before[0], &before[1]]).solve()
        };
        let start = [Field::zero(space), Field::zero(&scalars)];
        let found = solve_by_proximal_points(start, self.options(membrane.pressure), step, |_| ())?;
        let pressures = membrane.known_pressures(&found.multiplier)?;
        let newton = found.history.steps.iter().map(|step| step.newton_steps).collect();
        Ok(membrane.outcome(&found.solved, pressures).after(newton))
    }
}

//! Proximal Galerkin: the gap is e^ψ with ψ on the own surface, and the pressure is (ψ before − ψ)/α.

use contact_bench::outcome::not_defined;
use contact_bench::two_bodies::{SolvedLoad, pressed};
use contact_bench::{
    AfterLoad, Case, Contact, Formulation, Membrane, Outcome, Pressed, Refusal, Rubber, Sides, Slid, Sliding,
    TwoBodies,
};
use forms_contact::proximal::{Proximal, ProximalOptions, ProximalSolution, solve_by_proximal_points};
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
        /// ψ before.
        before: Given<Scalar>,
    }
    pub fn slack(psi: Scalar) -> Scalar {
        exp(before + whole * (psi - before)) * (1 + (1 - whole) * (psi - before))
    }
    pub fn on_obstacle(u: Unknown<Vector>, psi: Unknown<Scalar>, v: Test<Vector>, w: Test<Scalar>) -> Form {
        let pressed = (before - psi) / alpha * dot(v, obstacle_normal);
        balance(u, v) + integral(Surface, weight() * (pressed + (obstacle_distance(u) - slack(psi)) * w))
    }
    pub fn between(u: Unknown<Vector>, psi: Unknown<Scalar>, v: Test<Vector>, w: Test<Scalar>) -> Form {
        let pressed = this(before - psi) / alpha * dot(toward, jump(v));
        balance(u, v) + integral(Touch, own_weight() * (pressed + (distance(u) - this(slack(psi))) * this(w)))
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
        before: Given<Scalar>,
    }
    pub fn above(u: Unknown<Scalar>, psi: Unknown<Scalar>, v: Test<Scalar>, w: Test<Scalar>) -> Form {
        let slack = exp(before + whole * (psi - before)) * (1 + (1 - whole) * (psi - before));
        balance(u, v) + integral(Omega, (psi - before) / alpha * v + (height(u) - slack) * w)
    }
}

#[forms(dimension = 2)]
mod rubber {
    pub use contact_bench::rubber::{Omega, Surface};
    use contact_bench::rubber::{body, distance};
    #[includes(contact_bench::rubber::Data)]
    pub struct Data {
        alpha: Param,
        before: Given<Scalar>,
    }
    pub fn on_flat(
        u: Unknown<Vector>,
        p: Unknown<Scalar>,
        psi: Unknown<Scalar>,
        v: Test<Vector>,
        q: Test<Scalar>,
        w: Test<Scalar>,
    ) -> Form {
        let pressed = (before - psi) / alpha * dot(v, obstacle_normal);
        body(u, p, v, q) + integral(Surface, pressed + (distance(u) - exp(psi)) * w)
    }
}

#[forms(dimension = 3)]
mod stacked {
    pub use contact_bench::two_bodies::bodies::{Omega, Touch};
    use contact_bench::two_bodies::bodies::{balance, separation};
    #[includes(contact_bench::two_bodies::bodies::Data)]
    pub struct Data {
        alpha: Param,
        before: Given<Scalar>,
    }
    pub fn between(u: Unknown<Vector>, psi: Unknown<Scalar>, v: Test<Vector>, w: Test<Scalar>) -> Form {
        let pressed = this(before - psi) / alpha * dot(toward, jump(v));
        balance(u, v) + integral(Touch, pressed + (separation(u) - exp(this(psi))) * this(w))
    }
}

#[forms(dimension = 2)]
mod drawn {
    use contact_bench::sliding::balance;
    pub use contact_bench::sliding::{Omega, Touch};
    #[includes(contact_bench::sliding::Data)]
    pub struct Data {
        alpha: Param,
        before: Given<Scalar>,
    }
    pub fn between(u: Unknown<Vector>, psi: Unknown<Scalar>, v: Test<Vector>, w: Test<Scalar>) -> Form {
        let pressed = this(before - psi) / alpha * dot(toward, jump(v));
        balance(u, v) + integral(Touch(u), pressed + (gap - exp(this(psi))) * this(w))
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
    /// One, for α that double, until the change is below 10⁻⁵.
    One,
    /// One, for a constant α, as in MFEM's example 36, until the change is below 10⁻⁴.
    OneOfConstant,
}

/// Proximal Galerkin with a space of ψ and steps of α.
#[derive(Clone, Copy)]
pub struct ProximalGalerkin {
    latent: Latent,
    inner: Inner,
    /// α times the typical pressure at the start.
    first: f64,
}

/// Spaces of ψ with ways to choose α.
pub fn all() -> Vec<ProximalGalerkin> {
    let inner = [(Inner::Whole, 10.0), (Inner::Whole, 1.0), (Inner::One, 4.0), (Inner::OneOfConstant, 4.0)];
    let of = |latent| inner.map(|(inner, first)| ProximalGalerkin { latent, inner, first });
    [of(Latent::Equal), of(Latent::Cells)].concat()
}

impl ProximalGalerkin {
    fn whole(&self) -> f64 {
        if self.inner == Inner::Whole { 1.0 } else { 0.0 }
    }

    fn scalars_on(&self, case: &Case) -> Result<Arc<Space<2>>, Refusal> {
        match self.latent {
            Latent::Equal => case.scalars(),
            Latent::Cells => Err(not_defined("ψ is on a surface, which has no cells of its own")),
        }
    }

    fn scalars(&self, membrane: &Membrane) -> Result<Arc<Space<2>>, Refusal> {
        let (space, degree) = (&membrane.space, membrane.space.degree());
        match self.latent {
            Latent::Equal => Ok(Arc::clone(space)),
            Latent::Cells if degree < 2 => Err(not_defined("degree 2 or more")),
            Latent::Cells => Ok(Space::of(space.mesh(), Elements::Lagrange(degree - 2), Scope::Cell, &[])?),
        }
    }

    /// The iteration, with the Newton steps of each problem.
    fn iterate<const D: usize, const N: usize>(
        &self,
        pressure: f64,
        start: [Field<D>; N],
        step: impl Fn(Proximal<'_, D, N>) -> Result<Solved<D, N>, NewtonError>,
    ) -> Result<(ProximalSolution<D, N>, Vec<usize>), Refusal>
    where
        Dim: Dimension<D>,
    {
        let found = solve_by_proximal_points(start, self.options(pressure), step, |_| ())?;
        let newton = found.history.steps.iter().map(|step| step.newton_steps).collect();
        Ok((found, newton))
    }

    /// Paths are followed by whole problems with ψ of the displacement's degree: other variants are those of one problem.
    fn follows(&self) -> Result<(), Refusal> {
        match (self.latent, self.inner) {
            (Latent::Equal, Inner::Whole) => Ok(()),
            (Latent::Cells, _) => Err(not_defined("ψ is on a surface, which has no cells of its own")),
            (Latent::Equal, _) => Err(not_defined("paths take whole problems")),
        }
    }

    fn options(&self, pressure: f64) -> ProximalOptions {
        let usual = ProximalOptions { first_step: self.first / pressure, ..ProximalOptions::default() };
        match self.inner {
            Inner::OneOfConstant => ProximalOptions { growth: 1.0, tolerance: 1e-4, ..usual },
            Inner::One => ProximalOptions { tolerance: 1e-5, ..usual },
            Inner::Whole => usual,
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
        let (scalars, bodies, load) = (self.scalars_on(case)?, case.bodies(), case.load());
        let step = |at: Proximal<'_, 2>| {
            let data =
                law::data_from(case.data.clone()).alpha(at.alpha).whole(self.whole()).before(&at.before[1]);
            let form = match case.contact {
                Contact::Obstacle(_) => law::on_obstacle(&data, &bodies, &load, &case.surface()),
                Contact::Bodies(_) => law::between(&data, &bodies, &load, &case.touch(Sides::Own)),
            };
            // Undamped: a line search on the residual stalls where e^ψ is far off.
            let problem = case.mixed_problem(&form, [&case.space, &scalars]);
            problem.options(NewtonOptions::default()).start([&at.before[0], &at.before[1]]).solve()
        };
        let (found, newton) = self.iterate(case.pressure, [case.first(), Field::zero(&scalars)], step)?;
        let pressures = case.known_pressures(&found.multiplier)?;
        Ok(Outcome::of(case, &found.solved, pressures)?.after(newton))
    }

    fn cover(&self, membrane: &Membrane) -> Result<Outcome, Refusal> {
        let scalars = self.scalars(membrane)?;
        let step = |at: Proximal<'_, 2>| {
            let data = volume::data_from(membrane.data.clone()).alpha(at.alpha).whole(self.whole());
            let form = volume::above(&data.before(&at.before[1]), &membrane.omega());
            membrane.mixed_problem(&form, &scalars).start([&at.before[0], &at.before[1]]).solve()
        };
        let start = [Field::zero(&membrane.space), Field::zero(&scalars)];
        let (found, newton) = self.iterate(membrane.pressure, start, step)?;
        let pressures = membrane.known_pressures(&found.multiplier)?;
        Ok(membrane.outcome(&found.solved, pressures).after(newton))
    }

    fn press(&self, ring: &Rubber) -> Result<Pressed, Refusal> {
        self.follows()?;
        let (scalars, held, [u, p]) = (ring.scalars()?, ring.held_at(0.0)?, ring.spaces.each_ref());
        ring.follow_by([u, p, &scalars].map(Field::zero), |attempt| {
            let step = |at: Proximal<'_, 2, 3>| {
                let data = rubber::data_from(ring.data(attempt.way)).alpha(at.alpha).before(at.latent());
                let form = rubber::on_flat(&data, &ring.omega(), &ring.surface());
                attempt.solved(attempt.problem(&form).constrained(&held).start(at.before))
            };
            let [u, p, _] = attempt.before.clone();
            Ok(self.iterate(ring.pressure, [u, p, ring.latent(&scalars, attempt.way)?], step)?.0.solved)
        })
    }

    fn rub(&self, _bodies: &TwoBodies<2>) -> Result<Vec<AfterLoad<2>>, Refusal> {
        Err(not_defined("friction is no bound on a gap, which ψ keeps"))
    }

    fn stack(&self, bodies: &TwoBodies<3>) -> Result<Vec<AfterLoad<3>>, Refusal> {
        self.follows()?;
        let (omega, touch, space) = (bodies.omega(), bodies.touch(Sides::Own), &bodies.space);
        let scalars = Space::on_facets(space.mesh(), &bodies.surfaces[0], space.degree())?;
        bodies.follow_by(1.0, [space, &scalars].map(Field::zero), |given, load, [u, _]| {
            let step = |at: Proximal<'_, 3>| {
                let data = stacked::data_from(given.clone()).alpha(at.alpha).before(at.latent());
                let problem = Problem::new(&stacked::between(&data, &omega, &touch), [space, &scalars]);
                let problem = problem.constrained(&load.supports).assembler(bodies.assembler());
                problem.start(at.before).solve()
            };
            let (found, newton) = self.iterate(bodies.pressure, [u.clone(), Field::zero(&scalars)], step)?;
            let traction = pressed(&given, &found.multiplier);
            Ok(SolvedLoad { solved: found.solved, traction, newton })
        })
    }

    fn slide(&self, bodies: &Sliding) -> Result<Vec<Slid>, Refusal> {
        self.follows()?;
        let (omega, touch, space) = (bodies.omega(), bodies.touch(Sides::OwnWholeFacets), &bodies.space);
        let scalars = bodies.scalars(space.degree())?;
        bodies.follow_by([bodies.start.clone(), Field::zero(&scalars)], |supports, [u, _]| {
            let step = |at: Proximal<'_, 2>| {
                let data = drawn::data_from(bodies.data.clone()).alpha(at.alpha).before(at.latent());
                let problem = Problem::new(&drawn::between(&data, &omega, &touch), [space, &scalars]);
                let problem = problem.constrained(supports).assembler(bodies.assembler());
                problem.start(at.before).solve()
            };
            let start = [u.clone(), Field::zero(&scalars)];
            let (found, newton) = self.iterate(bodies.pressure, start, step)?;
            Ok((found.solved, newton))
        })
    }
}

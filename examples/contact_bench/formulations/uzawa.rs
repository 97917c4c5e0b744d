//! Uzawa's iteration: penalty with a multiplier at points of the own surface, updated outside of Newton's method.

use contact_bench::outcome::Refusal::Failed;
use contact_bench::{Case, Contact, Formulation, Membrane, Outcome, Refusal, Sides};
use forms_fem::prelude::*;

#[forms(dimension = 2)]
mod law {
    pub use contact_bench::body::{Surface, Touch};
    use contact_bench::body::{distance, obstacle_distance, own_stiffness, own_weight, weight};
    #[includes(contact_bench::body::Data)]
    pub struct Data {
        multiplier: History<Scalar>,
    }
    pub fn pressure(u: Vector) -> Scalar {
        pos_part(multiplier - 100 * young / h * obstacle_distance(u))
    }
    pub fn on_obstacle(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Surface, weight() * pressure(u) * dot(v, obstacle_normal))
    }
    pub fn pair_pressure(u: Vector) -> Scalar {
        pos_part(this(multiplier) - 100 * own_stiffness() * distance(u))
    }
    pub fn between(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Touch, own_weight() * pair_pressure(u) * dot(toward, jump(v)))
    }
}

#[forms(dimension = 2)]
mod volume {
    pub use contact_bench::volume::Omega;
    use contact_bench::volume::height;
    #[includes(contact_bench::volume::Data)]
    pub struct Data {
        multiplier: History<Scalar>,
    }
    pub fn force(u: Scalar) -> Scalar {
        pos_part(multiplier - 100 / (h * h) * height(u))
    }
    pub fn above(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        -integral(Omega, force(u) * v)
    }
}

/// The change of the multiplier, relative to the largest pressure, at which the iteration ends.
const TOLERANCE: f64 = 1e-8;
const MOST: usize = 200;

/// Uzawa's iteration.
pub struct Uzawa;

/// The one variant.
pub fn all() -> Vec<Uzawa> {
    vec![Uzawa]
}

/// The iteration for a problem from a start, with the pressure that becomes the multiplier, and the Newton steps of each problem.
fn iterate(
    (problem, mut u): (impl Fn(&Field<2>) -> Result<Solved<2>, NewtonError>, Field<2>),
    (assembler, multiplier): (&Assembler<2>, &History<f64, 2>),
    pressure: impl Fn(&Field<2>) -> Expression<2>,
    scale: f64,
) -> Result<(Solved<2>, Vec<usize>), Refusal> {
    let (mut newton, mut before) = (vec![], assembler.history_values(multiplier)?);
    while newton.len() < MOST {
        let solved = problem(&u)?;
        newton.push(solved.iterations());
        assembler.update_history(&pressure(solved.field()), multiplier)?;
        multiplier.commit();
        let after = assembler.history_values(multiplier)?;
        let change = before.iter().zip(&after).map(|(a, b)| (a[0] - b[0]).abs()).fold(0.0, f64::max);
        if change <= TOLERANCE * scale {
            return Ok((solved, newton));
        }
        (u, before) = (solved.into_field(), after);
    }
    Err(Failed(format!("the multiplier still changes after {MOST} iterations")))
}

fn multiplier(case: &Case, assembler: &Assembler<2>, rule: usize) -> Result<History<f64, 2>, Refusal> {
    match case.contact {
        Contact::Obstacle(_) => Ok(assembler.history(Entity::Facets, case.own(), rule, 0.0)?),
        Contact::Bodies(_) => Ok(assembler.history_on_pairs(&case.pairing(Sides::Own), rule, 0.0)?),
    }
}

impl Formulation for Uzawa {
    fn name(&self) -> String {
        "uzawa".to_owned()
    }

    fn solve(&self, case: &Case) -> Result<Outcome, Refusal> {
        // One point per facet more than the degree: more would constrain the displacement too much.
        let (is_pair, rule) = (matches!(case.contact, Contact::Bodies(_)), 2 * case.space.degree());
        let assembler = Assembler::new(case.mesh()).with_quadrature(Quadrature::Degree(rule));
        let multiplier = multiplier(case, &assembler, rule)?;
        let data = law::data_from(case.data.clone()).multiplier(multiplier.clone());
        let form = match is_pair {
            false => law::on_obstacle(&data, &case.surface()),
            true => law::between(&data, &case.touch(Sides::Own)),
        };
        let pressure =
            |u: &Field<2>| if is_pair { law::pair_pressure(&data, u) } else { law::pressure(&data, u) };
        let solve = |u: &Field<2>| case.problem(&form).assembler(&assembler).start(u).solve();
        let (solved, newton) =
            iterate((solve, case.first()), (&assembler, &multiplier), pressure, case.pressure)?;
        Ok(Outcome::of(case, &solved, case.pressures(&pressure(solved.field()))?)?.after(newton))
    }

    fn cover(&self, membrane: &Membrane) -> Result<Outcome, Refusal> {
        let rule = 2 * membrane.space.degree();
        let assembler = Assembler::new(membrane.space.mesh()).with_quadrature(Quadrature::Degree(rule));
        let multiplier = assembler.history(Entity::Cells, "all", rule, 0.0)?;
        let data = volume::data_from(membrane.data.clone()).multiplier(multiplier.clone());
        let form = volume::above(&data, &membrane.omega());
        let solve = |u: &Field<2>| membrane.problem(&form).assembler(&assembler).start(u).solve();
        let (start, force) = (Field::zero(&membrane.space), |u: &Field<2>| volume::force(&data, u));
        let (solved, newton) = iterate((solve, start), (&assembler, &multiplier), force, membrane.pressure)?;
        Ok(membrane.outcome(&solved, membrane.pressures(&force(solved.field()))?).after(newton))
    }
}

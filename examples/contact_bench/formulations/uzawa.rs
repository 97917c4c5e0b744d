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

pub struct Uzawa;

pub fn all() -> Vec<Uzawa> {
    vec![Uzawa]
}

/// The largest change of the multiplier, which becomes the pressure.
fn updated(
    assembler: &Assembler<2>,
    pressure: &Expression<2>,
    multiplier: &History<f64, 2>,
) -> Result<f64, Refusal> {
    let before = assembler.history_values(multiplier)?;
    assembler.update_history(pressure, multiplier)?;
    multiplier.commit();
    let after = assembler.history_values(multiplier)?;
    Ok(before.iter().zip(&after).map(|(a, b)| (a[0] - b[0]).abs()).fold(0.0, f64::max))
}

impl Formulation for Uzawa {
    fn name(&self) -> String {
        "uzawa".to_owned()
    }

    fn solve(&self, case: &Case) -> Result<Outcome, Refusal> {
        // One point per facet more than the degree: more would constrain the displacement too much.
        let (pairing, rule) = (case.pairing(Sides::Own), 2 * case.space.degree());
        let assembler = Assembler::new(case.mesh()).with_quadrature(Quadrature::Degree(rule));
        let multiplier = match case.contact {
            Contact::Obstacle(_) => assembler.history(Entity::Facets, case.own(), rule, 0.0)?,
            Contact::Bodies(_) => assembler.history_on_pairs(&pairing, rule, 0.0)?,
        };
        let data = law::data_from(case.data.clone()).multiplier(multiplier.clone());
        let form = match case.contact {
            Contact::Obstacle(_) => law::on_obstacle(&data, &case.surface()),
            Contact::Bodies(_) => law::between(&data, &case.touch(Sides::Own)),
        };
        let pressure = |u: &Field<2>| match case.contact {
            Contact::Obstacle(_) => law::pressure(&data, u),
            Contact::Bodies(_) => law::pair_pressure(&data, u),
        };
        let (mut u, mut newton) = (case.first(), vec![]);
        while newton.len() < MOST {
            let solved = case.problem(&form).assembler(&assembler).start(&u).solve()?;
            newton.push(solved.iterations());
            let pressures = case.pressures(&pressure(solved.field()))?;
            let change = updated(&assembler, &pressure(solved.field()), &multiplier)?;
            if change <= TOLERANCE * case.pressure {
                return Ok(Outcome::of(case, &solved, pressures)?.after(newton));
            }
            u = solved.into_field();
        }
        Err(Failed(format!("the multiplier still changes after {MOST} iterations")))
    }

    fn cover(&self, membrane: &Membrane) -> Result<Outcome, Refusal> {
        let rule = 2 * membrane.space.degree();
        let assembler = Assembler::new(membrane.space.mesh()).with_quadrature(Quadrature::Degree(rule));
        let multiplier = assembler.history(Entity::Cells, "all", rule, 0.0)?;
        let data = volume::data_from(membrane.data.clone()).multiplier(multiplier.clone());
        let (form, mut u, mut newton) =
            (volume::above(&data, &membrane.omega()), Field::zero(&membrane.space), vec![]);
        while newton.len() < MOST {
            let solved = membrane.problem(&form).assembler(&assembler).start(&u).solve()?;
            newton.push(solved.iterations());
            let force = volume::force(&data, solved.field());
            let pressures = membrane.pressures(&force)?;
            let change = updated(&assembler, &force, &multiplier)?;
            if change <= TOLERANCE * membrane.pressure {
                return Ok(membrane.outcome(&solved, pressures).after(newton));
            }
            u = solved.into_field();
        }
        Err(Failed(format!("the multiplier still changes after {MOST} iterations")))
    }
}

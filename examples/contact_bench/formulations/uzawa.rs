//! Uzawa's iteration: penalty with a multiplier at points of the own surface, updated outside of Newton's method.

use contact_bench::outcome::Refusal::Failed;
use contact_bench::two_bodies::SolvedLoad;
use contact_bench::{
    AfterLoad, Case, Contact, Formulation, Membrane, Outcome, Pressed, Refusal, Rubber, Sides, Slid, Sliding,
    TwoBodies,
};
use forms_fem::contract::FieldValue;
use forms_fem::history::WithoutPartner;
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

#[forms(dimension = 2)]
mod rubber {
    pub use contact_bench::rubber::{Omega, Surface};
    use contact_bench::rubber::{body, distance, stiffness};
    #[includes(contact_bench::rubber::Data)]
    pub struct Data {
        multiplier: History<Scalar>,
    }
    pub fn pressure(u: Vector) -> Scalar {
        pos_part(multiplier - 100 * stiffness() * distance(u))
    }
    pub fn on_flat(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        body(u, p, v, q) + integral(Surface, pressure(u) * dot(v, obstacle_normal))
    }
}

#[forms]
mod rough {
    pub use contact_bench::two_bodies::bodies::{Omega, Touch};
    use contact_bench::two_bodies::bodies::{allowed, balance};
    #[includes(contact_bench::two_bodies::bodies::Data)]
    pub struct Data {
        multiplier: History<Vector>,
    }
    pub fn traction(u: Vector) -> Vector {
        allowed(multiplier, u)
    }
    pub fn between(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        balance(u, v) - integral(Touch, dot(traction(u), jump(v)))
    }
}

#[forms(dimension = 2)]
mod drawn {
    pub use contact_bench::sliding::{Omega, Touch};
    use contact_bench::sliding::{balance, own_stiffness};
    #[includes(contact_bench::sliding::Data)]
    pub struct Data {
        multiplier: History<Scalar>,
    }
    pub fn pressure(u: State<Vector>) -> Scalar {
        pos_part(this(multiplier) - 100 * own_stiffness() * gap)
    }
    pub fn between(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let pressure = pos_part(this(multiplier) - 100 * own_stiffness() * gap);
        balance(u, v) + integral(Touch(u), pressure * dot(toward, jump(v)))
    }
}

/// The change of the multiplier, relative to a typical pressure, at which the iteration ends.
const TOLERANCE: f64 = 1e-8;
const MOST: usize = 200;

/// Uzawa's iteration.
pub struct Uzawa;

/// The one variant.
pub fn all() -> Vec<Uzawa> {
    vec![Uzawa]
}

/// The iteration for a problem from a start, with the Newton steps of each problem. `update` takes the pressure as the multiplier, and returns the
/// largest change.
fn iterate<const D: usize, const N: usize>(
    solve: impl Fn(&[Field<D>; N]) -> Result<Solved<D, N>, NewtonError>,
    mut fields: [Field<D>; N],
    update: impl Fn(&[Field<D>; N]) -> Result<f64, Refusal>,
    scale: f64,
) -> Result<(Solved<D, N>, Vec<usize>), Refusal> {
    let mut newton = vec![];
    while newton.len() < MOST {
        let solved = solve(&fields)?;
        newton.push(solved.iterations());
        if update(&solved.fields)? <= TOLERANCE * scale {
            return Ok((solved, newton));
        }
        fields = solved.fields;
    }
    Err(Failed(format!("the multiplier still changes after {MOST} iterations")))
}

/// The largest change of a multiplier by an update of it.
fn change<V: FieldValue, const D: usize>(
    (assembler, multiplier): (&Assembler<D>, &History<V, D>),
    update: impl FnOnce() -> Result<(), AssemblyError>,
) -> Result<f64, Refusal> {
    let before = assembler.history_values(multiplier)?;
    update()?;
    multiplier.commit();
    let after = assembler.history_values(multiplier)?;
    let changes = before.iter().flatten().zip(after.iter().flatten()).map(|(a, b)| (a - b).abs());
    Ok(changes.fold(0.0, f64::max))
}

fn multiplier(case: &Case, assembler: &Assembler<2>, rule: usize) -> Result<History<f64, 2>, Refusal> {
    match case.contact {
        Contact::Obstacle(_) => Ok(assembler.history(Entity::Facets, case.own(), rule, 0.0)?),
        Contact::Bodies(_) => Ok(assembler.history_on_pairs(&case.pairing(Sides::Own), rule, 0.0)?),
    }
}

/// The rule of the own surface, with one point per facet more than the degree: more would constrain the displacement too much.
fn rule<const D: usize>(space: &Space<D>) -> usize {
    2 * space.degree()
}

fn assembler<const D: usize>(space: &Space<D>) -> Assembler<D> {
    Assembler::new(space.mesh()).with_quadrature(Quadrature::Degree(rule(space)))
}

impl Uzawa {
    fn between<const D: usize>(&self, bodies: &TwoBodies<D>) -> Result<Vec<AfterLoad<D>>, Refusal>
    where
        Dim: Dimension<D>,
    {
        let (sides, assembler, omega) = (Sides::OwnWholeFacets, assembler(&bodies.space), bodies.omega());
        let (pairing, touch, rule) = (bodies.pairing(sides), bodies.touch(sides), rule(&bodies.space));
        let multiplier = assembler.history_on_pairs(&pairing, rule, [0.0; D])?;
        bodies.follow_by(100.0, [Field::zero(&bodies.space)], |data, load, fields| {
            let data = rough::data_from(data).multiplier(multiplier.clone());
            let form = rough::between(&data, &omega, &touch);
            let solve =
                |[u]: &[Field<D>; 1]| bodies.problem(&form, load).assembler(&assembler).start(u).solve();
            let update = |[u]: &[Field<D>; 1]| {
                let update = || assembler.update_history(&rough::traction(&data, u), &multiplier);
                change((&assembler, &multiplier), update)
            };
            let (solved, newton) = iterate(solve, fields.clone(), update, bodies.pressure)?;
            Ok(SolvedLoad { traction: bodies.traction_of_forces(&solved)?, solved, newton })
        })
    }
}

impl Formulation for Uzawa {
    fn name(&self) -> String {
        "uzawa".to_owned()
    }

    fn solve(&self, case: &Case) -> Result<Outcome, Refusal> {
        let (is_pair, assembler) = (matches!(case.contact, Contact::Bodies(_)), assembler(&case.space));
        let multiplier = multiplier(case, &assembler, rule(&case.space))?;
        let data = law::data_from(case.data.clone()).multiplier(multiplier.clone());
        let form = match is_pair {
            false => law::on_obstacle(&data, &case.surface()),
            true => law::between(&data, &case.touch(Sides::Own)),
        };
        let pressure =
            |u: &Field<2>| if is_pair { law::pair_pressure(&data, u) } else { law::pressure(&data, u) };
        let solve = |[u]: &[Field<2>; 1]| case.problem(&form).assembler(&assembler).start(u).solve();
        let update = |[u]: &[Field<2>; 1]| {
            change((&assembler, &multiplier), || assembler.update_history(&pressure(u), &multiplier))
        };
        let (solved, newton) = iterate(solve, [case.first()], update, case.pressure)?;
        Ok(Outcome::of(case, &solved, case.pressures(&pressure(solved.field()))?)?.after(newton))
    }

    fn cover(&self, membrane: &Membrane) -> Result<Outcome, Refusal> {
        let assembler = assembler(&membrane.space);
        let multiplier = assembler.history(Entity::Cells, "all", rule(&membrane.space), 0.0)?;
        let data = volume::data_from(membrane.data.clone()).multiplier(multiplier.clone());
        let form = volume::above(&data, &membrane.omega());
        let solve = |[u]: &[Field<2>; 1]| membrane.problem(&form).assembler(&assembler).start(u).solve();
        let force = |u: &Field<2>| volume::force(&data, u);
        let update = |[u]: &[Field<2>; 1]| {
            change((&assembler, &multiplier), || assembler.update_history(&force(u), &multiplier))
        };
        let (solved, newton) = iterate(solve, [Field::zero(&membrane.space)], update, membrane.pressure)?;
        Ok(membrane.outcome(&solved, membrane.pressures(&force(solved.field()))?).after(newton))
    }

    fn press(&self, ring: &Rubber) -> Result<Pressed, Refusal> {
        let (assembler, held) = (ring.assembler(), ring.held_at(0.0)?);
        let multiplier = assembler.history(Entity::Facets, ring.touching, Rubber::RULE, 0.0)?;
        ring.follow_by(ring.spaces.each_ref().map(Field::zero), |attempt| {
            let data = rubber::data_from(ring.data(attempt.way)).multiplier(multiplier.clone());
            let form = rubber::on_flat(&data, &ring.omega(), &ring.surface());
            let solve = |fields: &[Field<2>; 2]| {
                attempt.solved(attempt.problem(&form).constrained(&held).start(fields))
            };
            let update = |[u, _]: &[Field<2>; 2]| {
                let pressure = rubber::pressure(&data, u);
                change((&assembler, &multiplier), || assembler.update_history(&pressure, &multiplier))
            };
            Ok(iterate(solve, attempt.before.clone(), update, ring.pressure)?.0)
        })
    }

    fn rub(&self, bodies: &TwoBodies<2>) -> Result<Vec<AfterLoad<2>>, Refusal> {
        self.between(bodies)
    }

    fn stack(&self, bodies: &TwoBodies<3>) -> Result<Vec<AfterLoad<3>>, Refusal> {
        self.between(bodies)
    }

    fn slide(&self, bodies: &Sliding) -> Result<Vec<Slid>, Refusal> {
        let (assembler, pairing) = (assembler(&bodies.space), bodies.pairing(Sides::OwnWholeFacets));
        let multiplier = assembler.history_on_sliding_pairs(&pairing, rule(&bodies.space), 0.0)?;
        let data = drawn::data_from(bodies.data.clone()).multiplier(multiplier.clone());
        let form = drawn::between(&data, &bodies.omega(), &bodies.touch(Sides::OwnWholeFacets));
        bodies.follow_by([bodies.start.clone()], |supports, fields| {
            let solve =
                |[u]: &[Field<2>; 1]| bodies.problem(&form, supports).assembler(&assembler).start(u).solve();
            let update = |[u]: &[Field<2>; 1]| {
                let (pressure, without) = (drawn::pressure(&data, u), WithoutPartner::Restart);
                change((&assembler, &multiplier), || {
                    assembler.update_sliding_history(&pressure, &multiplier, &pairing, u, without)
                })
            };
            iterate(solve, fields.clone(), update, bodies.pressure)
        })
    }
}

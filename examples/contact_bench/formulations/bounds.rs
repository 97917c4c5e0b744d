//! Bounds on the unknowns at nodes, which is a dual multiplier for each of them: nothing is below the obstacle at a node, and forces act there.

use contact_bench::outcome::not_defined;
use contact_bench::{
    AfterLoad, Case, Contact, Formulation, Membrane, Outcome, Pressed, Refusal, Rubber, Slid, Sliding,
    TwoBodies, body,
};
use forms_fem::prelude::*;

const TWO_BODIES: &str = "the gap of two bodies is no bound on one unknown";

/// Bounds at nodes.
pub struct NodalBounds;

/// The one variant.
pub fn all() -> Vec<NodalBounds> {
    vec![NodalBounds]
}

/// The forces by which bounds act, by unknown.
fn reactions(solved: &Solved<2>, unknowns: usize) -> Vec<f64> {
    let mut forces = vec![0.0; unknowns];
    solved.held().iter().for_each(|held| forces[held.unknown] = held.reaction);
    forces
}

/// A rigid obstacle as bounds on one component of displacements at nodes.
fn bounds_of(case: &Case) -> Result<Bounds<2>, Refusal> {
    let (space, own, zero) = (&case.space, case.own(), Field::zero(&case.space));
    let nodes = space.nodes_on(own)?;
    let places: Vec<[f64; 2]> = nodes.iter().map(|node| space.positions()[*node as usize]).collect();
    let gaps = case.assembler().at_points(&body::obstacle_distance(&case.data, &zero), &places)?;
    let gap =
        |x: &[f64; 2]| places.iter().position(|place| place == x).map_or(f64::NAN, |k| gaps.values[k][0]);
    let normal = case.assembler().at_points(&body::normal_at(&case.data, &zero), &places[..1])?;
    let axis = (0..2).find(|one| normal.values[0][*one].abs() == 1.0);
    let component = axis.ok_or_else(|| not_defined("the obstacle's normal is no axis"))?;
    let mut bounds = Bounds::new(space);
    match normal.values[0][component] > 0.0 {
        true => bounds.component_at_most(own, component, gap)?,
        false => bounds.component_at_least(own, component, |x| -gap(x))?,
    };
    Ok(bounds)
}

impl Formulation for NodalBounds {
    fn name(&self) -> String {
        "dual multipliers (bounds at nodes)".to_owned()
    }

    fn solve(&self, case: &Case) -> Result<Outcome, Refusal> {
        if let Contact::Bodies(_) = case.contact {
            return Err(not_defined(TWO_BODIES));
        }
        let bounds = bounds_of(case)?;
        let problem = Problem::new(&case.balance(), &case.space).constrained(&case.constraints);
        let solved = problem.assembler(case.assembler()).bounded(&bounds).solve()?;
        let forces = reactions(&solved, case.space.unknowns());
        let outcome = Outcome::of(case, &solved, case.pressures_of_forces(&forces)?)?;
        Ok(Outcome { forces, ..outcome })
    }

    fn cover(&self, membrane: &Membrane) -> Result<Outcome, Refusal> {
        let mut bounds = Bounds::new(&membrane.space);
        bounds.at_least_field(&membrane.below)?;
        let problem = Problem::new(&membrane.balance(), &membrane.space).constrained(&membrane.constraints);
        let solved = problem.assembler(membrane.assembler()).bounded(&bounds).solve()?;
        let forces = reactions(&solved, membrane.space.unknowns());
        Ok(membrane.outcome(&solved, membrane.pressures_of_forces(&forces)?))
    }

    fn press(&self, ring: &Rubber) -> Result<Pressed, Refusal> {
        let [u, p] = &ring.spaces;
        let bounded = |way: f64| -> Result<Option<Bounds<2>>, Refusal> {
            let mut bounds = Bounds::new(u);
            // The flat is below.
            bounds.component_at_least(ring.touching, 1, |x| way - (ring.distance)(x))?;
            Ok(Some(bounds))
        };
        ring.follow_all([u, p], |_| ring.body(), bounded)
    }

    fn rub(&self, _bodies: &TwoBodies<2>) -> Result<Vec<AfterLoad<2>>, Refusal> {
        Err(not_defined(TWO_BODIES))
    }

    fn stack(&self, _bodies: &TwoBodies<3>) -> Result<Vec<AfterLoad<3>>, Refusal> {
        Err(not_defined(TWO_BODIES))
    }

    fn slide(&self, _bodies: &Sliding) -> Result<Vec<Slid>, Refusal> {
        Err(not_defined(TWO_BODIES))
    }
}

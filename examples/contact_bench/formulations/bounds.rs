//! Bounds on the unknowns at nodes, which is a dual multiplier for each of them: nothing is below the obstacle at a node, and forces act there.

use std::collections::HashMap;

use contact_bench::outcome::not_defined;
use contact_bench::{Case, Contact, Formulation, Membrane, Outcome, Pressed, Refusal, Rubber, body};
use forms_fem::prelude::*;

pub struct NodalBounds;

pub fn all() -> Vec<NodalBounds> {
    vec![NodalBounds]
}

/// The forces by which bounds act, by unknown.
fn reactions(solved: &Solved<2>, unknowns: usize) -> Vec<f64> {
    let mut forces = vec![0.0; unknowns];
    solved.held().iter().for_each(|held| forces[held.unknown] = held.reaction);
    forces
}

impl Formulation for NodalBounds {
    fn name(&self) -> String {
        "dual multipliers (bounds at nodes)".to_owned()
    }

    fn solve(&self, case: &Case) -> Result<Outcome, Refusal> {
        if let Contact::Bodies(_) = case.contact {
            return Err(not_defined("the gap of two bodies is no bound on one unknown"));
        }
        let zero = Field::zero(&case.space);
        let nodes = case.space.nodes_on(case.own())?;
        let places: Vec<[f64; 2]> = nodes.iter().map(|node| case.space.positions()[*node as usize]).collect();
        let gaps = case.assembler().at_points(&body::obstacle_distance(&case.data, &zero), &places)?;
        let normal = case.assembler().at_points(&body::normal_at(&case.data, &zero), &places[..1])?;
        let normal = &normal.values[0];
        let Some(component) = (0..2).find(|one| normal[*one].abs() == 1.0) else {
            return Err(not_defined("the obstacle's normal is no axis"));
        };
        let key = |x: &[f64; 2]| x.map(f64::to_bits);
        let gaps: HashMap<[u64; 2], f64> =
            places.iter().map(key).zip(gaps.values.iter().map(|g| g[0])).collect();
        let value = |x: &[f64; 2]| normal[component] * gaps.get(&key(x)).copied().unwrap_or(f64::NAN);
        let mut bounds = Bounds::new(&case.space);
        match normal[component] > 0.0 {
            true => bounds.component_at_most(case.own(), component, value)?,
            false => bounds.component_at_least(case.own(), component, value)?,
        };
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
}

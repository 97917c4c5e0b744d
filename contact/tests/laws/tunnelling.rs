//! A stiff block that is thrown at a thin plate. In one step it comes out at the other side, in balance, and nothing has touched; load
//! steps that follow the motion halve it, and end where small steps end.

use forms_contact::ContactProblem;
use forms_contact::laws::sliding_bodies as law;
use forms_contact::laws::two_bodies::data;
use forms_fem::pairs::PairError;
use forms_fem::prelude::*;
use forms_fem::solve::LoadPath;

use crate::setting::{LAMBDA, MU, YOUNG};

/// The plate's thickness, the block's height, the gap between them, and the way of the block.
const PLATE: f64 = 0.1;
const BLOCK: f64 = 0.1;
const GAP: f64 = 0.05;
const WAY: f64 = 0.6;

fn bodies() -> Arc<Space<2>> {
    let plate = rectangle([0.0, 0.0], [2.0, PLATE], [24, 2], CellShape::Quadrilateral, 1).unwrap();
    let bottom = PLATE + GAP;
    let block = rectangle([0.8, bottom], [1.2, bottom + BLOCK], [5, 2], CellShape::Quadrilateral, 1).unwrap();
    let mesh = Mesh::of_bodies(&[("plate", &plate), ("block", &block)]).unwrap();
    Space::vector(&mesh, 2).unwrap()
}

fn touch() -> Pairing {
    Pairing::onto("block bottom", "plate top").within_reach(0.15)
}

fn problem(space: &Arc<Space<2>>, way: f64) -> ContactProblem<2, law::Model<2>> {
    let mut constraints = Constraints::new(space);
    for end in ["plate left", "plate right"] {
        constraints.fix(end, |_| [0.0, 0.0]).unwrap();
    }
    constraints.fix("block", |_| [0.0, -way]).unwrap();
    let required = data().lambda(LAMBDA).mu(MU).gamma0(10.0 * YOUNG);
    let data = required.share(1.0);
    let regions = law::Regions::default().touch(touch()).gamma_n("block top");
    ContactProblem::new(space, law::Model { data, regions }, constraints).quadrature(Quadrature::Degree(4))
}

/// The force on the block and the displacement at the end of some load steps, which follow the motion by themselves.
fn thrown(space: &Arc<Space<2>>, steps: &LoadSteps) -> (f64, LoadPath<Field<2>>) {
    let mut force = 0.0;
    let solve = |step: &Increment<'_, Field<2>>| -> Result<Field<2>, Box<dyn std::error::Error>> {
        let problem = problem(space, step.factor);
        let solved = problem.direct()?.increment(step).solve()?;
        force = -solved.reaction("block")?[1];
        Ok(solved.into_field())
    };
    let path = steps.advance(Field::zero(space), solve).unwrap();
    (force, path)
}

#[test]
fn a_block_thrown_at_a_plate() {
    let space = bodies();
    // Newton's method alone: nothing is wrong where the block comes out.
    let unseen = problem(&space, WAY).direct().unwrap().solve().unwrap();
    assert!(unseen.reaction("block").unwrap()[1].abs() < 1e-9 * YOUNG);
    let error = Assembler::new(space.mesh()).follow(&touch(), 4, &Field::zero(&space), unseen.field());
    println!("{}", error.clone().unwrap_err());
    assert!(matches!(error, Err(PairError::Tunnelling { .. })));

    let (force, path) = thrown(&space, &LoadSteps::uniform(1, WAY));
    let (expected, small) = thrown(&space, &LoadSteps::uniform(40, WAY));
    let refused = path.steps.iter().filter(|step| step.failure.is_some()).count();
    println!("{} attempts, {refused} refused; {} small steps", path.steps.len(), small.steps.len());
    for step in &path.steps {
        println!("{} -> {}: {:?}", step.from, step.factor, step.failure);
    }
    println!("force {force} and {expected}");
    assert!(path.steps[0].failure.as_ref().is_some_and(|why| why.contains("may have passed through")));
    assert!(expected > 1e-3 * YOUNG, "{expected}");
    assert!((force / expected - 1.0).abs() < 1e-8, "{force} {expected}");
    let values = path.state.values().iter().zip(small.state.values());
    let apart = values.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart < 1e-8, "{apart:.1e}");
}

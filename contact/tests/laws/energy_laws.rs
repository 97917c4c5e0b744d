//! A law whose direct problem is an energy: the same solution as that of the energy by itself.

use forms_contact::{ContactProblem, contact_law};
use forms_fem::prelude::*;

#[forms]
mod penalty {
    use forms_contact::operators::obstacle::penalty_density;

    #[includes(forms_contact::operators::obstacle::Data)]
    pub struct Data {
        pub mu: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Bottom;

    pub fn direct(u: Unknown<Vector>) -> Energy {
        integral(Omega, mu * inner(eps(u), eps(u))) + integral(Bottom, penalty_density(u))
    }
}

contact_law!(penalty { direct: direct, region: bottom });

#[test]
fn an_energy_is_a_direct_problem() {
    let mesh = rectangle([0.0; 2], [2.0, 1.0], [8, 4], CellShape::Quadrilateral, 1).unwrap();
    let space = Space::vector(&mesh, 1).unwrap();
    let mut held = Constraints::new(&space);
    held.fix("top", |_| [0.0, -0.1]).unwrap();
    let data = penalty::data().gamma0(100.0).obstacle_normal([0.0, -1.0]);
    let data = data.gap(|x: &[f64; 2]| x[1]).theta(0.0).mu(1.0);
    let law = penalty::Model::new(data);
    let alone = Problem::new(&law.direct(), &space).constrained(&held).solve().unwrap();
    let problem = ContactProblem::new(&space, law, held);
    let solved = problem.direct().unwrap().solve().unwrap();
    let difference = solved.field().values().iter().zip(alone.field().values());
    assert!(difference.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < 1e-12);
    assert!(solved.reaction("top").unwrap()[1] < -0.1);
}

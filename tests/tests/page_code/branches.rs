//! `docs/continuation.md`.

use forms_fem::prelude::*;
use forms_fem::solve::Continuation;

#[forms]
pub mod arch {
    pub struct Data {
        load: Param,
    }
    #[cells]
    pub struct Omega;
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(grad(u), grad(v)) + load * v[1])
    }
    pub fn by_load(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        derivative(balance(u, v), load, 1)
    }
    pub fn deflection(u: State<Vector>) -> Functional {
        integral(Omega, u[1])
    }
}

pub fn branch(
    space: Arc<Space<2>>,
    clamps: Constraints<2>,
    model: &arch::Model<2>,
) -> Result<Vec<(f64, f64)>, Failure> {
    let forms = |load: f64| {
        let model = arch::Model::new(arch::data().load(load));
        [model.balance(), model.by_load()]
    };
    let branch = Continuation::new(&space, forms).constrained(&clamps).step(1e-4).within(0.0..=8e-4)
        .run(|load, solved| Ok((load, solved.functional(&model.deflection(solved.field()))?)))?;
    for event in &branch.events {
        println!("{:?} at {} ± {:.0e}", event.kind, event.parameter, event.uncertainty);
    }
    Ok(branch.points.iter().map(|point| point.measured).collect())
}

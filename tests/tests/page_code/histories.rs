//! `docs/inverse_problems.md`.

use forms_fem::inverse::{Controls, LoadHistory, ReducedProblem, second_order_taylor_test};
use forms_fem::prelude::*;

mod first_derivatives {
    use super::*;

    #[forms]
    mod creep {
        pub struct Data { pub conductivity: Param, pub source: Param }
        #[cells]
        pub struct Omega;

        #[controls(conductivity)]
        pub fn step(u: Unknown<Scalar>, v: Test<Scalar>, before: State<Scalar>) -> Form {
            integral(Omega, (u - before) * v + conductivity * (1 + sqr(u)) * dot(grad(u), grad(v)) - source * v)
        }
        pub fn misfit(u: Unknown<Scalar>) -> Energy { integral(Omega, sqr(u - x[0]) / 2) }
    }

    pub fn gradient(space: Arc<Space<2>>, held: Constraints<2>) -> Result<Vec<f64>, Failure> {
        let controls = Controls::new().number("conductivity", 0.3);
        let model = |conductivity| creep::Model::new(creep::data().conductivity(conductivity).source(1.0));
        let mut history = LoadHistory::new(&space, 10, controls)
            .step(|at| Ok(model(at.number("conductivity")?).step(at.before()?)))
            .sensitivities(|at, u, p| Ok(model(at.number("conductivity")?).step_sensitivities(u, at.before()?, p)))
            .criterion(|at| Ok(model(at.number("conductivity")?).misfit()))
            .constrained(&held);
        let (value, gradient) = history.value_and_gradient(&[0.3])?;
        println!("{value}");
        Ok(gradient)
    }
}

mod second_derivatives {
    use super::*;

    #[forms]
    mod creep {
        pub struct Data {
            pub conductivity: Param,
            pub source: Param,
        }
        #[cells]
        pub struct Omega;

        #[controls(conductivity, order = 2)]
        pub fn step(u: Unknown<Scalar>, v: Test<Scalar>, before: State<Scalar>) -> Form {
            integral(Omega, (u - before) * v + conductivity * (1 + sqr(u)) * dot(grad(u), grad(v)) - source * v)
        }
    }

    pub fn hessian(history: LoadHistory<'_, 2>, (m, d): ([f64; 1], [f64; 1])) -> Result<[Vec<f64>; 2], Failure> {
        let mut history = history.second_sensitivities(|at, s| {
            let data = creep::data().conductivity(at.number("conductivity")?).source(1.0).d_conductivity(s.along.number("conductivity")?);
            Ok(creep::Model::new(data).step_second_sensitivities(s.u, at.before()?, s.p, s.du, s.dbefore, s.dp))
        });
        let found = history.hessian(&m, &d)?;
        let [gradient, hessian] = second_order_taylor_test(&mut history, &m, &d, 0.1)?;
        println!("{gradient:?} {hessian:?}");
        Ok([found.gradient, found.along])
    }
}

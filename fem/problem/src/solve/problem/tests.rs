//! The number of threads of a problem, from its builder to the factor.

use super::Solver;
use crate::prelude::*;

#[forms(dimension = 2)]
mod membrane {
    #[cells]
    pub struct Omega;
    pub fn bend(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)) + u * v - v)
    }
}

#[test]
fn the_threads_of_a_problem_reach_its_own_solver() {
    let mesh = rectangle([0.0; 2], [1.0; 2], [6; 2], CellShape::Quadrilateral, 2).unwrap();
    let space = Space::scalar(&mesh, 2).unwrap();
    let form = membrane::Model::default().bend();
    for threads in [1, 2, 7].map(Threads::new) {
        let assembler = Assembler::new(&mesh).with_threads(threads);
        let problems = [
            Problem::new(&form, &space).threads(threads),
            Problem::new(&form, &space).assembler(&assembler),
            // The later choice counts.
            Problem::new(&form, &space).threads(Threads::new(5)).assembler(&assembler),
            Problem::new(&form, &space).assembler(&assembler).threads(Threads::new(5)).threads(threads),
        ];
        for mut problem in problems {
            problem.solve().unwrap();
            let Solver::Own(solver) = &problem.solver else { panic!("a solver of its own") };
            assert_eq!(problem.system.assembler.threads(), threads);
            assert_eq!((solver.threads(), solver.solver().threads()), (threads, threads));
            assert_eq!(solver.solver().threads_of_factor(), Some(threads));
        }
        // A solver that is given has its own.
        let mut given = TangentSolver::new(TangentSolverOptions { threads, ..Default::default() });
        Problem::new(&form, &space).threads(Threads::new(5)).solver(&mut given).solve().unwrap();
        assert_eq!((given.threads(), given.threads_of_factor()), (threads, Some(threads)));
    }
}

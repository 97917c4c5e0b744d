//! The number of threads of a problem, from its builder to the factor, and the memory that problems leave to each other.

use std::cell::OnceCell;
use std::sync::Arc;

use super::Solver;
use crate::prelude::*;
use crate::solve::LinearSolver;

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

#[test]
fn problems_with_one_solver_assemble_in_the_same_memory() {
    let mesh = rectangle([0.0; 2], [1.0; 2], [6; 2], CellShape::Quadrilateral, 2).unwrap();
    let space = Space::scalar(&mesh, 2).unwrap();
    let bend = membrane::Model::default().bend();
    // On springs that resist one way.
    let press = form!(|u: Unknown<Scalar>, v: Test<Scalar>| {
        integral(cells("all"), dot(grad(u), grad(v)) + u * v - v)
            + integral(facets("left"), 50 * pos_part(u - 0.5) * v)
    });
    let assembler = Assembler::new(&mesh);
    let pattern = Arc::new(assembler.pattern(&press, &[&space], &[&space]).unwrap());
    let mut solver = CondensedSolver::default();
    let mut places = vec![];
    for form in [&press, &press, &bend, &press] {
        let mut problem = Problem::new(form, &space).assembler(&assembler).solver(&mut solver);
        problem.system.pattern = OnceCell::from(Arc::clone(&pattern));
        let found = problem.solve().unwrap();
        drop(problem);
        let alone = Problem::new(form, &space).solve().unwrap();
        let pairs = found.field().values().iter().zip(alone.field().values());
        assert!(pairs.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs())) < 1e-12);
        let memory = solver.memory().and_then(|memory| memory.matrix.as_ref());
        places.push(memory.expect("the matrix is left to the solver").values().as_ptr());
    }
    places.dedup();
    assert_eq!(places.len(), 1);
}

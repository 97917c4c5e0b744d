//! The three adjoint states, which the main job solves together: each has the bits that it has by itself.

use forms_contact_problem::hollow_cylinder::{Settings, hollow_cylinder, solve};
use forms_contact_problem::paper_law::Adjoint;
use forms_fem::prelude::*;

#[test]
fn adjoint_states_that_are_solved_together_have_the_bits_of_each() {
    for theta in [-1.0, 1.0] {
        // A wide Neumann zone of (41), so that its matrix is another one than that of (22).
        let settings = Settings { radial: 8, theta, extension: 20.0, ..Settings::default() };
        let job = solve(&settings).expect("a solution");
        let problem = hollow_cylinder(&settings).expect("a problem");
        let mut solver = CondensedSolver::default();
        let direct = problem.direct().expect("a problem").solver(&mut solver).solve().expect("a solution");
        let u = direct.field();
        assert_eq!(u.values(), job.u.values());
        let mut alone = |which| problem.solve_adjoint(which, u, &mut solver).expect("an adjoint state");
        let states = [Adjoint::Consistent, Adjoint::Extended, Adjoint::Discrete].map(&mut alone);
        for (alone, together) in states.iter().zip([&job.p_consistent, &job.p_extended, &job.p_discrete]) {
            assert_eq!(alone.field().values(), together.values());
        }
        assert!(job.p_consistent.values() != job.p_extended.values());
        assert_eq!((job.solver.factorisations, solver.report().factorisations), (1, 1));
        assert_eq!(job.solver.solves, solver.report().solves);

        // In another order, with one of them twice, and the reactions of each.
        let order = [Adjoint::Discrete, Adjoint::Discrete, Adjoint::Consistent];
        let problems = order.map(|which| problem.adjoint_state(which, u).expect("a problem"));
        let found = LinearProblems::of(problems).solver(&mut solver).solve().expect("adjoint states");
        for (found, alone) in found.iter().zip([&states[2], &states[2], &states[0]]) {
            assert_eq!(found.field().values(), alone.field().values());
            let [found, alone] = [found, alone].map(|state| state.reaction("inner").expect("a reaction"));
            for (found, alone) in found.iter().zip(&alone) {
                assert!((found - alone).abs() <= 1e-9 * alone.abs().max(1.0), "{found:e} {alone:e}");
            }
        }
    }
}

//! Programs on 1, 2 and 4 processes give what one process gives with the solvers of `forms_fem`.

use std::collections::BTreeMap;

use forms_contact::ContactProblem;
use forms_contact::forms;
use forms_contact::hollow_cylinder::{Settings, hollow_cylinder, solve};
use forms_distributed::cases::adaptive::adapted;
use forms_distributed::cases::ball_on_flat::ball_on_flat;
use forms_distributed::cases::drawn_block::DrawnBlock;
use forms_distributed::cases::hanging_block::HangingBlock;
use forms_distributed::cases::histories::{creeping, held, swinging_motion};
use forms_distributed::cases::mixed_block::MixedBlock;
use forms_distributed::cases::motions::Motion;
use forms_distributed::cases::poisson::Poisson;
use forms_distributed::cases::report::read;
use forms_fem::prelude::*;
use forms_fem::time::Mass;

mod programs;

use programs::mpirun;

const SAME: f64 = 1e-9;
const PROCESSES: [usize; 3] = [1, 2, 4];

fn told(processes: usize, program: &str, arguments: &[&str]) -> String {
    let output = mpirun(processes, program, arguments).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{program} {arguments:?} on {processes}: {said}");
    String::from_utf8(output.stdout).unwrap()
}

/// ‖a − b‖∞ / ‖b‖∞.
fn difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let largest = |values: &mut dyn Iterator<Item = f64>| values.map(f64::abs).fold(0.0, f64::max);
    largest(&mut a.iter().zip(b).map(|(a, b)| a - b)) / largest(&mut b.iter().copied())
}

/// Runs a program on each number of processes and compares what it tells; Newton's iterates must be as many, and their
/// active sets as large, on each.
fn check(program: &str, arguments: &[&str], expected: &BTreeMap<&str, Vec<f64>>) {
    let mut iterates: Option<[Vec<f64>; 2]> = None;
    for processes in PROCESSES {
        let told = told(processes, program, arguments);
        let found = read(&told);
        for (name, expected) in expected {
            let difference = difference(&found[name], expected);
            println!("{arguments:?} on {processes}: {name} differs by {difference:.1e}");
            assert!(difference < SAME, "{arguments:?} on {processes}: {name} differs by {difference:e}");
        }
        if let Some(active) = found.get("active") {
            let now = [found["steps"].clone(), active.clone()];
            assert_eq!(iterates.get_or_insert_with(|| now.clone()), &now);
        }
    }
}

#[test]
fn the_cylinder_in_contact_is_the_same_on_any_number_of_processes() {
    let settings = Settings { radial: 4, threads: Threads::new(1), ..Settings::default() };
    let serial = solve(&settings).unwrap();
    let expected = BTreeMap::from([
        ("u", serial.u.values().to_vec()),
        ("adjoint", serial.p_discrete.values().to_vec()),
        ("J", vec![serial.criterion]),
        ("force", vec![serial.contact_force]),
    ]);
    check(env!("CARGO_BIN_EXE_cylinder"), &["4"], &expected);
}

fn ball(problem: &ContactProblem<3>) -> BTreeMap<&'static str, Vec<f64>> {
    let mut solver = TangentSolver::default();
    let solved = problem.direct().unwrap().solver(&mut solver).solve().unwrap();
    let u = solved.into_field();
    let (data, regions, assembler) = (&problem.law.data, &problem.law.regions, &problem.assembler);
    let criterion = forms::criterion(data, &regions.omega, &regions.boundary, &u);
    let force = forms::contact_force(data, &regions.gamma_c, &u);
    let force = assembler.functional(&force).unwrap();
    assert!(force > 1.0, "the ball is in contact");
    BTreeMap::from([
        ("J", vec![assembler.functional(&criterion).unwrap()]),
        ("force", vec![force]),
        ("u", u.values().to_vec()),
    ])
}

#[test]
fn a_ball_on_a_flat_is_the_same_by_a_direct_solver() {
    let expected = ball(&ball_on_flat(4, -1.0).unwrap());
    check(env!("CARGO_BIN_EXE_ball"), &["4", "-1", "direct"], &expected);
}

#[test]
fn a_ball_on_a_flat_is_the_same_by_conjugate_gradients() {
    let expected = ball(&ball_on_flat(4, 1.0).unwrap());
    check(env!("CARGO_BIN_EXE_ball"), &["4", "1", "cg"], &expected);
}

/// The tangent with θ = −1 is unsymmetric.
#[test]
fn a_ball_on_a_flat_is_the_same_by_gmres() {
    let expected = ball(&ball_on_flat(4, -1.0).unwrap());
    check(env!("CARGO_BIN_EXE_ball"), &["4", "-1", "gmres"], &expected);
}

/// Adjoint states are solutions of transposed equations.
#[test]
fn the_adjoint_states_of_a_cylinder_are_the_same_by_gmres() {
    let settings = Settings { radial: 4, threads: Threads::new(1), ..Settings::default() };
    let serial = solve(&settings).unwrap();
    let expected =
        BTreeMap::from([("u", serial.u.values().to_vec()), ("adjoint", serial.p_discrete.values().to_vec())]);
    check(env!("CARGO_BIN_EXE_cylinder"), &["4", "gmres"], &expected);
}

#[test]
fn a_mixed_block_is_the_same_by_a_direct_solver_and_by_blocks() {
    let block = MixedBlock::new(3).unwrap();
    let solved = block.problem().solve().unwrap();
    let [u, p] = &solved.fields;
    let expected = BTreeMap::from([("u", u.values().to_vec()), ("p", p.values().to_vec())]);
    check(env!("CARGO_BIN_EXE_mixed_block"), &["3", "direct"], &expected);
    check(env!("CARGO_BIN_EXE_mixed_block"), &["3", "gmres"], &expected);
}

/// Newton's method in each step, affine equations for accelerations, and two unknowns.
#[test]
fn motions_are_the_same_step_by_step() {
    for (name, motion) in Motion::ALL {
        let conditions = motion.conditions().unwrap();
        let (mut serial, size) = motion.begin(&conditions).unwrap();
        for _ in 0..8 {
            serial.take(size).unwrap();
        }
        // Of the bar's velocity −1 contact has changed some.
        let rates = serial.state().rate.values();
        assert!(rates.iter().any(|rate| rate.abs() > 1e-3 && (rate + 1.0).abs() > 0.1), "{name}: {rates:?}");
        let (mut numbers, mut names) = (vec![], vec![]);
        for (number, state) in serial.states().iter().enumerate() {
            names.extend([format!("value{number}"), format!("rate{number}")]);
            numbers.extend([state.value.values().to_vec(), state.rate.values().to_vec()]);
        }
        let expected = names.iter().map(String::as_str).zip(numbers).collect();
        check(env!("CARGO_BIN_EXE_motions"), &[name, "8"], &expected);
    }
}

/// Value, gradient and Hessian of load histories and of motions, with consistent and lumped masses.
#[test]
fn histories_are_the_same_with_gradient_and_hessian() {
    let direction = [0.3, -0.7];
    for name in ["creep", "swing", "lumped"] {
        let held = held(name).unwrap();
        let found = match name {
            "creep" => {
                let (mut history, m) = creeping(&held);
                history.hessian(&m, &direction)
            }
            _ => {
                let mass = if name == "lumped" { Mass::Lumped } else { Mass::Consistent };
                let (mut history, m) = swinging_motion(&held, mass).unwrap();
                history.hessian(&m, &direction)
            }
        };
        let found = found.unwrap();
        assert!(found.gradient.iter().chain(&found.along).all(|slope| slope.abs() > 1e-4), "{found:?}");
        let expected = BTreeMap::from([
            ("value", vec![found.value]),
            ("gradient", found.gradient),
            ("along", found.along),
        ]);
        check(env!("CARGO_BIN_EXE_histories"), &[name], &expected);
    }
}

/// Each process marks and divides the same cells, between whose sizes nodes hang.
#[test]
fn a_cycle_of_adaptivity_is_the_same() {
    let solve = |form: &Form<2>, space: &Arc<Space<2>>, constraints: &Constraints<2>| {
        Ok(Problem::new(form, space).constrained(constraints).solve()?.into_field())
    };
    let found = adapted(solve).unwrap();
    let estimates: Vec<f64> = found.steps.iter().map(|step| step.estimate).collect();
    assert!(estimates.len() > 3 && found.mesh.mesh().cell_count() > 100, "{estimates:?}");
    let expected = BTreeMap::from([("estimates", estimates), ("u", found.solution.field.values().to_vec())]);
    check(env!("CARGO_BIN_EXE_adaptive"), &[], &expected);
}

/// Options of the environment come before the method, by the solver's prefix.
#[test]
fn options_change_the_solver() {
    let iterations = |options: &str| {
        let mut program = mpirun(2, env!("CARGO_BIN_EXE_mixed_block"), &["2", "gmres"]);
        let output = program.env("PETSC_OPTIONS", options).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{options}: {said}");
        read(&String::from_utf8(output.stdout).unwrap())["iterations"][0]
    };
    let by_blocks = iterations("");
    let by_jacobi = iterations("-block_fieldsplit_0_pc_type jacobi");
    let of_another = iterations("-other_fieldsplit_0_pc_type jacobi");
    println!("{by_blocks} iterations, {by_jacobi} with Jacobi's method for the displacements");
    assert!(by_jacobi > by_blocks + 5.0 && of_another == by_blocks, "{by_blocks} {by_jacobi} {of_another}");
    assert_eq!(iterations("-block_pc_type lu -block_pc_factor_mat_solver_type mumps"), 1.0);
}

/// Pairs of bodies that slide on each other: which facets are opposite, and with them the positions of the matrix, change from iterate
/// to iterate, on each process.
#[test]
fn a_block_that_is_drawn_along_a_slab_is_the_same() {
    let block = DrawnBlock::new(4).unwrap();
    let (mut steps, mut before) = (vec![], None);
    let path = block.draw(|problem, step| {
        let solved = problem.direct()?.increment(step).solve()?;
        steps.push(solved.iterations() as f64);
        before = Some(step.before.clone());
        Ok(solved)
    });
    let (u, before) = (path.unwrap().state, before.unwrap());
    let problem = block.step(1.0, &before).unwrap();
    let adjoint = problem.adjoint(&u).unwrap().solve().unwrap().into_field();
    let force = block.of_block(&before).unwrap().contact_force(&u);
    let force = block.assembler().functional(&force).unwrap();
    assert!(force < -0.05, "friction holds the block back: {force}");
    let expected = BTreeMap::from([
        ("J", vec![problem.criterion(&u).unwrap()]),
        ("force", vec![force]),
        ("steps", steps),
        ("u", u.values().to_vec()),
        ("adjoint", adjoint.values().to_vec()),
    ]);
    check(env!("CARGO_BIN_EXE_drawn_block"), &["4"], &expected);
    let patterns =
        |processes| read(&told(processes, env!("CARGO_BIN_EXE_drawn_block"), &["4"]))["patterns"][0];
    assert!(patterns(2) > 2.0, "points leave the facets that the first pattern holds");
}

#[test]
fn a_hanging_block_is_the_same_by_both_solvers() {
    let HangingBlock { form, space, constraints } =
        HangingBlock::new(4, Given::constant([0.0, 0.0, -1.0])).unwrap();
    let problem = Problem::new(&form, &space);
    let u = problem.constrained(&constraints).solve().unwrap().into_field();
    let expected = BTreeMap::from([("u", u.values().to_vec())]);
    check(env!("CARGO_BIN_EXE_hanging_block"), &["4", "direct", "u"], &expected);
    check(env!("CARGO_BIN_EXE_hanging_block"), &["4", "cg", "u"], &expected);
}

#[test]
fn processes_without_cells_take_part() {
    let told = told(3, env!("CARGO_BIN_EXE_hanging_block"), &["1", "direct", "u"]);
    let HangingBlock { form, space, constraints } =
        HangingBlock::new(1, Given::constant([0.0, 0.0, -1.0])).unwrap();
    let problem = Problem::new(&form, &space);
    let u = problem.constrained(&constraints).solve().unwrap().into_field();
    assert!(difference(&read(&told)["u"], u.values()) < SAME);
}

/// Not the share of a process.
#[test]
fn a_functional_of_a_solution_is_the_whole_on_each_process() {
    let problem = Poisson::new(Default::default()).unwrap();
    let solved = problem.problem().solve().unwrap();
    let expected = problem.total(&solved).unwrap();
    assert!((expected - 0.0351).abs() < 1e-4, "{expected}");
    for processes in PROCESSES {
        let told = told(processes, env!("CARGO_BIN_EXE_total"), &[]);
        let found = read(&told);
        println!("on {processes}: {:?}", found["totals"]);
        assert_eq!(found["totals"].len(), processes);
        assert!(found["totals"].iter().all(|total| (total / expected - 1.0).abs() < SAME), "{told}");
        assert!(difference(&found["u"], solved.field().values()) < SAME);
    }
}

/// The facets at the end of contact are those of the whole boundary, and each is assembled by the process that owns its cell.
#[test]
fn facets_that_are_split_where_contact_ends_are_divided_among_processes() {
    let settings = Settings { radial: 4, threads: Threads::new(1), ..Settings::default() };
    let problem = hollow_cylinder(&settings).unwrap().with_split_facets();
    let u = problem.direct().unwrap().solve().unwrap().into_field();
    let expected = BTreeMap::from([
        ("u", u.values().to_vec()),
        ("adjoint", problem.adjoint(&u).unwrap().solve().unwrap().into_field().values().to_vec()),
    ]);
    check(env!("CARGO_BIN_EXE_cylinder"), &["4", "split"], &expected);
}

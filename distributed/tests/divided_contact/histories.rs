//! Histories and motions with contact pairs on parts of a mesh.

use std::collections::BTreeMap;

use forms_distributed::cases::divided_contact::{drawn_pairs, of_name};
use forms_distributed::cases::drawn_block::DrawnBlock;
use forms_distributed::cases::pair_histories::{STEP, STEPS, by_means, fallen, slid, switches, thrown_block};
use forms_fem::inverse::ReducedProblem;

use crate::{DIGITS, Directory, Numbers, check_to, refused, told, vertices};

const PROCESSES: [usize; 3] = [1, 2, 3];

fn drawn_block(name: &str) -> DrawnBlock {
    let (name, mesh) = of_name(name).unwrap();
    DrawnBlock::on(&mesh, drawn_pairs(name)).unwrap()
}

/// The gradient by friction, a modulus and loads of steps; opposite cells read the modulus in the criterion.
#[test]
fn gradients_of_sliding_steps_are_the_same_on_parts() {
    let block = drawn_block("");
    let mut history = slid(&block, None).unwrap();
    let m = history.start();
    let found = history.gradient(&m).unwrap();
    let end = history.states(&m).unwrap().pop().unwrap();
    assert!(found.gradient.iter().all(|rate| rate.abs() > 1e-6), "{:?}", found.gradient);
    let expected = BTreeMap::from([
        ("value", vec![found.value]),
        ("gradient", found.gradient),
        ("u", vertices(&end)),
        ("switches", switches(&mut history).unwrap().to_vec()),
    ]);
    check_to(DIGITS, &PROCESSES, &["slid"], &expected);
}

/// A block that strikes the slab, slides and rebounds; and the same where a run stops and goes on with other processes.
#[test]
fn a_thrown_block_is_the_same_on_parts() {
    thrown("thrown", &PROCESSES);
}

/// The same where nodes of the slab hang.
#[test]
fn a_thrown_block_is_the_same_where_nodes_hang() {
    thrown("thrown trees", &[1, 3, 4]);
}

fn thrown(name: &str, processes: &[usize]) {
    let block = drawn_block(name);
    let mut motion = thrown_block(&block).unwrap();
    let mut down = vec![];
    for _ in 0..STEPS {
        motion.take(STEP).unwrap();
        let touch = block.assembler().pairs_at(&drawn_pairs(""), 4, &motion.state().value).unwrap();
        down.push(touch.deepest_overlap);
    }
    assert!(down.iter().any(|depth| *depth > 1e-4) && down[STEPS - 1] == 0.0, "{down:?}");
    let state = motion.state();
    let expected: Numbers =
        BTreeMap::from([("value", vertices(&state.value)), ("rate", vertices(&state.rate))]);
    check_to(DIGITS, processes, &[name], &expected);
    let directory = Directory::new(name);
    let arguments = [name, "0", "0", "direct", &directory.file("run.checkpoint")];
    told(3, &arguments);
    check_to(DIGITS, &[2], &arguments, &expected);
}

/// Means over own facets, at points of whole facets and on moving segments.
#[test]
fn means_over_facets_are_the_same_on_parts() {
    for name in ["means", "means on segments"] {
        let block = drawn_block(name);
        let mut force = f64::NAN;
        let path = block.draw(|at_points, step| {
            let problem = by_means(at_points, drawn_pairs(name));
            let solved = problem.direct()?.increment(step).solve()?;
            let law = by_means(at_points, drawn_pairs("one sided")).law;
            force = block.assembler().functional(&law.contact_force(solved.field()))?;
            Ok(solved)
        });
        let expected = BTreeMap::from([("u", vertices(&path.unwrap().state)), ("force", vec![force])]);
        assert!(force < -0.05, "friction holds the block back: {force}");
        check_to(DIGITS, if name == "means" { &PROCESSES } else { &[3] }, &[name], &expected);
    }
}

/// Value, gradient and Hessian of a motion with pairs of fixed points.
#[test]
fn a_motion_with_springs_between_bodies_is_the_same_on_parts() {
    let block = drawn_block("");
    let (mut history, m) = fallen(&block).unwrap();
    let found = history.hessian(&m, &[0.3, -0.7]).unwrap();
    // Without contact the value is quadratic in the weight.
    assert!((found.gradient[1] * m[1] - 2.0 * found.value).abs() > 0.1 * found.value, "{found:?}");
    let expected =
        BTreeMap::from([("value", vec![found.value]), ("gradient", found.gradient), ("along", found.along)]);
    check_to(DIGITS, &PROCESSES, &["sprung"], &expected);
}

/// A field that only the criterion reads.
#[test]
fn a_criterion_of_fields_without_values_on_copies_is_refused() {
    let cause = "has other values on copies of cells than on the process that owns them";
    let said = refused(&["uncompleted"], cause);
    assert!(said.contains("`mu`") && said.contains("part.completed(&field)"), "{said}");
}

//! Rows of all cases, several at a time. Each case is computed on one thread, so that its seconds are those of one.

use std::cmp::Reverse;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;

use forms_fem::output::Failure;
use forms_fem::threads::Threads;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::formulation::Formulation;
use crate::options::Options;
use crate::posed::Posed;
use crate::rows::{Answer, Row};

/// The stack of a thread \[bytes\]: as large as that of a program's first one.
const STACK: usize = 8 << 20;

/// A formulation on a mesh of a problem, by their places.
#[derive(Clone, Copy)]
struct Task {
    problem: usize,
    formulation: usize,
    degree: usize,
    level: usize,
}

/// The rows of each problem, in the order of the problems, as soon as all of them are there.
///
/// # Errors
/// Those of `finished`, and of a problem that cannot be made.
pub fn run(
    problems: &[&dyn Posed],
    formulations: &[&dyn Formulation],
    options: &Options,
    mut finished: impl FnMut(&dyn Posed, Vec<Row>) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let tasks = tasks(problems.len(), formulations.len(), options);
    // Within a problem those that take longest begin first.
    let mut order: Vec<usize> = (0..tasks.len()).collect();
    order.sort_by_key(|place| (tasks[*place].problem, Reverse((tasks[*place].level, tasks[*place].degree))));
    let next = AtomicUsize::new(0);
    let pools = pools(Threads::all().count().min(tasks.len()))?;
    let (sender, receiver) = mpsc::channel();
    let compute = |sender: mpsc::Sender<(usize, Result<Row, String>)>| {
        while let Some(&place) = order.get(next.fetch_add(1, Ordering::Relaxed)) {
            let task = tasks[place];
            let row = row(problems[task.problem], formulations[task.formulation], task);
            // Nobody waits for the rest after an error.
            if sender.send((place, row.map_err(|why| why.to_string()))).is_err() {
                break;
            }
        }
    };
    std::thread::scope(|scope| {
        for pool in &pools {
            let sender = sender.clone();
            scope.spawn(move || pool.install(|| compute(sender)));
        }
        drop(sender);
        let mut rows: Vec<Option<Row>> = vec![None; tasks.len()];
        // Tasks are in the order of the problems.
        let (each, mut complete) = (tasks.len() / problems.len().max(1), 0);
        for (place, row) in receiver {
            rows[place] = Some(row?);
            while complete < problems.len() {
                let of_problem = &mut rows[complete * each..(complete + 1) * each];
                if of_problem.iter().any(Option::is_none) {
                    break;
                }
                let found = of_problem.iter_mut().filter_map(Option::take).collect();
                finished(problems[complete], up_to_reasons(found))?;
                complete += 1;
            }
        }
        Ok(())
    })
}

/// All tasks, in the order of the tables.
fn tasks(problems: usize, formulations: usize, options: &Options) -> Vec<Task> {
    let mut tasks = vec![];
    for problem in 0..problems {
        for &degree in &options.degrees {
            for formulation in 0..formulations {
                let levels = 0..options.levels;
                tasks.extend(levels.map(|level| Task { problem, formulation, degree, level }));
            }
        }
    }
    tasks
}

/// Pools of one thread each: what a case runs on threads stays in its own pool.
fn pools(count: usize) -> Result<Vec<ThreadPool>, Failure> {
    let pool = || ThreadPoolBuilder::new().num_threads(1).stack_size(STACK).build();
    (0..count).map(|_| pool().map_err(Failure::from)).collect()
}

fn row(problem: &dyn Posed, formulation: &dyn Formulation, task: Task) -> Result<Row, Failure> {
    let Task { degree, level, .. } = task;
    let (unknowns, answer) = problem.answer(formulation, level, degree)?;
    let (problem, formulation) = (problem.name(), formulation.name());
    Ok(Row { problem, formulation, degree, level, unknowns, answer })
}

/// Without the finer meshes of a formulation that does not exist for the problem.
fn up_to_reasons(rows: Vec<Row>) -> Vec<Row> {
    let mut kept: Vec<Row> = vec![];
    for row in rows {
        let ended = kept.last().is_some_and(|before| {
            matches!(before.answer, Answer::NotDefined(_))
                && (&before.formulation, before.degree) == (&row.formulation, row.degree)
        });
        if !ended {
            kept.push(row);
        }
    }
    kept
}

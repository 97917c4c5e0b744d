//! Whatever goes wrong on one process, all processes end, and the cause is printed.

use std::collections::BTreeSet;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::Stdio;
use std::thread;
use std::time::{Duration, Instant};

mod programs;

use programs::mpirun;

/// All processes have ended this long after the cause was printed.
const LIMIT: Duration = Duration::from_secs(10);

/// Time limit of a whole run, including the start of the processes on a busy machine.
const PATIENCE: Duration = Duration::from_secs(300);

/// Runs the program, which has to fail, say why, and leave no process.
fn fails(processes: usize, arguments: &[&str], causes: &[&str]) {
    let mut command = mpirun(processes, env!("CARGO_BIN_EXE_failures"), arguments);
    let mut run = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let lines = BufReader::new(run.stderr.take().unwrap()).lines();
    let told: Vec<String> = causes.iter().map(|cause| (*cause).to_owned()).collect();
    // What was said, and when each cause was.
    let listener = thread::spawn(move || {
        let (mut said, mut first) = (vec![], None);
        for line in lines.map_while(Result::ok) {
            if first.is_none() && told.iter().any(|cause| line.contains(cause)) {
                first = Some(Instant::now());
            }
            said.push(line);
        }
        (said, first)
    });
    let start = Instant::now();
    let status = loop {
        if let Some(status) = run.try_wait().unwrap() {
            break status;
        }
        if start.elapsed() > PATIENCE {
            run.kill().unwrap();
            panic!("{arguments:?} on {processes} processes hangs");
        }
        thread::sleep(Duration::from_millis(10));
    };
    let (said, first) = listener.join().unwrap();
    let whole = said.join("\n");
    assert!(!status.success(), "{arguments:?} on {processes}: {whole}");
    for cause in causes {
        assert!(whole.contains(cause), "{arguments:?} on {processes} does not say {cause:?}: {whole}");
    }
    let pids: BTreeSet<&str> = said.iter().filter_map(|line| line.strip_prefix("pid ")).collect();
    assert_eq!(pids.len(), processes, "{whole}");
    // `mpirun` has ended, and with it what it started.
    let cause = first.unwrap();
    while pids.iter().any(|pid| is_running(pid)) {
        assert!(cause.elapsed() < LIMIT, "{arguments:?} on {processes}: a process is left");
        thread::sleep(Duration::from_millis(10));
    }
    let seconds = cause.elapsed();
    assert!(seconds < LIMIT, "{arguments:?} on {processes}: {seconds:?} after the cause");
    let causes = said.iter().filter(|line| line.contains("error: ") || line.contains("panicked"));
    println!("{arguments:?} on {processes}: {:.1} s after the cause", seconds.as_secs_f64());
    causes.for_each(|line| println!("    {line}"));
}

/// Whether there is a process of this number that has not ended. One that nobody has asked for its exit code has.
fn is_running(pid: &str) -> bool {
    let status = std::fs::read_to_string(Path::new("/proc").join(pid).join("stat"));
    status.is_ok_and(|status| !status.rsplit(") ").next().is_some_and(|rest| rest.starts_with(['Z', 'X'])))
}

fn fails_on_two_and_four(arguments: &[&str], causes: &[&str]) {
    fails(2, arguments, causes);
    fails(4, arguments, causes);
}

/// Message of the others about a process that failed.
const ELSEWHERE: &str = "failed, and says why itself";

#[test]
fn an_error_of_one_process_ends_all() {
    fails_on_two_and_four(&["error"], &["no further step on this process", ELSEWHERE]);
    fails_on_two_and_four(&["part"], &["no reaction on this process", ELSEWHERE]);
}

#[test]
fn an_error_of_one_process_ends_others_that_are_busy() {
    let causes = ["no further step while others are busy", "the others took no notice"];
    fails_on_two_and_four(&["busy"], &causes);
}

#[test]
fn a_panic_of_one_process_ends_all() {
    fails_on_two_and_four(&["panic"], &["a mistake on this process", "it panicked"]);
}

#[test]
fn a_bad_argument_of_one_process_ends_all() {
    fails_on_two_and_four(&["argument"], &["invalid digit found in string", ELSEWHERE]);
    fails_on_two_and_four(&["region"], &["boundry", ELSEWHERE]);
}

#[test]
fn a_missing_file_of_one_process_ends_all() {
    fails_on_two_and_four(&["file"], &["missing.msh: No such file or directory", ELSEWHERE]);
}

#[test]
fn a_process_that_ends_early_ends_all() {
    fails_on_two_and_four(&["early"], &["at the end, this process at a comparison"]);
    fails_on_two_and_four(&["exit"], &["exited with non-zero status"]);
}

/// `mpirun` ends the others as soon as one has failed, so that they may say nothing.
#[test]
fn a_world_without_run_ends_as_well() {
    fails_on_two_and_four(&["error", "by hand"], &["no further step on this process"]);
    fails_on_two_and_four(&["panic", "by hand"], &["a mistake on this process", "it panicked"]);
    fails_on_two_and_four(&["file", "by hand"], &["missing.msh: No such file or directory"]);
}

#[test]
fn problems_that_differ_are_refused() {
    let solvers = "the processes have different unknowns";
    fails_on_two_and_four(&["mesh"], &[solvers]);
    fails_on_two_and_four(&["space"], &[solvers]);
    let problems = "the processes have different problems: what differs is";
    fails_on_two_and_four(&["parameter"], &[&format!("{problems} the parameters")]);
    fails_on_two_and_four(&["boundary"], &[&format!("{problems} the constraints")]);
}

/// The same cell of all processes, and no other one.
#[test]
fn cells_that_are_no_partition_are_refused() {
    fails_on_two_and_four(&["cells"], &["the processes' own cells are no partition of the mesh's"]);
}

#[test]
fn a_petsc_solver_without_on_is_refused() {
    for processes in [2, 4] {
        let cause = format!("the linear solver adds up the matrices of {processes} processes");
        fails(processes, &["without on"], &[&cause, "write `.on(&world)` before `.solve()`"]);
    }
}

#[test]
fn on_without_a_petsc_solver_is_refused() {
    for processes in [2, 4] {
        let cause = format!("the problem is solved on {processes} processes, and each has a part");
        fails(processes, &["without PETSc"], &[&cause]);
    }
}

#[test]
fn an_error_that_all_share_ends_all() {
    fails_on_two_and_four(&["assembly"], &["of the other processes failed", "weight"]);
    fails_on_two_and_four(&["twice"], &["PETSc was started already in this process"]);
}

#[test]
fn a_solver_that_did_not_converge_says_why_and_how_far_it_came() {
    let cause = "CG with GAMG failed: stopped after 3 iterations: DIVERGED_ITS; residuals: [";
    fails_on_two_and_four(&["convergence"], &[cause]);
}

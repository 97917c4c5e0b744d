//! One descent: from the round holes, or from where an earlier run was stopped, to the best shape.

use std::fmt::Write;
use std::io::IsTerminal;
use std::time::{Duration, Instant};

use forms_contact::shape_problem::{ContactShape, ContactState, Criterion};
use forms_fem::output::tell;
use forms_fem::prelude::*;
use forms_fem::shape_optimisation::{
    Descent, DescentState, Logbook, Remesh, Remeshed, Report, Rotations, ShapeProblem, StopReason, Wall,
};
use indicatif::{ProgressBar, ProgressStyle};

use crate::Outcome;
use crate::meshes;
use crate::options::Options;
use crate::ring::ProblemOn;

/// A finished run.
pub struct Run {
    /// Number of the adjoint state's equation.
    pub number: &'static str,
    /// The history.
    pub state: DescentState,
    /// The best shape.
    pub mesh: Mesh<2>,
    /// The state on the round holes.
    pub start: ContactState<2>,
    /// The state on the best shape.
    pub end: ContactState<2>,
    /// The adjoint states, on the round holes and on the best shape; none if the criterion is not the paper's.
    pub adjoints: Option<[Field<2>; 2]>,
    /// The directory of the results.
    pub logbook: Logbook,
    /// The least wall of the best shape \[cm\].
    wall: f64,
    seconds: f64,
}

impl Run {
    /// Runs to the end, telling of each step.
    pub fn new(
        options: &Options,
        initial: &Mesh<2>,
        name: &'static str,
        number: &'static str,
        problem: &ContactShape<ProblemOn>,
        pattern: Option<Rotations<2>>,
    ) -> Outcome<Run> {
        let clock = Instant::now();
        let clearance = |x: &[f64; 2]| meshes::clearance(options, x);
        let wall = Some(Wall { region: problem.moving.clone(), clearance: &clearance });
        let with = |mesh: &Mesh<2>, factor: f64| meshes::remeshed(options, mesh, factor);
        let remesh = Remesh { with: &with, below: options.remesh_below(), tolerance: meshes::TOLERANCE };
        let remesh = (options.remesh_below() > 0.0).then_some(remesh);
        let descent =
            Descent { problem, initial: initial.clone(), options: options.descent(), pattern, wall, remesh };
        let (settings, changeable) = (options.settings(name)?, options.changeable());
        let mut logbook = Logbook::new(options.out.join(name), settings, changeable, options.every)?;
        if options.anew {
            logbook.forget()?;
        }
        let from = logbook.state()?;
        if let Some(from) = &from {
            tell(format!("{name}: goes on from step {}", from.iterations()));
        }
        let progress = Progress::new(name, options.steps);
        let mut hear = |report: &Report<ContactState<2>, 2>| {
            progress.hear(report.state, report.solved.criterion);
            logbook.write(report, &[("displacement", &report.solved.u)])
        };
        let best = descent.run(from, &mut hear)?;
        progress.finish();
        let start = problem.solve(initial)?.state;
        let end = best.values.state;
        let adjoints = match problem.criterion {
            Criterion::Paper => {
                let solve = |state: &ContactState<2>| -> Outcome<Field<2>> {
                    let mut solver = TangentSolver::default();
                    Ok(state.problem.solve_adjoint(problem.adjoint, &state.u, &mut solver)?.into_field())
                };
                Some([solve(&start)?, solve(&end)?])
            }
            _ => None,
        };
        let seconds = clock.elapsed().as_secs_f64();
        let wall = meshes::least_wall(options, &best.mesh, &problem.moving)?;
        Ok(Run { number, state: best.state, mesh: best.mesh, start, end, adjoints, logbook, wall, seconds })
    }
}

/// The results, one line per run: J, and J with the perimeter penalty, which the descent minimises.
pub fn table(runs: &[Run]) -> String {
    let mut text = format!(
        "{:<8}{:>14}{:>14}{:>10}{:>14}{:>14}{:>12}{:>10}{:>7}{:>8}{:>7}{:>9}  why it stopped\n",
        "adjoint",
        "J at first",
        "J at last",
        "change",
        "penalised",
        "at last",
        "volume off",
        "quality",
        "wall",
        "steps",
        "meshes",
        "seconds"
    );
    for Run { number, state, seconds, start, end, wall, .. } in runs {
        let [Some(first), Some(last)] = [state.history.first(), state.history.last()] else { continue };
        let finish = match &state.finish {
            Some(StopReason::Converged) => "the derivative vanishes",
            Some(StopReason::Stalled) => "hardly any decrease",
            Some(StopReason::Iterations) => "steps",
            Some(StopReason::NoStep(_)) => "no decrease along the direction",
            Some(StopReason::MeshQuality) => "the cells",
            Some(StopReason::NoNewMesh(why)) => why,
            None => "",
        };
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{number:<8}{:>14.6}{:>14.6}{:>9.2}%{:>14.6}{:>14.6}{:>12.1e}{:>10.3}{wall:>7.3}{:>8}{:>7}{seconds:>9.1}  {finish}",
            start.criterion,
            end.criterion,
            100.0 * (end.criterion / start.criterion - 1.0),
            first.criterion,
            last.criterion,
            last.constraint.unwrap_or(0.0),
            last.quality,
            state.iterations(),
            1 + state.history.iter().filter(|row| row.remeshed.is_some()).count(),
        );
    }
    text
}

/// A new mesh, with what was before it.
fn new_mesh(Remeshed { criterion, constraint, quality, cells }: &Remeshed) -> String {
    let volume = constraint.unwrap_or(0.0);
    format!(
        "; a new mesh of {cells} cells, before it penalised {criterion:.6}, volume off by {volume:.1e}, quality {quality:.2}"
    )
}

/// A bar on a terminal, a line per step elsewhere; both on the standard error stream.
struct Progress {
    bar: Option<ProgressBar>,
    name: &'static str,
}

impl Progress {
    fn new(name: &'static str, steps: usize) -> Progress {
        let bar = std::io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::new(steps as u64);
            if let Ok(style) = ProgressStyle::with_template("{prefix} {bar:30} {pos}/{len} {elapsed} {msg}") {
                bar.set_style(style);
            }
            bar.set_prefix(name);
            bar.enable_steady_tick(Duration::from_millis(200));
            bar
        });
        Progress { bar, name }
    }

    /// Tells of a step: J alone, and J with the perimeter penalty, which the descent minimises.
    fn hear(&self, state: &DescentState, alone: f64) {
        let Some(row) = state.history.last() else { return };
        let step = row.step.as_ref().map_or_else(String::new, |step| {
            format!(", moved {:.3} cm, derivative {:.2e}", step.longest_move, step.gradient_norm)
        });
        let volume = row.constraint.unwrap_or(0.0);
        let text = format!(
            "J = {alone:.6}, penalised {:.6}, volume off by {volume:.1e}, quality {:.2}{step}{}",
            row.criterion,
            row.quality,
            row.remeshed.as_ref().map_or_else(String::new, new_mesh)
        );
        match &self.bar {
            Some(bar) => {
                bar.set_position(state.iterations() as u64);
                bar.set_message(text);
            }
            None => tell(format!("{} step {}: {text}", self.name, state.iterations())),
        }
    }

    fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

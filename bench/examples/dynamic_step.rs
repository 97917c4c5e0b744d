//! The cost of a linear step in time: plane strain on a square, half a million unknowns, by the trapezoidal rule, from a form that names
//! no scheme; compared with scikit-fem with matrices M and K written by hand and SuperLU, in turns of some steps each.
//!
//! `cargo run --release -p forms-bench --example dynamic_step -- [CELLS [STEPS [PYTHON [TURNS]]]]` (default 499: 500,000 unknowns; 10;
//! python3, with scikit-fem==12.0.1; 3). Without Python, or one that has no scikit-fem, ours runs alone.

use std::error::Error;
use std::io::{BufRead, BufReader, Lines, Write};
use std::path::PathBuf;
use std::process::{Child, ChildStdin, ChildStdout, Command, ExitCode, Stdio};
use std::time::Instant;

use forms_fem::output::{StandardOutput, program};
use forms_fem::prelude::*;
use forms_fem::time::{GeneralisedAlpha, State, Step, StepCost, TimeLoop};
use serde_json::Value;

#[forms(dimension = 2)]
mod square {
    use forms_fem::time::operators::vector::{acceleration, displacement};

    #[includes(forms_fem::time::operators::vector::Data)]
    pub struct Data {
        pub lambda: Param,
        pub mu: Param,
        pub rho: Param,
    }
    #[cells]
    pub struct Omega;

    fn stress(w: Vector) -> Tensor {
        lambda * tr(eps(w)) * I + 2 * mu * eps(w)
    }

    pub fn motion(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, rho * dot(acceleration(u), v) + inner(stress(displacement(u)), eps(v)))
    }

    pub fn energy(u: State<Vector>, velocity: State<Vector>) -> Functional {
        integral(Omega, rho * dot(velocity, velocity) / 2 + inner(stress(u), eps(u)) / 2)
    }
}

/// λ, μ, ρ and the step size of both programs.
const LAMBDA: f64 = 1.0;
const MU: f64 = 0.5;
const DENSITY: f64 = 1.0;
const SIZE: f64 = 0.01;

fn model(step: forms_fem::time::operators::vector::Data<2>) -> square::Model<2> {
    square::Model::new(square::data_from(step).lambda(LAMBDA).mu(MU).rho(DENSITY))
}

/// scikit-fem's program, which takes the given number of steps.
struct Peer {
    process: Child,
    orders: ChildStdin,
    answers: Lines<BufReader<ChildStdout>>,
}

impl Peer {
    fn begin(python: &str, cells: usize) -> Result<Self, Box<dyn Error>> {
        let script = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("peers/dynamic_step_skfem.py");
        let mut command = Command::new(python);
        command.arg(script).arg(cells.to_string()).stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut process = command.stderr(Stdio::inherit()).spawn()?;
        let orders = process.stdin.take().ok_or("scikit-fem's program has no input")?;
        let output = process.stdout.take().ok_or("scikit-fem's program has no output")?;
        Ok(Peer { process, orders, answers: BufReader::new(output).lines() })
    }

    fn answer(&mut self) -> Result<Value, Box<dyn Error>> {
        match self.answers.next() {
            Some(line) => Ok(serde_json::from_str(&line?)?),
            None => Err("scikit-fem did not run".into()),
        }
    }

    fn steps(&mut self, count: usize) -> Result<Value, Box<dyn Error>> {
        writeln!(self.orders, "{count}")?;
        self.answer()
    }

    fn end(mut self) -> Result<(), Box<dyn Error>> {
        drop(self.orders);
        self.process.wait()?;
        Ok(())
    }
}

fn number(answer: &Value, name: &str) -> Result<f64, String> {
    answer[name].as_f64().ok_or_else(|| format!("scikit-fem's program gave no `{name}`"))
}

/// Parts of a step in milliseconds.
fn row(name: &str, parts: [f64; 3], step: f64, change: f64) -> String {
    let rest = step - parts.iter().sum::<f64>();
    let parts: Vec<String> =
        parts.iter().chain([&rest, &step]).map(|part| format!("{:.2}", 1e3 * part)).collect();
    format!("| {name} | {} | {change:+.1e} |", parts.join(" | "))
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let given =
        |place: usize, otherwise: usize| arguments.get(place).map_or(Ok(otherwise), |text| text.parse());
    let (cells, steps, turns) = (given(0, 499)?, given(1, 10)?.max(1), given(3, 3)?.max(1));
    let python = arguments.get(2).map_or("python3", String::as_str);

    let mesh = rectangle([0.0; 2], [1.0; 2], [cells; 2], CellShape::Quadrilateral, 1)?;
    let space = Space::vector(&mesh, 1)?;
    let mut held = Constraints::new(&space);
    held.fix("left", |_| [0.0; 2])?;
    let velocity = Field::interpolate(&space, |x| [0.0, x[0] * x[0]])?;
    let start = State::new(0.0, Field::zero(&space), velocity)?;
    let assembler = Assembler::new(&mesh);
    let energy =
        |state: &State<2>| assembler.functional(&model(Default::default()).energy(&state.value, &state.rate));
    let first = energy(&start)?;
    // The factor's solution is checked, and not refined to the last bit: SuperLU's is not either.
    let options = TangentSolverOptions { refinement_steps: 0, ..TangentSolverOptions::default() };
    let mut solver = TangentSolver::new(options);
    let mut motion =
        TimeLoop::new(|step: &Step<2>| model(step.into()).motion(), GeneralisedAlpha::trapezoidal(), start)
            .assembler(&assembler)
            .constrained(&held)
            .constant_coefficients()
            .solver(&mut solver);
    let begun = Instant::now();
    motion.take(SIZE)?;
    let first_step = begun.elapsed().as_secs_f64();
    let mut peer = Peer::begin(python, cells)?;
    let begins = peer.answer();
    let mut peer = match &begins {
        Ok(_) => Some(peer),
        Err(_) => {
            peer.end()?;
            None
        }
    };

    out.line(format!(
        "{} unknowns; turns of {steps} steps of {SIZE}; milliseconds per step",
        space.unknowns()
    ));
    out.line("| turn | residual, or product | solve | matrix | rest | step | energy beside the start's |");
    out.line("| --- | --: | --: | --: | --: | --: | --: |");
    let (mut taken, mut quickest) = (0, [f64::INFINITY; 2]);
    for _ in 0..turns {
        let (mut sum, begun) = (StepCost::default(), Instant::now());
        for _ in 0..steps {
            let step = motion.take(SIZE)?;
            let cost = step.cost.ok_or("the form is affine")?;
            // The promise is looked into at each 32nd step.
            let looked = usize::from(step.number % 32 == 0);
            if [cost.residuals, cost.matrices, cost.solves] != [1 + looked, 0, 1] {
                return Err(format!("a step took {cost:?}").into());
            }
            sum.residual_seconds += cost.residual_seconds;
            sum.solve_seconds += cost.solve_seconds;
            sum.matrix_seconds += cost.matrix_seconds;
        }
        let per_step = 1.0 / steps as f64;
        let of_step = begun.elapsed().as_secs_f64() * per_step;
        let parts = [sum.residual_seconds, sum.solve_seconds, sum.matrix_seconds].map(|part| part * per_step);
        taken += steps;
        let last = energy(motion.state())?;
        out.line(row("forms", parts, of_step, last / first - 1.0));
        quickest[0] = quickest[0].min(of_step);
        if let (Some(peer), Ok(begins)) = (&mut peer, &begins) {
            let found = peer.steps(steps)?;
            let parts = [number(&found, "product")?, number(&found, "solve")?, 0.0];
            let (step, change) =
                (number(&found, "step")?, number(&found, "last")? / number(begins, "first")? - 1.0);
            out.line(row("scikit-fem, matrices by hand", parts, step, change));
            quickest[1] = quickest[1].min(step);
        }
    }
    drop(motion);
    let report = solver.report();
    out.line(format!(
        "\nOurs: assembly and factor {first_step:.2} s, {} numbers in the factor; {} factorisations and {} solves for {} steps and the \
         start.",
        report.factor_entries,
        report.factorisations,
        report.solves,
        taken + 1
    ));
    match (&begins, peer) {
        (Ok(begins), Some(peer)) => {
            peer.end()?;
            let set_up = number(begins, "assembly")? + number(begins, "factor")?;
            out.line(format!(
                "scikit-fem: {set_up:.2} s, {} numbers in its factors. Energies at the start differ by {:.1e}; its quickest turn takes \
                 {:.2} times as long for a step as ours.",
                number(begins, "factor_entries")?,
                (number(begins, "first")? / first - 1.0).abs(),
                quickest[1] / quickest[0]
            ));
        }
        _ => out.line("scikit-fem did not run"),
    }
    Ok(())
}

fn main() -> ExitCode {
    program(run)
}

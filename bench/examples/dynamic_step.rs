//! The cost of a linear step in time: plane strain on a square, half a million unknowns, by the trapezoidal rule, from a form that names
//! no scheme; beside it scikit-fem with matrices M and K written by hand and SuperLU.
//!
//! `cargo run --release -p forms-bench --example dynamic_step -- [CELLS [STEPS [PYTHON]]]` (default 499: 500,000 unknowns; 20; python3,
//! with scikit-fem==12.0.1).

use std::error::Error;
use std::path::PathBuf;
use std::process::{Command, ExitCode, Stdio};
use std::time::Instant;

use forms_fem::output::{StandardOutput, program};
use forms_fem::prelude::*;
use forms_fem::time::{GeneralisedAlpha, State, Step, TimeLoop};

#[forms(dimension = 2)]
mod square {
    use forms_fem::time::operators::vector::{acceleration, displacement};

    #[extends(forms_fem::time::operators::vector::Data)]
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

fn model(base: forms_fem::time::operators::vector::Data<2>) -> square::Model<2> {
    square::Model::new(square::Data { base, lambda: LAMBDA, mu: MU, rho: DENSITY })
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let given =
        |place: usize, otherwise: usize| arguments.get(place).map_or(Ok(otherwise), |text| text.parse());
    let (cells, steps) = (given(0, 499)?, given(1, 20)?.max(1));
    let python = arguments.get(2).map_or("python3", String::as_str);

    let mesh = Arc::new(rectangle([0.0; 2], [1.0; 2], [cells; 2], CellShape::Quadrilateral, 1)?);
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
    let begun = Instant::now();
    for _ in 1..=steps {
        motion.take(SIZE)?;
    }
    let of_step = begun.elapsed().as_secs_f64() / steps as f64;
    let last = energy(motion.state())?;
    let report = {
        drop(motion);
        solver.report().clone()
    };
    out.line(format!("{} unknowns, {steps} steps of {SIZE}, the first apart", space.unknowns()));
    out.line("| program | assembly and factor (s) | a step (s) | energy at the end beside the start |\n| --- | --: | --: | --: |");
    out.line(format!("| forms | {first_step:.2} | {of_step:.4} | {:+.1e} |", last / first - 1.0));

    let script = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("peers/dynamic_step_skfem.py");
    let mut command = Command::new(python);
    command.arg(script).arg(cells.to_string()).arg(steps.to_string()).stderr(Stdio::inherit());
    let output = command.output()?;
    if output.status.success() {
        let theirs: serde_json::Value = serde_json::from_slice(&output.stdout)?;
        let number =
            |name: &str| theirs[name].as_f64().ok_or(format!("scikit-fem's program gave no `{name}`"));
        let (set_up, step) = (number("assembly")? + number("factor")?, number("step")?);
        out.line(format!(
            "| scikit-fem, matrices by hand | {set_up:.2} | {step:.4} | {:+.1e} |",
            number("last")? / number("first")? - 1.0
        ));
        out.line(format!(
            "\nThe energies at the start differ by {:.1e}; scikit-fem takes {:.2} times as long for a step.",
            (number("first")? / first - 1.0).abs(),
            step / of_step
        ));
    } else {
        out.line("\nscikit-fem did not run");
    }
    out.line(format!(
        "Ours: {} factorisations {:.2} s, {} solves {:.3} s each; {} numbers in the factor.",
        report.factorisations,
        report.factorisation_seconds,
        report.solves,
        report.solve_seconds / report.solves.max(1) as f64,
        report.factor_entries
    ));
    Ok(())
}

fn main() -> ExitCode {
    program(run)
}

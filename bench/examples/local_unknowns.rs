//! Bodies with unknowns of one cell each: these eliminated first, and LU of the whole matrix, their times and memory.
//!
//! `cargo run --release -p forms-bench --example local_unknowns -- SOLVER [BODY] [CELLS] [DIMENSION]` solves with the solver `eliminated`,
//! `signs` (Cholesky with signs of the whole) or `lu`, and a body `pressure` (Q2, one pressure per cell), `linear` (Q2/P₋₁), `enhanced`
//! (Q1, enhanced strains with the mean zero) or `dilatation` (Q2 with one pressure and one dilatation per cell). A process measures one solver, for
//! its memory.

use std::error::Error;
use std::process::ExitCode;
use std::time::Instant;

use forms_bench::beside_petsc::peak_memory;
use forms_fem::contract::Form;
use forms_fem::output::{StandardOutput, program};
use forms_fem::prelude::*;
use forms_fem::solve::{LocalUnknowns, PerUnknown};

/// Bodies that are held at one side and pulled.
#[forms]
mod body {
    /// Ω.
    #[cells]
    pub struct Omega;

    /// A nearly incompressible body, K/μ = 10⁴.
    pub fn pressure(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        integral(Omega, 2 * inner(eps(u), eps(v)) - p * div(v) - q * div(u) - 0.0001 * p * q - v[0])
    }

    /// Enhanced strains e with the mean zero, by stresses s of degree 0.
    pub fn enhanced(
        u: Unknown<Vector>,
        e: Unknown<Tensor>,
        s: Unknown<Tensor>,
        v: Test<Vector>,
        d: Test<Tensor>,
        t: Test<Tensor>,
    ) -> Form {
        let strain = eps(u) + sym(e);
        let virtual_strain = eps(v) + sym(d);
        integral(Omega, 2 * inner(strain, virtual_strain) + 20 * tr(strain) * tr(virtual_strain))
            + integral(Omega, 0.5 * inner(e, d) + inner(s, d) + inner(t, e) - v[0])
    }

    /// Neo-Hooke with a mean dilatation 1 + j.
    pub fn dilatation(u: Unknown<Vector>, j: Unknown<Scalar>, p: Unknown<Scalar>) -> Energy {
        let F = I + grad(u);
        integral(Omega, inner(F, F) / 2 - ln(1 + j) + 5000 * pow(j, 2) + p * (det(F) - 1 - j) - 0.001 * u[0])
    }
}

fn main() -> ExitCode {
    program(run)
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let word = |place: usize, otherwise: &str| -> String {
        arguments.get(place).map_or(otherwise, String::as_str).to_owned()
    };
    let (solver, body) = (word(0, "eliminated"), word(1, "pressure"));
    let cells: usize = word(2, "100").parse()?;
    if word(3, "2") == "3" {
        let mesh = cuboid([0.0; 3], [1.0; 3], [cells; 3], CellShape::Hexahedron, 1)?;
        choose(out, &mesh, &solver, &body)
    } else {
        let mesh = rectangle([0.0; 2], [1.0; 2], [cells; 2], CellShape::Quadrilateral, 1)?;
        choose(out, &mesh, &solver, &body)
    }
}

fn choose<const D: usize>(
    out: &mut StandardOutput,
    mesh: &Mesh<D>,
    solver: &str,
    body: &str,
) -> Result<(), Box<dyn Error>>
where
    Dim: Dimension<D>,
{
    let all = body::Omega::on("all");
    let degree = if body == "enhanced" { 1 } else { 2 };
    let bodies = Space::vector(mesh, degree)?;
    let cell = |elements, shape: &[usize]| Space::of(mesh, elements, Scope::Cell, shape);
    match body {
        "enhanced" => {
            let [strains, stresses] =
                [cell(Elements::Lagrange(1), &[D, D])?, cell(Elements::Lagrange(0), &[D, D])?];
            measure(out, &body::enhanced(&all), [&bodies, &strains, &stresses], solver)
        }
        "dilatation" => {
            let constant = cell(Elements::Lagrange(0), &[])?;
            measure(out, &body::dilatation(&all).into(), [&bodies, &constant, &constant], solver)
        }
        "linear" => {
            let linear = cell(Elements::LinearInSpace, &[])?;
            measure(out, &body::pressure(&all), [&bodies, &linear], solver)
        }
        _ => {
            let constant = cell(Elements::Lagrange(0), &[])?;
            measure(out, &body::pressure(&all), [&bodies, &constant], solver)
        }
    }
}

/// One linear solve, or Newton's method.
fn measure<const D: usize, const N: usize>(
    out: &mut StandardOutput,
    form: &Form<D>,
    spaces: [&Arc<Space<D>>; N],
    name: &str,
) -> Result<(), Box<dyn Error>>
where
    Dim: Dimension<D>,
    for<'s> [&'s Arc<Space<D>>; N]: PerUnknown<'s, Arc<Space<D>>, N>,
{
    let mut solver: Box<dyn LinearSolver> = match name {
        "lu" => Box::new(LuSolver::default()),
        "signs" => Box::new(TangentSolver::default()),
        _ => Box::new(LocalUnknowns::<TangentSolver>::default()),
    };
    let mut held = Constraints::new(spaces[0]);
    held.fix("left", |_| [0.0; D])?;
    let start = Instant::now();
    let solved = {
        let mut problem = Problem::new(form, spaces).constrained(&held).solver(&mut *solver);
        let solved = problem.solve()?;
        out.line(format!("assembly {:.2} s", problem.assembly_seconds()));
        solved
    };
    let seconds = start.elapsed().as_secs_f64();
    let unknowns: usize = spaces.iter().map(|space| space.unknowns()).sum();
    let sum: f64 = solved.fields.iter().flat_map(|field| field.values()).map(|value| value * value).sum();
    out.line(format!(
        "{name}: {unknowns} unknowns, {} steps, {seconds:.2} s, {}, |x|² = {sum:.15e}",
        solved.iterations(),
        peak_memory()
    ));
    if let Some(report) = solver.report() {
        out.line(format!(
            "{:?}, analysis {:.2} s, factors {:.2} s ({}), solves {:.2} s ({}), {} numbers in a factor, {}",
            report.path,
            report.analysis_seconds,
            report.factorisation_seconds,
            report.factorisations,
            report.solve_seconds,
            report.solves,
            report.factor_entries,
            report.local_unknowns.map_or_else(String::new, |counts| counts.to_string())
        ));
    }
    Ok(())
}

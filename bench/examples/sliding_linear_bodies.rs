//! A linear block that is pressed onto another one and slides over it, condensed to what contact touches and by whole tangents.
//!
//! `cargo run --release -p forms-bench --example sliding_linear_bodies [-- CELLS]`
//!
//! The first rows have Newton steps whose residual must fall at each one, the others those of a watchdog, which may raise it.
//! Nitsche's method with Coulomb's friction at pairs that follow the displacement, quadratic quadrilaterals, some 10⁵ unknowns unless
//! told otherwise: seconds per load step and Newton step, and what of them is the linear algebra.

use std::error::Error;
use std::process::ExitCode;
use std::time::Instant;

use forms_fem::contract::PairQuadrature;
use forms_fem::output::{StandardOutput, program};
use forms_fem::prelude::*;
use forms_fem::solve::{LineSearch, LuSolver, NewtonOptions};

#[forms(dimension = 2)]
mod elastic {
    use forms_contact::operators::friction::{augmented_traction, contact_traction};
    use forms_contact::operators::linear_elastic::stress;

    pub struct Data {
        lambda: Param,
        mu: Param,
        gamma0: Param,
        kappa: Param,
        old: Given<Vector>,
    }
    #[cells]
    pub struct Omega;
    #[pairs]
    pub struct Touch;

    fn contact(u: Vector) -> Vector {
        let P = augmented_traction(this(stress(u) * n), gap, jump(u - old), gamma0 / this(h), toward);
        contact_traction(P, kappa * neg_part(dot(P, toward)), toward)
    }
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v))) - integral(Touch(u), dot(contact(u), jump(v)) / 2)
    }
}

/// Presses the block down, then moves it along in steps of a cell and a half.
fn slide(
    out: &mut StandardOutput,
    name: &str,
    space: &Arc<Space<2>>,
    width: f64,
    line_search: LineSearch,
    solver: &mut dyn LinearSolver,
) -> Result<Field<2>, Box<dyn Error>> {
    let touch = elastic::Touch::on(Pairing::between("slab top", "block bottom").at(PairQuadrature::Pieces));
    let mut u = Field::zero(space);
    for step in 0..4 {
        let mut plates = Constraints::new(space);
        plates.fix("slab bottom", |_| [0.0; 2])?;
        plates.fix("block top", |_| [1.5 * width * f64::from(step), -0.004])?;
        let data = elastic::data().lambda(115.4).mu(76.9).gamma0(4e3).kappa(0.3).old(u.clone());
        let form = elastic::balance(&data, &elastic::Omega::on("all"), &touch);
        let options = NewtonOptions { line_search, ..NewtonOptions::default() };
        let start = Instant::now();
        let solved = Problem::new(&form, space)
            .constrained(&plates)
            .start(&u)
            .solver(&mut *solver)
            .options(options)
            .solve()?;
        let seconds = start.elapsed().as_secs_f64();
        let report = solved.report.clone().unwrap_or_default();
        let of_step = |seconds: f64| seconds / solved.iterations().max(1) as f64;
        out.line(format!(
            "| {name} | {step} | {} | {seconds:.2} | {:.3} | {:.2} | {} | {} | {} |",
            solved.iterations(),
            of_step(seconds),
            solved.assembly_seconds,
            report.factorisations + report.lu_factorisations,
            report.iterations.iter().max().copied().unwrap_or(0),
            report.condensed_unknowns.map_or("-".to_owned(), |count| count.to_string()),
        ));
        u = solved.into_field();
    }
    Ok(u)
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let count: usize = std::env::args().nth(1).map_or(Ok(110), |count| count.parse())?;
    let quads = CellShape::Quadrilateral;
    let slab = rectangle([0.0, 0.0], [2.0, 0.5], [count, count], quads, 1)?;
    let block = rectangle([0.7, 0.501], [1.2, 0.801], [count / 3, count / 3], quads, 1)?;
    let mesh = Mesh::of_bodies(&[("slab", &slab), ("block", &block)])?;
    let space = Space::vector(&mesh, 2)?;
    let width = 2.0 / count as f64;
    out.line(format!("{} unknowns", space.unknowns()));
    out.line("| way | step | Newton steps | s | s per Newton step | assembly, s | factors so far | most Krylov iterations | condensed unknowns |");
    out.line("| --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    let falling = LineSearch::OnResidual;
    if let Err(error) =
        slide(out, "condensed, residuals that fall", &space, width, falling, &mut CondensedSolver::default())
    {
        out.line(format!("| condensed, residuals that fall | {error} |"));
    }
    let watched = LineSearch::Watchdog;
    let one = slide(out, "condensed", &space, width, watched, &mut CondensedSolver::default())?;
    let options = TangentSolverOptions { lu_after: Some(usize::MAX), ..Default::default() };
    let gmres = &mut TangentSolver::new(options);
    let other = slide(out, "GMRES, symmetrised Cholesky", &space, width, watched, gmres)?;
    slide(out, "GMRES, then LU", &space, width, watched, &mut TangentSolver::default())?;
    let last = slide(out, "LU", &space, width, watched, &mut LuSolver::default())?;
    let size = |a: &Field<2>, b: &Field<2>| {
        let pairs = a.values().iter().zip(b.values());
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    out.line(format!(
        "largest difference to GMRES {:.1e}, to LU {:.1e}",
        size(&one, &other),
        size(&one, &last)
    ));
    Ok(())
}

fn main() -> ExitCode {
    program(run)
}

//! Bodies that are cut by a level set function: microseconds of cutting, of matrices of cut cells and ghost facets, and of a derivative by the function.
//!
//! `cargo run --release -p forms-bench --example cut_cells [-- CELLS]`
//!
//! A disc in a square of triangles and a ball in a cube of tetrahedra, elasticity of degrees 1 and 2, one thread.

use std::error::Error;
use std::process::ExitCode;
use std::time::Instant;

use forms_fem::assemble::Parts;
use forms_fem::linear_algebra::BlockMatrix;
use forms_fem::output::{StandardOutput, program};
use forms_fem::prelude::*;

#[forms(level_set_derivatives)]
mod elastic {
    use forms_contact::operators::ghost_penalty::vector_ghost;
    use forms_contact::operators::linear_elastic::stress;

    #[includes(forms_contact::operators::linear_elastic::Data, forms_contact::operators::ghost_penalty::Data)]
    pub struct Data {}
    #[cells]
    pub struct Omega;
    #[interior_facets]
    pub struct Ghost;

    pub fn stiffness(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v)))
    }
    pub fn ghost(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Ghost, (2 * mu + lambda) * vector_ghost(u, v))
    }
    pub fn measure(t: Test<Scalar>) -> Form {
        integral(Omega, t)
    }
}

/// The least of some times in microseconds per entity.
fn least<E: Into<Box<dyn Error>>>(
    count: usize,
    mut run: impl FnMut() -> Result<(), E>,
) -> Result<f64, Box<dyn Error>> {
    let mut least = f64::INFINITY;
    for _ in 0..5 {
        let start = Instant::now();
        run().map_err(Into::into)?;
        least = least.min(start.elapsed().as_secs_f64());
    }
    Ok(1e6 * least / count as f64)
}

fn rows<const D: usize>(mesh: &Mesh<D>, out: &mut StandardOutput) -> Result<(), Box<dyn Error>>
where
    Dim: Dimension<D>,
{
    let radius = |x: &[f64; D]| x.iter().map(|x| (x - 0.013) * (x - 0.013)).sum::<f64>().sqrt();
    let phi = Field::interpolate(&Space::scalar(mesh, 1)?, |x| radius(x) - 0.7)?;
    let body = Assembler::new(mesh).cut_by(&phi)?.with_threads(Threads::new(1));
    let Some(cut) = body.cut().cloned() else { return Ok(()) };
    let name = if D == 2 { "triangles" } else { "tetrahedra" };
    let (inside, crossed, facets) =
        (cut.inside_cells().len(), cut.cut_cells().len(), cut.ghost_facets().len());
    out.line(format!(
        "{name}: {} cells, {inside} inside, {crossed} cut, {facets} ghost facets",
        mesh.cell_count()
    ));
    let signs = least(mesh.cell_count(), || Cut::by(&phi).map(|_| ()))?;
    let data = elastic::data().lambda(1.0).mu(1.0);
    let volume = elastic::measure(&data, &elastic::Omega::on("cut"));
    let constants = Space::discontinuous_scalar(mesh, 0)?;
    let rule = least(crossed, || body.linear_form(&volume, &constants).map(|_| ()))?;
    let one = Field::interpolate(&constants, |_| 1.0)?;
    let rates = least(crossed, || body.derivative_by_level_set(&volume, &[], &[&one]).map(|_| ()))?;
    out.line(format!(
        "signs {signs:.3} per cell; cut, rule and volume {rule:.2} per cut cell; its derivative {rates:.2}"
    ));
    for degree in [1, 2] {
        let space = Space::vector(mesh, degree)?;
        let u = Field::zero(&space);
        let mut times = vec![];
        let on = |name: &str| elastic::stiffness(&data, &elastic::Omega::on(name));
        let forms = [
            (on("inside"), inside),
            (on("cut"), crossed),
            (elastic::ghost(&data, &elastic::Ghost::on("ghost")), facets),
        ];
        for (form, count) in &forms {
            let problem = Problem::new(form, &space).assembler(&body);
            let pattern = problem.pattern()?;
            let mut matrix = BlockMatrix::zero(pattern.sparsity());
            times.push(least(*count, || {
                body.assemble_tangent(form, &[&u], &[&space], Parts::ALL, pattern, &mut matrix)
            })?);
        }
        out.line(format!(
            "P{degree}: matrix {:.3} per inner cell, {:.2} per cut cell, {:.2} per ghost facet",
            times[0], times[1], times[2]
        ));
    }
    Ok(())
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let count: usize = std::env::args().nth(1).map_or(Ok(256), |count| count.parse())?;
    rows(&rectangle([-1.0; 2], [1.0; 2], [count; 2], CellShape::Triangle, 1)?, out)?;
    rows(&cuboid([-1.0; 3], [1.0; 3], [count / 8; 3], CellShape::Tetrahedron, 1)?, out)
}

fn main() -> ExitCode {
    program(run)
}

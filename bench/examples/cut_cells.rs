//! Bodies that are cut by a level set function: microseconds of cutting, of matrices of cut cells and ghost facets, and of a derivative by the function.
//!
//! `cargo run --release -p forms-bench --example cut_cells [-- CELLS]`
//!
//! A disc in a square of triangles and a ball in a cube of tetrahedra, elasticity of degrees 1 and 2, one thread; quadrilaterals with a function of degree
//! 2, and hexahedra with functions of degrees 1 and 2.

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

fn rows<const D: usize>(
    mesh: &Mesh<D>,
    degree_of_function: usize,
    out: &mut StandardOutput,
) -> Result<(), Box<dyn Error>>
where
    Dim: Dimension<D>,
{
    let radius = |x: &[f64; D]| x.iter().map(|x| (x - 0.013) * (x - 0.013)).sum::<f64>().sqrt();
    let phi = Field::interpolate(&Space::scalar(mesh, degree_of_function)?, |x| radius(x) - 0.7)?;
    let body = Assembler::new(mesh).cut_by(&phi)?.with_threads(Threads::new(1));
    let Some(cut) = body.cut().cloned() else { return Ok(()) };
    let (inside, crossed, facets) =
        (cut.inside_cells().len(), cut.cut_cells().len(), cut.ghost_facets().len());
    out.line(format!(
        "{:?}, φ of degree {degree_of_function}: {} cells, {inside} inside, {crossed} cut, {facets} ghost facets",
        mesh.shapes(),
        mesh.cell_count()
    ));
    let signs = least(mesh.cell_count(), || Cut::by(&phi).map(|_| ()))?;
    let data = elastic::data().lambda(1.0).mu(1.0);
    let volume = elastic::measure(&data, &elastic::Omega::on("cut"));
    let constants = Space::discontinuous_scalar(mesh, 0)?;
    let again = least(crossed, || body.linear_form(&volume, &constants).map(|_| ()))?;
    // A cut keeps its points: each run has a new one.
    let mut first = f64::INFINITY;
    for _ in 0..5 {
        let fresh = Assembler::new(mesh).cut_by(&phi)?.with_threads(Threads::new(1));
        let start = Instant::now();
        fresh.linear_form(&volume, &constants)?;
        first = first.min(1e6 * start.elapsed().as_secs_f64() / crossed as f64);
    }
    let one = Field::interpolate(&constants, |_| 1.0)?;
    let rates = least(crossed, || body.derivative_by_level_set(&volume, &[], &[&one]).map(|_| ()))?;
    out.line(format!(
        "signs {signs:.3} per cell; cut, rule and volume {first:.2} per cut cell, {again:.2} again; its derivative {rates:.2}"
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
        // From a new φ to a new matrix, compared with a matrix of as many cells of a fitted mesh.
        let fitted = elastic::stiffness(&data, &elastic::Omega::on("all"));
        let own = fitted.clone() + elastic::ghost(&data, &elastic::Ghost::on("ghost"));
        let whole = Assembler::new(mesh).with_threads(Threads::new(1));
        let known = Problem::new(&fitted, &space).assembler(&whole);
        let (pattern, mut matrix) = (known.pattern()?, BlockMatrix::zero(known.pattern()?.sparsity()));
        let plain = least(mesh.cell_count(), || {
            whole.assemble_tangent(&fitted, &[&u], &[&space], Parts::ALL, pattern, &mut matrix)
        })?;
        let plain_with_pattern = least(mesh.cell_count(), || -> Result<(), Box<dyn Error>> {
            let problem = Problem::new(&fitted, &space).assembler(&whole);
            let pattern = problem.pattern()?;
            let mut matrix = BlockMatrix::zero(pattern.sparsity());
            Ok(whole.assemble_tangent(&fitted, &[&u], &[&space], Parts::ALL, pattern, &mut matrix)?)
        })?;
        let cut_by_phi = || Assembler::new(mesh).cut_by(&phi).map(|own| own.with_threads(Threads::new(1)));
        let known = Problem::new(&own, &space).assembler(&body);
        let (pattern, mut matrix) = (known.pattern()?, BlockMatrix::zero(known.pattern()?.sparsity()));
        let new = least(inside + crossed, || -> Result<(), Box<dyn Error>> {
            let fresh = cut_by_phi()?;
            Ok(fresh.assemble_tangent(&own, &[&u], &[&space], Parts::ALL, pattern, &mut matrix)?)
        })?;
        let new_with_pattern = least(inside + crossed, || -> Result<(), Box<dyn Error>> {
            let fresh = cut_by_phi()?;
            let problem = Problem::new(&own, &space).assembler(&fresh);
            let pattern = problem.pattern()?;
            let mut matrix = BlockMatrix::zero(pattern.sparsity());
            Ok(fresh.assemble_tangent(&own, &[&u], &[&space], Parts::ALL, pattern, &mut matrix)?)
        })?;
        out.line(format!(
            "P{degree}: new φ to new matrix {new:.3} per active cell ({:.2} times fitted {plain:.3}); with patterns {new_with_pattern:.3} ({:.2} times fitted {plain_with_pattern:.3})",
            new / plain,
            new_with_pattern / plain_with_pattern
        ));
    }
    Ok(())
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let count: usize = std::env::args().nth(1).map_or(Ok(256), |count| count.parse())?;
    let (triangle, square) = (CellShape::Triangle, CellShape::Quadrilateral);
    for (shape, degree) in [(triangle, 1), (square, 1), (square, 2)] {
        rows(&rectangle([-1.0; 2], [1.0; 2], [count; 2], shape, 1)?, degree, out)?;
    }
    let (tetrahedron, cube) = (CellShape::Tetrahedron, CellShape::Hexahedron);
    for (shape, degree) in [(tetrahedron, 1), (cube, 1), (cube, 2)] {
        rows(&cuboid([-1.0; 3], [1.0; 3], [count / 8; 3], shape, 1)?, degree, out)?;
    }
    Ok(())
}

fn main() -> ExitCode {
    program(run)
}

//! One assembly on a small mesh, for programs that count its instructions: `bench/instructions/count.py`.
//!
//! `counted_assembly CASE` prints a line with the instruction set of its kernels, assembles, and exits at once: what is counted lies between the
//! line and the end. Without a case it prints their names.

use std::error::Error;
use std::process::ExitCode;
use std::sync::Arc;

use forms_bench::forms::given::{body_in_contact, elasticity, neo_hookean, poisson};
use forms_fem::assemble::{Assembler, BlockPattern, Parts};
use forms_fem::contract::Form;
use forms_fem::dimension::{Dim, Dimension};
use forms_fem::element::CellShape;
use forms_fem::field::Field;
use forms_fem::lanes::InstructionSet;
use forms_fem::linear_algebra::BlockMatrix;
use forms_fem::mesh::{Mesh, annulus, cuboid, rectangle};
use forms_fem::output::{StandardOutput, program};
use forms_fem::quadrature::Quadrature;
use forms_fem::space::Space;
use forms_fem::threads::Threads;

/// λ, μ, γ₀.
const CONSTANTS: [f64; 3] = [1.2, 0.8, 10.0];
const CASES: [&str; 6] = [
    "poisson on linear triangles",
    "elasticity on quadratic triangles",
    "elasticity on quadratic tetrahedra",
    "neo-Hooke on quadratic triangles",
    "contact on curved quadrilaterals",
    "residual of neo-Hooke on quadratic triangles",
];

/// What is assembled.
#[derive(Clone, Copy)]
enum Kind {
    Tangent,
    Residual,
}

fn main() -> ExitCode {
    program(run)
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let asked = std::env::args().nth(1);
    let Some(case) = asked.and_then(|name| CASES.iter().position(|case| *case == name)) else {
        CASES.iter().for_each(|case| out.line(case));
        return Ok(());
    };
    let triangles = || rectangle([0.0; 2], [1.0; 2], [6; 2], CellShape::Triangle, 1);
    match case {
        0 => count(out, triangles()?, &poisson::<2>(), 1, 1, Kind::Tangent),
        1 => count(out, triangles()?, &elasticity::<2>(&CONSTANTS), 2, 2, Kind::Tangent),
        2 => {
            let mesh = cuboid([0.0; 3], [1.0; 3], [2; 3], CellShape::Tetrahedron, 1)?;
            count(out, mesh, &elasticity::<3>(&CONSTANTS), 3, 2, Kind::Tangent)
        }
        3 => count(out, triangles()?, &neo_hookean::<2>(&CONSTANTS), 2, 2, Kind::Tangent),
        4 => {
            let mesh = annulus(1.0, 2.0, 2, 16, CellShape::Quadrilateral, 2)?;
            // The gap is negative: every facet is in contact.
            let form = body_in_contact::<2>(&CONSTANTS, "outer", -0.001);
            count(out, mesh, &form, 2, 2, Kind::Tangent)
        }
        _ => count(out, triangles()?, &neo_hookean::<2>(&CONSTANTS), 2, 2, Kind::Residual),
    }
}

/// Assembles a form with so many components once, so that memory and tables are there, and then again.
fn count<F: Form<D>, const D: usize>(
    out: &mut StandardOutput,
    mesh: Mesh<D>,
    form: &F,
    components: usize,
    degree: usize,
    kind: Kind,
) -> Result<(), Box<dyn Error>>
where
    Dim: Dimension<D>,
{
    let mesh = Arc::new(mesh);
    let space = if components == 1 { Space::scalar(&mesh, degree)? } else { Space::vector(&mesh, degree)? };
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(4)).with_threads(Threads::ONE);
    let (u, spaces) = (Field::zero(&space), [&space]);
    let pattern = BlockPattern::for_form(form, &spaces, &spaces)?;
    let mut matrix = BlockMatrix::zero(pattern.sparsity());
    let mut assemble = || -> Result<f64, Box<dyn Error>> {
        Ok(match kind {
            Kind::Tangent => {
                assembler.assemble_tangent(form, &[&u], &spaces, Parts::ALL, &pattern, &mut matrix)?;
                matrix.values()[0]
            }
            Kind::Residual => assembler.residual(form, &[&u], &spaces)?[0],
        })
    };
    assemble()?;
    out.line(InstructionSet::best());
    std::hint::black_box(assemble()?);
    // Nothing is to be counted of what follows.
    std::process::exit(0)
}

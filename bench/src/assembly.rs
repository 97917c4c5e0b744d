//! Whole assembly on our side: the cases that the peers' scripts have too (`peers/assembly_case.py`).

use std::error::Error;
use std::time::Instant;

use forms_fem::assemble::{Assembler, Parts, TangentAction};
use forms_fem::dimension::{Dim, Dimension};
use forms_fem::element::CellShape;
use forms_fem::field::Field;
use forms_fem::linear_algebra::BlockMatrix;
use forms_fem::mesh::{Mesh, annulus, cuboid, rectangle};
use forms_fem::quadrature::Quadrature;
use forms_fem::solve::{NonlinearProblem, Problem};
use forms_fem::space::Space;
use forms_fem::threads::Threads;
use serde::{Deserialize, Serialize};

use crate::forms::given::{body_in_contact, elasticity};

/// λ, μ as in the peers' scripts, and γ₀.
const CONSTANTS: [f64; 3] = [1.2, 0.8, 10.0];

/// A case of whole assembly: P2 or Q2 elasticity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Case {
    /// Unit square, n × n × 2 straight triangles.
    Triangles,
    /// Unit cube, n × n × n × 6 straight tetrahedra.
    Tetrahedra,
    /// 1 < r < 2, n × 8 n isoparametric quadrilaterals.
    Annulus,
}

impl Case {
    /// All cases.
    pub const ALL: [Case; 3] = [Case::Triangles, Case::Tetrahedra, Case::Annulus];

    /// The name that the peers' scripts know.
    pub fn name(self) -> &'static str {
        match self {
            Case::Triangles => "triangles",
            Case::Tetrahedra => "tetrahedra",
            Case::Annulus => "annulus",
        }
    }

    /// The case of a name.
    pub fn named(name: &str) -> Option<Case> {
        Case::ALL.into_iter().find(|case| case.name() == name)
    }

    /// n of the full size.
    pub fn divisions(self) -> usize {
        match self {
            Case::Triangles => 256,
            Case::Tetrahedra => 32,
            Case::Annulus => 64,
        }
    }

    /// n for a quick look.
    pub fn quick_divisions(self) -> usize {
        match self {
            Case::Triangles => 128,
            Case::Tetrahedra => 12,
            Case::Annulus => 32,
        }
    }

    /// Number of cells for n.
    pub fn cells(self, divisions: usize) -> usize {
        match self {
            Case::Triangles => 2 * divisions.pow(2),
            Case::Tetrahedra => 6 * divisions.pow(3),
            Case::Annulus => 8 * divisions.pow(2),
        }
    }
}

/// Measurements; times in seconds, one entry per sample.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Measured {
    /// The program.
    pub program: String,
    /// Its version.
    pub version: String,
    /// Number of threads, if it is not one.
    #[serde(default)]
    pub threads: Option<usize>,
    /// Unknowns.
    pub unknowns: usize,
    /// The matrix's Frobenius norm.
    pub norm: f64,
    /// The values of a matrix whose pattern is known.
    pub reassembly: Vec<f64>,
    /// Pattern, maps and values.
    pub first: Vec<f64>,
    /// Residual at a field.
    #[serde(default)]
    pub residual: Vec<f64>,
    /// The tangent times a vector without a matrix.
    #[serde(default)]
    pub action: Vec<f64>,
    /// The matrix times a vector.
    #[serde(default)]
    pub product: Vec<f64>,
    /// Largest memory of the process \[byte\].
    #[serde(default)]
    pub peak_bytes: Option<usize>,
    /// Memory of the matrix, values and sparsity \[byte\].
    #[serde(default)]
    pub matrix_bytes: Option<usize>,
}

/// Contact on the outer circle of the annulus.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ContactUpdate {
    /// n_r, cells across.
    pub across: usize,
    /// Contact facets.
    pub facets: usize,
    /// Unknowns.
    pub unknowns: usize,
    /// The tangent of the next iterate, updated in place \[s\].
    pub update: Vec<f64>,
    /// Assembling everything again, for comparison \[s\].
    pub reassembly: Vec<f64>,
}

fn timed<T>(work: impl FnOnce() -> Result<T, Box<dyn Error>>) -> Result<(f64, T), Box<dyn Error>> {
    let start = Instant::now();
    let result = work()?;
    Ok((start.elapsed().as_secs_f64(), result))
}

/// Measures a case.
///
/// # Errors
/// Errors of mesh, space or assembler.
pub fn measure(
    case: Case,
    divisions: usize,
    samples: usize,
    threads: usize,
) -> Result<Measured, Box<dyn Error>> {
    match case {
        Case::Triangles => {
            let mesh = rectangle([0.0; 2], [1.0; 2], [divisions; 2], CellShape::Triangle, 1)?;
            measure_on(mesh, 2, samples, threads)
        }
        Case::Tetrahedra => {
            let mesh = cuboid([0.0; 3], [1.0; 3], [divisions; 3], CellShape::Tetrahedron, 1)?;
            measure_on(mesh, 2, samples, threads)
        }
        Case::Annulus => measure_on(ring(divisions)?, 4, samples, threads),
    }
}

fn ring(divisions: usize) -> Result<Mesh<2>, Box<dyn Error>> {
    Ok(annulus(1.0, 2.0, divisions, 8 * divisions, CellShape::Quadrilateral, 2)?)
}

fn measure_on<const D: usize>(
    mesh: Mesh<D>,
    rule: usize,
    samples: usize,
    threads: usize,
) -> Result<Measured, Box<dyn Error>>
where
    Dim: Dimension<D>,
{
    let space = Space::vector(&mesh, 2)?;
    let assembler =
        Assembler::new(&mesh).with_quadrature(Quadrature::Degree(rule)).with_threads(Threads::new(threads));
    let form = elasticity::<D>(&CONSTANTS);
    let (u, spaces) = (Field::zero(&space), [&space]);
    let make = || -> Result<_, Box<dyn Error>> {
        let pattern = assembler.pattern(&form, &spaces, &spaces)?;
        let mut matrix = BlockMatrix::zero(pattern.sparsity());
        assembler.assemble_tangent(&form, &[&u], &spaces, Parts::ALL, &pattern, &mut matrix)?;
        Ok((pattern, matrix))
    };
    // Once unmeasured: memory comes from the system, and tables are read for the first time.
    let (pattern, mut matrix) = make()?;
    let mut measured = Measured {
        program: if threads == 1 { "forms-fem".to_owned() } else { format!("forms-fem, {threads} threads") },
        version: env!("CARGO_PKG_VERSION").to_owned(),
        threads: (threads > 1).then_some(threads),
        unknowns: space.unknowns(),
        norm: matrix.values().iter().map(|value| value * value).sum::<f64>().sqrt(),
        matrix_bytes: Some(matrix.memory() + matrix.sparsity().memory()),
        peak_bytes: peak_memory(),
        ..Measured::default()
    };
    let action = TangentAction::new(&assembler, &form, &[&u]);
    let direction: Vec<f64> = (0..space.unknowns()).map(|k| (k as f64).sin()).collect();
    let mut by_action = vec![0.0; direction.len()];
    let mut by_matrix = by_action.clone();
    for _ in 0..samples {
        let again =
            || Ok(assembler.assemble_tangent(&form, &[&u], &spaces, Parts::ALL, &pattern, &mut matrix)?);
        measured.reassembly.push(timed(again)?.0);
        measured.residual.push(timed(|| Ok(assembler.residual(&form, &[&u], &spaces)?))?.0);
        measured.action.push(timed(|| Ok(action.apply(&direction, &mut by_action)?))?.0);
        measured.product.push(
            timed(|| {
                by_matrix = matrix.multiply(&direction)?;
                Ok(())
            })?
            .0,
        );
    }
    let difference = by_action.iter().zip(&by_matrix).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    if difference > 1e-10 * measured.norm {
        return Err(format!("action and matrix differ by {difference}").into());
    }
    drop((pattern, matrix));
    for _ in 0..samples {
        let (seconds, made) = timed(make)?;
        measured.first.push(seconds);
        drop(made);
    }
    Ok(measured)
}

/// Measures the update of a contact tangent on the annulus with n_r cells across and its outer circle in contact.
///
/// # Errors
/// As [`measure`].
pub fn measure_contact(across: usize, samples: usize) -> Result<ContactUpdate, Box<dyn Error>> {
    let mesh = ring(across)?;
    let facets = mesh.facet_region("outer")?.len();
    let space = Space::vector(&mesh, 2)?;
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(4)).with_threads(Threads::ONE);
    // The gap is negative: every facet is in contact.
    let form = body_in_contact::<2>(&CONSTANTS, "outer", -0.001);
    let mut problem = Problem::new(&form, &space).assembler(&assembler);
    let (u, spaces) = (Field::zero(&space), [&space]);
    let pattern = problem.pattern()?.clone();
    let mut matrix = BlockMatrix::zero(pattern.sparsity());
    let mut found =
        ContactUpdate { across, facets, unknowns: space.unknowns(), update: vec![], reassembly: vec![] };
    problem.tangent(u.values())?;
    for _ in 0..samples {
        let whole =
            || Ok(assembler.assemble_tangent(&form, &[&u], &spaces, Parts::ALL, &pattern, &mut matrix)?);
        found.reassembly.push(timed(whole)?.0);
        let start = Instant::now();
        problem.tangent(u.values())?;
        found.update.push(start.elapsed().as_secs_f64());
    }
    Ok(found)
}

/// Largest memory of this process so far \[byte\], where the system says it.
fn peak_memory() -> Option<usize> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse::<usize>().ok().map(|kibibytes| 1024 * kibibytes)
}

//! Contact of two bodies on our side: the term by itself and a whole solve, on meshes that are written for `peers/bodies_getfem.py`.

use std::error::Error;
use std::path::Path;
use std::sync::{Arc, LazyLock};
use std::time::Instant;

use forms_fem::assemble::{Assembler, Parts};
use forms_fem::contract::Form;
use forms_fem::dimension::{Dim, Dimension};
use forms_fem::element::CellShape;
use forms_fem::field::Field;
use forms_fem::linear_algebra::BlockMatrix;
use forms_fem::mesh::{Mesh, cuboid, rectangle};
use forms_fem::output::write_whole;
use forms_fem::prelude::{Constraints, Pairing, Problem};
use forms_fem::quadrature::Quadrature;
use forms_fem::solve::{CondensedSolver, LineSearch, NewtonOptions, TangentSolverOptions};
use forms_fem::space::Space;
use forms_fem::threads::Threads;
use serde::{Deserialize, Serialize};

use crate::forms::sliding;

/// λ, μ, γ times the number of cells along the slab, κ.
const CONSTANTS: [f64; 4] = [100.0, 80.0, 2e3, 0.3];

/// The degree of the rule on facets: 3 points in the plane, 7 in space, GetFEM's too.
const RULE: usize = 5;

/// Depth of the block in the slab where the term alone is measured, in cells of the slab.
const OVERLAP: f64 = 0.2;

/// Two blocks of quadratic simplices on meshes that do not match, a smaller one on a slab.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Bodies {
    /// The contact term alone, in the plane.
    PlaneTerm,
    /// The contact term alone, in space.
    SpaceTerm,
    /// A block pressed onto a slab and drawn along, in the plane.
    PlaneSolve,
    /// The same in space.
    SpaceSolve,
}

/// Whether the surfaces have Coulomb's friction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Law {
    /// No friction.
    Frictionless,
    /// Coulomb's friction, κ = 0.3.
    Friction,
}

/// Measured norms and times; seconds of processor time of one thread.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct MeasuredBodies {
    /// The program.
    pub program: String,
    /// Unknowns of both bodies.
    pub unknowns: usize,
    /// Facets that are integrated over.
    pub facets: usize,
    /// Of the term: a residual, pairs included, at a new iterate each.
    #[serde(default)]
    pub residual: Vec<f64>,
    /// A tangent, pairs and insertion included.
    #[serde(default)]
    pub tangent: Vec<f64>,
    /// Only the search for pairs, where a program times it separately.
    #[serde(default)]
    pub search: Vec<f64>,
    /// Norms of residual and tangent, or of the displacement that was solved for: programs that state the same agree.
    pub norms: Vec<f64>,
    /// A whole solve.
    #[serde(default)]
    pub solve: Vec<f64>,
    /// Newton steps of the solve.
    #[serde(default)]
    pub steps: usize,
}

impl Bodies {
    /// All cases.
    pub const ALL: [Bodies; 4] =
        [Bodies::PlaneTerm, Bodies::SpaceTerm, Bodies::PlaneSolve, Bodies::SpaceSolve];

    /// The name that the worker and the peer's script know.
    pub fn name(self) -> &'static str {
        match self {
            Bodies::PlaneTerm => "plane-term",
            Bodies::SpaceTerm => "space-term",
            Bodies::PlaneSolve => "plane-solve",
            Bodies::SpaceSolve => "space-solve",
        }
    }

    /// The case of a name.
    pub fn named(name: &str) -> Option<Bodies> {
        Bodies::ALL.into_iter().find(|case| case.name() == name)
    }

    /// Cells along the slab: some 10⁵ unknowns of a solve. Of terms a multiple of ten: then no point of a facet meets an edge of the
    /// opposite surface, where the tangent, but not the residual, is free to take either facet's derivative.
    pub fn divisions(self) -> usize {
        match self {
            Bodies::PlaneTerm => 1000,
            Bodies::SpaceTerm => 20,
            Bodies::PlaneSolve => 96,
            Bodies::SpaceSolve => 14,
        }
    }

    /// The same for a quick look.
    pub fn quick_divisions(self) -> usize {
        match self {
            Bodies::PlaneTerm => 200,
            Bodies::SpaceTerm => 10,
            Bodies::PlaneSolve => 32,
            Bodies::SpaceSolve => 6,
        }
    }
}

impl Law {
    /// Both.
    pub const ALL: [Law; 2] = [Law::Frictionless, Law::Friction];

    /// The name that the worker and the peer's script know.
    pub fn name(self) -> &'static str {
        match self {
            Law::Frictionless => "frictionless",
            Law::Friction => "friction",
        }
    }

    /// The law with the given name, if there is one.
    pub fn named(name: &str) -> Option<Law> {
        Law::ALL.into_iter().find(|law| law.name() == name)
    }
}

/// Ends of a block on a slab with the given number of cells along \[0, 1\], further from the points of the slab's rule than the block slips. A
/// point that leaves the block loses its pressure all at once: where it is drawn along with the end, there are several solutions.
fn ends_between_points(divisions: usize) -> [f64; 2] {
    let low = ((0.3 * divisions as f64).floor() + 0.4) / divisions as f64;
    [low, 1.0 - low]
}

/// Measures a case, and writes its meshes, start and constants for the peer to a file first.
///
/// # Errors
/// Errors of mesh, space, assembler, solver or file.
pub fn measure(
    case: Bodies,
    law: Law,
    divisions: usize,
    samples: usize,
    file: &Path,
) -> Result<MeasuredBodies, Box<dyn Error>> {
    let n = divisions;
    // The block's cells are larger by 10/7 or so, so that the meshes do not match.
    let m = (7 * n).div_ceil(10);
    let overlap = OVERLAP / n as f64;
    // Cells as high as wide: GetFEM takes nodes of very flat ones for the same.
    let height = 2.0 / n as f64;
    let triangles =
        |low, high, counts| -> Result<Mesh<2>, _> { rectangle(low, high, counts, CellShape::Triangle, 1) };
    let tetrahedra =
        |low, high, counts| -> Result<Mesh<3>, _> { cuboid(low, high, counts, CellShape::Tetrahedron, 1) };
    match case {
        Bodies::PlaneTerm => {
            let slab = triangles([0.0, -height], [1.0, 0.0], [n, 2])?;
            let block = triangles([0.0, -overlap], [1.0, height], [m, 2])?;
            term(&case.pair(&slab, &block, n)?, law, samples, file)
        }
        Bodies::SpaceTerm => {
            let slab = tetrahedra([0.0, 0.0, -height], [1.0, 1.0, 0.0], [n, n, 2])?;
            let block = tetrahedra([0.0, 0.0, -overlap], [1.0, 1.0, height], [m, m, 2])?;
            term(&case.pair(&slab, &block, n)?, law, samples, file)
        }
        Bodies::PlaneSolve => {
            let slab = triangles([0.0, -0.5], [2.0, 0.0], [2 * n, n])?;
            let block = triangles([0.7, 0.0], [1.2, 0.3], [m / 2, m / 3])?;
            solve(&case.pair(&slab, &block, n)?, law, samples, file)
        }
        Bodies::SpaceSolve => {
            let slab = tetrahedra([0.0, 0.0, -0.5], [1.0, 1.0, 0.0], [n, n, n])?;
            let [low, high] = ends_between_points(n);
            let block = tetrahedra([low, low, 0.0], [high, high, 0.3], [m / 2, m / 2, m / 2])?;
            solve(&case.pair(&slab, &block, n)?, law, samples, file)
        }
    }
}

/// Two bodies, together and apart.
struct Pair<'a, const D: usize> {
    mesh: Mesh<D>,
    parts: [&'a Mesh<D>; 2],
    gamma: f64,
}

impl Bodies {
    fn pair<'a, const D: usize>(
        self,
        slab: &'a Mesh<D>,
        block: &'a Mesh<D>,
        divisions: usize,
    ) -> Result<Pair<'a, D>, Box<dyn Error>> {
        let mesh = Mesh::of_bodies(&[("slab", slab), ("block", block)])?;
        Ok(Pair { mesh, parts: [slab, block], gamma: CONSTANTS[2] * divisions as f64 })
    }
}

/// Of the displacement that a solve prescribes on top of the block: along, and down.
const PUSH: [f64; 2] = [0.002, -0.004];

impl<const D: usize> Pair<'_, D> {
    /// Input of the peer: nodes and cells of each body, constants, prescribed values.
    fn write(&self, law: Law, file: &Path) -> Result<(), Box<dyn Error>> {
        #[derive(Serialize)]
        struct Body {
            nodes: Vec<Vec<f64>>,
            cells: Vec<u32>,
        }
        let bodies = self.parts.map(|part| Body {
            nodes: part.nodes().iter().map(|node| node.to_vec()).collect(),
            cells: part.cells().to_vec(),
        });
        let [lambda, mu, _, kappa] = CONSTANTS;
        let text = serde_json::json!({
            "bodies": bodies, "dimension": D, "lambda": lambda, "mu": mu, "gamma": self.gamma, "rule": RULE,
            "kappa": (law == Law::Friction).then_some(kappa), "push": PUSH,
        });
        write_whole(file, |file| std::io::Write::write_all(file, text.to_string().as_bytes()))?;
        Ok(())
    }

    fn data(&self) -> sliding::Data<D> {
        let [lambda, mu, _, kappa] = CONSTANTS;
        sliding::data().lambda(lambda).mu(mu).gamma(self.gamma).kappa(kappa)
    }

    fn touch(&self) -> sliding::Touch {
        sliding::Touch::on(Pairing::onto("slab top", "block bottom"))
    }

    fn assembler(&self) -> Assembler<D> {
        let rule = Quadrature::Degree(RULE);
        Assembler::new(&self.mesh).with_threads(Threads::ONE).with_quadrature(rule)
    }

    fn measured(&self, space: &Space<D>) -> Result<MeasuredBodies, Box<dyn Error>> {
        Ok(MeasuredBodies {
            program: "forms-fem".to_owned(),
            unknowns: space.unknowns(),
            facets: self.mesh.facet_region("slab top")?.len(),
            residual: vec![],
            tangent: vec![],
            search: vec![],
            norms: vec![],
            solve: vec![],
            steps: 0,
        })
    }
}

/// Seconds of a processor that this thread has had, where the system says it; else of the clock.
fn processor_seconds() -> f64 {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    // The system brings the time up to date where a thread yields, and otherwise in steps of some milliseconds.
    std::thread::yield_now();
    let spent = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let spent = spent.and_then(|text| text.split_whitespace().next()?.parse::<f64>().ok());
    spent.map_or_else(|| START.elapsed().as_secs_f64(), |nanoseconds| 1e-9 * nanoseconds)
}

fn norm(values: &[f64]) -> f64 {
    values.iter().map(|value| value * value).sum::<f64>().sqrt()
}

fn term<const D: usize>(
    pair: &Pair<D>,
    law: Law,
    samples: usize,
    file: &Path,
) -> Result<MeasuredBodies, Box<dyn Error>>
where
    Dim: Dimension<D>,
{
    pair.write(law, file)?;
    match law {
        Law::Frictionless => term_of(pair, &sliding::frictionless(&pair.data(), &pair.touch()), samples),
        Law::Friction => term_of(pair, &sliding::friction(&pair.data(), &pair.touch()), samples),
    }
}

/// Residual and tangent of the contact term at iterates that differ a little, so that pairs are searched for at each.
fn term_of<const D: usize>(
    pair: &Pair<D>,
    form: &Form<D>,
    samples: usize,
) -> Result<MeasuredBodies, Box<dyn Error>>
where
    Dim: Dimension<D>,
{
    let space = Space::vector(&pair.mesh, 2)?;
    // `peers/bodies_getfem.py` has the same: all of the slab is in contact, and slips.
    let at = |shift: f64| {
        Field::interpolate(&space, |x: &[f64; D]| {
            let mut value = [shift; D];
            value[0] += 0.5 * x[D - 1];
            value[D - 1] = 0.01 * (x[0] - 0.5) * x[D - 1];
            value
        })
    };
    let (mut found, assembler) = (pair.measured(&space)?, pair.assembler());
    let u = at(0.0)?;
    let pattern = Arc::clone(Problem::new(form, &space).assembler(&assembler).start(&u).pattern()?);
    let mut matrix = BlockMatrix::zero(pattern.sparsity());
    let spaces = [&space];
    let residual = assembler.residual(form, &[&u], &spaces)?;
    assembler.assemble_tangent(form, &[&u], &spaces, Parts::ALL, &pattern, &mut matrix)?;
    found.norms = vec![norm(&residual), norm(matrix.values())];
    for sample in 1..=samples {
        let [first, second, third] = [0, 1, 2].map(|k| at(1e-9 * (3 * sample + k) as f64));
        let (first, second, third) = (first?, second?, third?);
        let start = processor_seconds();
        assembler.residual(form, &[&first], &spaces)?;
        found.residual.push(processor_seconds() - start);
        let start = processor_seconds();
        assembler.assemble_tangent(form, &[&second], &spaces, Parts::ALL, &pattern, &mut matrix)?;
        found.tangent.push(processor_seconds() - start);
        let start = processor_seconds();
        assembler.pairs_at(&Pairing::onto("slab top", "block bottom"), RULE, &third)?;
        found.search.push(processor_seconds() - start);
    }
    Ok(found)
}

fn solve<const D: usize>(
    pair: &Pair<D>,
    law: Law,
    samples: usize,
    file: &Path,
) -> Result<MeasuredBodies, Box<dyn Error>>
where
    Dim: Dimension<D>,
{
    pair.write(law, file)?;
    let (data, omega) = (pair.data(), sliding::Omega::on("all"));
    match law {
        Law::Frictionless => solve_of(pair, &sliding::balance(&data, &omega, &pair.touch()), samples),
        Law::Friction => {
            solve_of(pair, &sliding::balance_with_friction(&data, &omega, &pair.touch()), samples)
        }
    }
}

/// The block pressed down and drawn along in one step; mesh and space are not in the time, pattern and factorisations are.
fn solve_of<const D: usize>(
    pair: &Pair<D>,
    form: &Form<D>,
    samples: usize,
) -> Result<MeasuredBodies, Box<dyn Error>>
where
    Dim: Dimension<D>,
{
    let space = Space::vector(&pair.mesh, 2)?;
    let mut plates = Constraints::new(&space);
    plates.fix("slab bottom", |_| [0.0; D])?;
    plates.fix("block top", |_| {
        let mut value = [0.0; D];
        (value[0], value[D - 1]) = (PUSH[0], PUSH[1]);
        value
    })?;
    let mut found = pair.measured(&space)?;
    for _ in 0..samples {
        let assembler = pair.assembler();
        let threads = TangentSolverOptions { threads: Threads::ONE, ..TangentSolverOptions::default() };
        let mut solver = CondensedSolver::new(threads);
        let options = NewtonOptions { line_search: LineSearch::OnResidual, ..NewtonOptions::default() };
        let start = processor_seconds();
        let solved = Problem::new(form, &space)
            .assembler(&assembler)
            .constrained(&plates)
            .solver(&mut solver)
            .options(options)
            .solve()?;
        found.solve.push(processor_seconds() - start);
        found.steps = solved.iterations();
        found.norms = vec![norm(solved.field().values())];
    }
    Ok(found)
}

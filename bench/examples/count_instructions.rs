//! Instructions that element kernels, assembly and the update of a contact tangent take, counted by valgrind and compared with the counts
//! that are committed: a change that makes them slower is seen on any machine, however busy.
//!
//! `FORMS_INSTRUCTION_SET=avx2 cargo run --release -p forms-bench --example count_instructions [-- --write]` ends with an error where
//! a count is more than 3 % above the committed one; `--write` commits what is counted. Valgrind does not know AVX-512.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

use forms_bench::basket::BASKET;
use forms_bench::forms::given::{body_in_contact, elasticity};
use forms_fem::assemble::BlockPattern;
use forms_fem::lanes::InstructionSet;
use forms_fem::linear_algebra::BlockMatrix;
use forms_fem::output::{StandardOutput, program, tell, write_whole};
use forms_fem::prelude::*;
use forms_fem::solve::NonlinearProblem;
use serde::{Deserialize, Serialize};

/// The argument of the process that valgrind watches.
const COUNTED: &str = "--counted";

/// The function that valgrind counts in.
const COUNTED_CALL: &str = "count_instructions::counted_call";

/// A count may be larger than the committed one by this part of it: links and the C library differ between machines.
const TOLERANCE: f64 = 0.03;

/// λ, μ, γ₀, as in the other measurements of assembly.
const CONSTANTS: [f64; 3] = [1.2, 0.8, 10.0];

/// Counts, and what they hang on.
#[derive(Serialize, Deserialize)]
struct Counts {
    /// The compiler.
    rustc: String,
    instruction_set: String,
    /// Instructions per call, by the names of the cases.
    instructions: BTreeMap<String, u64>,
}

/// Source of the counts: valgrind begins to count when this function is entered, and writes a file when it is left.
#[inline(never)]
fn counted_call(work: &mut dyn FnMut()) {
    work();
    // The work is no tail call: this function returns after it.
    std::hint::black_box(());
}

/// Does some work twice, the second time counted, and tells its name in the order of valgrind's files.
fn count(out: &mut StandardOutput, name: &str, mut work: impl FnMut()) {
    work();
    counted_call(&mut work);
    out.line(name);
}

fn kernels(out: &mut StandardOutput) {
    for entry in BASKET {
        let mut call = entry.prepare();
        count(out, entry.name, || {
            call.run();
        });
    }
}

/// Pattern, tangent and residual of elasticity with quadratic elements.
fn assembly<const D: usize>(out: &mut StandardOutput, name: &str, mesh: Mesh<D>) -> Result<(), Box<dyn Error>>
where
    Dim: Dimension<D>,
{
    let space = Space::vector(&mesh, 2)?;
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(2)).with_threads(Threads::ONE);
    let form = elasticity::<D>(&CONSTANTS);
    let (u, spaces) = (Field::zero(&space), [&space]);
    let pattern = BlockPattern::for_form(&form, &spaces, &spaces)?;
    let mut matrix = BlockMatrix::zero(pattern.sparsity());
    let mut outcome = Ok(());
    count(out, &format!("{name}, pattern"), || {
        outcome = BlockPattern::for_form(&form, &spaces, &spaces).map(|_| ());
    });
    outcome?;
    let mut outcome = Ok(());
    count(out, &format!("{name}, tangent"), || {
        outcome = assembler.assemble_tangent(&form, &[&u], &spaces, Parts::ALL, &pattern, &mut matrix);
    });
    outcome?;
    let mut outcome = Ok(());
    count(out, &format!("{name}, residual"), || {
        outcome = assembler.residual(&form, &[&u], &spaces).map(|_| ());
    });
    Ok(outcome?)
}

/// The tangent of the next iterate of a ring in contact.
fn contact_update(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let mesh = annulus(1.0, 2.0, 4, 32, CellShape::Quadrilateral, 2)?;
    let space = Space::vector(&mesh, 2)?;
    let form = body_in_contact::<2>(&CONSTANTS, "outer", -0.001);
    let mut problem = Problem::new(&form, &space).quadrature(Quadrature::Degree(4)).threads(Threads::ONE);
    // For the iterate of the last tangent nothing would be computed.
    let mut iterates = [0.0, 1e-9].map(|shift| vec![shift; space.unknowns()]).into_iter();
    let mut outcome = Ok(());
    count(out, "ring, update of a contact tangent", || {
        if let Some(u) = iterates.next() {
            outcome = problem.tangent(&u).map(|_| ());
        }
    });
    Ok(outcome?)
}

/// Everything that is counted.
fn all(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    kernels(out);
    assembly(out, "triangles", rectangle([0.0; 2], [1.0; 2], [16; 2], CellShape::Triangle, 1)?)?;
    assembly(out, "tetrahedra", cuboid([0.0; 3], [1.0; 3], [4; 3], CellShape::Tetrahedron, 1)?)?;
    assembly(out, "annulus", annulus(1.0, 2.0, 4, 32, CellShape::Quadrilateral, 2)?)?;
    contact_update(out)
}

/// The counts of this build.
fn counts(directory: &Path) -> Result<BTreeMap<String, u64>, Box<dyn Error>> {
    let files = directory.join("counts");
    let watched = Command::new("valgrind")
        .args(["--tool=callgrind", "--demangle=yes"])
        .args(["--zero-before", "--dump-after"].map(|option| format!("{option}={COUNTED_CALL}")))
        .arg(format!("--callgrind-out-file={}", files.display()))
        .arg(std::env::current_exe()?)
        .arg(COUNTED)
        .stderr(Stdio::piped())
        .output()?;
    if !watched.status.success() {
        return Err(String::from_utf8_lossy(&watched.stderr).trim().to_owned().into());
    }
    let mut counts = BTreeMap::new();
    for (number, name) in String::from_utf8(watched.stdout)?.lines().enumerate() {
        let path = format!("{}.{}", files.display(), number + 1);
        let text = std::fs::read_to_string(&path).map_err(|error| format!("{path}: {error}"))?;
        let total = text.lines().find_map(|line| line.strip_prefix("totals: ")?.trim().parse().ok());
        counts.insert(name.to_owned(), total.ok_or(format!("no count of {name}"))?);
    }
    Ok(counts)
}

fn rustc() -> String {
    let version = Command::new("rustc").arg("--version").output();
    version.map_or_else(|_| String::new(), |output| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

/// The reason that nothing can be compared here, if there is one.
fn hindrance(committed: Option<&Counts>) -> Option<String> {
    let set = InstructionSet::best();
    if Command::new("valgrind").arg("--version").stdout(Stdio::null()).status().is_err() {
        return Some("valgrind is not installed".to_owned());
    }
    if set != InstructionSet::Avx2 {
        return Some(format!("this build has {set}; FORMS_INSTRUCTION_SET=avx2 builds what valgrind knows"));
    }
    let expected = &committed?.rustc;
    let found = rustc();
    (*expected != found)
        .then(|| format!("the counts are of {expected}, this is {found}: `--write` counts anew"))
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (write, file) = match arguments.first().map(String::as_str) {
        Some(COUNTED) => return all(out),
        Some("--write") => (true, committed_file()),
        None => (false, committed_file()),
        Some(other) => return Err(format!("`{other}` is no option: there is --write").into()),
    };
    let committed: Option<Counts> = match write {
        true => None,
        false => Some(serde_json::from_str(&std::fs::read_to_string(&file)?)?),
    };
    if let Some(reason) = hindrance(committed.as_ref()) {
        out.line(format!("SKIPPED: {reason}"));
        return Ok(());
    }
    let directory = std::env::temp_dir().join(format!("instructions-{}", std::process::id()));
    std::fs::create_dir_all(&directory)?;
    let found = counts(&directory);
    // What is left in the directory for temporary files does no harm.
    let _ = std::fs::remove_dir_all(&directory);
    let instructions = found?;
    let Some(committed) = committed else {
        let counts =
            Counts { rustc: rustc(), instruction_set: InstructionSet::best().to_string(), instructions };
        let text = serde_json::to_string_pretty(&counts)? + "\n";
        write_whole(&file, |file| std::io::Write::write_all(file, text.as_bytes()))?;
        out.line(format!("{} counts written", counts.instructions.len()));
        return Ok(());
    };
    compare(&committed.instructions, &instructions, out)
}

/// Names each count that is not the committed one.
fn compare(
    committed: &BTreeMap<String, u64>,
    found: &BTreeMap<String, u64>,
    out: &mut StandardOutput,
) -> Result<(), Box<dyn Error>> {
    let mut worse = 0;
    for (name, count) in found {
        let Some(before) = committed.get(name) else {
            return Err(format!("{name} has no committed count: `--write` counts anew").into());
        };
        let change = *count as f64 / *before as f64 - 1.0;
        if change.abs() > TOLERANCE {
            tell(format!("{name}: {count} instructions, committed {before} ({:+.1} %)", 100.0 * change));
        }
        worse += usize::from(change > TOLERANCE);
    }
    if let Some(name) = committed.keys().find(|name| !found.contains_key(*name)) {
        return Err(format!("{name} was not counted").into());
    }
    if worse > 0 {
        let most = 100.0 * TOLERANCE;
        return Err(format!("{worse} of {} counts are more than {most} % too large", found.len()).into());
    }
    out.line(format!("{} counts of instructions are no larger than committed", found.len()));
    Ok(())
}

fn committed_file() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("data/instruction_counts.json")
}

fn main() -> ExitCode {
    program(run)
}

//! Whole assembly: ours and the peers', one process each.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use forms_fem::output::{StandardOutput, tell};

use super::machine::{ARCHITECTURE, architecture};
use super::process::{environment_python, output, peers, succeeds, system_python};
use super::rows::AssemblyRow;
use super::{ComparisonError, Options, Report};
use crate::assembly::{Case, Measured};
use crate::bodies::{Bodies, Law};

/// The first argument with which the program that compares becomes one of its own workers.
pub const WORKER: &str = "--measure";

/// Another program.
struct Peer {
    name: &'static str,
    /// The commands that install it.
    install: &'static str,
    present: bool,
    command: fn(Case) -> Option<Command>,
    /// Its time on the full 3D case allows this many samples only.
    samples: usize,
}

fn script(python: PathBuf, name: &str, case: Case) -> Command {
    let mut command = Command::new(python);
    command.arg(peers().join(name)).arg(case.name());
    command
}

fn freefem(case: Case) -> Option<Command> {
    let mut command = Command::new("FreeFem++");
    // Debian's build looks for its plugins elsewhere than where the package has them.
    if std::env::var_os("FF_LOADPATH").is_none() {
        command.env("FF_LOADPATH", "/usr/lib/freefem++");
    }
    command.args(["-nw", "-v", "0"]).arg(peers().join("assembly_freefem.edp")).args(["-case", case.name()]);
    // It has no quadrilaterals.
    (case != Case::Annulus).then_some(command)
}

fn known() -> [Peer; 4] {
    let system = system_python;
    [
        Peer {
            name: "DOLFINx",
            install: "Debian 12's package python3-dolfinx",
            present: succeeds(system(), &["-c", "import dolfinx.fem.petsc"]),
            command: |case| Some(script(system_python(), "assembly_dolfinx.py", case)),
            samples: 5,
        },
        Peer {
            name: "GetFEM",
            install: "Debian 12's package python3-getfem",
            present: succeeds(system(), &["-c", "import getfem"]),
            command: |case| Some(script(system_python(), "assembly_getfem.py", case)),
            samples: 3,
        },
        Peer {
            name: "FreeFEM",
            install: "Debian 12's packages freefem++ and libfreefem++, which has its plugins (elsewhere: FF_LOADPATH)",
            present: freefem_runs(),
            command: freefem,
            samples: 1,
        },
        Peer {
            name: "scikit-fem",
            install: "`pip install scikit-fem==12.0.1` in the virtual environment of the harness",
            present: succeeds(environment_python(), &["-c", "import skfem"]),
            command: |case| Some(script(environment_python(), "assembly_skfem.py", case)),
            samples: 1,
        },
    ]
}

/// Success of FreeFEM's script on the smallest mesh: the program alone, without its plugins, does not run it.
fn freefem_runs() -> bool {
    let smallest = freefem(Case::Triangles).map(|mut command| {
        command.args(["-divisions", "1", "-samples", "1"]);
        output("FreeFEM", &mut command)
    });
    smallest.is_some_and(|text| text.is_ok_and(|text| read::<Measured>("FreeFEM", &text).is_ok()))
}

/// Runs this program again as a worker that prints what it measures.
pub(super) fn ours(arguments: &[&str]) -> Result<String, ComparisonError> {
    let program =
        std::env::current_exe().map_err(|source| ComparisonError::File { path: PathBuf::new(), source })?;
    output("forms-fem", Command::new(program).arg(WORKER).args(arguments))
}

/// Runs a worker with the arguments after [`WORKER`]: prints one line of JSON.
///
/// # Errors
/// The measured program's error, or that the arguments are wrong.
pub fn work(arguments: &[String], out: &mut StandardOutput) -> Result<(), Box<dyn std::error::Error>> {
    let number = |index: usize| -> Result<usize, Box<dyn std::error::Error>> {
        Ok(arguments.get(index).ok_or("a number is missing")?.parse()?)
    };
    let name = arguments.first().ok_or("the case is missing")?;
    if name == "bodies" {
        let word = |index: usize| arguments.get(index).map(String::as_str).unwrap_or_default();
        let case = Bodies::named(word(1)).ok_or("no such case")?;
        let law = Law::named(word(2)).ok_or("no such law")?;
        let measured = crate::bodies::measure(case, law, number(3)?, number(4)?, Path::new(word(5)))?;
        out.line(serde_json::to_string(&measured)?);
        return Ok(());
    }
    if name == "contact" {
        let measured = crate::assembly::measure_contact(number(1)?, number(2)?)?;
        out.line(serde_json::to_string(&measured)?);
        return Ok(());
    }
    let case = Case::named(name).ok_or("no such case")?;
    let measured = crate::assembly::measure(case, number(1)?, number(2)?, number(3)?)?;
    out.line(serde_json::to_string(&measured)?);
    Ok(())
}

/// The rows of JSON that a program prints, at least one.
pub(super) fn read<T: serde::de::DeserializeOwned>(
    program: &str,
    text: &str,
) -> Result<Vec<T>, ComparisonError> {
    // Some programs print more than their report.
    let lines = text.lines().filter(|line| line.starts_with('{'));
    let parsed = lines.map(serde_json::from_str).collect::<Result<Vec<T>, _>>();
    let bad = |reason| ComparisonError::Output { program: program.to_owned(), reason };
    let rows = parsed.map_err(|error| bad(error.to_string()))?;
    if rows.is_empty() { Err(bad("there is none".to_owned())) } else { Ok(rows) }
}

/// Measures all cases.
pub(super) fn compare(options: &Options, report: &mut Report) -> Result<(), ComparisonError> {
    let peers = known();
    for peer in peers.iter().filter(|peer| !peer.present) {
        report.missing.push((peer.name.to_owned(), peer.install.to_owned()));
    }
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    for case in Case::ALL {
        let divisions = if options.quick { case.quick_divisions() } else { case.divisions() };
        let size = divisions.to_string();
        let mut programs: Vec<Measured> = Vec::new();
        let mut places: BTreeMap<String, usize> = BTreeMap::new();
        let mut keep = |found: Measured, programs: &mut Vec<Measured>| match places.get(&found.program) {
            // Ours runs before and after the peers: both count.
            Some(place) => {
                let known = &mut programs[*place];
                known.reassembly.extend(found.reassembly);
                known.first.extend(found.first);
                known.residual.extend(found.residual);
            }
            None => {
                places.insert(found.program.clone(), programs.len());
                programs.push(found);
            }
        };
        let measure = |threads: usize| -> Result<Vec<Measured>, ComparisonError> {
            read("forms-fem", &ours(&[case.name(), &size, "5", &threads.to_string()])?)
        };
        tell(format!("{}: forms-fem", case.name()));
        for threads in [1, 2].into_iter().filter(|threads| *threads <= cores) {
            measure(threads)?.into_iter().for_each(|found| keep(found, &mut programs));
        }
        for peer in peers.iter().filter(|peer| peer.present) {
            let Some(mut command) = (peer.command)(case) else { continue };
            tell(format!("{}: {}", case.name(), peer.name));
            let samples = if options.quick { 1 } else { peer.samples }.to_string();
            let flags = if peer.name == "FreeFEM" {
                ["-divisions", "-samples"]
            } else {
                ["--divisions", "--samples"]
            };
            command.args([flags[0], &size, flags[1], &samples]);
            command.env("OMP_NUM_THREADS", "1").env("PYTHONDONTWRITEBYTECODE", "1");
            command.env(ARCHITECTURE, architecture());
            match output(peer.name, &mut command).and_then(|text| read::<Measured>(peer.name, &text)) {
                Ok(found) => found.into_iter().for_each(|found| keep(found, &mut programs)),
                Err(error) => report.failures.push(error.to_string()),
            }
        }
        measure(1)?.into_iter().for_each(|found| keep(found, &mut programs));
        report.assembly.push(AssemblyRow { case, divisions, programs });
    }
    for across in if options.quick { vec![8, 16, 32] } else { vec![8, 16, 32, 64] } {
        report.contact.extend(read("forms-fem", &ours(&["contact", &across.to_string(), "21"])?)?);
    }
    Ok(())
}

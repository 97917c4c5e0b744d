//! Finds PETSc and checks that it was built as the bindings expect.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::{env, fs};

const HOW: &str = "PETSc was not found. On Debian or Ubuntu install libpetsc-real-dev and libopenmpi-dev, so that \
                   `pkg-config --exists PETSc` succeeds (PKG_CONFIG_PATH may say where); or set PETSC_DIR, and PETSC_ARCH if \
                   it has one, to a PETSc that was built with shared libraries, Open MPI and MUMPS";

/// Assumptions of the bindings: a definition of petscconf.h, whether it must be there, and its value.
const RELIED_ON: [(&str, bool, &str); 5] = [
    ("PETSC_USE_REAL_DOUBLE", true, "numbers are doubles"),
    ("PETSC_USE_COMPLEX", false, "numbers are real"),
    ("PETSC_USE_64BIT_INDICES", false, "indices have 32 bits"),
    ("PETSC_HAVE_OMPI_MAJOR_VERSION", true, "MPI is Open MPI, whose communicators are pointers"),
    ("PETSC_HAVE_MUMPS", true, "MUMPS is there"),
];

/// Programs that divide graphs: the definition of one that PETSc has, and its name there.
const PARTITIONERS: [(&str, &str); 2] =
    [("PETSC_HAVE_PTSCOTCH", "ptscotch"), ("PETSC_HAVE_PARMETIS", "parmetis")];

fn main() -> ExitCode {
    if env::var_os("CARGO_FEATURE_PETSC").is_none() {
        return ExitCode::SUCCESS;
    }
    match find() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn find() -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-env-changed=PETSC_DIR");
    println!("cargo:rerun-if-env-changed=PETSC_ARCH");
    let includes = match env::var_os("PETSC_DIR") {
        Some(directory) => by_directory(Path::new(&directory))?,
        None => pkg_config::probe_library("PETSc").map_err(|error| format!("{HOW}.\n{error}"))?.include_paths,
    };
    link_mpi();
    let found = includes.iter().map(|path| path.join("petscconf.h")).find(|path| path.is_file());
    let path = found.ok_or_else(|| format!("{HOW}.\nThere is no petscconf.h in {includes:?}"))?;
    let configuration = fs::read_to_string(&path)?;
    let defines = |name: &str| configuration.lines().any(|line| line.split(' ').nth(1) == Some(name));
    for (name, wanted, meaning) in RELIED_ON {
        if defines(name) != wanted {
            let how = if wanted { "does not define" } else { "defines" };
            let path = path.display();
            return Err(format!("this PETSc cannot be used: {path} {how} {name}; {meaning}").into());
        }
    }
    let partitioner = PARTITIONERS.iter().find(|(name, _)| defines(name)).map_or("", |(_, program)| program);
    println!("cargo:rustc-env=PETSC_PARTITIONER={partitioner}");
    Ok(())
}

/// Links MPI itself, by which processes meet and are ended: where PETSc was found, or as `pkg-config` or Open MPI's compiler knows.
fn link_mpi() {
    if pkg_config::probe_library("ompi-c").is_ok() {
        return;
    }
    let asked = Command::new("mpicc").arg("--showme:libdirs").output();
    let directories =
        asked.map(|output| String::from_utf8_lossy(&output.stdout).into_owned()).unwrap_or_default();
    for directory in directories.split_whitespace() {
        println!("cargo:rustc-link-search=native={directory}");
        println!("cargo:rustc-link-arg=-Wl,-rpath,{directory}");
    }
    println!("cargo:rustc-link-lib=dylib=mpi");
}

/// A PETSc that was built in a directory, perhaps with a name of its own for the architecture.
fn by_directory(directory: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let built = env::var_os("PETSC_ARCH").map_or_else(|| directory.to_owned(), |name| directory.join(name));
    let libraries = built.join("lib");
    let names = ["petsc", "petsc_real"];
    let is_there = |name: &&str| libraries.join(format!("lib{name}.so")).exists();
    let name = names.into_iter().find(is_there);
    let name = name.ok_or_else(|| format!("{HOW}.\nThere is no libpetsc.so in {}", libraries.display()))?;
    println!("cargo:rustc-link-search=native={}", libraries.display());
    println!("cargo:rustc-link-lib=dylib={name}");
    println!("cargo:rustc-link-arg=-Wl,-rpath,{}", libraries.display());
    Ok(vec![directory.join("include"), built.join("include")])
}

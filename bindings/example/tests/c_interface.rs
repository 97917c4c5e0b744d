//! The C interface compared with the same problems in Rust: results are bit-identical, and wrong arguments give messages in place of numbers.
#![cfg(unix)]

use std::path::{Path, PathBuf};
use std::process::Command;

use beam_on_ground::{deflection, level};
use forms_bindings::Parameters;
use forms_fem::inverse::DifferentiableMap;

/// The folder of the libraries that cargo has built for this test.
fn libraries() -> PathBuf {
    let test = std::env::current_exe().unwrap();
    test.parent().unwrap().to_owned()
}

/// Output of the C program.
fn printed() -> String {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join("c_interface");
    let libraries = libraries();
    let mut compile = Command::new(std::env::var_os("CC").unwrap_or_else(|| "cc".into()));
    compile.args(["-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror", "-o"]).arg(&program);
    compile.arg(here.join("tests/c_interface.c")).arg("-I").arg(here.join("../include"));
    compile
        .arg("-L")
        .arg(&libraries)
        .arg("-lbeam_on_ground")
        .arg(format!("-Wl,-rpath,{}", libraries.display()));
    assert!(compile.status().unwrap().success(), "{compile:?}");
    // Cargo's own path has the folder above first, where a wheel's build may have left a library with Python's names.
    let output = Command::new(&program).env_remove("LD_LIBRARY_PATH").output().unwrap();
    assert!(output.status.success(), "{output:?}");
    String::from_utf8(output.stdout).unwrap()
}

fn given(numbers: &[(&str, f64)]) -> Parameters {
    Parameters::new(numbers.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect()).unwrap()
}

#[test]
fn c_and_rust_have_the_same_numbers() {
    let printed = printed();
    let numbers = |name: &str| -> Vec<f64> {
        let own = printed.lines().filter_map(|line| line.split_once(' ')).filter(|(first, _)| *first == name);
        own.map(|(_, number)| number.parse().unwrap()).collect()
    };

    let mut beam = level(&mut given(&[("cells", 8.0), ("load", 2e-3)])).unwrap();
    let m: Vec<f64> = beam.start().iter().enumerate().map(|(k, gap)| gap + 1e-3 * k as f64).collect();
    let direction: Vec<f64> = (0..m.len()).map(|k| 1.0 + k as f64).collect();
    assert!(printed.contains(&format!("control gap {}\n", m.len())), "{printed}");
    assert_eq!(numbers("value"), beam.value(&m).unwrap());
    assert_eq!(numbers("slope"), beam.vjp(&m, &[1.0]).unwrap());
    assert_eq!(numbers("along"), beam.jvp(&m, &direction).unwrap());

    let mut beam = deflection(&mut given(&[("cells", 8.0)])).unwrap();
    let start = beam.start();
    let displacement = beam.value(&start).unwrap();
    assert_eq!(numbers("displacement"), displacement);
    assert_eq!(numbers("product"), beam.vjp(&start, &displacement).unwrap());

    let errors: Vec<&str> = printed.lines().filter_map(|line| line.strip_prefix("error ")).collect();
    assert_eq!(
        errors,
        [
            "the vector of controls has 8 values; the map has 9: `gap` (9)",
            "the value NaN of `gap` in the vector of controls is not finite (its number 2)",
            "the value has 1 values, and there is room for 2",
            "there is no parameter `cels`; there are `cells` (16), `load` (0.001)",
            "there is no part 1 of Inputs, which are 1",
        ]
    );
}

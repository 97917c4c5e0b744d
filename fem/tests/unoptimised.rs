//! The notice that kernels are not optimised: once per process, and silent where it is asked to be.

use std::process::Command;

use forms_fem::contract::{FieldDescription, Formula, Inputs, Integrals};
use forms_fem::prelude::*;

/// A functional without integrals.
struct Nothing;

impl Integrals<2> for Nothing {
    fn fields() -> &'static [FieldDescription] {
        &[]
    }
}

const CHILD: &str = "FORMS_TEST_UNOPTIMISED";

/// The standard error of a process that assembles twice.
fn said(silent: bool) -> String {
    let mut command = Command::new(std::env::current_exe().expect("this binary"));
    command.args(["--exact", "unoptimised::told_once_per_process", "--nocapture"]);
    command.env(CHILD, "1").env_remove("FORMS_QUIET");
    if silent {
        command.env("FORMS_QUIET", "1");
    }
    let output = command.output().expect("it runs");
    assert!(output.status.success(), "{output:?}");
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn told_once_per_process() {
    if std::env::var_os(CHILD).is_some() {
        let mesh = rectangle([0.0, 0.0], [1.0, 1.0], [1, 1], CellShape::Triangle, 1).expect("a mesh");
        let assembler = Assembler::new(&mesh);
        let inputs = Inputs { optimised: false, ..Inputs::empty() };
        let form = Functional::of::<Nothing>("length", &Formula::NONE, inputs);
        for _ in 0..2 {
            assert_eq!(assembler.functional(&form).expect("no integrals"), 0.0);
        }
        return;
    }
    let text = said(false);
    assert_eq!(text.matches("compiled without optimisation").count(), 1, "{text}");
    assert!(text.contains("`length`") && text.contains("opt-level = 1"), "{text}");
    assert!(!said(true).contains("optimisation"));
}

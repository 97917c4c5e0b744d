//! Notices of kernels that are slow, or cannot run: compiled without optimisation, or for the instructions of another
//! machine.

use std::sync::Once;

use forms_core::contract::Inputs;

use crate::assemble::AssemblyError;
use crate::lanes::InstructionSet;

/// Set to anything, it silences the notice.
const SILENT: &str = "FORMS_QUIET";

/// A word on standard error, once per process, where the kernels of a form were compiled without optimisation.
pub(in crate::assemble) fn tell<const D: usize>(form: &str, inputs: &Inputs<D>) {
    static TOLD: Once = Once::new();
    if inputs.optimised {
        return;
    }
    TOLD.call_once(|| {
        if std::env::var_os(SILENT).is_none() {
            eprintln!(
                "forms-fem: the kernels of `{form}` are compiled without optimisation and are 60 to 110 times slower: set \
                 `opt-level = 1` or more under `[profile.dev]` in Cargo.toml, or build with `--release` ({SILENT}=1 silences this)"
            );
        }
    });
}

/// A word on standard error, once per process, where a form reads the curvature of facets that have none, as of a polygon that approximates
/// a circle.
pub(in crate::assemble) fn tell_of_straight_facets(form: &str, place: &str) {
    static TOLD: Once = Once::new();
    TOLD.call_once(|| {
        if std::env::var_os(SILENT).is_none() {
            eprintln!("{}", on_straight_facets(form, place));
        }
    });
}

fn on_straight_facets(form: &str, place: &str) -> String {
    format!(
        "forms-fem: `{form}` reads the curvature of {place}, whose facets are straight: it is 0 there, also where they approximate a \
         curve; take geometry of degree 2 ({SILENT}=1 silences this)"
    )
}

/// Refuses a form whose kernels were compiled for no set of instructions that this machine has; `best` is the best that it has.
pub(in crate::assemble) fn check_instructions(
    form: &'static str,
    best: InstructionSet,
) -> Result<(), AssemblyError> {
    if best.is_available() {
        return Ok(());
    }
    let compiled: Vec<String> = InstructionSet::compiled().iter().map(InstructionSet::to_string).collect();
    Err(AssemblyError::Instructions { form, compiled: compiled.join(", ") })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kernels_of_another_machine_are_refused() {
        assert!(check_instructions("direct", InstructionSet::best()).is_ok());
        let foreign =
            [InstructionSet::Plain, InstructionSet::Neon, InstructionSet::Avx2, InstructionSet::Avx512];
        let mut refused = 0;
        for set in foreign.into_iter().filter(|set| !set.is_available()) {
            let error = check_instructions("direct", set).unwrap_err().to_string();
            assert!(error.contains("`direct`") && error.contains("FORMS_ALL_INSTRUCTION_SETS"), "{error}");
            assert!(error.contains(&InstructionSet::best().to_string()), "{error}");
            refused += 1;
        }
        // NEON and AVX are never on one machine.
        assert!(refused > 0);
    }
}

//! Notices, once per process, that kernels were compiled without optimisation or without the machine's instructions.

use std::sync::Once;

use forms_core::contract::Inputs;

use crate::lanes::InstructionSet;

/// Set to anything, it silences the notices.
const SILENT: &str = "FORMS_QUIET";

static TOLD: Once = Once::new();

/// A word on standard error on what makes the kernels of a form slow, if anything does and nothing was told before.
pub(super) fn tell<const D: usize>(form: &str, inputs: &Inputs<D>) {
    if inputs.optimised {
        if let Some(set) = InstructionSet::missed() {
            TOLD.call_once(|| tell_of_missed(set));
        }
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

fn tell_of_missed(set: InstructionSet) {
    if std::env::var_os(SILENT).is_none() {
        eprintln!(
            "forms-fem: this program was built on a machine with other instructions, and kernels run without this one's {set}, \
             several times slower: build it here, or with FORMS_ALL_INSTRUCTION_SETS=1 in the environment ({SILENT}=1 silences this)"
        );
    }
}

//! A notice, once per process, that kernels were compiled without optimisation.

use std::sync::Once;

use forms_core::contract::Inputs;

/// Set to anything, it silences the notice.
const SILENT: &str = "FORMS_QUIET";

static TOLD: Once = Once::new();

/// Tells on standard error that the kernels of a form are slow, if they are and nothing was told before.
pub(super) fn notice<const D: usize>(form: &str, inputs: &Inputs<D>) {
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

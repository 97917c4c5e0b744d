//! The machine of a comparison.

use serde::Serialize;

use super::process::{environment_python, first_line};

/// Machine, compilers, versions.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Machine {
    /// Name of the processor.
    pub processor: String,
    /// Cores.
    pub cores: usize,
    /// The instruction set that our kernels run with.
    pub instruction_set: String,
    /// `-march` of the peers' compilers, where they compile with one.
    pub architecture: String,
    /// Compilers and peers with their versions.
    pub versions: Vec<(String, String)>,
}

impl Machine {
    /// This machine.
    pub fn this() -> Self {
        let information = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let model = information.lines().find(|line| line.starts_with("model name"));
        let processor = model.and_then(|line| line.split(':').nth(1)).unwrap_or("unknown").trim().to_owned();
        let environment = environment_python().to_string_lossy().into_owned();
        let ffcx = "import ffcx; print(ffcx.__version__)";
        let dolfinx = "import dolfinx; print(dolfinx.__version__)";
        let system = super::process::system_python().to_string_lossy().into_owned();
        let commands: [(&str, &str, &[&str]); 8] = [
            ("rustc", "rustc", &["--version"]),
            ("gcc", "gcc", &["--version"]),
            ("clang", "clang", &["--version"]),
            ("FFCx (pip)", &environment, &["-c", ffcx]),
            (
                "FFCx (Debian)",
                &system,
                &["-c", "from importlib.metadata import version; print(version('fenics-ffcx'))"],
            ),
            ("DOLFINx", &system, &["-c", dolfinx]),
            ("GetFEM", &system, &["-c", "import getfem; print(getfem.getfem_env('version'))"]),
            ("scikit-fem", &environment, &["-c", "import skfem; print(skfem.__version__)"]),
        ];
        let versions = commands
            .into_iter()
            .filter_map(|(name, program, arguments)| Some((name.to_owned(), first_line(program, arguments)?)))
            .collect();
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let instruction_set = forms_fem::lanes::InstructionSet::best().to_string();
        Machine { processor, cores, instruction_set, architecture: architecture().to_owned(), versions }
    }
}

/// The variable that chooses the instruction set of a build (`fem/problem/build.rs`).
pub(super) const INSTRUCTION_SET: &str = "FORMS_INSTRUCTION_SET";

/// The instruction set that this program was built for, where one was asked for.
pub(super) const CHOSEN: Option<&str> = option_env!("FORMS_INSTRUCTION_SET");

/// The variable that tells the harness and the peers' scripts their compilers' `-march`.
pub(super) const ARCHITECTURE: &str = "PEERS_MARCH";

/// `-march` of the peers' compilers: they have the instructions that ours has.
pub(super) fn architecture() -> &'static str {
    match CHOSEN {
        Some("plain") => "x86-64",
        Some("avx2") => "x86-64-v3",
        _ => "native",
    }
}

//! Programs on several processes.

use std::process::Command;

/// The command that runs a program on several processes.
pub fn mpirun(processes: usize, program: &str, arguments: &[&str]) -> Command {
    let mut command = Command::new("mpirun");
    // As root in a container there are no other users to protect, and no rights for copies between processes.
    command.args([
        "--allow-run-as-root",
        "--oversubscribe",
        "--timeout",
        "600",
        "-n",
        &processes.to_string(),
    ]);
    command.env("OMPI_MCA_btl_vader_single_copy_mechanism", "none").env("OMPI_MCA_mpi_yield_when_idle", "1");
    command.env("OMP_NUM_THREADS", "1").arg(program).args(arguments);
    command
}

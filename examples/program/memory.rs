//! Memory: what this process has taken, what the system has, and what a computation will need.

/// Bytes per unknown of the direct contact problem in the plane with adjoint states, on Q2 elements: `AT_FIRST` + `PER_DOUBLING`
/// log₂(unknowns), where the second part is the Cholesky factor's. Fitted by hand to the five meshes of
/// docs/scaling.md (33,792 to 3,287,040 unknowns), each within 5 %.
const AT_FIRST: f64 = 1950.0;
const PER_DOUBLING: f64 = 24.0;

/// The memory that a contact problem in the plane with its adjoint states takes \[bytes\].
pub fn of_contact(unknowns: f64) -> f64 {
    unknowns * (AT_FIRST + PER_DOUBLING * unknowns.max(1.0).log2())
}

/// An error if a computation needs more memory than the system reports. Without a report nothing is refused. `option` is the
/// option of the command line that asks for this memory.
///
/// # Errors
/// One line with the option, the estimate and what is available.
pub fn check(option: &str, unknowns: f64, bytes: f64) -> Result<(), String> {
    match available() {
        Some(available) if bytes > available => {
            let [needed, available] = [bytes, available].map(|bytes| bytes / 1e9);
            Err(format!(
                "{option}: {unknowns:.0} unknowns need about {needed:.1} GB of memory, and {available:.1} GB are \
                 available (--any-memory goes on all the same)"
            ))
        }
        _ => Ok(()),
    }
}

/// Memory that the system can still give \[bytes\]; `None` if the system does not report it (Linux does).
fn available() -> Option<f64> {
    kibibytes(&std::fs::read_to_string("/proc/meminfo").ok()?, "MemAvailable:")
        .map(|kibibytes| kibibytes * 1024.0)
}

/// Peak resident memory of this process \[10⁶ bytes\]; `None` if the system does not report it (Linux does).
pub fn peak_megabytes() -> Option<f64> {
    kibibytes(&std::fs::read_to_string("/proc/self/status").ok()?, "VmHWM:")
        .map(|kibibytes| kibibytes * 1024.0 / 1e6)
}

/// The number of a line `VmHWM:   123 kB`; the kernel's kB are 1024 bytes.
fn kibibytes(text: &str, name: &str) -> Option<f64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    let (number, unit) = line.trim().split_once(char::is_whitespace)?;
    let kibibytes: f64 = number.parse().ok()?;
    (unit.trim() == "kB").then_some(kibibytes)
}

#[cfg(test)]
mod tests {
    use super::{check, kibibytes, of_contact};

    #[test]
    fn the_kernels_line_is_understood() {
        let peak = |text| kibibytes(text, "VmHWM:");
        assert_eq!(peak("Name:\tx\nVmHWM:\t   15625 kB\nVmRSS:\t 1 kB\n"), Some(15625.0));
        assert_eq!(peak("VmHWM:\t 15625 pages\n"), None);
        assert_eq!(peak("VmRSS:\t 1 kB\n"), None);
    }

    /// The peaks that docs/scaling.csv states, which another program measured.
    #[test]
    fn the_estimate_is_that_of_the_meshes_that_were_measured() {
        let table = include_str!("../../docs/scaling.csv");
        let mut rows = 0;
        for row in table.lines().skip(1) {
            let numbers: Vec<f64> = row.split(',').map(|number| number.parse().expect("a number")).collect();
            let (unknowns, measured) = (numbers[1], numbers[11] * f64::from(1 << 30));
            let estimate = of_contact(unknowns);
            assert!((estimate / measured - 1.0).abs() < 0.05, "{unknowns}: {estimate:e} for {measured:e}");
            rows += 1;
        }
        assert_eq!(rows, 5);
    }

    #[test]
    fn what_no_machine_has_is_refused_by_name() {
        assert_eq!(check("--radial 1", 128.0, of_contact(128.0)), Ok(()));
        if cfg!(target_os = "linux") {
            let error = check("--radial 2000", 512_128_000.0, 1e15).unwrap_err();
            assert!(
                error.starts_with("--radial 2000: 512128000 unknowns need about 1000000.0 GB"),
                "{error}"
            );
        }
    }
}

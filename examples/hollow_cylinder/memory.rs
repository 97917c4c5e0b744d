//! Peak memory of this process.

/// The most memory that this process has had resident \[10⁶ bytes\]; `None` where the system has no file
/// that says it (Linux has one).
pub fn peak_megabytes() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    parse(&status)
}

/// The line `VmHWM:   123 kB`; the kernel's kB are 1024 bytes.
fn parse(status: &str) -> Option<f64> {
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let (number, unit) = line.trim().split_once(char::is_whitespace)?;
    let kibibytes: f64 = number.parse().ok()?;
    (unit.trim() == "kB").then_some(kibibytes * 1024.0 / 1e6)
}

#[cfg(test)]
mod tests {
    use super::parse;

    #[test]
    fn the_kernels_line_is_understood() {
        assert_eq!(parse("Name:\tx\nVmHWM:\t   15625 kB\nVmRSS:\t 1 kB\n"), Some(16.0));
        assert_eq!(parse("VmHWM:\t 15625 pages\n"), None);
        assert_eq!(parse("VmRSS:\t 1 kB\n"), None);
    }
}

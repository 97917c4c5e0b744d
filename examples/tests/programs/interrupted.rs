//! Programs that are killed at any moment, and started again.

use std::process::Command;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// The number of times that a program was killed, each time later, until it came to its end; at least twice.
pub fn killed_until_it_ends(command: impl Fn() -> Command, mut patience: Duration) -> usize {
    let mut kills = 0;
    loop {
        let mut child = command().spawn().expect("the program starts");
        let start = Instant::now();
        let ended = loop {
            match child.try_wait().expect("a status") {
                Some(status) => break Some(status),
                None if start.elapsed() > patience => break None,
                None => sleep(Duration::from_millis(3)),
            }
        };
        if let Some(status) = ended {
            assert!(status.success(), "{status}");
            assert!(kills >= 2, "killed {kills} times");
            return kills;
        }
        child.kill().expect("it is killed");
        child.wait().expect("it ends");
        kills += 1;
        patience = patience.mul_f64(1.3);
    }
}

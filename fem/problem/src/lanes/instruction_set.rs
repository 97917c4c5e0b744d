//! The instruction sets, which of them the machine has, and the choice of a lane type.

use std::fmt;
use std::sync::OnceLock;

#[cfg(target_arch = "x86_64")]
use super::x86;
use super::{LaneWork, SharedWork, SimdLane};

/// A set of instructions that kernels are compiled for.
///
/// Results differ between sets in the last bits, because sums of products are rounded once where the hardware
/// has fused multiply-add. Within one set they are the same on every machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum InstructionSet {
    /// One cell at a time, on any machine.
    Plain,
    /// Four cells at a time: NEON (AArch64).
    Neon,
    /// Four cells at a time: AVX2 with fused multiply-add (x86-64).
    Avx2,
    /// Eight cells at a time: AVX-512 F, DQ and VL (x86-64).
    Avx512,
}

impl InstructionSet {
    pub(super) const ALL: [InstructionSet; 4] =
        [InstructionSet::Plain, InstructionSet::Neon, InstructionSet::Avx2, InstructionSet::Avx512];

    /// The best set that this machine has and that was compiled; found once. The plain one where there is none: forms are
    /// refused then ([`InstructionSet::is_available`]).
    pub fn best() -> Self {
        static BEST: OnceLock<InstructionSet> = OnceLock::new();
        *BEST.get_or_init(|| Self::available().into_iter().next_back().unwrap_or(InstructionSet::Plain))
    }

    /// The instruction sets of this machine that were compiled, from the plain one to the best.
    pub fn available() -> Vec<Self> {
        Self::ALL.into_iter().filter(|set| set.is_available()).collect()
    }

    /// The instruction sets that were compiled: the best of the machine of the build, all of the target where `FORMS_ALL_INSTRUCTION_SETS` is
    /// set in the environment of the build.
    pub fn compiled() -> Vec<Self> {
        Self::ALL.into_iter().filter(|set| set.is_compiled()).collect()
    }

    /// Whether this machine has it and it was compiled.
    pub fn is_available(self) -> bool {
        self.is_compiled() && self.is_of_machine()
    }

    fn is_compiled(self) -> bool {
        match self {
            InstructionSet::Plain => cfg!(not(without_plain)),
            InstructionSet::Neon => cfg!(target_arch = "aarch64"),
            InstructionSet::Avx2 => cfg!(all(target_arch = "x86_64", not(without_avx2))),
            InstructionSet::Avx512 => cfg!(all(target_arch = "x86_64", not(without_avx512))),
        }
    }

    pub(super) fn is_of_machine(self) -> bool {
        match self {
            InstructionSet::Plain => true,
            InstructionSet::Neon => cfg!(target_arch = "aarch64"),
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx2 => x86::has_avx2(),
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx512 => x86::has_avx512(),
            #[cfg(not(target_arch = "x86_64"))]
            InstructionSet::Avx2 | InstructionSet::Avx512 => false,
        }
    }

    /// Number of cells at a time.
    pub fn width(self) -> usize {
        match self {
            InstructionSet::Plain => 1,
            InstructionSet::Neon | InstructionSet::Avx2 => 4,
            InstructionSet::Avx512 => 8,
        }
    }

    /// This set if it is available, else the best that is.
    pub(crate) fn checked(self) -> Checked {
        Checked(if self.is_available() { self } else { InstructionSet::best() })
    }
}

/// A set that is available, or the plain one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Checked(InstructionSet);

impl Checked {
    /// The set.
    pub(crate) fn set(self) -> InstructionSet {
        self.0
    }

    /// Number of cells at a time.
    pub(crate) fn width(self) -> usize {
        self.0.width()
    }

    /// Runs the work of a kernel, compiled for the set.
    #[inline]
    pub(crate) fn run<W: LaneWork>(self, work: W) -> W::Output {
        with_lanes!(self, L => L::call(InLanes(work)))
    }

    /// Runs work of this crate alone, which is compiled for the plain set in any build.
    #[inline]
    pub(crate) fn run_without_kernel<W: LaneWork>(self, work: W) -> W::Output {
        match self.0 {
            InstructionSet::Plain => work.run::<f64>(),
            _ => self.run(work),
        }
    }
}

/// Work for any lane type as work for one.
pub(super) struct InLanes<W>(pub W);

impl<L: SimdLane, W: LaneWork> SharedWork<L> for InLanes<W> {
    type Output = W::Output;

    #[inline(always)]
    fn run(self) -> W::Output {
        self.0.run::<L>()
    }
}

/// The value of an expression that names the lane type of a checked set `$lane`. The expression itself is compiled for any machine: what it
/// hands to [`SimdLane::call`] is compiled for the set.
macro_rules! with_lanes {
    ($set:expr, $lane:ident => $work:expr) => {
        match $set.set() {
            #[cfg(all(target_arch = "x86_64", not(without_avx512)))]
            $crate::lanes::InstructionSet::Avx512 => {
                type $lane = $crate::lanes::Avx512;
                $work
            }
            #[cfg(all(target_arch = "x86_64", not(without_avx2)))]
            $crate::lanes::InstructionSet::Avx2 => {
                type $lane = $crate::lanes::Avx2;
                $work
            }
            #[cfg(target_arch = "aarch64")]
            $crate::lanes::InstructionSet::Neon => {
                type $lane = $crate::lanes::Neon;
                $work
            }
            #[cfg(not(without_plain))]
            _ => {
                type $lane = f64;
                $work
            }
            #[cfg(without_plain)]
            _ => unreachable!("a form is refused where no instructions of its kernels are available"),
        }
    };
}
pub(crate) use with_lanes;

impl fmt::Display for InstructionSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            InstructionSet::Plain => "plain",
            InstructionSet::Neon => "NEON",
            InstructionSet::Avx2 => "AVX2",
            InstructionSet::Avx512 => "AVX-512",
        })
    }
}

//! Derivatives of the energies of units whose points move, in the plane: the density is run on values with two derivatives along the own facet.
//!
//! Points s and weights W of moving segments are linear functions of the coordinates c of their feet. With the density ρ
//!
//! ```text
//! ∂Π/∂c = Σ W (ρ′ ∂s/∂c + ρ ∂W/∂c / W)
//! ∂²Π/∂c∂d = Σ W (ρ″ ∂s/∂c ∂s/∂d + ρ′ (∂s/∂c ∂W/∂d + ∂s/∂d ∂W/∂c) / W)
//! ```

// Closures and iterator adaptors do not inherit a caller's target features: loops over lane values are plain.
#![allow(clippy::needless_range_loop)]

use std::ops::Range;

use forms_core::contract::{Basis, Further, Lane, LinearConstants};

use super::linear_calls::{VectorCall, VectorCalls, values_at_point};
use super::sink::Deliver;
use super::vectors::ElementVectors;
use crate::assemble::AssemblyError;
use crate::assemble::batch::{Batch, BatchBuffers};
use crate::lanes::{Moving, SharedWork, SimdLane, Transposition, WIDEST};

/// Values with two derivatives.
pub(in crate::assemble) type Twice<L> = Moving<Moving<L>>;

/// The loops over the batches of a range: of each unit the first derivatives by its feet, then the second ones, row after row.
pub(in crate::assemble) struct Loops<'a, 'd, 'c, L, const D: usize> {
    pub task: &'a ElementVectors<'d, D>,
    pub kernel: &'a LinearConstants,
    pub calls: &'a mut dyn VectorCalls<Twice<L>, D>,
    pub range: Range<usize>,
    pub deliver: Deliver<'c>,
}

impl<L: SimdLane, const D: usize> SharedWork<L> for Loops<'_, '_, '_, L, D> {
    type Output = Result<(), AssemblyError>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Loops { task, kernel, calls, range, deliver } = self;
        let group = task.group;
        let Some(moving) = group.pairs().map(|pairs| &pairs.group.motion) else { return Ok(()) };
        let (feet, zero) = (moving.coordinates(group.entities()), L::splat(0.0));
        let unit = Basis { value: Twice::splat(1.0), gradient: [Twice::splat(0.0); D] };
        let mut buffers = BatchBuffers::<Twice<L>, D>::default();
        let mut batch = Batch::new(task.binding, group, task.cells, *kernel.requirements, &[], &mut buffers)?;
        let stride = feet + feet * feet;
        let nothing = Twice::splat(0.0);
        let (mut at_point, mut sums) = (vec![nothing; kernel.components], vec![zero; stride]);
        let (mut along, mut stretch) = (vec![zero; feet], vec![zero; feet]);
        let mut numbers = vec![0.0; L::WIDTH * stride];
        let mut start = range.start;
        while start < range.end {
            let filled = L::WIDTH.min(range.end - start);
            calls.call(&mut VectorCall::Cell(&batch.load(start, filled)));
            for k in 0..stride {
                sums[k] = zero;
            }
            for q in 0..group.points() {
                batch.point(q)?;
                values_at_point(calls, &batch, (&[unit], &[Further::none()]), &mut at_point);
                // The test function's first component has the density.
                let Moving { value, slope } = at_point[0];
                let (density, first, second) = (value.value, value.slope, slope.slope);
                let mut places = [0; WIDEST];
                for lane in 0..L::WIDTH {
                    let unit = start + lane.min(filled - 1);
                    places[lane] = (unit * group.points() + q) * feet * D;
                }
                for foot in 0..feet {
                    let shares = L::gather::<D>(&moving.shares, &places);
                    (along[foot], stretch[foot]) = (shares[0], shares[D - 1]);
                    for lane in 0..L::WIDTH {
                        places[lane] += D;
                    }
                }
                for one in 0..feet {
                    let change = along[one].multiply_add(first, stretch[one] * density);
                    sums[one] += change;
                    for other in 0..feet {
                        let both = along[one].multiply_add(stretch[other], stretch[one] * along[other]);
                        let change = (along[one] * along[other]).multiply_add(second, both * first);
                        let sum = &mut sums[feet + one * feet + other];
                        *sum += change;
                    }
                }
            }
            L::call(Transposition { source: &sums[..], filled, target: &mut numbers, stride });
            deliver(start, &numbers[..filled * stride])?;
            start += filled;
        }
        Ok(())
    }
}

//! Smoother cuts: cells near a cut change sides where the halves then have fewer blocks in common.

use crate::cell_blocks::CellBlocks;

/// Most passes over the cells near a cut.
const PASSES: usize = 4;
/// Percentage of cells per side that may cross a cut. Each half keeps at least this percentage.
const NEAR: usize = 20;
const KEPT: usize = 30;

/// Memory for the smoothing of one cut after the other.
pub(super) struct Smoothing {
    /// Of each block the numbers of cells in the lower and in the upper half.
    counts: Vec<[u32; 2]>,
    sides: Vec<bool>,
    moved: Vec<u32>,
}

impl Smoothing {
    /// For the given number of blocks.
    pub(super) fn new(blocks: usize) -> Self {
        Smoothing { counts: vec![[0; 2]; blocks], sides: vec![], moved: vec![] }
    }

    /// Moves cells across the cut of a part, whose lower half comes first, and gives the new number of the lower ones. Blocks that
    /// are separated already do not count.
    pub(super) fn smooth(
        &mut self,
        cells: &CellBlocks,
        separated: &[bool],
        part: &mut [u32],
        mut lower: usize,
    ) -> usize {
        let Smoothing { counts, sides, moved } = self;
        let near = part.len() * NEAR / 100;
        let (first, last) = (lower.saturating_sub(near), (lower + near).min(part.len()));
        for cell in &part[first..last] {
            cells.of(*cell).iter().for_each(|block| counts[*block as usize] = [0; 2]);
        }
        sides.clear();
        sides.extend((0..part.len()).map(|place| place >= lower));
        for (cell, side) in part.iter().zip(&*sides) {
            cells.of(*cell).iter().for_each(|block| counts[*block as usize][usize::from(*side)] += 1);
        }
        for _ in 0..PASSES {
            let mut changes = false;
            for place in first..last {
                let side = usize::from(sides[place]);
                let left = if side == 0 { lower } else { part.len() - lower };
                let of_cell = cells.of(part[place]);
                let gain: i32 = of_cell
                    .iter()
                    .filter(|block| !separated[**block as usize])
                    .map(|block| {
                        let count = counts[*block as usize];
                        i32::from(count[1 - side] > 0) - i32::from(count[side] > 1)
                    })
                    .sum();
                if gain > 0 && 100 * left > KEPT * part.len() {
                    for block in of_cell {
                        counts[*block as usize][side] -= 1;
                        counts[*block as usize][1 - side] += 1;
                    }
                    sides[place] = !sides[place];
                    lower = if side == 0 { lower - 1 } else { lower + 1 };
                    changes = true;
                }
            }
            if !changes {
                break;
            }
        }
        moved.clear();
        for wanted in [false, true] {
            moved
                .extend(part.iter().zip(&*sides).filter(|(_, side)| **side == wanted).map(|(cell, _)| *cell));
        }
        part.copy_from_slice(moved);
        lower
    }
}

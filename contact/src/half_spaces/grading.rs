//! Cells along a side that grow with the distance from the contact.

/// A cell is this much longer than the one before.
const GROWTH: f64 = 1.6;

/// The side is at least this many reaches of the contact long.
const LENGTH: f64 = 6.0;

/// Ends of cells, from 0 outwards: of equal length near the contact, then longer and longer.
#[derive(Clone, Debug)]
pub(super) struct Grading {
    ends: Vec<f64>,
}

impl Grading {
    /// `cells` cells over the reach of the contact, of equal length up to `near` times the reach.
    pub fn new(reach: f64, near: f64, cells: usize) -> Grading {
        let mut length = reach / cells as f64;
        let equal = (near * cells as f64).ceil() as usize;
        let mut ends: Vec<f64> = (0..=equal).map(|end| length * end as f64).collect();
        while cells > 0 && *ends.last().unwrap_or(&0.0) < LENGTH * reach {
            length *= GROWTH;
            ends.push(ends.last().unwrap_or(&0.0) + length);
        }
        Grading { ends }
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.ends.len() - 1
    }

    /// Length of the side.
    pub fn length(&self) -> f64 {
        self.place(1.0)
    }

    /// The place at a part of the row of cells; the middle of a cell is in its middle.
    pub fn place(&self, part: f64) -> f64 {
        let along = part * self.cells() as f64;
        let cell = (along.floor() as usize).min(self.cells().saturating_sub(1));
        let [start, end] = [cell, cell + 1].map(|end| self.ends.get(end).copied().unwrap_or(0.0));
        start + (along - cell as f64) * (end - start)
    }

    /// The place at a part of two rows that meet at 0.
    pub fn on_both_sides(&self, part: f64) -> f64 {
        let away = 2.0 * part - 1.0;
        self.place(away.abs()) * away.signum()
    }
}

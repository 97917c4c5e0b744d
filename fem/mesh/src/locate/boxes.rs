//! A grid of bounding boxes: which of them hold a point, or meet another box.

use super::distance;

/// Lower and upper corner of a box.
pub type Corners<const D: usize> = ([f64; D], [f64; D]);

/// Boxes, sorted into bins of about their size.
#[derive(Clone, Debug)]
pub struct BoxGrid<const D: usize> {
    boxes: Vec<Corners<D>>,
    lower: [f64; D],
    /// Edge lengths of a bin.
    bin: [f64; D],
    /// Number of bins per direction.
    bins: [usize; D],
    /// `members[starts[b]..starts[b + 1]]` are the boxes that meet bin b, ascending.
    starts: Vec<usize>,
    members: Vec<u32>,
}

impl<const D: usize> BoxGrid<D> {
    /// A grid of some boxes, at least one; linear in their number.
    pub fn new(boxes: Vec<Corners<D>>) -> Self {
        let lower = std::array::from_fn(|k| boxes.iter().map(|b| b.0[k]).fold(f64::INFINITY, f64::min));
        let upper: [f64; D] =
            std::array::from_fn(|k| boxes.iter().map(|b| b.1[k]).fold(f64::NEG_INFINITY, f64::max));
        let extent: [f64; D] = std::array::from_fn(|k| upper[k] - lower[k]);
        let size = bin_size(extent, boxes.len());
        let bins = extent.map(|extent| ((extent / size) as usize).clamp(1, boxes.len()));
        let bin = std::array::from_fn(|k| extent[k] / bins[k] as f64);
        let mut grid = BoxGrid { boxes, lower, bin, bins, starts: vec![], members: vec![] };
        grid.fill();
        grid
    }

    /// The boxes that hold a point, ascending.
    pub fn around(&self, point: &[f64; D]) -> impl Iterator<Item = usize> {
        let holds = |index: &usize| {
            let (lower, upper) = &self.boxes[*index];
            (0..D).all(|k| lower[k] <= point[k] && point[k] <= upper[k])
        };
        self.members_of(self.bin_of(point)).iter().map(|&index| index as usize).filter(holds)
    }

    /// The boxes that meet another one, ascending.
    pub fn meeting(&self, (low, high): &Corners<D>) -> Vec<usize> {
        let mut found = Vec::new();
        for_each_bin(self.bin_of(low), self.bin_of(high), |bin| {
            let near = |index: &usize| {
                let (lower, upper) = &self.boxes[*index];
                (0..D).all(|k| lower[k] <= high[k] && low[k] <= upper[k])
            };
            found.extend(self.members_of(bin).iter().map(|&index| index as usize).filter(near));
        });
        found.sort_unstable();
        found.dedup();
        found
    }

    fn fill(&mut self) {
        let count = self.bins.iter().product::<usize>();
        let mut bins = vec![Vec::new(); count];
        for (number, (lower, upper)) in self.boxes.iter().enumerate() {
            for_each_bin(self.bin_of(lower), self.bin_of(upper), |bin| {
                bins[self.index(bin)].push(number as u32);
            });
        }
        self.starts.push(0);
        for bin in bins {
            self.members.extend(bin);
            self.starts.push(self.members.len());
        }
    }

    // Points outside the grid go to its nearest bin.
    fn bin_of(&self, point: &[f64; D]) -> [usize; D] {
        // The conversion of a negative number or NaN gives 0.
        std::array::from_fn(|k| (((point[k] - self.lower[k]) / self.bin[k]) as usize).min(self.bins[k] - 1))
    }

    fn index(&self, bin: [usize; D]) -> usize {
        (0..D).rev().fold(0, |index, k| index * self.bins[k] + bin[k])
    }

    fn members_of(&self, bin: [usize; D]) -> &[u32] {
        let index = self.index(bin);
        &self.members[self.starts[index]..self.starts[index + 1]]
    }
}

/// The box around some points; one of curved entities is enlarged by `bulge` of its extent, since a quadratic map bulges
/// beyond its nodes by an eighth of their spread per direction. It is a little wider than exact.
pub fn box_around<'a, const D: usize>(
    points: impl IntoIterator<Item = &'a [f64; D]>,
    bulge: f64,
) -> Corners<D> {
    let (mut lower, mut upper) = ([f64::INFINITY; D], [f64::NEG_INFINITY; D]);
    for x in points {
        for k in 0..D {
            lower[k] = lower[k].min(x[k]);
            upper[k] = upper[k].max(x[k]);
        }
    }
    let diagonal = distance(&lower, &upper);
    for k in 0..D {
        let margin = bulge * (upper[k] - lower[k]) + 2.0 * super::INSIDE * diagonal;
        lower[k] -= margin;
        upper[k] += margin;
    }
    (lower, upper)
}

// The edge of cubic bins, about one per box. Directions thinner than a bin do not count: else a plate
// would get far more bins than cells.
fn bin_size<const D: usize>(extent: [f64; D], boxes: usize) -> f64 {
    let mut size = 0.0;
    for _ in 0..D {
        let wide = extent.iter().filter(|&&extent| extent > size);
        let (product, count) = wide.fold((1.0, 0), |(product, count), extent| (product * extent, count + 1));
        if count > 0 {
            size = (product / boxes as f64).powf(1.0 / f64::from(count));
        }
    }
    size
}

fn for_each_bin<const D: usize>(first: [usize; D], last: [usize; D], mut visit: impl FnMut([usize; D])) {
    let mut bin = first;
    loop {
        visit(bin);
        let Some(k) = (0..D).find(|&k| bin[k] < last[k]) else { return };
        bin[k] += 1;
        bin[..k].copy_from_slice(&first[..k]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_at_most_as_many_bins_as_boxes_ask_for() {
        // A cube of 1000 cells, and a plate of 100 × 100 cells, however thin.
        assert!((bin_size([1.0, 1.0, 1.0], 1000) - 0.1).abs() < 1e-15);
        for thickness in [1e-3, 1e-9] {
            assert!((bin_size([1.0, 1.0, thickness], 10_000) - 0.01).abs() < 1e-15);
        }
    }

    #[test]
    fn boxes_that_meet_are_found() {
        let boxes: Vec<Corners<2>> =
            (0..50).map(|k| ([f64::from(k), 0.0], [f64::from(k) + 1.0, 0.1])).collect();
        let grid = BoxGrid::new(boxes);
        assert_eq!(grid.meeting(&([3.5, -1.0], [5.5, 2.0])), [3, 4, 5]);
        assert_eq!(grid.meeting(&([3.5, 0.2], [5.5, 2.0])), [0_usize; 0]);
        assert_eq!(grid.around(&[7.5, 0.05]).collect::<Vec<_>>(), [7]);
    }
}

//! Differences between the entries of a square matrix and their partners, each relative to its own size.

/// The largest difference between an entry and its partner.
pub(super) struct Asymmetry<'a> {
    pub(super) sizes: &'a [f64],
    pub(super) most: f64,
}

impl Asymmetry<'_> {
    pub(super) fn visit(&mut self, (i, j): (usize, usize), entry: f64, partner: f64) {
        if entry != partner {
            let size = (self.sizes[i] * self.sizes[j]).max(entry.abs()).max(partner.abs());
            let part = (entry - partner).abs() / size;
            // The first NaN stays.
            if part > self.most || part.is_nan() && !self.most.is_nan() {
                self.most = part;
            }
        }
    }
}

/// √|a_ii|, or its substitute where the diagonal is zero. `visit_row` calls its second argument with the columns
/// and values of a row.
pub(super) fn sizes_of_unknowns(
    diagonal: Vec<f64>,
    visit_row: impl Fn(usize, &mut dyn FnMut(usize, f64)),
) -> Vec<f64> {
    let mut sizes: Vec<f64> = diagonal.iter().map(|value| value.abs().sqrt()).collect();
    for (row, _) in diagonal.iter().enumerate().filter(|(_, value)| **value == 0.0) {
        let mut largest = 0.0_f64;
        visit_row(row, &mut |column, value| {
            if let Some(other) = diagonal.get(column).filter(|other| **other != 0.0) {
                largest = largest.max(value.abs() / other.abs().sqrt());
            }
        });
        sizes[row] = largest;
    }
    sizes
}

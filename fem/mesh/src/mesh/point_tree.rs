//! Points of a set in a box, found by halving the set along one axis after the other.

/// Points sorted so that each part of the list is split at its middle: a k-d tree without pointers (J. L. Bentley 1975). How
/// far points are apart does not matter, so that no mesh makes a search slow.
pub(super) struct PointTree<const D: usize> {
    points: Vec<([f64; D], u32)>,
}

/// Parts of the list this short are looked through.
const SHORT: usize = 8;

impl<const D: usize> PointTree<D> {
    /// A tree of points with a number each.
    pub(super) fn new(mut points: Vec<([f64; D], u32)>) -> Self {
        sort(&mut points, 0);
        PointTree { points }
    }

    /// Calls `visit` with each point between a lower and an upper corner, the box's faces included.
    pub(super) fn for_each_within(
        &self,
        lower: &[f64; D],
        upper: &[f64; D],
        visit: &mut dyn FnMut(&[f64; D], u32),
    ) {
        search(&self.points, 0, lower, upper, visit);
    }
}

fn sort<const D: usize>(points: &mut [([f64; D], u32)], axis: usize) {
    if points.len() <= SHORT {
        return;
    }
    let middle = points.len() / 2;
    points.select_nth_unstable_by(middle, |a, b| a.0[axis].total_cmp(&b.0[axis]).then(a.1.cmp(&b.1)));
    let (before, after) = points.split_at_mut(middle);
    sort(before, (axis + 1) % D);
    sort(&mut after[1..], (axis + 1) % D);
}

fn search<const D: usize>(
    points: &[([f64; D], u32)],
    axis: usize,
    lower: &[f64; D],
    upper: &[f64; D],
    visit: &mut dyn FnMut(&[f64; D], u32),
) {
    let mut look = |(x, number): &([f64; D], u32)| {
        if (0..D).all(|k| lower[k] <= x[k] && x[k] <= upper[k]) {
            visit(x, *number);
        }
    };
    if points.len() <= SHORT {
        points.iter().for_each(look);
        return;
    }
    let middle = points.len() / 2;
    let at = points[middle].0[axis];
    look(&points[middle]);
    if lower[axis] <= at {
        search(&points[..middle], (axis + 1) % D, lower, upper, visit);
    }
    if at <= upper[axis] {
        search(&points[middle + 1..], (axis + 1) % D, lower, upper, visit);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_points_of_a_box_are_found() {
        // Many equal coordinates, and equal points.
        let points: Vec<([f64; 3], u32)> = (0..500_u32)
            .map(|n| ([f64::from(n * 7 % 10), f64::from(n * 3 % 8), f64::from(n % 5)], n))
            .collect();
        let tree = PointTree::new(points.clone());
        for (lower, upper) in [([2.0, 1.0, 0.0], [5.0, 6.0, 3.0]), ([0.0; 3], [9.0; 3]), ([4.5; 3], [4.6; 3])]
        {
            let mut found = Vec::new();
            tree.for_each_within(&lower, &upper, &mut |_, number| found.push(number));
            found.sort_unstable();
            let inside = |x: &[f64; 3]| (0..3).all(|k| lower[k] <= x[k] && x[k] <= upper[k]);
            let expected: Vec<u32> = points.iter().filter(|(x, _)| inside(x)).map(|(_, n)| *n).collect();
            assert_eq!(found, expected);
        }
    }
}

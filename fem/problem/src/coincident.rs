//! Finding the point of a set that coincides with a given one.

use std::collections::HashMap;

/// Points sorted into boxes of the size of the tolerance: one that coincides is in the same box or in one next to it.
pub struct Coincident<'a, const D: usize> {
    points: &'a [[f64; D]],
    tolerance: f64,
    boxes: HashMap<[i64; D], usize>,
}

/// Points coincide within this part of their set's extent.
const TOLERANCE: f64 = 1e-8;

impl<'a, const D: usize> Coincident<'a, D> {
    /// A set of points that are all different.
    pub fn new(points: &'a [[f64; D]]) -> Self {
        let extent = (0..D).fold(0.0_f64, |extent, k| {
            let (low, high) = points
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x[k]), high.max(x[k])));
            extent.max(high - low)
        });
        let tolerance = TOLERANCE * if extent > 0.0 { extent } else { 1.0 };
        let boxes = points.iter().enumerate().map(|(index, x)| (box_of(x, tolerance), index)).collect();
        Coincident { points, tolerance, boxes }
    }

    /// The number of the point at `x`.
    pub fn find(&self, x: &[f64; D]) -> Option<usize> {
        let own = box_of(x, self.tolerance);
        (0..3_usize.pow(D as u32)).find_map(|number| {
            let near = std::array::from_fn(|k| {
                own[k].saturating_add((number / 3_usize.pow(k as u32) % 3) as i64 - 1)
            });
            let index = self.boxes.get(&near).copied();
            index.filter(|&index| distance(&self.points[index..=index], x) <= self.tolerance)
        })
    }
}

fn box_of<const D: usize>(x: &[f64; D], size: f64) -> [i64; D] {
    x.map(|x| (x / size).floor() as i64)
}

/// To the nearest of some points.
pub fn distance<const D: usize>(points: &[[f64; D]], x: &[f64; D]) -> f64 {
    let square = |y: &[f64; D]| -> f64 { x.iter().zip(y).map(|(x, y)| (x - y) * (x - y)).sum() };
    points.iter().map(square).fold(f64::INFINITY, f64::min).sqrt()
}

//! Pieces on their way to groups: entities with nearly equal numbers of points make a group, so that lanes are filled.

use std::collections::BTreeMap;

use crate::element::CellShape;
use crate::lanes::WIDEST;

/// Common properties of a group's entities: the cells' shape, the facet's local number.
pub(super) type Key = (CellShape, Option<u8>);

/// Cells in the order of the walk with their points.
#[derive(Default)]
pub(super) struct Entry {
    cells: Vec<u32>,
    /// Numbers of points.
    counts: Vec<usize>,
    points: Vec<f64>,
}

pub(super) type Entries = BTreeMap<Key, Entry>;

pub(super) fn add_entry(entries: &mut Entries, key: Key, cell: u32, stride: usize, own: &[f64]) {
    if !own.is_empty() {
        let entry = entries.entry(key).or_default();
        entry.cells.push(cell);
        entry.counts.push(own.len() / stride);
        entry.points.extend_from_slice(own);
    }
}

/// Points of one batch that take as long as a further group.
const POINTS_OF_A_GROUP: usize = 32;

/// The numbers of points of groups for entities with these numbers, ascending: an entity joins the first group that has enough. Points of all batches
/// are as few as can be, so that lanes are filled where cells have many numbers of points.
fn numbers_of_groups(counts: &[usize]) -> Vec<usize> {
    let mut histogram = vec![0; counts.iter().max().map_or(0, |most| most + 1)];
    counts.iter().for_each(|count| histogram[*count] += 1);
    let entries: Vec<(usize, usize)> =
        histogram.into_iter().enumerate().filter(|(_, own)| *own > 0).collect();
    // Of the first entries: the least cost, and the start of the last group.
    let mut best = vec![(0, 0)];
    for (index, (count, _)) in entries.iter().enumerate() {
        let (mut least, mut entities) = ((usize::MAX, 0), 0);
        for start in (0..=index).rev() {
            entities += entries[start].1;
            let cost = best[start].0 + entities.div_ceil(WIDEST) * count + POINTS_OF_A_GROUP;
            least = least.min((cost, start));
        }
        best.push(least);
    }
    let (mut numbers, mut end) = (vec![], entries.len());
    while end > 0 {
        numbers.push(entries[end - 1].0);
        end = best[end].1;
    }
    numbers.reverse();
    numbers
}

impl Entry {
    /// Entities in groups with equal numbers of points, the last ones without weight where an entity has fewer.
    pub(super) fn grouped<const D: usize>(&self, stride: usize) -> Vec<(usize, Vec<u32>, Vec<f64>)> {
        let numbers = numbers_of_groups(&self.counts);
        let mut groups: Vec<_> = numbers.iter().map(|number| (*number, vec![], vec![])).collect();
        let mut start = 0;
        for (cell, count) in self.cells.iter().zip(&self.counts) {
            let own = &self.points[start..start + count * stride];
            start += own.len();
            let (number, cells, points) = &mut groups[numbers.partition_point(|number| number < count)];
            cells.push(*cell);
            points.extend_from_slice(own);
            for _ in *count..*number {
                points.extend_from_slice(&own[own.len() - stride..]);
                let weight = points.len() - stride + D;
                points[weight] = 0.0;
            }
        }
        groups
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_fill_lanes() {
        // A batch for each entity would take 1 + … + 8 points, one for all of them 8.
        assert_eq!(numbers_of_groups(&[3, 1, 8, 2, 5, 4, 7, 6]), [8]);
        // Many entities of two numbers stay apart.
        let counts: Vec<usize> = (0..4000).map(|k| if k % 2 == 0 { 3 } else { 60 }).collect();
        assert_eq!(numbers_of_groups(&counts), [3, 60]);
        assert!(numbers_of_groups(&[]).is_empty());
    }

    #[test]
    fn missing_points_have_no_weight() {
        let mut entries = Entries::new();
        add_entry(&mut entries, (CellShape::Triangle, None), 7, 3, &[0.1, 0.2, 0.5, 0.3, 0.4, 0.6]);
        add_entry(&mut entries, (CellShape::Triangle, None), 9, 3, &[0.7, 0.8, 0.9]);
        add_entry(&mut entries, (CellShape::Triangle, None), 11, 3, &[]);
        let groups = entries[&(CellShape::Triangle, None)].grouped::<2>(3);
        let points = vec![0.1, 0.2, 0.5, 0.3, 0.4, 0.6, 0.7, 0.8, 0.9, 0.7, 0.8, 0.0];
        assert_eq!(groups, [(2, vec![7, 9], points)]);
    }
}

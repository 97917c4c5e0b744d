//! Points of rules on the pieces of cut cells: made once for each rule, on all threads, and kept with the cut.

use std::sync::{Arc, Mutex, PoisonError};

use super::heights::{CellPolynomial, LineRules};
use super::{Cut, VertexValues};
use crate::element::CellShape;
use crate::quadrature::QuadratureRule;
use crate::threads::Threads;

/// A rule on the simplices of a cell's dimension, of a facet's, or on each line through a cell cut along heights.
#[derive(Clone)]
pub(crate) enum PieceRule<const D: usize> {
    Cells(QuadratureRule<D>),
    Facets(QuadratureRule<2>),
    Lines(LineRules),
}

/// Location of points, and the degree of the rule that they come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PointsOn {
    Inside(CellShape, usize),
    Interface(CellShape, usize),
}

/// The points on the pieces of some cells.
#[derive(Debug)]
pub(crate) struct CutPoints {
    cells: Vec<u32>,
    /// The end of each cell's numbers.
    ends: Vec<usize>,
    numbers: Vec<f64>,
}

impl CutPoints {
    /// The numbers of a cell, none for one without pieces.
    pub fn of(&self, cell: u32) -> &[f64] {
        match self.cells.binary_search(&cell) {
            Ok(index) => {
                let start = if index == 0 { 0 } else { self.ends[index - 1] };
                &self.numbers[start..self.ends[index]]
            }
            Err(_) => &[],
        }
    }
}

/// The points that were asked for so far.
#[derive(Debug, Default)]
pub(crate) struct KnownPoints(Mutex<Vec<(PointsOn, Arc<CutPoints>)>>);

impl Clone for KnownPoints {
    /// An empty list: another cut may have other cells.
    fn clone(&self) -> Self {
        KnownPoints::default()
    }
}

impl KnownPoints {
    fn find(&self, on: PointsOn) -> Option<Arc<CutPoints>> {
        let known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        known.iter().find(|(asked, _)| *asked == on).map(|(_, points)| Arc::clone(points))
    }

    /// Nothing is locked while points are made: a thread that waits for others may take up an assembly that asks, too.
    fn add(&self, on: PointsOn, points: CutPoints) -> Arc<CutPoints> {
        let points = Arc::new(points);
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        known.push((on, Arc::clone(&points)));
        points
    }
}

/// Cells below which another thread does not pay.
const PER_THREAD: usize = 128;

/// Numbers that `make` appends for each entry, in order, and the end of each; the same on any number of threads.
fn in_parts<T: Sync>(
    entries: &[T],
    threads: Threads,
    make: &(impl Fn(&T, &mut Vec<f64>) + Sync),
) -> (Vec<f64>, Vec<usize>) {
    let parts = threads.count().min(entries.len().div_ceil(PER_THREAD)).max(1);
    let ranges = (0..parts).map(|part| part * entries.len() / parts..(part + 1) * entries.len() / parts);
    let found = threads.run(ranges.collect(), |range| {
        let (mut numbers, mut ends) = (Vec::new(), Vec::with_capacity(range.len()));
        for entry in &entries[range] {
            make(entry, &mut numbers);
            ends.push(numbers.len());
        }
        (numbers, ends)
    });
    let mut found = found.into_iter();
    let (mut numbers, mut ends) = found.next().unwrap_or_default();
    for (further, own_ends) in found {
        let before = numbers.len();
        numbers.extend(further);
        ends.extend(own_ends.into_iter().map(|end| before + end));
    }
    (numbers, ends)
}

impl<const D: usize> Cut<D> {
    /// The points of a rule on the pieces of all cut cells of a shape: as [`VertexValues::points_inside`] and
    /// [`VertexValues::points_of_interface`] list them, and [`CellPolynomial`]. The rule is the one of the degree in `on`.
    pub(crate) fn points(&self, on: PointsOn, rule: &PieceRule<D>, threads: Threads) -> Arc<CutPoints> {
        if let Some(points) = self.known.find(on) {
            return points;
        }
        let (PointsOn::Inside(shape, _) | PointsOn::Interface(shape, _)) = on;
        let own = |cell: &u32| self.mesh.cell_shape(*cell as usize) == shape;
        let cells: Vec<u32> = self.cut.iter().copied().filter(own).collect();
        let (numbers, ends) = in_parts(&cells, threads, &|cell, numbers| match (rule, on) {
            (PieceRule::Cells(rule), _) => {
                VertexValues::<f64>::new(self, *cell).points_inside(rule, numbers);
            }
            (PieceRule::Facets(rule), _) => {
                VertexValues::<f64>::new(self, *cell).points_of_interface::<D>(rule, numbers);
            }
            (PieceRule::Lines(rule), PointsOn::Inside(..)) => {
                CellPolynomial::<f64>::new(self, *cell).points_inside::<D>(rule, numbers);
            }
            (PieceRule::Lines(rule), PointsOn::Interface(..)) => {
                CellPolynomial::<f64>::new(self, *cell).points_of_interface::<D>(rule, numbers);
            }
        });
        self.known.add(on, CutPoints { cells, ends, numbers })
    }
}

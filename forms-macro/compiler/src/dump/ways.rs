//! Ways of a backend to run a kernel other than direct loops, in operations per element: a reference tensor on affine
//! cells, sum factorisation on tensor-product cells. Fields at points are not in it: they are the same for all.

use crate::optimise::elements::StandardElement;
use crate::optimise::plan::Operations;
use crate::optimise::scalar::{Argument, Derivative, Graph, Node, Scalar};
use crate::sorted::SortedSet;

/// The derivatives of the test function or of the trial function that expressions read; `None` if there are second ones or means.
pub fn slots(graph: &Graph, roots: &[Scalar], argument: Argument) -> Option<SortedSet<Derivative>> {
    let mut slots = SortedSet::new();
    for scalar in graph.reachable(roots) {
        match graph.node(scalar) {
            Node::Basis(_, Derivative::Second(..) | Derivative::MeanValue | Derivative::MeanFirst(_)) => {
                return None;
            }
            Node::Basis(of, derivative) if *of == argument => {
                slots.insert(*derivative);
            }
            _ => {}
        }
    }
    Some(slots)
}

/// Geometry and coefficients once per cell, for each pair of derivatives on the reference cell; then, per pair of nodes,
/// a sum over these per entry of the block. The tensor's own zeros are not known here: a bound.
pub fn reference_tensor(
    operations: &Operations,
    [tests, trials]: [usize; 2],
    entries: usize,
    element: &StandardElement,
    symmetric: bool,
) -> usize {
    let Operations { point, test, trial, pair, finish } = operations;
    let pairs =
        if symmetric { element.nodes * (element.nodes + 1) / 2 } else { element.nodes * element.nodes };
    let cell = point + tests * test + trials * trial + tests * trials * (pair + finish);
    cell + pairs * tests * trials * entries
}

/// Coefficients at each point for each pair of derivatives, then one axis after the other for each entry of the block.
pub fn factorised_matrix(
    operations: &Operations,
    slots: [&SortedSet<Derivative>; 2],
    entries: usize,
    element: &StandardElement,
    points: usize,
) -> usize {
    let Operations { point, test, trial, pair, finish } = operations;
    let [tests, trials] = slots.map(SortedSet::len);
    let at_points = points * (point + tests * test + trials * trial + tests * trials * (pair + finish));
    let (nodes, along) = (element.degree + 1, root(points, element.dimension));
    let stages = (0..element.dimension).map(|axis| {
        let kinds: usize = slots.iter().map(|slots| remaining(slots, axis)).product();
        let (done, left) = (axis + 1, element.dimension - axis);
        kinds * nodes.pow(2 * done as u32) * along.pow(left as u32)
    });
    at_points + entries * stages.sum::<usize>()
}

/// The flux at each point, then one axis after the other for each component.
pub fn factorised_vector(
    [point, test]: [usize; 2],
    slots: &SortedSet<Derivative>,
    components: usize,
    element: &StandardElement,
    points: usize,
) -> usize {
    let (nodes, along) = (element.degree + 1, root(points, element.dimension));
    let stages = (0..element.dimension).map(|axis| {
        let (done, left) = (axis + 1, element.dimension - axis);
        remaining(slots, axis) * nodes.pow(done as u32) * along.pow(left as u32)
    });
    points * (point + slots.len() * test) + components * stages.sum::<usize>()
}

/// The number of kinds of derivatives that are left when the axes before one have been summed over: those along them are no
/// longer told apart from values.
fn remaining(slots: &SortedSet<Derivative>, axis: usize) -> usize {
    let kinds = slots.iter().map(|slot| match slot {
        Derivative::First(along) if *along >= axis => Some(*along),
        _ => None,
    });
    kinds.collect::<SortedSet<_>>().len()
}

/// Points along one axis.
fn root(points: usize, dimension: usize) -> usize {
    (1..).find(|along: &usize| along.pow(dimension as u32) >= points).unwrap_or(1)
}

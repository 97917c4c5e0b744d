//! Fields at points, interpolated from nodal values without the contract.

use super::Nodal;
use super::mesh::Place;

/// A component of a field at a point of a place.
pub fn value<const D: usize>(place: &Place<D>, point: usize, field: &Nodal, component: usize) -> f64 {
    let nodes = place.nodes.iter().zip(&place.points[point].basis);
    nodes.map(|(node, basis)| basis.value * field.values[node * field.components + component]).sum()
}
/// Its derivative along an axis.
pub fn slope<const D: usize>(
    place: &Place<D>,
    point: usize,
    field: &Nodal,
    component: usize,
    axis: usize,
) -> f64 {
    let nodes = place.nodes.iter().zip(&place.points[point].basis);
    nodes.map(|(node, basis)| basis.gradient[axis] * field.values[node * field.components + component]).sum()
}
/// The gradient of a scalar field.
pub fn gradient<const D: usize>(place: &Place<D>, point: usize, field: &Nodal) -> Vec<f64> {
    (0..D).map(|axis| slope(place, point, field, 0, axis)).collect()
}

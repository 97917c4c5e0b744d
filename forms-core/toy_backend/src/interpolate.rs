//! Fields at points, interpolated from nodal values without the contract.

use super::Nodal;
use super::mesh::Element;

/// A component of a field at a point of an element.
pub fn value<const D: usize>(element: &Element<D>, point: usize, field: &Nodal, component: usize) -> f64 {
    let nodes = element.nodes.iter().zip(&element.points[point].basis);
    nodes.map(|(node, basis)| basis.value * field.values[node * field.components + component]).sum()
}
/// The derivative along an axis.
pub fn slope<const D: usize>(
    element: &Element<D>,
    point: usize,
    field: &Nodal,
    component: usize,
    axis: usize,
) -> f64 {
    let nodes = element.nodes.iter().zip(&element.points[point].basis);
    nodes.map(|(node, basis)| basis.gradient[axis] * field.values[node * field.components + component]).sum()
}
/// The gradient of a scalar field.
pub fn gradient<const D: usize>(element: &Element<D>, point: usize, field: &Nodal) -> Vec<f64> {
    (0..D).map(|axis| slope(element, point, field, 0, axis)).collect()
}

//! Some cells, one per lane: geometry, basis functions and fields at their points, in arrays of known lengths.

// Closures and iterator adaptors do not inherit a caller's target features, and copies of slices may become calls:
// loops over lane values are plain.
#![allow(clippy::needless_range_loop, clippy::manual_memcpy)]

use forms_core::contract::{
    Basis, CellGeometry, FieldSlot, OppositePoint, Order, PointGeometry, Requirements,
};

use super::tables::{FieldTables, FixedTables};
use crate::assemble::batch::{inverse_transposed, largest_distance, surface};
use crate::assemble::element_kernel::ElementCells;
use crate::assemble::element_kernel::sizes::{Array, Sizes};
use crate::element::Tables;
use crate::lanes::{SimdLane, Starts};

/// Memory of a batch, kept from one run to the next.
pub(super) struct FieldBuffers<L> {
    /// Coefficients per slot, node × component; only the first slot of a field has any.
    coefficients: Vec<Vec<L>>,
    pub fields: Vec<L>,
}

/// A batch of cells, with loops of fixed lengths.
pub(super) struct FixedBatch<'a, L: SimdLane, S: Sizes, const D: usize> {
    tables: &'a FixedTables<S, D>,
    nodes: S::GeometryNodes<[L; D]>,
    /// Of affine cells.
    affine: PointMap<L, D>,
}

/// The map at a point.
#[derive(Clone, Copy)]
pub(super) struct PointMap<L, const D: usize> {
    /// Weight of the point without its quadrature weight.
    measure: L,
    pub determinant: L,
    /// J⁻ᵀ.
    pub inverse: [[L; D]; D],
    normal: [L; D],
}

impl<L: SimdLane> FieldBuffers<L> {
    /// Room for what a kernel reads.
    pub fn new<S: Sizes, const D: usize>(requirements: &Requirements, tables: &FixedTables<S, D>) -> Self {
        let zero = L::splat(0.0);
        let coefficients = requirements.fields.iter().map(|slot| {
            let nodes = tables.fields[slot.field].as_ref().map_or(0, |field| field.tables.nodes);
            vec![zero; nodes * slot.components]
        });
        FieldBuffers { coefficients: coefficients.collect(), fields: vec![zero; requirements.field_length] }
    }
}

impl<'a, L: SimdLane, S: Sizes, const D: usize> FixedBatch<'a, L, S, D> {
    /// Loads `filled` cells from `start` on.
    #[inline(always)]
    pub fn load(
        requirements: &Requirements,
        tables: &'a FixedTables<S, D>,
        cells: &ElementCells,
        start: usize,
        filled: usize,
        buffers: &mut FieldBuffers<L>,
    ) -> Self {
        let zero = L::splat(0.0);
        let mut nodes = S::GeometryNodes::filled([zero; D]);
        let (offsets, nodes_mut) = (tables.coordinate_offsets.entries(), nodes.entries_mut());
        let starts = Starts::new::<L>(start, filled, tables.coordinate_stride);
        for node in 0..nodes_mut.len() {
            nodes_mut[node] = L::gather_from(cells.coordinates, &starts, offsets[node]);
        }
        if !requirements.fields.is_empty() {
            let starts = Starts::new::<L>(start, filled, tables.coefficient_stride);
            for index in 0..requirements.fields.len() {
                let slot = &requirements.fields[index];
                let Some(field) = &tables.fields[slot.field] else { continue };
                if first_slot(requirements, index) == index {
                    let target = &mut buffers.coefficients[index];
                    gather_field(cells.coefficients, &starts, &field.offsets, slot.components, target);
                }
            }
        }
        let none = PointMap { measure: zero, determinant: zero, inverse: [[zero; D]; D], normal: [zero; D] };
        let mut batch = FixedBatch { tables, nodes, affine: none };
        if const { FixedTables::<S, D>::AFFINE } {
            batch.affine = batch.map_of(&batch.edges());
        }
        batch
    }

    /// The map at the q-th point.
    #[inline(always)]
    pub fn map_at(&self, q: usize) -> PointMap<L, D> {
        if const { FixedTables::<S, D>::AFFINE } {
            self.affine
        } else {
            self.map_of(&self.jacobian(self.tables.geometry.slopes.entries()[q].entries()))
        }
    }

    #[inline(always)]
    fn map_of(&self, jacobian: &[[L; D]; D]) -> PointMap<L, D> {
        let (determinant, inverse) = inverse_transposed(jacobian);
        let (measure, normal) = match &self.tables.tangents {
            None => (determinant, [L::splat(0.0); D]),
            Some(tangents) => surface(jacobian, tangents),
        };
        PointMap { measure, determinant, inverse, normal }
    }

    /// ∂x_i/∂ξ_j of affine cells: the edges from the first vertex.
    #[inline(always)]
    fn edges(&self) -> [[L; D]; D] {
        let mut jacobian = [[L::splat(0.0); D]; D];
        let nodes = self.nodes.entries();
        for i in 0..D {
            for j in 0..D {
                jacobian[i][j] = nodes[j + 1][i] - nodes[0][i];
            }
        }
        jacobian
    }

    /// ∂x_i/∂ξ_j.
    #[inline(always)]
    fn jacobian(&self, slopes: &[[f64; D]]) -> [[L; D]; D] {
        let mut jacobian = [[L::splat(0.0); D]; D];
        let nodes = self.nodes.entries();
        let slopes = &slopes[..nodes.len()];
        for node in 0..nodes.len() {
            for i in 0..D {
                for j in 0..D {
                    jacobian[i][j] = nodes[node][i].multiply_add(L::splat(slopes[node][j]), jacobian[i][j]);
                }
            }
        }
        jacobian
    }

    /// The quantities that are constant on the cells.
    #[inline(always)]
    pub fn cell_geometry(&self, requirements: &Requirements) -> CellGeometry<L> {
        let zero = L::splat(0.0);
        let mut geometry = CellGeometry {
            diameter: zero,
            cell_volume: zero,
            facet_area: zero,
            opposite_diameter: zero,
            opposite_volume: zero,
        };
        if requirements.diameter {
            geometry.diameter = largest_distance(&self.nodes.entries()[..self.tables.vertices]);
        }
        if requirements.cell_volume {
            let measure = &self.tables.measure;
            geometry.cell_volume = if const { FixedTables::<S, D>::AFFINE } {
                self.affine.determinant * L::splat(total(&measure.cell_weights))
            } else {
                let mut volume = zero;
                for q in 0..measure.cell_weights.len() {
                    let (determinant, _) = inverse_transposed(&self.jacobian(row(&measure.cell, q)));
                    volume = determinant.multiply_add(L::splat(measure.cell_weights[q]), volume);
                }
                volume
            };
        }
        if requirements.facet_area
            && let (Some((map, weights)), Some(tangents)) =
                (&self.tables.measure.facet, &self.tables.tangents)
        {
            geometry.facet_area = if const { FixedTables::<S, D>::AFFINE } {
                self.affine.measure * L::splat(total(weights))
            } else {
                let mut area = zero;
                for q in 0..weights.len() {
                    let (element, _) = surface(&self.jacobian(row(map, q)), tangents);
                    area = element.multiply_add(L::splat(weights[q]), area);
                }
                area
            };
        }
        geometry
    }

    /// The q-th point, and the fields there.
    #[inline(always)]
    pub fn point(
        &self,
        requirements: &Requirements,
        q: usize,
        map: &PointMap<L, D>,
        buffers: &mut FieldBuffers<L>,
    ) -> PointGeometry<L, D> {
        let zero = L::splat(0.0);
        let mut position = [zero; D];
        if requirements.position {
            let (nodes, values) = (self.nodes.entries(), &self.tables.geometry.values.entries()[q]);
            for node in 0..nodes.len() {
                for axis in 0..D {
                    position[axis] =
                        nodes[node][axis].multiply_add(L::splat(values.entries()[node]), position[axis]);
                }
            }
        }
        // One by one, so that each is compiled for its slot.
        macro_rules! evaluate {
            ($($index:literal)*) => {
                $(if requirements.fields.len() > $index {
                    self.evaluate_slot(requirements, $index, q, map, buffers);
                })*
            };
        }
        evaluate!(0 1 2 3);
        for index in 4..requirements.fields.len() {
            self.evaluate_slot(requirements, index, q, map, buffers);
        }
        PointGeometry {
            weight: map.measure * L::splat(self.tables.weights.entries()[q]),
            position,
            normal: map.normal,
            curvature: zero,
            opposite: OppositePoint::none(),
        }
    }

    #[inline(always)]
    fn evaluate_slot(
        &self,
        requirements: &Requirements,
        index: usize,
        q: usize,
        map: &PointMap<L, D>,
        buffers: &mut FieldBuffers<L>,
    ) {
        let slot = &requirements.fields[index];
        let Some(field) = &self.tables.fields[slot.field] else { return };
        let FieldBuffers { coefficients, fields } = buffers;
        let coefficients = &coefficients[first_slot(requirements, index)][..];
        let target = &mut fields[slot.offset..];
        match slot.components {
            1 => self.interpolate::<1>(slot, field, q, map, coefficients, target),
            2 => self.interpolate::<2>(slot, field, q, map, coefficients, target),
            _ => self.interpolate::<3>(slot, field, q, map, coefficients, target),
        }
    }

    #[inline(always)]
    fn interpolate<const C: usize>(
        &self,
        slot: &FieldSlot,
        field: &FieldTables<D>,
        q: usize,
        map: &PointMap<L, D>,
        coefficients: &[L],
        target: &mut [L],
    ) {
        let arguments = &self.tables.arguments;
        match (slot.order, field.as_arguments) {
            (Order::Value, true) => {
                value::<L, C>(arguments.values.entries()[q].entries(), coefficients, target)
            }
            (Order::Value, false) => {
                let nodes = field.tables.nodes;
                value::<L, C>(&field.tables.value[q * nodes..][..nodes], coefficients, target);
            }
            (_, true) => gradient::<L, C, D>(
                arguments.slopes.entries()[q].entries(),
                &map.inverse,
                coefficients,
                target,
            ),
            (_, false) => {
                gradient::<L, C, D>(row(&field.tables, q), &map.inverse, coefficients, target);
            }
        }
    }

    /// Values and gradients of the test functions at the q-th point.
    #[inline(always)]
    pub fn evaluate_basis(
        &self,
        requirements: &Requirements,
        q: usize,
        map: &PointMap<L, D>,
        basis: &mut S::Nodes<Basis<L, D>>,
    ) {
        let arguments = &self.tables.arguments;
        let values = arguments.values.entries()[q].entries();
        let slopes = arguments.slopes.entries()[q].entries();
        let basis = basis.entries_mut();
        let (values, slopes) = (&values[..basis.len()], &slopes[..basis.len()]);
        for node in 0..basis.len() {
            if requirements.basis_value {
                basis[node].value = L::splat(values[node]);
            }
            if requirements.basis_gradient && const { FixedTables::<S, D>::LINEAR } {
                basis[node].gradient = barycentric(&map.inverse, node);
            } else if requirements.basis_gradient {
                basis[node].gradient = transformed(&map.inverse, &slopes[node]);
            }
        }
    }
}

/// The gradient of a barycentric coordinate of a straight simplex.
#[inline(always)]
fn barycentric<L: SimdLane, const D: usize>(inverse: &[[L; D]; D], vertex: usize) -> [L; D] {
    let mut gradient = [L::splat(0.0); D];
    for i in 0..D {
        gradient[i] = if vertex > 0 { inverse[i][vertex - 1] } else { -sum(&inverse[i]) };
    }
    gradient
}

#[inline(always)]
fn sum<L: SimdLane, const D: usize>(terms: &[L; D]) -> L {
    let mut sum = terms[0];
    for k in 1..D {
        sum += terms[k];
    }
    sum
}

/// J⁻ᵀ ∇φ.
#[inline(always)]
fn transformed<L: SimdLane, const D: usize>(inverse: &[[L; D]; D], slope: &[f64; D]) -> [L; D] {
    let mut gradient = [L::splat(0.0); D];
    for i in 0..D {
        gradient[i] = inverse[i][0] * L::splat(slope[0]);
        for j in 1..D {
            gradient[i] = inverse[i][j].multiply_add(L::splat(slope[j]), gradient[i]);
        }
    }
    gradient
}

/// Σ over nodes of coefficient × basis function.
#[inline(always)]
fn value<L: SimdLane, const C: usize>(values: &[f64], coefficients: &[L], target: &mut [L]) {
    let coefficients = &coefficients[..values.len() * C];
    let mut sums = [L::splat(0.0); C];
    for node in 0..values.len() {
        for component in 0..C {
            sums[component] =
                coefficients[node * C + component].multiply_add(L::splat(values[node]), sums[component]);
        }
    }
    let target = &mut target[..C];
    for component in 0..C {
        target[component] = sums[component];
    }
}

/// The gradient in reference coordinates, then in physical ones.
#[inline(always)]
fn gradient<L: SimdLane, const C: usize, const D: usize>(
    slopes: &[[f64; D]],
    inverse: &[[L; D]; D],
    coefficients: &[L],
    target: &mut [L],
) {
    let coefficients = &coefficients[..slopes.len() * C];
    let mut sums = [[L::splat(0.0); D]; C];
    for node in 0..slopes.len() {
        for component in 0..C {
            for j in 0..D {
                sums[component][j] = coefficients[node * C + component]
                    .multiply_add(L::splat(slopes[node][j]), sums[component][j]);
            }
        }
    }
    let target = &mut target[..C * D];
    for component in 0..C {
        for i in 0..D {
            let mut sum = inverse[i][0] * sums[component][0];
            for j in 1..D {
                sum = inverse[i][j].multiply_add(sums[component][j], sum);
            }
            target[component * D + i] = sum;
        }
    }
}

/// The first slot that reads the field of a slot: coefficients are loaded once.
#[inline(always)]
fn first_slot(requirements: &Requirements, index: usize) -> usize {
    let mut first = 0;
    while requirements.fields[first].field != requirements.fields[index].field {
        first += 1;
    }
    first
}

#[inline(always)]
fn gather_field<L: SimdLane>(
    values: &[f64],
    starts: &Starts,
    offsets: &[usize],
    components: usize,
    target: &mut [L],
) {
    let target = &mut target[..offsets.len() * components];
    for node in 0..offsets.len() {
        let target = &mut target[node * components..][..components];
        match target {
            [a] => [*a] = L::gather_from(values, starts, offsets[node]),
            [a, b] => [*a, *b] = L::gather_from(values, starts, offsets[node]),
            [a, b, c] => [*a, *b, *c] = L::gather_from(values, starts, offsets[node]),
            _ => {}
        }
    }
}

/// Slopes at the q-th point of a table.
#[inline(always)]
fn row<const D: usize>(tables: &Tables<D>, q: usize) -> &[[f64; D]] {
    &tables.gradient[q * tables.nodes..][..tables.nodes]
}

#[inline(always)]
fn total(weights: &[f64]) -> f64 {
    let mut sum = 0.0;
    for weight in weights {
        sum += *weight;
    }
    sum
}

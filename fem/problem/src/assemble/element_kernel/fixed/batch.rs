//! Some cells, one per lane: geometry and basis functions at their points, in arrays of known lengths.

// Closures and iterator adaptors do not inherit a caller's target features, and copies of slices may become calls:
// loops over lane values are plain.
#![allow(clippy::needless_range_loop, clippy::manual_memcpy)]

use forms_core::contract::{Basis, CellGeometry, OppositePoint, PointGeometry, Requirements};

use super::field_buffers::{FieldBuffers, Numbers};
use super::tables::{FixedTables, MOST_CORNERS, corner};
use crate::assemble::batch::{inverse_transposed, largest_distance, surface};
use crate::assemble::element_kernel::ElementCells;
use crate::assemble::element_kernel::sizes::{Array, Sizes};
use crate::element::Tables;
use crate::lanes::{SimdLane, Starts};

/// A batch of cells, with loops of fixed lengths.
#[derive(Clone, Copy)]
pub(super) struct FixedBatch<'a, L: SimdLane, S: Sizes, const D: usize> {
    pub tables: &'a FixedTables<S, D>,
    nodes: S::GeometryNodes<[L; D]>,
    /// Of multilinear maps the coefficients of products of coordinates, by [`corner`].
    products: S::GeometryNodes<[L; D]>,
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

impl<'a, L: SimdLane, S: Sizes, const D: usize> FixedBatch<'a, L, S, D> {
    /// Data of `filled` cells from `start` on, loaded.
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
            buffers.load(requirements, tables, cells.coefficients, &starts);
        }
        let none = PointMap { measure: zero, determinant: zero, inverse: [[zero; D]; D], normal: [zero; D] };
        let mut batch = FixedBatch { tables, nodes, products: nodes, affine: none };
        if const { FixedTables::<S, D>::AFFINE } {
            batch.affine = batch.map_of(&batch.edges());
        }
        if const { FixedTables::<S, D>::MULTILINEAR } {
            batch.products = products::<L, S, D>(&nodes);
        }
        batch
    }

    /// The map at the q-th point.
    #[inline(always)]
    pub fn map_at(&self, q: usize) -> PointMap<L, D> {
        if const { FixedTables::<S, D>::AFFINE } {
            self.affine
        } else if const { FixedTables::<S, D>::MULTILINEAR } {
            self.map_of(&self.multilinear_jacobian(&self.tables.monomials.entries()[q]))
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

    /// ∂x_i/∂ξ_j of multilinear maps, from the products of coordinates at a point: a derivative has half of the terms.
    #[inline(always)]
    fn multilinear_jacobian(&self, monomials: &[f64; MOST_CORNERS]) -> [[L; D]; D] {
        let mut jacobian = [[L::splat(0.0); D]; D];
        let products = self.products.entries();
        for j in 0..D {
            for i in 0..D {
                jacobian[i][j] = products[1 << j][i];
            }
            for product in (1 << j) + 1..1 << D {
                if product >> j & 1 == 1 {
                    let monomial = L::splat(monomials[product - (1 << j)]);
                    for i in 0..D {
                        jacobian[i][j] = products[product][i].multiply_add(monomial, jacobian[i][j]);
                    }
                }
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
                self.affine.determinant * L::splat(self.tables.reference_measure[0])
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
                self.affine.measure * L::splat(self.tables.reference_measure[1])
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
        buffers: &FieldBuffers<L>,
        numbers: &mut Numbers<L>,
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
                    self.evaluate_slot(requirements, $index, q, map, buffers, numbers);
                })*
            };
        }
        evaluate!(0 1 2 3);
        for index in 4..requirements.fields.len() {
            self.evaluate_slot(requirements, index, q, map, buffers, numbers);
        }
        PointGeometry {
            weight: map.measure * L::splat(self.tables.weights.entries()[q]),
            position,
            normal: map.normal,
            curvature: zero,
            opposite: OppositePoint::none(),
        }
    }

    /// Value and gradient of a test function at the q-th point.
    #[inline(always)]
    pub fn basis(
        &self,
        requirements: &Requirements,
        q: usize,
        map: &PointMap<L, D>,
        node: usize,
    ) -> Basis<L, D> {
        let arguments = &self.tables.arguments;
        let zero = L::splat(0.0);
        let mut basis = Basis { value: zero, gradient: [zero; D] };
        if requirements.basis_value {
            basis.value = L::splat(arguments.values.entries()[q].entries()[node]);
        }
        if requirements.basis_gradient && const { FixedTables::<S, D>::LINEAR } {
            basis.gradient = barycentric(&map.inverse, node);
        } else if requirements.basis_gradient {
            basis.gradient = transformed(&map.inverse, &arguments.slopes.entries()[q].entries()[node]);
        }
        basis
    }
}

/// Of a multilinear map, from its corners: the coefficients of the products of coordinates, whose axes are the bits of their numbers.
#[inline(always)]
fn products<L: SimdLane, S: Sizes, const D: usize>(
    nodes: &S::GeometryNodes<[L; D]>,
) -> S::GeometryNodes<[L; D]> {
    let mut products = *nodes;
    let (nodes, coefficients) = (nodes.entries(), products.entries_mut());
    for node in 0..1 << D {
        coefficients[corner(node)] = nodes[node];
    }
    for axis in 0..D {
        for product in 0..1 << D {
            if product >> axis & 1 == 1 {
                for i in 0..D {
                    coefficients[product][i] =
                        coefficients[product][i] - coefficients[product - (1 << axis)][i];
                }
            }
        }
    }
    products
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

/// Slopes at the q-th point of a table.
#[inline(always)]
pub(super) fn row<const D: usize>(tables: &Tables<D>, q: usize) -> &[[f64; D]] {
    &tables.gradient[q * tables.nodes..][..tables.nodes]
}

//! The points of contact pairs: each lane has its own on both sides, so that basis functions are evaluated in lanes and
//! not read from tables.

// Closures and iterator adaptors do not inherit a caller's target features, and copies of slices may become calls:
// loops over lane values are plain.
#![allow(clippy::needless_range_loop, clippy::manual_memcpy)]

use forms_core::contract::{PointGeometry, Requirements};

use super::Batch;
use super::cell_map::{curvature, inverse_transposed, shape_operator, surface, tangential};
use super::side::{SideBuffers, SideTables};
use crate::assemble::AssemblyError;
use crate::assemble::batch::basis_in_lanes::{LaneBasis, LaneElement};
use crate::assemble::groups::dual_functions::{DualFunctions, MOST_FUNCTIONS};
use crate::assemble::groups::pair_groups::PairTables;
use crate::lanes::{SimdLane, WIDEST};
use crate::pairs::PairGroup;

/// Basis functions at points of a pair.
pub(super) struct PairBuffers<L, const D: usize> {
    /// Of the geometry map.
    geometry: LaneBasis<L, D>,
    /// Of another element.
    basis: LaneBasis<L, D>,
}

impl<L, const D: usize> Default for PairBuffers<L, D> {
    fn default() -> Self {
        PairBuffers { geometry: LaneBasis::default(), basis: LaneBasis::default() }
    }
}

/// A point of a facet, or inside a cell, seen from the cell.
pub(super) struct FacetPoint<L, const D: usize> {
    pub position: [L; D],
    /// Surface element and outward unit normal; zero inside a cell.
    pub element: L,
    pub normal: [L; D],
    pub curvature: L,
    /// ∇n along the facet.
    shape_operator: [[L; D]; D],
}

impl<L: SimdLane, const D: usize> Batch<'_, L, D> {
    /// Moves to the q-th point of each unit.
    #[inline(always)]
    pub(super) fn pair_point(
        &mut self,
        requirements: &Requirements,
        q: usize,
        pairs: &PairTables<D>,
    ) -> Result<(), AssemblyError> {
        let (stride, points, motion) = (PairGroup::<D>::STRIDE, &pairs.group.points, &pairs.group.motion);
        let slopes = match L::DIRECTIONS {
            2 => motion.slopes.each_ref().map(|slopes| &slopes[..]),
            _ => [&motion.slopes[self.direction][..], &motion.bends],
        };
        let mut places = [0; WIDEST];
        for lane in 0..L::WIDTH {
            let unit = self.start + lane.min(self.filled - 1);
            places[lane] = (unit * pairs.group.count + q) * stride;
        }
        let own = L::gather_with_slopes::<D>(points, slopes, &places);
        let mut later = places;
        for lane in 0..L::WIDTH {
            later[lane] += D;
        }
        let opposite = L::gather_with_slopes::<D>(points, slopes, &later);
        for lane in 0..L::WIDTH {
            later[lane] += D;
        }
        let [weight, gap] = L::gather_with_slopes::<2>(points, slopes, &later);
        for lane in 0..L::WIDTH {
            later[lane] += 2;
        }
        let toward = L::gather_with_slopes::<D>(points, slopes, &later);
        let normals = &pairs.group.rigid_normals;
        let rigid = if normals.is_empty() {
            None
        } else {
            for lane in 0..L::WIDTH {
                later[lane] = places[lane] / stride * D;
            }
            Some(L::gather::<D>(normals, &later))
        };
        let lanes = [0, 1].map(|side: usize| (&pairs.geometry[side], &pairs.elements[side][..]));
        let this = self.facet_point(requirements, 0, &own, lanes[0], None, &pairs.dual);
        let other = self.facet_point(requirements, 1, &opposite, lanes[1], rigid, &[]);
        // Part by part: the whole is long, and would be copied.
        let PointGeometry { weight: measure, position, normal, curvature, opposite } =
            &mut self.buffers.geometry;
        *measure = weight * this.element;
        (*position, *normal, *curvature) = (this.position, this.normal, this.curvature);
        (opposite.gap, opposite.toward) = (gap, toward);
        (opposite.position, opposite.normal) = (other.position, other.normal);
        if requirements.opposite_shape_operator {
            opposite.shape_operator = other.shape_operator;
        }
        self.evaluate_fields(requirements, q, &this.position, &other.position)
    }

    /// Geometry and basis functions on one side, by the map's and the other elements' functions; the normal of a rigid surface is none of its cell's facets'.
    /// Of each element, there may be dual functions of the units' covers.
    #[inline(always)]
    pub(super) fn facet_point(
        &mut self,
        requirements: &Requirements,
        side: usize,
        reference: &[L; D],
        (of_map, elements): (&LaneElement, &[LaneElement]),
        rigid_normal: Option<[L; D]>,
        dual: &[Option<DualFunctions>],
    ) -> FacetPoint<L, D> {
        let zero = L::splat(0.0);
        let read = [requirements.position, requirements.opposite_position][side];
        let placed = read || self.reads_functions(requirements) || self.tables[side].group.centre.is_some();
        let (start, last) = (self.start, self.filled - 1);
        let reads = &self.buffers.reads[side];
        let PairBuffers { geometry, basis } = &mut self.buffers.pairs;
        let (tables, buffers) = (&self.tables[side], &mut self.buffers.sides[side]);
        let bent = requirements.curvature && side == 0 && !self.binding.mesh.has_affine_facets();
        let flat = tables.affine || rigid_normal.is_some();
        let turning = requirements.opposite_shape_operator && side == 1 && !flat;
        let mut second = bent || turning;
        for index in 0..reads.len() {
            second |= reads[index].hessian;
        }
        // An affine map is known, except for the place of the point.
        if placed || second || !tables.affine {
            evaluate(of_map, reference, if second { 2 } else { 1 }, geometry);
        }
        let mut position = [zero; D];
        if placed {
            for node in 0..geometry.value.len() {
                for axis in 0..D {
                    position[axis] =
                        buffers.nodes[node][axis].multiply_add(geometry.value[node], position[axis]);
                }
            }
        }
        if !tables.affine {
            let mut jacobian = [[zero; D]; D];
            for node in 0..geometry.gradient.len() {
                for i in 0..D {
                    for j in 0..D {
                        jacobian[i][j] =
                            buffers.nodes[node][i].multiply_add(geometry.gradient[node][j], jacobian[i][j]);
                    }
                }
            }
            buffers.jacobian = jacobian;
            (buffers.determinant, buffers.inverse) = inverse_transposed(&jacobian);
            self.least = self.least.minimum(buffers.determinant);
        }
        let mut point = FacetPoint {
            position,
            element: zero,
            normal: [zero; D],
            curvature: zero,
            shape_operator: [[zero; D]; D],
        };
        if let Some(normal) = rigid_normal {
            point.normal = normal;
        } else if let Some((_, tangents)) = &tables.group.facet {
            (point.element, point.normal) = match (&self.affine, side) {
                (Some(affine), 0) => (affine.measure, affine.normal),
                // The other side's element counts nowhere.
                (Some(affine), _) => (zero, affine.opposite_normal),
                (None, _) => surface(&buffers.jacobian, tangents),
            };
            if bent || turning {
                let mut along = [zero; 3];
                for node in 0..geometry.hessian.len() {
                    let mut x = zero;
                    for axis in 0..D {
                        x = buffers.nodes[node][axis].multiply_add(point.normal[axis], x);
                    }
                    for i in 0..D {
                        for j in 0..D {
                            let entry = x * geometry.hessian[node][i][j];
                            for (k, [a, b]) in [[0, 0], [0, 1], [1, 1]].into_iter().enumerate() {
                                let factor = L::splat(tangents[a][i] * tangents[b][j]);
                                along[k] = entry.multiply_add(factor, along[k]);
                            }
                        }
                    }
                }
                if bent {
                    point.curvature = curvature(&along, &buffers.jacobian, tangents);
                } else {
                    point.shape_operator = shape_operator(&along, &buffers.jacobian, tangents);
                }
            }
        }
        for index in 0..reads.len() {
            let reads = reads[index];
            if !reads.value && !reads.gradient && !reads.hessian {
                continue;
            }
            if buffers.is_in_space(tables, index) {
                buffers.evaluate_in_space(tables, index, &position);
                continue;
            }
            let order = if reads.hessian { 2 } else { usize::from(reads.gradient) };
            evaluate(&elements[index], reference, order, basis);
            if let Some(Some(dual)) = dual.get(index) {
                let mut units = [0; WIDEST];
                for lane in 0..L::WIDTH {
                    units[lane] = start + lane.min(last);
                }
                combine(basis, dual, &units);
            }
            take_basis(buffers, tables, index, basis, &point.normal);
            if reads.hessian {
                take_hessians(buffers, tables, index, basis, geometry);
            }
        }
        point
    }
}

/// Derivatives of an element's functions up to an order.
#[inline(always)]
fn evaluate<L: SimdLane, const D: usize>(
    element: &LaneElement,
    point: &[L; D],
    order: usize,
    basis: &mut LaneBasis<L, D>,
) {
    match order {
        0 => element.evaluate::<L, 0, D>(point, basis),
        1 => element.evaluate::<L, 1, D>(point, basis),
        _ => element.evaluate::<L, 2, D>(point, basis),
    }
}

/// Dual functions of the units' covers in the place of those to which they are dual.
#[inline(always)]
fn combine<L: SimdLane, const D: usize>(
    basis: &mut LaneBasis<L, D>,
    dual: &DualFunctions,
    units: &[usize; WIDEST],
) {
    let (zero, count) = (L::splat(0.0), basis.value.len());
    let mut values = [zero; MOST_FUNCTIONS];
    let mut gradients = [[zero; D]; MOST_FUNCTIONS];
    let mut places = [0; WIDEST];
    for i in 0..count {
        for j in 0..count {
            for lane in 0..L::WIDTH {
                places[lane] = (units[lane] * count + i) * count + j;
            }
            let [factor] = L::gather::<1>(&dual.matrices, &places);
            values[i] = factor.multiply_add(basis.value[j], values[i]);
            if basis.gradient.len() == count {
                for axis in 0..D {
                    gradients[i][axis] = factor.multiply_add(basis.gradient[j][axis], gradients[i][axis]);
                }
            }
        }
    }
    for i in 0..count {
        basis.value[i] = values[i];
    }
    for i in 0..basis.gradient.len() {
        basis.gradient[i] = gradients[i];
    }
}

/// Values of an element's functions, and physical gradients where there are gradients.
#[inline(always)]
fn take_basis<L: SimdLane, const D: usize>(
    side: &mut SideBuffers<L, D>,
    tables: &SideTables<D>,
    index: usize,
    basis: &LaneBasis<L, D>,
    normal: &[L; D],
) {
    let inverse = side.inverse;
    let on_facets = tables.elements[index].on_facets;
    for node in 0..basis.value.len() {
        side.basis[index][node].value = basis.value[node];
    }
    for node in 0..basis.gradient.len() {
        let slopes = &basis.gradient[node];
        let mut gradient = [L::splat(0.0); D];
        for i in 0..D {
            if tables.affine {
                for j in 0..D {
                    gradient[i] = slopes[j].multiply_add_constant(inverse[i][j], gradient[i]);
                }
                continue;
            }
            gradient[i] = inverse[i][0] * slopes[0];
            for j in 1..D {
                gradient[i] = inverse[i][j].multiply_add(slopes[j], gradient[i]);
            }
        }
        side.basis[index][node].gradient = if on_facets { tangential(&gradient, normal) } else { gradient };
    }
}

/// Second derivatives, after the gradients: ∂²φ/∂x² = J⁻ᵀ (∂²φ/∂ξ² − Σ_k ∂φ/∂x_k ∂²x_k/∂ξ²) J⁻¹.
#[inline(always)]
fn take_hessians<L: SimdLane, const D: usize>(
    side: &mut SideBuffers<L, D>,
    tables: &SideTables<D>,
    index: usize,
    basis: &LaneBasis<L, D>,
    geometry: &LaneBasis<L, D>,
) {
    let zero = L::splat(0.0);
    if tables.elements[index].on_facets {
        // A trace has none: what would read it must not pass for a number.
        for further in &mut side.further[index] {
            further.hessian = [[L::splat(f64::NAN); D]; D];
        }
        return;
    }
    let mut map = [[[zero; D]; D]; D];
    for node in 0..geometry.hessian.len() {
        for k in 0..D {
            for a in 0..D {
                for b in 0..D {
                    map[k][a][b] =
                        side.nodes[node][k].multiply_add(geometry.hessian[node][a][b], map[k][a][b]);
                }
            }
        }
    }
    let inverse = side.inverse;
    for node in 0..basis.hessian.len() {
        let gradient = side.basis[index][node].gradient;
        let mut half = [[zero; D]; D];
        for a in 0..D {
            for b in 0..D {
                let mut entry = basis.hessian[node][a][b];
                for k in 0..D {
                    entry = entry - gradient[k] * map[k][a][b];
                }
                for i in 0..D {
                    half[i][b] = inverse[i][a].multiply_add(entry, half[i][b]);
                }
            }
        }
        let hessian = &mut side.further[index][node].hessian;
        for i in 0..D {
            for j in 0..D {
                hessian[i][j] = zero;
                for b in 0..D {
                    hessian[i][j] = half[i][b].multiply_add(inverse[j][b], hessian[i][j]);
                }
            }
        }
    }
}

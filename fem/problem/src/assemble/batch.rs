//! One batch of cells (or facets), one per lane: geometry, basis functions and fields at its points.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lane values are plain.
#![allow(clippy::needless_range_loop)]

pub(super) mod basis_in_lanes;
mod buffers;
mod cell_map;
mod checks;
mod cut;
mod fields;
mod means;
mod pairs;
mod side;

use forms_core::contract::{Basis, CellGeometry, Further, PointGeometry, Requirements};

pub(super) use self::buffers::{ArgumentBasis, BatchBuffers, Reads};
pub(super) use self::cell_map::{inverse_transposed, largest_distance, surface};
use self::side::SideTables;

use super::AssemblyError;
use super::binding::Binding;
use super::groups::{Group, OwnPoints};
use crate::lanes::{SharedWork, SimdLane, WIDEST};
use crate::mesh::Mesh;

/// The source of the cells' nodes.
#[derive(Clone, Copy)]
pub(super) enum Cells<'a, const D: usize> {
    /// The cells of the group, on their mesh.
    Mesh(&'a Mesh<D>),
    /// Cells that the caller lists: the coordinates of geometry node n of cell c start at
    /// `coordinates[c * stride + offsets[n]]`; the coefficients of its fields are in
    /// `coefficients[c * coefficient_stride..]`.
    Given {
        coordinates: &'a [f64],
        stride: usize,
        offsets: &'a [usize],
        coefficients: &'a [f64],
        coefficient_stride: usize,
    },
}

/// A loop over the batches of a group.
pub(super) struct Batch<'a, L, const D: usize> {
    binding: &'a Binding<'a, D>,
    group: &'a Group<D>,
    requirements: Requirements,
    cells: Cells<'a, D>,
    tables: [SideTables<'a, D>; 2],
    buffers: &'a mut BatchBuffers<L, D>,
    /// The first entity.
    start: usize,
    /// Number of lanes that hold cells of their own.
    filled: usize,
    /// The own facet's coordinate along which points of moving segments have slopes, or the number of pieces' points by which they have.
    direction: usize,
    /// Largest distance between the two sides of an interior facet.
    tolerance: [f64; WIDEST],
    /// Weight of a point without its quadrature weight, and the normal, where the geometry is affine.
    affine: Option<AffineGeometry<L, D>>,
    /// The least Jacobian determinant so far, lane by lane.
    least: L,
}

/// The geometry that is constant on affine cells.
#[derive(Clone, Copy)]
struct AffineGeometry<L, const D: usize> {
    measure: L,
    normal: [L; D],
    /// On the other side of a contact pair.
    opposite_normal: [L; D],
}

impl<'a, L: SimdLane, const D: usize> Batch<'a, L, D> {
    /// A loop over a group. `arguments` are the test and trial functions whose basis the kernel reads.
    ///
    /// # Errors
    /// [`AssemblyError`]: something that the kernel reads and the group does not have.
    #[inline]
    pub fn new(
        binding: &'a Binding<'a, D>,
        group: &'a Group<D>,
        cells: Cells<'a, D>,
        requirements: Requirements,
        arguments: &[ArgumentBasis],
        buffers: &'a mut BatchBuffers<L, D>,
    ) -> Result<Self, AssemblyError> {
        if !buffers.prepared {
            buffers.prepare(binding, group, requirements, arguments)?;
        }
        let affine = group.is_affine(binding.mesh);
        let (first, second) = (&group.sides[0], &group.sides[group.sides.len() - 1]);
        let tables = [
            SideTables::new(first, &binding.elements, affine),
            SideTables::new(second, &binding.elements, affine),
        ];
        Ok(Batch {
            binding,
            group,
            requirements,
            cells,
            tables,
            buffers,
            start: 0,
            filled: 0,
            direction: 0,
            tolerance: [0.0; WIDEST],
            affine: None,
            least: L::splat(f64::INFINITY),
        })
    }

    /// Slopes along one of the own facet's coordinates, where values carry any and points are those of moving segments; of pieces by one of the numbers of a
    /// point, other than its weight.
    #[inline(always)]
    pub fn move_along(&mut self, direction: usize) {
        self.direction = direction;
    }

    fn two_sided(&self) -> bool {
        self.group.sides.len() == 2
    }

    /// The cells of this batch on a side, without the repeated ones.
    pub fn cells(&self, side: usize) -> &[u32] {
        &self.buffers.sides[side].cells[..self.filled]
    }

    /// The basis functions of an element at the current point.
    #[inline(always)]
    pub fn basis(&self, side: usize, element: usize) -> &[Basis<L, D>] {
        &self.buffers.sides[side].basis[element]
    }

    /// Second derivatives of the basis functions of an element at the current point, and their means over the cell.
    #[inline(always)]
    pub fn further(&self, side: usize, element: usize) -> &[Further<L, D>] {
        &self.buffers.sides[side].further[element]
    }

    /// The first functions of an element at the current point, with their second derivatives and means.
    #[inline(always)]
    pub fn functions(&self, side: usize, element: usize, count: usize) -> (&[Basis<L, D>], &[Further<L, D>]) {
        (&self.basis(side, element)[..count], &self.further(side, element)[..count])
    }

    /// The fields at the current point, as the kernel wants them.
    #[inline(always)]
    pub fn fields(&self) -> &[L] {
        &self.buffers.fields
    }

    /// J⁻ᵀ on the first side at the current point.
    #[inline(always)]
    pub fn inverse(&self) -> &[[L; D]; D] {
        &self.buffers.sides[0].inverse
    }

    /// det J and J⁻ᵀ of this side's cells, for affine cells after [`Batch::load`].
    #[inline(always)]
    pub fn affine_map(&self, side: usize) -> (L, [[L; D]; D]) {
        let side = &self.buffers.sides[side];
        (side.determinant, side.inverse)
    }

    /// Data of `filled` of the group's entities (at most one per lane, at least one) from `start` on, loaded. The result is
    /// what is constant on their cells. Other lanes repeat the last entity.
    #[inline(always)]
    pub fn load(&mut self, start: usize, filled: usize) -> CellGeometry<L> {
        L::call(Load { batch: self, start, filled })
    }

    #[inline(always)]
    fn load_here(&mut self, requirements: &Requirements, start: usize, filled: usize) -> CellGeometry<L> {
        (self.start, self.filled) = (start, filled);
        let sides = if self.two_sided() { 2 } else { 1 };
        for side in 0..sides {
            self.buffers.sides[side].load(&self.tables[side], self.cells, start, filled);
        }
        for side in 0..sides {
            if !self.tables[side].affine {
                self.buffers.sides[side].map_centre(&self.tables[side]);
            }
        }
        self.load_coefficients(requirements, start);
        self.factorise_fields(requirements);
        self.affine = None;
        if self.tables[0].affine {
            for side in 0..sides {
                self.buffers.sides[side].map_affinely(&self.tables[side]);
                self.least = self.least.minimum(self.buffers.sides[side].determinant);
            }
            let this = &self.buffers.sides[0];
            let nowhere = [L::splat(0.0); D];
            let (measure, normal) = match &self.tables[0].group.facet {
                None => (this.determinant, nowhere),
                Some((_, tangents)) => surface(&this.jacobian, tangents),
            };
            let opposite_normal = match (&self.group.own, &self.tables[1].group.facet) {
                (Some(OwnPoints::Pairs(_)), Some((_, tangents))) => {
                    surface(&self.buffers.sides[1].jacobian, tangents).1
                }
                _ => nowhere,
            };
            self.affine = Some(AffineGeometry { measure, normal, opposite_normal });
        }
        self.load_means(requirements);
        self.cell_geometry(requirements)
    }

    #[inline(always)]
    fn cell_geometry(&mut self, requirements: &Requirements) -> CellGeometry<L> {
        let zero = L::splat(0.0);
        let mut geometry = CellGeometry {
            diameter: zero,
            cell_volume: zero,
            facet_area: zero,
            opposite_diameter: zero,
            opposite_volume: zero,
        };
        let (this, tables) = (&self.buffers.sides[0], &self.tables[0]);
        if requirements.diameter {
            geometry.diameter = this.diameter(tables);
        }
        if requirements.cell_volume {
            geometry.cell_volume = this.volume(tables);
        }
        if requirements.facet_area
            && let (Some((map, weights)), Some((_, tangents))) =
                (&tables.group.measure.facet, &tables.group.facet)
        {
            match &self.affine {
                Some(affine) => {
                    let mut sum = 0.0;
                    for weight in weights {
                        sum += *weight;
                    }
                    geometry.facet_area = affine.measure * L::splat(sum);
                }
                None => {
                    for q in 0..weights.len() {
                        let (element, _) = surface(&this.jacobian_at(map, q), tangents);
                        geometry.facet_area = element.multiply_add(L::splat(weights[q]), geometry.facet_area);
                    }
                }
            }
        }
        if self.two_sided() {
            let (other, tables) = (&self.buffers.sides[1], &self.tables[1]);
            let diameter = other.diameter(tables);
            diameter.store(&mut self.tolerance);
            if requirements.opposite_diameter {
                geometry.opposite_diameter = diameter;
            }
            if requirements.opposite_volume {
                geometry.opposite_volume = other.volume(tables);
            }
        }
        geometry
    }

    /// The geometry at the current point.
    #[inline(always)]
    pub fn geometry(&self) -> &PointGeometry<L, D> {
        &self.buffers.geometry
    }

    /// Data at the q-th point: geometry, basis functions, fields.
    ///
    /// # Errors
    /// A Jacobian determinant that is not positive, or a value that is not finite.
    #[inline(always)]
    pub fn point(&mut self, q: usize) -> Result<(), AssemblyError> {
        L::call(Point { batch: self, q })
    }

    #[inline(always)]
    fn point_here(&mut self, requirements: &Requirements, q: usize) -> Result<(), AssemblyError> {
        let group = self.group;
        match &group.own {
            None => {}
            Some(OwnPoints::Pairs(pairs)) => return self.pair_point(requirements, q, pairs),
            Some(OwnPoints::Cut(cut)) => return self.cut_point(requirements, q, cut),
        }
        let reads_position = requirements.position || self.two_sided() || self.reads_functions(requirements);
        // In place: with what contact pairs have, the geometry is too long to be handed on as a copy.
        let BatchBuffers { sides: [this, other], reads, geometry, .. } = &mut *self.buffers;
        let ([own_reads, other_reads], tables) = (&*reads, &self.tables[0]);
        geometry.weight = L::splat(self.group.weights[q]);
        if reads_position {
            geometry.position = this.position(tables, q);
        }
        let inverse = match &self.affine {
            Some(affine) => {
                geometry.weight = geometry.weight * affine.measure;
                geometry.normal = affine.normal;
                this.inverse
            }
            None => {
                let jacobian = this.jacobian_at(&tables.group.geometry, q);
                let (determinant, inverse) = inverse_transposed(&jacobian);
                this.inverse = inverse;
                self.least = self.least.minimum(determinant);
                match &tables.group.facet {
                    None => geometry.weight = geometry.weight * determinant,
                    Some((_, tangents)) => {
                        let (element, normal) = surface(&jacobian, tangents);
                        geometry.weight = geometry.weight * element;
                        geometry.normal = normal;
                        if requirements.curvature {
                            geometry.curvature = this.curvature(tables, q, &jacobian, tangents, &normal);
                        }
                    }
                }
                inverse
            }
        };
        let (position, normal) = (geometry.position, geometry.normal);
        this.evaluate_basis(tables, own_reads, q, &inverse, &normal);
        if self.group.sides.len() == 2 {
            let tables = &self.tables[1];
            let inverse = match self.affine {
                Some(_) => other.inverse,
                None => {
                    let jacobian = other.jacobian_at(&tables.group.geometry, q);
                    let (determinant, inverse) = inverse_transposed(&jacobian);
                    self.least = self.least.minimum(determinant);
                    inverse
                }
            };
            other.evaluate_basis(tables, other_reads, q, &inverse, &normal);
            self.check_facing(q, &position)?;
        }
        self.evaluate_fields(requirements, q, &position, &position)
    }
}

struct Load<'b, 'a, L, const D: usize> {
    batch: &'b mut Batch<'a, L, D>,
    start: usize,
    filled: usize,
}

impl<L: SimdLane, const D: usize> SharedWork<L> for Load<'_, '_, L, D> {
    type Output = CellGeometry<L>;

    #[inline(always)]
    fn run(self) -> CellGeometry<L> {
        let requirements = self.batch.requirements;
        self.batch.load_here(&requirements, self.start, self.filled)
    }
}

struct Point<'b, 'a, L, const D: usize> {
    batch: &'b mut Batch<'a, L, D>,
    q: usize,
}

impl<L: SimdLane, const D: usize> SharedWork<L> for Point<'_, '_, L, D> {
    type Output = Result<(), AssemblyError>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let requirements = self.batch.requirements;
        self.batch.point_here(&requirements, self.q)
    }
}

#[cfg(test)]
mod tests;

//! The points of pieces of cells, facets and interfaces: each lane has its own, so that basis functions are evaluated in lanes and not read
//! from tables.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lane values are plain.
#![allow(clippy::needless_range_loop)]

use forms_core::contract::Requirements;

use super::Batch;
use crate::assemble::AssemblyError;
use crate::assemble::groups::cut_groups::{CutTables, PieceKind};
use crate::lanes::{SimdLane, WIDEST};

impl<L: SimdLane, const D: usize> Batch<'_, L, D> {
    /// Moves to the q-th point of each entity.
    #[inline(always)]
    pub(super) fn cut_point(
        &mut self,
        requirements: &Requirements,
        q: usize,
        cut: &CutTables<D>,
    ) -> Result<(), AssemblyError> {
        let stride = cut.stride();
        let mut places = [0; WIDEST];
        for lane in 0..L::WIDTH {
            let entity = self.start + lane.min(self.filled - 1);
            places[lane] = (entity * cut.count + q) * stride;
        }
        let mut reference = L::gather::<D>(&cut.points, &places);
        if L::DIRECTIONS > 0 && self.direction < D {
            reference[self.direction] = reference[self.direction].with_slope(L::splat(1.0));
        }
        for lane in 0..L::WIDTH {
            places[lane] += D;
        }
        let [weight] = L::gather::<1>(&cut.points, &places);
        let this = self.facet_point(requirements, 0, &reference, (&cut.geometry, &cut.elements), None, &[]);
        let side = &self.buffers.sides[0];
        let (determinant, inverse) = (side.determinant, side.inverse);
        let geometry = &mut self.buffers.geometry;
        geometry.position = this.position;
        match cut.kind {
            PieceKind::Cell => geometry.weight = weight * determinant,
            PieceKind::Facet => {
                geometry.weight = weight * this.element;
                geometry.normal = this.normal;
                geometry.curvature = this.curvature;
            }
            PieceKind::Interface => {
                geometry.curvature = L::splat(0.0);
                for lane in 0..L::WIDTH {
                    places[lane] += 1;
                }
                let mut normal = L::gather::<D>(&cut.points, &places);
                if L::DIRECTIONS > 0 && self.direction > D {
                    let axis = self.direction - D - 1;
                    normal[axis] = normal[axis].with_slope(L::splat(1.0));
                }
                // Nanson's formula: n da = det J J⁻ᵀ ν dA.
                let mut image = [L::splat(0.0); D];
                let mut square = L::splat(0.0);
                for i in 0..D {
                    for j in 0..D {
                        image[i] = inverse[i][j].multiply_add(normal[j], image[i]);
                    }
                    square = image[i].multiply_add(image[i], square);
                }
                let length = square.sqrt();
                geometry.weight = weight * determinant * length;
                for i in 0..D {
                    geometry.normal[i] = image[i] / length;
                }
            }
        }
        self.evaluate_fields(requirements, q, &this.position, &this.position)
    }
}

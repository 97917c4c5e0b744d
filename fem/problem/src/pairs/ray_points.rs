//! The quadrature points of a whole own facet, each with the opposite point on its ray; several side by side in lanes.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lanes are plain.
#![allow(clippy::needless_range_loop)]

use super::candidates::Beam;
use super::found::{Found, PairPoint, Room};
use super::nearest_on_rays::NearestOnRays;
use super::rays::Rays;
use super::search::Search;
use super::surface::{dot, over};
use crate::element::CellShape;
use crate::lanes::{SimdLane, WIDEST};
use crate::quadrature::QuadratureRule;

/// The points of a rule side by side; the last one fills lanes that are left over.
struct RuleInLanes<L> {
    shape: CellShape,
    points: Vec<[L; 2]>,
}

/// Rules in lanes, and room for the rays of one own facet.
pub(super) struct RayRoom<const D: usize, L> {
    rules: Vec<RuleInLanes<L>>,
    rays: Vec<Rays<D, L>>,
    elements: Vec<f64>,
}

impl<const D: usize, L: SimdLane> RayRoom<D, L> {
    #[inline(always)]
    pub fn new(rules: &[(CellShape, QuadratureRule<2>)]) -> Self {
        let mut in_lanes = Vec::new();
        for (shape, rule) in rules {
            let mut points = Vec::new();
            for batch in rule.points.chunks(L::WIDTH) {
                let mut lanes = [[0.0; WIDEST]; 2];
                for lane in 0..L::WIDTH {
                    let point = batch[lane.min(batch.len() - 1)];
                    (lanes[0][lane], lanes[1][lane]) = (point[0], point[1]);
                }
                points.push([L::load(&lanes[0]), L::load(&lanes[1])]);
            }
            in_lanes.push(RuleInLanes { shape: *shape, points });
        }
        RayRoom { rules: in_lanes, rays: Vec::new(), elements: Vec::new() }
    }
}

impl<const D: usize> Search<'_, '_, D> {
    /// Adds the opposite points on the rays from the points of a whole facet.
    #[inline(always)]
    pub fn add_rays_of<L: SimdLane>(
        &self,
        index: usize,
        found: &mut Found<D>,
        room: &mut Room<D>,
        in_lanes: &mut RayRoom<D, L>,
    ) {
        let own = &self.own[index];
        let shape = self.mesh.cell_shape(own.facet.cell as usize);
        let RayRoom { rules, rays, elements } = in_lanes;
        let Some(number) = rules.iter().position(|known| known.shape == shape) else { return };
        let (batches, rule) = (&rules[number].points, &self.rules[number].1);
        let (mut lanes, mut measure) = ([0.0; WIDEST], 0.0);
        let diameter = own.diameter;
        let reach = self.reach_of(diameter);
        let mut beam = Beam::along_normal_of(own, reach);
        rays.clear();
        elements.clear();
        for batch in 0..batches.len() {
            let point = own.at(&batches[batch]);
            let normal = point.long_normal();
            let element = dot(&normal, &normal).sqrt();
            let from_points = Rays { x: point.position, n: over(&normal, element) };
            beam.hold(&from_points);
            rays.push(from_points);
            element.store(&mut lanes);
            elements.extend_from_slice(&lanes[..L::WIDTH]);
        }
        for q in 0..rule.weights.len() {
            measure += rule.weights[q] * elements[q];
        }
        found.counts().measure = measure;
        let made = self.candidates.of(
            index,
            &beam,
            diameter,
            |facet| self.may_face(own, facet),
            &mut room.candidates,
        );
        found.remade.extend(made.map(|list| (index, list)));
        for batch in 0..batches.len() {
            let rays = &rays[batch];
            let nearest = self.nearest_on_rays(own, &batches[batch], rays, &room.candidates, reach);
            let lanes = InMemory::of(&nearest, rays);
            let first = batch * L::WIDTH;
            for q in first..rule.points.len().min(first + L::WIDTH) {
                let (lane, counts) = (q - first, found.counts());
                if lanes.found[lane] == 0.0 {
                    counts.open += 1;
                    counts.rejected += usize::from(lanes.rejected[lane] != 0.0);
                    continue;
                }
                let (gap, weight) = (lanes.gap[lane], rule.weights[q]);
                let [mut position, mut toward] = [[0.0; D]; 2];
                for k in 0..D {
                    (position[k], toward[k]) = (lanes.x[k][lane], lanes.n[k][lane]);
                }
                counts.add_point(&position, gap, weight * elements[q]);
                let facet = lanes.facet[lane] as usize;
                let (opposite, s) = (&self.opposite[facet], [lanes.s[0][lane], lanes.s[1][lane]]);
                let reference = [own.reference(&rule.points[q]), opposite.reference(&s)];
                let rigid_normal = opposite.rigid_normal;
                room.pairs.push((facet, PairPoint { reference, weight, gap, toward, rigid_normal }));
            }
        }
    }
}

/// Rays and their opposite points, lane after lane.
struct InMemory<const D: usize> {
    found: [f64; WIDEST],
    rejected: [f64; WIDEST],
    facet: [f64; WIDEST],
    gap: [f64; WIDEST],
    s: [[f64; WIDEST]; 2],
    x: [[f64; WIDEST]; D],
    n: [[f64; WIDEST]; D],
}

impl<const D: usize> InMemory<D> {
    #[inline(always)]
    fn of<L: SimdLane>(nearest: &NearestOnRays<L>, rays: &Rays<D, L>) -> Self {
        let zeros = [0.0; WIDEST];
        let mut lanes = InMemory {
            found: zeros,
            rejected: zeros,
            facet: zeros,
            gap: zeros,
            s: [zeros; 2],
            x: [zeros; D],
            n: [zeros; D],
        };
        let (zero, one) = (L::splat(0.0), L::splat(1.0));
        L::select(nearest.found, one, zero).store(&mut lanes.found);
        L::select(nearest.rejected, one, zero).store(&mut lanes.rejected);
        nearest.facet.store(&mut lanes.facet);
        nearest.gap.store(&mut lanes.gap);
        for k in 0..2 {
            nearest.s[k].store(&mut lanes.s[k]);
        }
        for k in 0..D {
            rays.x[k].store(&mut lanes.x[k]);
            rays.n[k].store(&mut lanes.n[k]);
        }
        lanes
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use forms_core::contract::Pairing;

    use super::*;
    use crate::field::Field;
    use crate::lanes::{InstructionSet, LaneWork};
    use crate::mesh::{Mesh, cuboid, rectangle};
    use crate::pairs::found::Counts;
    use crate::pairs::points::OfFacets;
    use crate::pairs::surfaces::Surfaces;
    use crate::pairs::{Displacement, DisplacementField};
    use crate::quadrature::Quadrature;
    use crate::space::Space;
    use crate::threads::Threads;

    /// Pairs of the top and the bottom of a thin body, which is bent and moved so that some rays miss.
    fn the_same_in_all_lanes<const D: usize>(mesh: Mesh<D>, degree: usize) {
        let mesh = Arc::new(mesh);
        let space = Space::vector(&mesh, degree).unwrap();
        let bent = |x: &[f64; D]| {
            let mut u = [0.0; D];
            u[0] = if x[D - 1] > 0.05 { 0.33 } else { 0.0 };
            u[D - 1] = 0.04 * (7.0 * x[0] + 3.0 * x[D - 2]).sin() + 0.03 * x[0] * x[0];
            u
        };
        let u = Field::interpolate(&space, bent).unwrap();
        let displacement =
            Displacement { fields: vec![DisplacementField { space: &space, values: u.values() }] };
        let pairing = Pairing::between("top", "bottom").within_reach(0.16);
        let surfaces = Surfaces::new(&mesh, &pairing, Some(&displacement), Threads::ONE).unwrap();
        let quadrature = Quadrature::Degree(7);
        for facing in &pairing.surfaces {
            let search = Search::new(&mesh, &pairing, facing, (&quadrature, 0), &surfaces, None).unwrap();
            let facets = 0..search.own.len();
            let work = || OfFacets { search: &search, facets: facets.clone() };
            let one = work().run::<f64>().unwrap();
            let all = |count: fn(&Counts<D>) -> usize| one.counts.iter().map(count).sum::<usize>();
            assert!(all(|counts| counts.points) > 0 && all(|counts| counts.open) > 0);
            for set in InstructionSet::available() {
                let many = set.checked().run_without_kernel(work()).unwrap();
                assert_eq!(one.points, many.points, "{set}");
                assert_eq!(one.counts, many.counts, "{set}");
            }
        }
    }

    /// Bits of pairs do not depend on the number of lanes: what a ray meets does not depend on those beside it.
    #[test]
    fn lanes_have_the_bits_of_single_rays() {
        for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
            for degree in 1..4 {
                the_same_in_all_lanes(rectangle([0.0; 2], [1.0, 0.1], [13, 1], shape, 1).unwrap(), degree);
            }
        }
        for shape in [CellShape::Tetrahedron, CellShape::Hexahedron] {
            for degree in 1..4 {
                the_same_in_all_lanes(
                    cuboid([0.0; 3], [1.0, 1.0, 0.1], [5, 4, 1], shape, 1).unwrap(),
                    degree,
                );
            }
        }
    }
}

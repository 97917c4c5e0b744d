//! The quadrature points of a whole own facet, each with the opposite point on its ray; several side by side in lanes.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lanes are plain.
#![allow(clippy::needless_range_loop)]

use super::candidates::RayBundle;
use super::found::{Found, PairPoint, Unit};
use super::nearest_on_rays::NearestOnRays;
use super::rays::Rays;
use super::search::Search;
use super::surface::{SurfaceFacet, dot, over};
use super::tolerances::INSIDE;
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
    /// The surface element at each point.
    elements: Vec<f64>,
    batches: Vec<Batch<D>>,
    candidates: Vec<usize>,
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
        let most = in_lanes.iter().map(|rule| rule.points.len()).max().unwrap_or(0);
        let batches = vec![Batch::EMPTY; most];
        RayRoom { rules: in_lanes, rays: vec![], elements: vec![], batches, candidates: vec![] }
    }
}

impl<const D: usize> Search<'_, '_, D> {
    /// Opposite points on the rays from the points of a whole facet, added.
    #[inline(always)]
    pub fn add_rays_of<L: SimdLane>(&self, index: usize, found: &mut Found<D>, room: &mut RayRoom<D, L>) {
        let own = &self.own[index];
        let shape = self.mesh.cell_shape(own.facet.cell as usize);
        let RayRoom { rules, rays, elements, batches, candidates } = room;
        let Some(number) = rules.iter().position(|known| known.shape == shape) else { return };
        let (points, rule) = (&rules[number].points, &self.rules[number].1);
        let (mut lanes, mut measure) = ([0.0; WIDEST], 0.0);
        let diameter = own.diameter;
        let reach = self.reach_of(diameter);
        let mut beam = RayBundle::along_normal_of(own, reach);
        rays.clear();
        elements.clear();
        for batch in 0..points.len() {
            let point = own.at(&points[batch]);
            let normal = point.long_normal();
            let element = dot(&normal, &normal).sqrt();
            let from_points = Rays { x: point.position, n: over(&normal, element) };
            beam.hold(&from_points, L::WIDTH.min(rule.points.len() - batch * L::WIDTH));
            rays.push(from_points);
            element.store(&mut lanes);
            elements.extend_from_slice(&lanes[..L::WIDTH]);
        }
        for q in 0..rule.weights.len() {
            measure += rule.weights[q] * elements[q];
        }
        let made = self.candidates.of(index, &beam, diameter, |facet| self.may_face(own, facet), candidates);
        found.remade.extend(made.map(|list| (index, list)));
        let counts = found.counts();
        counts.measure = measure;
        for batch in 0..points.len() {
            let rays = &rays[batch];
            let nearest = self.nearest_on_rays(own, &points[batch], rays, candidates, reach, INSIDE);
            let lanes = &mut batches[batch];
            lanes.take(&nearest, rays);
            let first = batch * L::WIDTH;
            for q in first..rule.points.len().min(first + L::WIDTH) {
                let lane = q - first;
                if lanes.facet[lane] == TAKEN {
                    counts.open += 1;
                    counts.rejected += usize::from(lanes.rejected[lane] != 0.0);
                    continue;
                }
                let mut position = [0.0; D];
                for k in 0..D {
                    position[k] = lanes.x[k][lane];
                }
                counts.add_point(&position, lanes.gap[lane], rule.weights[q] * elements[q]);
            }
        }
        self.add_units(own, rule, batches, L::WIDTH, found);
    }

    /// Adds the points of a whole facet by opposite facets, in the order of the rule. All facets of a rigid surface move with one cell, and count as
    /// one.
    #[inline(always)]
    fn add_units(
        &self,
        own: &SurfaceFacet<D>,
        rule: &QuadratureRule<2>,
        batches: &mut [Batch<D>],
        width: usize,
        found: &mut Found<D>,
    ) {
        let place = self.mesh.walk_of_facet(&[own.facet]);
        let count_of_points = rule.points.len();
        for first in 0..count_of_points {
            let index = batches[first / width].facet[first % width];
            if index == TAKEN {
                continue;
            }
            let (mut count, start) = (0, found.next_point());
            let facet = self.opposite[index as usize].facet;
            for q in first..count_of_points {
                let (batch, lane) = (&mut batches[q / width], q % width);
                let other = batch.facet[lane];
                if other == TAKEN || (other != index && self.opposite[other as usize].facet != facet) {
                    continue;
                }
                batch.facet[lane] = TAKEN;
                count += 1;
                let opposite = &self.opposite[other as usize];
                let mut toward = [0.0; D];
                for k in 0..D {
                    toward[k] = batch.n[k][lane];
                }
                found.add_point(&PairPoint {
                    reference: [
                        own.reference(&rule.points[q]),
                        opposite.reference(&[batch.s[0][lane], batch.s[1][lane]]),
                    ],
                    weight: rule.weights[q],
                    gap: batch.gap[lane],
                    toward,
                    rigid_normal: opposite.rigid_normal,
                });
                found.rule_points.push(q as u16);
            }
            found.units.push(Unit { place, facets: [own.facet, facet], count, start, segment: None });
        }
    }
}

/// The index of the opposite facet of a point that has none, or is in its unit.
const TAKEN: f64 = -1.0;

/// Rays and their opposite points, lane after lane.
#[derive(Clone, Copy)]
struct Batch<const D: usize> {
    rejected: [f64; WIDEST],
    facet: [f64; WIDEST],
    gap: [f64; WIDEST],
    s: [[f64; WIDEST]; 2],
    x: [[f64; WIDEST]; D],
    n: [[f64; WIDEST]; D],
}

impl<const D: usize> Batch<D> {
    const EMPTY: Self = Batch {
        rejected: [0.0; WIDEST],
        facet: [TAKEN; WIDEST],
        gap: [0.0; WIDEST],
        s: [[0.0; WIDEST]; 2],
        x: [[0.0; WIDEST]; D],
        n: [[0.0; WIDEST]; D],
    };

    #[inline(always)]
    fn take<L: SimdLane>(&mut self, nearest: &NearestOnRays<L>, rays: &Rays<D, L>) {
        L::select(nearest.rejected, L::splat(1.0), L::splat(0.0)).store(&mut self.rejected);
        L::select(nearest.found, nearest.facet, L::splat(TAKEN)).store(&mut self.facet);
        nearest.gap.store(&mut self.gap);
        for k in 0..2 {
            nearest.s[k].store(&mut self.s[k]);
        }
        for k in 0..D {
            rays.x[k].store(&mut self.x[k]);
            rays.n[k].store(&mut self.n[k]);
        }
    }
}

#[cfg(test)]
mod tests {
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
        let surfaces =
            Surfaces::new(&mesh, &pairing, &Default::default(), Some(&displacement), Threads::ONE).unwrap();
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

    /// Bits of pairs do not depend on the number of lanes: what a ray meets does not depend on its neighbours.
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

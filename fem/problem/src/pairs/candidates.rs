//! Facets that rays from an own facet may meet: lists that are made with a skin, and kept until motions have used it up.
//!
//! Which facets are tried follows from the displacement alone: a list holds at least those that the rays of an iterate can meet,
//! and at that iterate it is reduced to just those.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lanes are plain.
#![allow(clippy::needless_range_loop)]

use std::sync::{Arc, OnceLock};

use super::rays::Rays;
use super::surface::{SurfaceFacet, SurfacePoint, dot, minus, splat};
use crate::lanes::{SimdLane, WIDEST};
use crate::locate::BoxGrid;

/// The skin of an own facet's list, in its diameters.
const SKIN: f64 = 0.5;

/// The part of a skin that may be used up; the rest is for rounding.
const USABLE: f64 = 1.0 - 1e-6;

fn length<const D: usize>(a: &[f64; D]) -> f64 {
    dot(a, a).sqrt()
}

/// Vectors whose convex combinations are the tangents along one coordinate at all points of a facet of degree two in space: the coefficients of
/// Bernstein's polynomials, of degree one on triangles and of degree one and two on quadrilaterals.
fn tangents_of<const D: usize>(own: &SurfaceFacet<D>, axis: usize) -> Vec<[f64; D]> {
    let tangent = |s: [f64; 2]| own.at(&s).tangents[axis];
    if own.parameters().len() == 3 {
        return own.parameters().iter().map(|s| tangent(*s)).collect();
    }
    let mut all = Vec::with_capacity(6);
    for end in [0.0, 1.0] {
        let at = |across: f64| tangent(if axis == 0 { [end, across] } else { [across, end] });
        let [first, middle, last] = [0.0, 0.5, 1.0].map(at);
        all.extend([first, std::array::from_fn(|k| 2.0 * middle[k] - 0.5 * (first[k] + last[k])), last]);
    }
    all
}

/// All rays from the points of an own facet, to both sides.
#[derive(Clone, Copy, Debug)]
pub(super) struct RayBundle<const D: usize> {
    /// They start within a radius of a point.
    centre: [f64; D],
    radius: f64,
    /// Their unit directions differ from one by this vector length at most.
    direction: [f64; D],
    spread: f64,
    /// The length of a ray.
    reach: f64,
}

impl<const D: usize> RayBundle<D> {
    /// The ray from the middle of a facet along its normal.
    pub fn along_normal_of(own: &SurfaceFacet<D>, reach: f64) -> Self {
        let direction = own.at(&own.middle()).normal();
        RayBundle { centre: own.centre, radius: 0.0, direction, spread: 0.0, reach }
    }

    /// The rays from all points of a facet whose position is a polynomial of degree two at most. In the plane, and of degree one, its normals are
    /// between those of its corners. Of others the tangents are convex combinations of some vectors, and the normals of their products: within a
    /// hemisphere what holds these holds their combinations.
    pub fn of_facet(own: &SurfaceFacet<D>, reach: f64) -> Self {
        let mut beam = RayBundle { radius: own.radius, ..RayBundle::along_normal_of(own, reach) };
        if D == 2 || own.degree == 1 {
            for end in own.parameters().iter().map(|s| own.at(s)) {
                beam.hold(&Rays { x: end.position, n: end.normal() }, 1);
            }
            return beam;
        }
        let [along, across] = [0, 1].map(|axis| tangents_of(own, axis));
        for first in &along {
            for second in &across {
                let point = SurfacePoint { position: own.centre, tangents: [*first, *second] };
                beam.hold(&Rays { x: point.position, n: point.normal() }, 1);
            }
        }
        beam
    }

    /// Room for the first `count` of some rays.
    #[inline(always)]
    pub fn hold<L: SimdLane>(&mut self, rays: &Rays<D, L>, count: usize) {
        let off = minus(&rays.x, &splat(&self.centre));
        let turned = minus(&rays.n, &splat(&self.direction));
        let mut lanes = [[0.0; WIDEST]; 2];
        dot(&off, &off).store(&mut lanes[0]);
        dot(&turned, &turned).store(&mut lanes[1]);
        let mut squares = [0.0_f64; 2];
        for k in 0..2 {
            for lane in 0..count {
                // Not `max`, which asks for what is no number as well.
                if lanes[k][lane] > squares[k] {
                    squares[k] = lanes[k][lane];
                }
            }
        }
        self.radius = self.radius.max(squares[0].sqrt());
        self.spread = self.spread.max(squares[1].sqrt());
    }

    /// Half the length and half the width of what holds the rays.
    fn extents(&self) -> [f64; 2] {
        [self.reach + self.radius, self.radius + self.reach * self.spread]
    }

    /// Whether rays may come to a ball, or within a skin of it.
    fn meets(&self, ball: &Ball<D>, skin: f64) -> bool {
        let off = minus(&ball.centre, &self.centre);
        let along = dot(&off, &self.direction);
        let [length, width] = self.extents().map(|extent| extent + ball.radius + skin);
        along.abs() <= length && dot(&off, &off) - along * along <= width * width
    }

    /// Upper bound on how much closer a ball that `earlier` missed can be, by the motion of the rays;
    /// no ball that this beam meets has a larger radius.
    fn moved_since(&self, earlier: &RayBundle<D>, largest: f64) -> f64 {
        let [length_now, width] = self.extents().map(|extent| extent + largest);
        let turned = length(&minus(&self.direction, &earlier.direction));
        let widened = (self.radius - earlier.radius).max(0.0);
        let spread = (self.spread - earlier.spread).max(0.0) * self.reach;
        length(&minus(&self.centre, &earlier.centre)) + (length_now + width) * turned + widened + spread
    }
}

/// A ball around a facet.
#[derive(Clone, Copy, Debug)]
struct Ball<const D: usize> {
    centre: [f64; D],
    radius: f64,
}

/// The candidates of an own facet.
#[derive(Debug)]
pub(super) struct KeptList<const D: usize> {
    /// The state in which the list was made: the rays, and how far balls had moved from where they are kept.
    beam: RayBundle<D>,
    moved: f64,
    skin: f64,
    /// Ascending.
    facets: Vec<u32>,
}

/// The candidates of all facets of a surface.
#[derive(Debug)]
pub(super) struct KeptCandidates<const D: usize> {
    balls: Arc<[Ball<D>]>,
    lists: Arc<Vec<Option<Arc<KeptList<D>>>>>,
    /// The least skin of a list.
    least_skin: f64,
}

/// The candidates at an iterate.
pub(super) struct Candidates<const D: usize> {
    balls: Arc<[Ball<D>]>,
    /// The largest of their radii.
    largest: f64,
    /// The motion of a ball from its kept place, or its growth.
    moved: f64,
    kept: KeptCandidates<D>,
    grid: OnceLock<BoxGrid<D>>,
}

impl<const D: usize> Candidates<D> {
    /// The candidates among opposite facets, with lists that an earlier iterate had.
    pub fn new(
        own: &[SurfaceFacet<D>],
        opposite: &[SurfaceFacet<D>],
        earlier: Option<&KeptCandidates<D>>,
    ) -> Self {
        let ball = |facet: &SurfaceFacet<D>| Ball { centre: facet.centre, radius: facet.radius };
        let balls: Arc<[Ball<D>]> = opposite.iter().map(ball).collect();
        let largest = balls.iter().map(|ball| ball.radius).fold(0.0, f64::max);
        let mut moved = 0.0;
        let fits =
            |known: &&KeptCandidates<D>| known.balls.len() == balls.len() && known.lists.len() == own.len();
        let usable = earlier.filter(fits).filter(|known| {
            let motion = |(now, then): (&Ball<D>, &Ball<D>)| {
                length(&minus(&now.centre, &then.centre)) + (now.radius - then.radius).max(0.0)
            };
            moved = balls.iter().zip(&*known.balls).map(motion).fold(0.0, f64::max);
            moved <= 0.5 * USABLE * known.least_skin
        });
        let kept = match usable {
            Some(KeptCandidates { balls, lists, least_skin }) => {
                KeptCandidates { balls: Arc::clone(balls), lists: Arc::clone(lists), least_skin: *least_skin }
            }
            None => {
                moved = 0.0;
                let lists = Arc::new(vec![None; own.len()]);
                KeptCandidates { balls: Arc::clone(&balls), lists, least_skin: f64::INFINITY }
            }
        };
        Candidates { balls, largest, moved, kept, grid: OnceLock::new() }
    }

    /// The opposite facets that an own facet's rays may meet, ascending; a list that had to be made for them is handed back.
    /// `may_face` says which facets count at all.
    pub fn of(
        &self,
        own: usize,
        beam: &RayBundle<D>,
        diameter: f64,
        may_face: impl Fn(usize) -> bool,
        found: &mut Vec<usize>,
    ) -> Option<KeptList<D>> {
        found.clear();
        let still_holds = |list: &&KeptList<D>| {
            let moved = beam.moved_since(&list.beam, self.largest) + self.moved + list.moved;
            moved <= USABLE * list.skin && beam.reach <= list.beam.reach
        };
        let known = self.kept.lists[own].as_deref().filter(still_holds);
        let made = known.is_none().then(|| self.list(beam, SKIN * diameter, may_face));
        if let Some(list) = known.or(made.as_ref()) {
            let met = list.facets.iter().filter(|facet| beam.meets(&self.balls[**facet as usize], 0.0));
            found.extend(met.map(|facet| *facet as usize));
        }
        made
    }

    fn list(&self, beam: &RayBundle<D>, skin: f64, may_face: impl Fn(usize) -> bool) -> KeptList<D> {
        let grid = self.grid.get_or_init(|| {
            // A ball that meets the rays meets the box around them if its own is wider by √2.
            let around = |ball: &Ball<D>| {
                let half = std::f64::consts::SQRT_2 * (1.0 + 1e-9) * ball.radius;
                (ball.centre.map(|x| x - half), ball.centre.map(|x| x + half))
            };
            BoxGrid::new(self.balls.iter().map(around).collect())
        });
        let [length, width] = beam.extents().map(|extent| extent + skin);
        let half: [f64; D] = beam.direction.map(|component| component.abs() * length + width);
        let corner = |sign: f64| std::array::from_fn(|k| beam.centre[k] + sign * half[k]);
        let met = grid.meeting(&(corner(-1.0), corner(1.0))).into_iter();
        let met = met.filter(|facet| beam.meets(&self.balls[*facet], skin) && may_face(*facet));
        KeptList { beam: *beam, moved: self.moved, skin, facets: met.map(|facet| facet as u32).collect() }
    }

    /// Candidates for the next iterate: the lists with those that were made for this one.
    pub fn keep(self, made: Vec<(usize, KeptList<D>)>) -> KeptCandidates<D> {
        let mut kept = self.kept;
        if !made.is_empty() {
            let lists = Arc::make_mut(&mut kept.lists);
            for (own, list) in made {
                lists[own] = Some(Arc::new(list));
            }
            let skins = lists.iter().flatten().map(|list| list.skin);
            kept.least_skin = skins.fold(f64::INFINITY, f64::min);
        }
        kept
    }
}

#[cfg(test)]
mod tests {
    use forms_core::contract::Pairing;

    use super::*;
    use crate::element::CellShape;
    use crate::field::Field;
    use crate::mesh::rectangle;
    use crate::pairs::surfaces::Surfaces;
    use crate::pairs::{Displacement, DisplacementField};
    use crate::space::Space;
    use crate::threads::Threads;

    /// Lists serve while motions are small, and give what new ones give.
    #[test]
    fn lists_are_kept_until_the_skin_is_used_up() {
        let mesh = rectangle([0.0; 2], [1.0, 0.1], [20, 1], CellShape::Quadrilateral, 1).unwrap();
        let space = Space::vector(&mesh, 2).unwrap();
        let pairing = Pairing::onto("top", "bottom");
        let mut kept: Option<KeptCandidates<2>> = None;
        let mut made_at = vec![];
        // Facets are 0.05 long, the skin is a half of that; the lower side moves.
        for step in 0..12 {
            let shift = 0.003 * f64::from(step);
            let lower = |x: &[f64; 2]| [if x[1] < 0.05 { shift } else { 0.0 }, 0.0];
            let u = Field::interpolate(&space, lower).unwrap();
            let displacement =
                Displacement { fields: vec![DisplacementField { space: &space, values: u.values() }] };
            let surfaces =
                Surfaces::new(&mesh, &pairing, &Default::default(), Some(&displacement), Threads::ONE)
                    .unwrap();
            let (own, opposite) = (surfaces.of("top"), surfaces.of("bottom"));
            let keeping = Candidates::new(own, opposite, kept.as_ref());
            let fresh = Candidates::new(own, opposite, None);
            let (mut made, mut one, mut other) = (vec![], vec![], vec![]);
            for (index, facet) in own.iter().enumerate() {
                let mut beam = RayBundle::along_normal_of(facet, 0.15);
                for end in facet.parameters().iter().map(|s| facet.at(s)) {
                    beam.hold(&Rays { x: end.position, n: end.normal() }, 1);
                }
                made.extend(keeping.of(index, &beam, 0.05, |_| true, &mut one).map(|list| (index, list)));
                assert!(fresh.of(index, &beam, 0.05, |_| true, &mut other).is_some());
                assert!(one == other && !one.is_empty());
            }
            if !made.is_empty() {
                assert_eq!(made.len(), own.len());
                made_at.push(step);
            }
            kept = Some(keeping.keep(made));
        }
        assert_eq!(made_at, [0, 5, 10]);
    }
}

//! The opposite points of the quadrature points of a surface's facets.

use std::collections::HashMap;
use std::sync::OnceLock;

use forms_core::contract::{Facing, PairQuadrature, Pairing, Projection};

use super::PairError;
use super::boundary_edges::BoundaryEdges;
use super::candidates::{Candidates, KeptCandidates, RayBundle};
use super::cuts;
use super::opposite::{ClosestPoint, hit, nearest};
use super::rays::{Rays, along_ray};
use super::surface::{SurfaceFacet, SurfacePoint, dot, minus, unit};
use super::surfaces::Surfaces;
use super::tolerances::INSIDE;
use crate::element::CellShape;
use crate::locate::BoxGrid;
use crate::mesh::{Facet, Mesh};
use crate::quadrature::{Quadrature, QuadratureRule};

/// Points are accepted whose surfaces face each other: the product of the normals is below this.
pub(super) const FACING: f64 = -0.1;

/// Points of one body count as separated by it up to this many diameters of a facet.
const BEHIND: f64 = 4.0;

/// A point of an own facet, from which an opposite one is looked for.
pub(super) struct RayOrigin<'a, 'm, const D: usize> {
    pub own: &'a SurfaceFacet<'m, D>,
    pub s: [f64; 2],
    pub position: [f64; D],
    pub normal: [f64; D],
}

impl<'a, 'm, const D: usize> RayOrigin<'a, 'm, D> {
    pub fn new(own: &'a SurfaceFacet<'m, D>, s: [f64; 2], point: &SurfacePoint<D>) -> Self {
        RayOrigin { own, s, position: point.position, normal: point.normal() }
    }
}

/// The opposite point that was found.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair<const D: usize> {
    /// The facet, by index among the opposite ones.
    pub facet: usize,
    pub hit: ClosestPoint<D>,
    pub gap: f64,
}

/// Places of an own facet's quadrature points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PlacesOfPoints {
    /// Those of one rule, whatever they face.
    WholeFacets,
    /// A rule on each piece that faces one opposite facet, of surfaces that are fixed.
    Pieces,
    /// The same on displaced surfaces.
    Segments,
}

/// The outcome of a search.
pub(super) enum SearchResult<const D: usize> {
    Found(Pair<D>),
    /// Facets were met, but from behind or beyond the reach.
    Rejected,
    Open,
}

/// The number of facets that are in both of two ascending lists, and the first; none where there is none.
fn in_both<const D: usize>(own: &[SurfaceFacet<D>], opposite: &[SurfaceFacet<D>]) -> Option<(usize, Facet)> {
    let (mut shared, mut rest) = (None, opposite.iter().peekable());
    for SurfaceFacet { facet, .. } in own {
        while rest.next_if(|other| other.facet < *facet).is_some() {}
        if rest.peek().is_some_and(|other| other.facet == *facet) {
            shared.get_or_insert((0, *facet)).0 += 1;
        }
    }
    shared
}

/// A surface, its opposite surface, and the rule that pairs their points.
pub(super) struct Search<'s, 'm, const D: usize> {
    pub mesh: &'m Mesh<D>,
    pub own: &'s [SurfaceFacet<'m, D>],
    pub opposite: &'s [SurfaceFacet<'m, D>],
    /// Boxes around the opposite facets, if requested.
    grid: OnceLock<BoxGrid<D>>,
    rim: BoundaryEdges,
    /// Normals at corners of the opposite surface, means of those of its facets there.
    corner_normals: HashMap<u32, [f64; D]>,
    pub projection: Projection,
    pub places: PlacesOfPoints,
    reach: Option<f64>,
    pub quadrature: &'m Quadrature<D>,
    pub degree: usize,
    /// Rules for whole facets, or segments, of each shape.
    pub rules: Vec<(CellShape, QuadratureRule<2>)>,
    /// A surface that faces itself.
    pub within: bool,
    /// The facets that rays may meet.
    pub candidates: Candidates<D>,
}

impl<'s, 'm, const D: usize> Search<'s, 'm, D> {
    /// The search on surfaces that may be displaced, with the candidates of an earlier one.
    ///
    /// # Errors
    /// A surface that does not exist, or that cannot be searched.
    pub fn new(
        mesh: &'m Mesh<D>,
        pairing: &Pairing,
        facing: &Facing,
        (quadrature, degree): (&'m Quadrature<D>, usize),
        surfaces: &'s Surfaces<'m, D>,
        earlier: Option<&KeptCandidates<D>>,
    ) -> Result<Self, PairError> {
        let (own, opposite) = (surfaces.of(&facing.own), surfaces.of(&facing.opposite));
        if mesh.rigid_surface(&facing.own).is_some() {
            return Err(PairError::RigidSide { surface: facing.own.clone() });
        }
        let within = facing.own == facing.opposite;
        if !within && let Some((count, first)) = in_both(own, opposite) {
            let (own, opposite) = (facing.own.clone(), facing.opposite.clone());
            let position = mesh.facet_centre(first).to_vec();
            return Err(PairError::Overlap { own, opposite, count, position });
        }
        // Displaced surfaces have only rays.
        let projection = if surfaces.displaced { Projection::Ray } else { pairing.projection };
        let places = match (pairing.quadrature, surfaces.displaced) {
            (Some(PairQuadrature::WholeFacets), _) | (None, true) => PlacesOfPoints::WholeFacets,
            (_, false) => PlacesOfPoints::Pieces,
            (Some(PairQuadrature::Pieces), true) => PlacesOfPoints::Segments,
        };
        if places == PlacesOfPoints::Segments {
            cuts::check([&facing.own, &facing.opposite], [own, opposite])?;
        }
        let mut corner_normals: HashMap<u32, [f64; D]> = HashMap::new();
        let mut rim = BoundaryEdges::default();
        if projection == Projection::Nearest {
            for facet in opposite.iter().filter(|_| D == 3) {
                for (vertex, s) in facet.vertices().zip(facet.parameters()) {
                    let sum = corner_normals.entry(vertex).or_insert([0.0; D]);
                    *sum = std::array::from_fn(|k| sum[k] + facet.at(s).normal()[k]);
                }
            }
            corner_normals.values_mut().for_each(|normal| *normal = unit(normal));
            rim = BoundaryEdges::of(opposite);
        }
        let mut rules = Vec::new();
        let estimated = match places {
            PlacesOfPoints::Segments => cuts::degree_of(own, opposite),
            _ => degree,
        };
        for shape in mesh.shapes().into_iter().filter(|_| places != PlacesOfPoints::Pieces) {
            // Pieces in space are triangles.
            let of = match (shape, places) {
                (CellShape::Hexahedron, PlacesOfPoints::Segments) => CellShape::Tetrahedron,
                _ => shape,
            };
            let rule = quadrature.facet_reference_rule(of, estimated);
            rules.push((shape, rule.map_err(|source| PairError::Quadrature { source })?));
        }
        Ok(Search {
            mesh,
            rim,
            own,
            opposite,
            grid: OnceLock::new(),
            corner_normals,
            projection,
            places,
            reach: pairing.reach,
            quadrature,
            degree,
            rules,
            within,
            candidates: Candidates::new(own, opposite, earlier),
        })
    }

    /// The distance at which points of an own facet have partners.
    pub fn reach(&self, own: &SurfaceFacet<D>) -> f64 {
        self.reach_of(own.diameter)
    }

    /// The distance at which points of a facet with this diameter have partners.
    pub fn reach_of(&self, diameter: f64) -> f64 {
        self.reach.unwrap_or(2.0 * diameter)
    }

    /// Whether points of an own facet may face another one: on one surface not a neighbour.
    pub fn may_face(&self, own: &SurfaceFacet<D>, opposite: usize) -> bool {
        if !self.within {
            return true;
        }
        let vertices = self.mesh.cell_vertices(own.facet.cell as usize);
        let others = self.mesh.cell_vertices(self.opposite[opposite].facet.cell as usize);
        !others.iter().any(|vertex| vertices.contains(vertex))
    }

    /// Opposite facets that points of an own one may face, ascending.
    pub fn around(&self, index: usize) -> Vec<usize> {
        let (own, reach) = (&self.own[index], self.reach(&self.own[index]));
        let mut found = Vec::new();
        if self.projection == Projection::Ray && own.affine {
            let mut beam = RayBundle::along_normal_of(own, reach);
            for corner in own.parameters().iter().map(|s| own.at(s)) {
                beam.hold(&Rays { x: corner.position, n: corner.normal() }, 1);
            }
            let may_face = |facet| self.may_face(own, facet);
            self.candidates.of(index, &beam, own.diameter, may_face, &mut found);
            return found;
        }
        let boxes = || BoxGrid::new(self.opposite.iter().map(|facet| facet.corners()).collect());
        let (lower, upper) = own.corners();
        let near = (lower.map(|x| x - reach), upper.map(|x| x + reach));
        found = self.grid.get_or_init(boxes).meeting(&near);
        found.retain(|facet| self.may_face(own, *facet));
        found
    }

    /// The direction in which an opposite corner is taken along to an own facet: the normal of the own facet for rays.
    pub fn direction_at(&self, vertex: u32, normal: &[f64; D]) -> [f64; D] {
        match self.projection {
            Projection::Ray => *normal,
            Projection::Nearest => self.corner_normals.get(&vertex).copied().unwrap_or(*normal),
        }
    }

    /// The point of one facet opposite to x, with the gap.
    pub fn on_facet(&self, facet: usize, from: &RayOrigin<D>) -> Option<Pair<D>> {
        let (x, n) = (&from.position, &from.normal);
        let hit = match self.projection {
            Projection::Ray => along_ray(&self.opposite[facet], x, n)?,
            Projection::Nearest => nearest(&self.opposite[facet], &self.rim, x)?,
        };
        let off = minus(&hit.position, x);
        let gap = match self.projection {
            Projection::Ray => dot(n, &off),
            Projection::Nearest => -dot(&hit.normal, &off),
        };
        Some(Pair { facet, hit, gap })
    }

    /// Candidates with lower bounds of their distance from a point, nearest points first: of these few are looked at.
    fn by_distance(&self, x: &[f64; D], candidates: &[usize]) -> Vec<(f64, usize)> {
        let bound = |facet: &usize| {
            let off = minus(&self.opposite[*facet].centre, x);
            ((dot(&off, &off).sqrt() - self.opposite[*facet].radius).max(0.0), *facet)
        };
        let mut bounds: Vec<(f64, usize)> = candidates.iter().map(bound).collect();
        bounds.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        bounds
    }

    pub fn accepts(&self, partner: &Pair<D>, from: &RayOrigin<D>, reach: f64) -> bool {
        dot(&from.normal, &partner.hit.normal) < FACING
            && partner.gap.abs() <= reach
            && !self.through_the_body((from.own, &from.s), (&self.opposite[partner.facet], &partner.hit.s))
    }

    /// Whether the body itself lies between a point and one that was found on its own surface: before anything was displaced
    /// the point lay behind the other one's surface, and near.
    pub fn through_the_body(
        &self,
        (own, from): (&SurfaceFacet<D>, &[f64; 2]),
        (facet, s): (&SurfaceFacet<D>, &[f64; 2]),
    ) -> bool {
        if !self.within {
            return false;
        }
        let ((x, _), (y, normal)) = (own.undisplaced(from), facet.undisplaced(s));
        let off = minus(&x, &y);
        let distance = dot(&off, &off).sqrt();
        distance < BEHIND * own.diameter && dot(&off, &normal) < -0.01 * distance
    }

    /// The point opposite to x: of those accepted the one with the smallest |g|, or the nearest; of several the one on
    /// the facet with the lowest number.
    pub fn opposite_to(&self, from: &RayOrigin<D>, candidates: &[usize], reach: f64) -> SearchResult<D> {
        match self.projection {
            Projection::Ray => {
                let rays = Rays { x: from.position, n: from.normal };
                let found = self.nearest_on_rays(from.own, &from.s, &rays, candidates, reach, INSIDE);
                let facet = found.facet as usize;
                match (found.found, found.rejected) {
                    (true, _) => {
                        let hit = hit(&self.opposite[facet], found.s, false);
                        SearchResult::Found(Pair { facet, hit, gap: found.gap })
                    }
                    (false, true) => SearchResult::Rejected,
                    (false, false) => SearchResult::Open,
                }
            }
            Projection::Nearest => self.nearest_to(from, candidates, reach),
        }
    }

    /// The nearest point that is accepted.
    fn nearest_to(&self, from: &RayOrigin<D>, candidates: &[usize], reach: f64) -> SearchResult<D> {
        let (mut best, mut rejected): (Option<(f64, Pair<D>)>, bool) = (None, false);
        for (bound, facet) in self.by_distance(&from.position, candidates) {
            if best.as_ref().is_some_and(|(least, _)| bound > *least) {
                break;
            }
            let Some(partner) = self.on_facet(facet, from) else { continue };
            if !self.accepts(&partner, from, reach) {
                rejected |= !partner.hit.at_rim;
                continue;
            }
            let off = minus(&partner.hit.position, &from.position);
            let distance = dot(&off, &off).sqrt();
            let nearer = |(least, known): &(f64, Pair<D>)| (distance, facet) < (*least, known.facet);
            if best.as_ref().is_none_or(nearer) {
                best = Some((distance, partner));
            }
        }
        match best {
            // Beyond the end of a surface its nearest point is no opposite one.
            Some((_, partner)) if !partner.hit.at_rim => SearchResult::Found(partner),
            None if rejected => SearchResult::Rejected,
            _ => SearchResult::Open,
        }
    }
}

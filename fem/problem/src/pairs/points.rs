//! The quadrature points of an own facet, each with its opposite point.

use std::ops::Range;

use forms_core::contract::Projection;

use super::found::{Found, PairPoint, Room};
use super::ray_points::RayRoom;
use super::search::{Pair, PlacesOfPoints, RayOrigin, Search, SearchResult};
use super::segments::SegmentRoom;
use super::surface::SurfaceFacet;
use super::{PairError, clip, pieces};
use crate::lanes::{LaneWork, SimdLane};
use crate::quadrature::{QuadratureRule, facet_reference_rule};

/// Gaps that differ by less than this part of the facet's diameter are of one surface.
const SAME_GAP: f64 = 1e-8;

/// The search for the points of some own facets.
pub(super) struct OfFacets<'a, 's, 'm, const D: usize> {
    pub search: &'a Search<'s, 'm, D>,
    pub facets: Range<usize>,
}

impl<const D: usize> LaneWork for OfFacets<'_, '_, '_, D> {
    type Output = Result<Found<D>, PairError>;

    #[inline(always)]
    fn run<L: SimdLane>(self) -> Self::Output {
        let OfFacets { search, facets } = self;
        let points = search.rules.iter().map(|(_, rule)| rule.points.len()).max().unwrap_or(0);
        let mut found = Found::with_room(facets.len(), points);
        if search.places == PlacesOfPoints::Segments {
            let mut room = SegmentRoom::default();
            for (done, index) in facets.clone().enumerate() {
                found.make_room(done, facets.len());
                found.begin();
                search.add_segments_of::<L>(index, &mut found, &mut room)?;
            }
        } else if search.places == PlacesOfPoints::WholeFacets && search.projection == Projection::Ray {
            let mut rays = RayRoom::<D, L>::new(&search.rules);
            for index in facets {
                found.begin();
                search.add_rays_of(index, &mut found, &mut rays);
            }
        } else {
            let mut room = Room::default();
            for index in facets {
                found.begin();
                search.add_pieces_of(index, &mut found, &mut room)?;
                found.end(search.mesh, &search.own[index], search.opposite, &mut room);
            }
        }
        Ok(found)
    }
}

impl<const D: usize> Search<'_, '_, D> {
    /// The points of pieces, or those that are nearest to the points of a whole facet.
    fn add_pieces_of(&self, index: usize, found: &mut Found<D>, room: &mut Room<D>) -> Result<(), PairError> {
        let own = &self.own[index];
        let shape = self.mesh.cell_shape(own.facet.cell as usize);
        let failed = |source| PairError::Quadrature { source };
        let exact = facet_reference_rule(shape, D * self.mesh.degree() + 6).map_err(failed)?;
        let weighted = exact.points.iter().zip(&exact.weights);
        found.counts().measure = weighted.map(|(s, w)| w * own.at(s).element()).sum();
        let (candidates, reach) = (self.around(index), self.reach(own));
        for (facing, rule) in self.rules(own, &candidates, reach)? {
            for (s, &weight) in rule.points.iter().zip(&rule.weights) {
                let point = own.at(s);
                let from = RayOrigin::new(own, *s, &point);
                let sought = self.opposite_to(&from, &candidates, reach);
                let Some(sought) = self.of_piece(facing, sought, &from, reach) else { continue };
                self.add(sought, &from, (weight, point.element()), found, room);
            }
        }
        Ok(())
    }

    /// Counts the outcome for a point of given weight and surface element.
    fn add(
        &self,
        sought: SearchResult<D>,
        from: &RayOrigin<D>,
        (weight, element): (f64, f64),
        found: &mut Found<D>,
        room: &mut Room<D>,
    ) {
        let counts = found.counts();
        let partner = match sought {
            SearchResult::Found(partner) => partner,
            SearchResult::Rejected | SearchResult::Open => {
                counts.open += 1;
                counts.rejected += usize::from(matches!(sought, SearchResult::Rejected));
                return;
            }
        };
        counts.add_point(&from.position, partner.gap, weight * element);
        let reference = [from.own.reference(&from.s), self.opposite[partner.facet].reference(&partner.hit.s)];
        let toward = match self.projection {
            Projection::Ray => from.normal,
            Projection::Nearest => partner.hit.normal.map(|component| -component),
        };
        let rigid_normal = self.opposite[partner.facet].rigid_normal;
        let point = PairPoint { reference, weight, gap: partner.gap, toward, rigid_normal };
        room.pairs.push((partner.facet, point));
    }

    /// Rules on the own facet's reference cell, each with the opposite facet that it is made for.
    fn rules(
        &self,
        own: &SurfaceFacet<D>,
        candidates: &[usize],
        reach: f64,
    ) -> Result<Vec<(Option<usize>, QuadratureRule<2>)>, PairError> {
        let failed = |source| PairError::Quadrature { source };
        let shape = self.mesh.cell_shape(own.facet.cell as usize);
        if let Some((_, rule)) = self.rules.iter().find(|(known, _)| *known == shape) {
            return Ok(vec![(None, rule.clone())]);
        }
        let on_pieces = |pieces: &[_]| self.quadrature.rule_on_pieces(shape, self.degree, pieces);
        let mut rules = Vec::new();
        if D == 2 {
            for (facet, piece) in pieces::segments(self, own, candidates, reach) {
                rules.push((Some(facet), on_pieces(&[piece]).map_err(failed)?));
            }
        } else {
            let plane = clip::FacetPlane::new(own);
            for &facet in candidates {
                let triangles = plane.facing(self, facet);
                if !triangles.is_empty() {
                    let rule = on_pieces(&triangles).map_err(failed)?;
                    rules.push((Some(facet), plane.on_reference_cell(rule)));
                }
            }
        }
        Ok(rules)
    }

    /// Outcome of the search for a point of a piece that was made for one facet; `None` where another piece, of a surface that is
    /// nearer, lies there too.
    fn of_piece(
        &self,
        facing: Option<usize>,
        sought: SearchResult<D>,
        from: &RayOrigin<D>,
        reach: f64,
    ) -> Option<SearchResult<D>> {
        let (Some(facing), SearchResult::Found(best)) = (facing, &sought) else { return Some(sought) };
        if best.facet == facing {
            return Some(sought);
        }
        let (a, b) = (&self.opposite[best.facet], &self.opposite[facing]);
        let same_gap = |partner: &Pair<D>| best.gap.abs() >= partner.gap.abs() - SAME_GAP * b.radius;
        match self.on_facet(facing, from).filter(|partner| self.accepts(partner, from, reach)) {
            Some(partner) if self.projection == Projection::Ray => {
                if same_gap(&partner) {
                    return Some(SearchResult::Found(partner));
                }
                None
            }
            // The pieces of curved facets are right up to their curvature: the point is its neighbour's.
            _ if D == 2 || a.vertices().any(|vertex| b.vertices().any(|other| other == vertex)) => {
                Some(sought)
            }
            _ => None,
        }
    }
}

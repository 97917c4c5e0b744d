//! The opposite points of the quadrature points of a surface's facets.

use std::collections::HashMap;

use forms_core::contract::{Facing, PairQuadrature, Pairing, Projection};

use super::displacement::Displacement;
use super::opposite::{Hit, along_ray, nearest};
use super::surface::{Rim, SurfaceFacet, SurfacePoint, dot, minus, unit};
use super::{PairError, clip, pieces};
use crate::locate::BoxGrid;
use crate::mesh::{Facet, Mesh};
use crate::quadrature::{Quadrature, QuadratureRule, facet_reference_rule};

/// Points are accepted whose surfaces face each other: the product of the normals is below this.
const FACING: f64 = -0.1;

/// Points of one body count as separated by it up to this many diameters of a facet.
const BEHIND: f64 = 4.0;

/// Gaps that differ by less than this part of the facet's diameter are of one surface.
const SAME_GAP: f64 = 1e-8;

/// A quadrature point with its opposite point.
#[derive(Clone, Copy, Debug)]
pub(super) struct PairPoint<const D: usize> {
    /// Reference coordinates in the own cell and in the opposite one.
    pub reference: [[f64; D]; 2],
    /// Weight on the own facet's reference cell.
    pub weight: f64,
    pub gap: f64,
    pub toward: [f64; D],
}

/// The points of an own facet that lie opposite to one facet.
#[derive(Clone, Debug)]
pub(super) struct Unit<const D: usize> {
    /// The own facet and the opposite one.
    pub facets: [Facet; 2],
    pub points: Vec<PairPoint<D>>,
}

/// A point of an own facet, from which an opposite one is looked for.
pub(super) struct Viewpoint<'a, 'm, const D: usize> {
    own: &'a SurfaceFacet<'m, D>,
    s: [f64; 2],
    pub position: [f64; D],
    pub normal: [f64; D],
}

impl<'a, 'm, const D: usize> Viewpoint<'a, 'm, D> {
    pub fn new(own: &'a SurfaceFacet<'m, D>, s: [f64; 2], point: &SurfacePoint<D>) -> Self {
        Viewpoint { own, s, position: point.position, normal: point.normal() }
    }
}

/// The opposite point that was found.
#[derive(Clone, Copy, Debug)]
pub(super) struct Partner<const D: usize> {
    /// The facet, by index among the opposite ones.
    pub facet: usize,
    pub hit: Hit<D>,
    pub gap: f64,
}

/// The outcome of a search.
pub(super) enum Sought<const D: usize> {
    Found(Partner<D>),
    /// Facets were met, but from behind or beyond the reach.
    Rejected,
    Open,
}

/// Numbers of a search, added up over facets.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Counts {
    pub points: usize,
    pub open: usize,
    pub rejected: usize,
    pub deepest: f64,
    pub largest: f64,
    pub paired: f64,
    pub measure: f64,
}

impl Counts {
    pub fn add(&mut self, other: &Counts) {
        self.points += other.points;
        self.open += other.open;
        self.rejected += other.rejected;
        self.deepest = self.deepest.max(other.deepest);
        self.largest = self.largest.max(other.largest);
        self.paired += other.paired;
        self.measure += other.measure;
    }
}

/// A surface, the one opposite to it, and how points of the two belong together.
pub(super) struct Search<'m, const D: usize> {
    mesh: &'m Mesh<D>,
    pub own: Vec<SurfaceFacet<'m, D>>,
    pub opposite: Vec<SurfaceFacet<'m, D>>,
    grid: BoxGrid<D>,
    rim: Rim,
    /// Normals at corners of the opposite surface, means of those of its facets there.
    corner_normals: HashMap<u32, [f64; D]>,
    pub projection: Projection,
    whole: bool,
    reach: Option<f64>,
    quadrature: &'m Quadrature<D>,
    degree: usize,
    /// A surface that faces itself.
    within: bool,
}

impl<'m, const D: usize> Search<'m, D> {
    pub fn new(
        mesh: &'m Mesh<D>,
        pairing: &Pairing,
        facing: &Facing,
        quadrature: &'m Quadrature<D>,
        degree: usize,
        displacement: Option<&Displacement<D>>,
    ) -> Result<Self, PairError> {
        if let Some(reach) = pairing.reach
            && !(reach > 0.0 && reach.is_finite())
        {
            return Err(PairError::Reach { reach });
        }
        let surface = |name: &str| {
            let facets = mesh.facet_region(name).map_err(|source| PairError::Surface { source })?;
            match facets.is_empty() {
                true => Err(PairError::Empty { surface: name.to_owned() }),
                false => Ok(facets),
            }
        };
        let (own, opposite) = (surface(&facing.own)?, surface(&facing.opposite)?);
        let within = facing.own == facing.opposite;
        let shared: Vec<&Facet> =
            own.iter().filter(|facet| !within && opposite.binary_search(facet).is_ok()).collect();
        if let Some(first) = shared.first() {
            let (own, opposite) = (facing.own.clone(), facing.opposite.clone());
            let position = mesh.facet_centre(**first).to_vec();
            return Err(PairError::Overlap { own, opposite, count: shared.len(), position });
        }
        // Displaced surfaces have rays alone.
        let projection = if displacement.is_some() { Projection::Ray } else { pairing.projection };
        let parametrised = |facets: &[Facet]| -> Vec<SurfaceFacet<'m, D>> {
            facets.iter().map(|facet| SurfaceFacet::new(mesh, *facet, displacement)).collect()
        };
        let (own, opposite) = (parametrised(own), parametrised(opposite));
        let grid = BoxGrid::new(opposite.iter().map(SurfaceFacet::corners).collect());
        let mut corner_normals: HashMap<u32, [f64; D]> = HashMap::new();
        for facet in opposite.iter().filter(|_| D == 3 && projection == Projection::Nearest) {
            for (vertex, s) in facet.vertices().zip(facet.parameters()) {
                let sum = corner_normals.entry(vertex).or_insert([0.0; D]);
                *sum = std::array::from_fn(|k| sum[k] + facet.at(s).normal()[k]);
            }
        }
        corner_normals.values_mut().for_each(|normal| *normal = unit(normal));
        Ok(Search {
            mesh,
            rim: Rim::of(&opposite),
            own,
            opposite,
            grid,
            corner_normals,
            projection,
            whole: pairing.quadrature == PairQuadrature::WholeFacets || displacement.is_some(),
            reach: pairing.reach,
            quadrature,
            degree,
            within,
        })
    }

    /// The distance at which points of an own facet have partners.
    fn reach(&self, own: &SurfaceFacet<D>) -> f64 {
        self.reach.unwrap_or_else(|| 2.0 * own.diameter())
    }

    /// Opposite facets that points of an own one may face, ascending.
    fn candidates(&self, own: &SurfaceFacet<D>) -> Vec<usize> {
        let reach = self.reach(own);
        let (lower, upper) = own.corners();
        let mut found = self.grid.meeting(&(lower.map(|x| x - reach), upper.map(|x| x + reach)));
        if self.within {
            let vertices = self.mesh.cell_vertices(own.facet.cell as usize);
            found.retain(|index| {
                let others = self.mesh.cell_vertices(self.opposite[*index].facet.cell as usize);
                !others.iter().any(|vertex| vertices.contains(vertex))
            });
        }
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
    fn on_facet(&self, facet: usize, from: &Viewpoint<D>) -> Option<Partner<D>> {
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
        Some(Partner { facet, hit, gap })
    }

    /// Candidates with lower bounds of their distance from a point, nearest points first: of these few are looked at. Rays
    /// pass most candidates by, which is seen at once.
    fn by_distance(&self, x: &[f64; D], candidates: &[usize]) -> Vec<(f64, usize)> {
        if self.projection == Projection::Ray {
            return candidates.iter().map(|facet| (0.0, *facet)).collect();
        }
        let bound = |facet: &usize| {
            let off = minus(&self.opposite[*facet].centre, x);
            ((dot(&off, &off).sqrt() - self.opposite[*facet].radius).max(0.0), *facet)
        };
        let mut bounds: Vec<(f64, usize)> = candidates.iter().map(bound).collect();
        bounds.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        bounds
    }

    fn accepts(&self, partner: &Partner<D>, from: &Viewpoint<D>, reach: f64) -> bool {
        dot(&from.normal, &partner.hit.normal) < FACING
            && partner.gap.abs() <= reach
            && !self.through_the_body(from, partner)
    }

    /// Whether the body itself lies between a point and one that was found on its own surface: before anything was displaced
    /// the point lay behind the other one's surface, and near.
    fn through_the_body(&self, from: &Viewpoint<D>, partner: &Partner<D>) -> bool {
        if !self.within {
            return false;
        }
        let own = from.own;
        let ((x, _), (y, normal)) =
            (own.undisplaced(&from.s), self.opposite[partner.facet].undisplaced(&partner.hit.s));
        let off = minus(&x, &y);
        let distance = dot(&off, &off).sqrt();
        distance < BEHIND * own.diameter() && dot(&off, &normal) < -0.01 * distance
    }

    /// The point opposite to x: of those accepted the one with the smallest |g|, or the nearest; of several the one on
    /// the facet with the lowest number.
    pub fn opposite_to(&self, from: &Viewpoint<D>, candidates: &[usize], reach: f64) -> Sought<D> {
        let x = &from.position;
        let (mut best, mut rejected): (Option<(f64, Partner<D>)>, bool) = (None, false);
        for (bound, facet) in self.by_distance(x, candidates) {
            if best.as_ref().is_some_and(|(least, _)| bound > *least) {
                break;
            }
            let Some(partner) = self.on_facet(facet, from) else { continue };
            if !self.accepts(&partner, from, reach) {
                rejected |= !partner.hit.at_rim;
                continue;
            }
            let measure = match self.projection {
                Projection::Ray => partner.gap.abs(),
                Projection::Nearest => {
                    let off = minus(&partner.hit.position, x);
                    dot(&off, &off).sqrt()
                }
            };
            let nearer = |(least, known): &(f64, Partner<D>)| (measure, facet) < (*least, known.facet);
            if best.as_ref().is_none_or(nearer) {
                best = Some((measure, partner));
            }
        }
        match best {
            // Beyond the end of a surface its nearest point is no opposite one.
            Some((_, partner)) if !partner.hit.at_rim => Sought::Found(partner),
            None if rejected => Sought::Rejected,
            _ => Sought::Open,
        }
    }

    /// The pairs of an own facet, by opposite facets in the order of its points.
    pub fn pairs_of(&self, index: usize) -> Result<(Vec<Unit<D>>, Counts), PairError> {
        let own = &self.own[index];
        let shape = self.mesh.cell_shape(own.facet.cell as usize);
        let failed = |source| PairError::Quadrature { source };
        let exact = facet_reference_rule(shape, D * self.mesh.degree() + 6).map_err(failed)?;
        let weighted = exact.points.iter().zip(&exact.weights);
        let mut counts =
            Counts { measure: weighted.map(|(s, w)| w * own.at(s).element()).sum(), ..Counts::default() };
        let (candidates, reach) = (self.candidates(own), self.reach(own));
        let mut units: Vec<Unit<D>> = Vec::new();
        for (facing, rule) in self.rules(own, &candidates, reach)? {
            for (s, &weight) in rule.points.iter().zip(&rule.weights) {
                let point = own.at(s);
                let from = Viewpoint::new(own, *s, &point);
                let sought = self.opposite_to(&from, &candidates, reach);
                let Some(sought) = self.of_piece(facing, sought, &from, reach) else { continue };
                let partner = match sought {
                    Sought::Found(partner) => partner,
                    Sought::Rejected | Sought::Open => {
                        counts.open += 1;
                        counts.rejected += usize::from(matches!(sought, Sought::Rejected));
                        continue;
                    }
                };
                counts.points += 1;
                counts.deepest = counts.deepest.max(-partner.gap);
                counts.largest = counts.largest.max(partner.gap);
                counts.paired += weight * point.element();
                let opposite = &self.opposite[partner.facet];
                let reference = [own.reference(s), opposite.reference(&partner.hit.s)];
                let toward = match self.projection {
                    Projection::Ray => from.normal,
                    Projection::Nearest => partner.hit.normal.map(|component| -component),
                };
                let facets = [own.facet, opposite.facet];
                let point = PairPoint { reference, weight, gap: partner.gap, toward };
                match units.iter_mut().find(|unit| unit.facets == facets) {
                    Some(unit) => unit.points.push(point),
                    None => units.push(Unit { facets, points: vec![point] }),
                }
            }
        }
        Ok((units, counts))
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
        if self.whole {
            let rule = self.quadrature.facet_reference_rule(shape, self.degree).map_err(failed)?;
            return Ok(vec![(None, rule)]);
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
        sought: Sought<D>,
        from: &Viewpoint<D>,
        reach: f64,
    ) -> Option<Sought<D>> {
        let (Some(facing), Sought::Found(best)) = (facing, &sought) else { return Some(sought) };
        if best.facet == facing {
            return Some(sought);
        }
        let (a, b) = (&self.opposite[best.facet], &self.opposite[facing]);
        let same_gap = |partner: &Partner<D>| best.gap.abs() >= partner.gap.abs() - SAME_GAP * b.radius;
        match self.on_facet(facing, from).filter(|partner| self.accepts(partner, from, reach)) {
            Some(partner) if self.projection == Projection::Ray => {
                if same_gap(&partner) {
                    return Some(Sought::Found(partner));
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

//! The pieces of a facet in the plane: parts of its segment that face one opposite facet.

use forms_core::contract::Projection;

use super::search::{RayOrigin, Search, SearchResult};
use super::surface::{SurfaceFacet, dot, minus};
use crate::quadrature::Piece;

/// Pieces shorter than this part of their facet hold nothing.
const SHORTEST: f64 = 1e-14;

/// Halvings of the interval of a root: to the last bit.
const HALVINGS: usize = 60;

/// The parts of an own facet between the places that face ends of opposite facets, each with the facet that it faces.
pub(super) fn segments<const D: usize>(
    search: &Search<D>,
    own: &SurfaceFacet<D>,
    candidates: &[usize],
    reach: f64,
) -> Vec<(usize, Piece)> {
    let mut ends = vec![0.0, 1.0];
    for &index in candidates {
        let opposite = &search.opposite[index];
        for s in opposite.parameters() {
            let end = opposite.at(s);
            // Where the end lies on the normal of the own facet, or the own point on the normal at the end.
            let across = |t: f64| {
                let point = own.at(&[t, 0.0]);
                let off = minus(&end.position, &point.position);
                match search.projection {
                    Projection::Ray => dot(&off, &point.tangents[0]),
                    Projection::Nearest => dot(&off, &end.tangents[0]),
                }
            };
            ends.extend(root(across, own.affine));
        }
    }
    ends.sort_unstable_by(f64::total_cmp);
    let mut found: Vec<(usize, Piece)> = Vec::new();
    for pair in ends.windows(2) {
        let [first, last] = [pair[0], pair[1]];
        if last - first <= SHORTEST {
            continue;
        }
        let middle = [0.5 * (first + last), 0.0];
        let middle = RayOrigin::new(own, middle, &own.at(&middle));
        let sought = search.opposite_to(&middle, candidates, reach);
        let SearchResult::Found(partner) = sought else { continue };
        match found.last_mut() {
            // The end of a facet that is hidden behind another one ends nothing.
            Some((facet, piece))
                if *facet == partner.facet
                    && first - piece[1][0] <= SHORTEST
                    && search.projection == Projection::Ray =>
            {
                piece[1][0] = last;
            }
            _ => found.push((partner.facet, [[first, 0.0], [last, 0.0], [0.0; 2]])),
        }
    }
    found
}

/// The zero inside (0, 1) of a function that changes its sign there.
fn root(function: impl Fn(f64) -> f64, affine: bool) -> Option<f64> {
    let (mut low, mut high) = (0.0, 1.0);
    let (first, last) = (function(low), function(high));
    let product = first * last;
    if product.is_nan() || product >= 0.0 {
        return None;
    }
    if affine {
        return Some(first / (first - last));
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if function(middle) * first > 0.0 { low = middle } else { high = middle }
    }
    Some(0.5 * (low + high))
}

//! Interior facets between a small cell and a larger one: the small cell's facet is a part of the other's.

use std::collections::HashMap;

use super::conformity::{HangingNode, SAME_PLACE};
use super::{BOUNDARY, Facet, INTERIOR, Mesh, MeshError};
use crate::element::{CellShape, Lagrange};

/// The corners of a small facet, its first, second and last vertex, in reference coordinates of the larger one's cell.
pub(super) type PartCorners<const D: usize> = [[f64; D]; 3];

/// A node of a cell by its local number, with its coordinates on a facet.
type NodeOnFacet = (usize, [f64; 2]);

/// The facets of a mesh that are parts of larger ones.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct FacetParts<const D: usize> {
    /// The small facets in ascending order, each with the larger one and the number of its place there.
    facets: Vec<(Facet, Facet, u32)>,
    /// The different places.
    places: Vec<PartCorners<D>>,
}

/// Relation of the two sides of an interior facet.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Facing {
    /// For each vertex of the first side's facet, in the order of [`crate::element::CellShape::facet_vertices`], its place among
    /// those of the second side.
    Whole([u8; 4]),
    /// The first side is a part of the second; [`Mesh::part_corners`] knows the number.
    FirstIsPart(u32),
    /// The second side is a part of the first.
    SecondIsPart(u32),
}

impl<const D: usize> FacetParts<D> {
    /// Parts from small facets, the larger ones and the places on these.
    pub(super) fn new(found: Vec<(Facet, Facet, PartCorners<D>)>) -> Self {
        let mut numbers: HashMap<[[u64; D]; 3], u32> = HashMap::new();
        let mut places = Vec::new();
        let mut facets: Vec<(Facet, Facet, u32)> = Vec::with_capacity(found.len());
        for (small, large, corners) in found {
            let bits = corners.map(|corner| corner.map(f64::to_bits));
            let number = *numbers.entry(bits).or_insert_with(|| {
                places.push(corners);
                places.len() as u32 - 1
            });
            facets.push((small, large, number));
        }
        facets.sort_unstable();
        FacetParts { facets, places }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.facets.is_empty()
    }

    /// The same of cells with other numbers, in addition to the present ones.
    pub(super) fn extend_shifted(&mut self, others: &Self, start: u32) {
        let first = self.places.len() as u32;
        let shifted = |facet: &Facet| Facet { cell: facet.cell + start, ..*facet };
        let moved =
            others.facets.iter().map(|(small, large, place)| (shifted(small), shifted(large), place + first));
        self.facets.extend(moved);
        self.facets.sort_unstable();
        self.places.extend(&others.places);
    }

    /// The larger facet that a small one is a part of, and where.
    fn of(&self, small: Facet) -> Option<(Facet, u32)> {
        let found = self.facets.binary_search_by_key(&small, |(small, ..)| *small).ok()?;
        let (_, large, place) = self.facets[found];
        Some((large, place))
    }
}

impl<const D: usize> Mesh<D> {
    /// The small facets that are parts of larger ones across them, with these and with the places of their first, second and last vertices
    /// in reference coordinates of the larger one's cell.
    #[doc(hidden)]
    pub fn facet_parts(&self) -> impl Iterator<Item = (Facet, Facet, &[[f64; D]; 3])> {
        self.parts
            .facets
            .iter()
            .map(|(small, large, place)| (*small, *large, &self.parts.places[*place as usize]))
    }

    /// Makes interior facets of exterior ones that are parts of larger ones.
    pub(super) fn join_parts(&mut self, parts: FacetParts<D>) {
        let mut joined: Vec<Facet> =
            parts.facets.iter().flat_map(|(small, large, _)| [*small, *large]).collect();
        joined.sort_unstable();
        let data = self.data_mut();
        if let Some(facets) = data.facet_regions.get_mut(BOUNDARY) {
            facets.retain(|facet| joined.binary_search(facet).is_err());
        }
        if !parts.is_empty() {
            let interior = data.interior_regions.entry(INTERIOR.to_owned()).or_default();
            interior
                .extend(parts.facets.iter().map(|(small, large, _)| [*small.min(large), *small.max(large)]));
            interior.sort_unstable();
        }
        data.parts = parts;
    }

    /// Which of two sides is a part of the other, if one is.
    pub(super) fn facing_in_part(&self, sides: &[Facet; 2]) -> Option<Facing> {
        let of = |small: Facet, large: Facet| {
            self.parts.of(small).filter(|(other, _)| *other == large).map(|(_, place)| place)
        };
        if self.parts.is_empty() {
            return None;
        }
        let first = of(sides[0], sides[1]).map(Facing::FirstIsPart);
        first.or_else(|| of(sides[1], sides[0]).map(Facing::SecondIsPart))
    }

    /// The corners of a part in reference coordinates of the larger cell, by the number that [`Mesh::facing`] gives.
    #[doc(hidden)]
    pub fn part_corners(&self, number: u32) -> &[[f64; D]; 3] {
        &self.parts.places[number as usize]
    }

    /// The side of an interior facet that is no larger than the other.
    #[doc(hidden)]
    pub fn smaller_side(&self, sides: &[Facet; 2]) -> Facet {
        match self.facing_in_part(sides) {
            Some(Facing::SecondIsPart(_)) => sides[1],
            _ => sides[0],
        }
    }

    /// Whether no facet is a part of a larger one across it, for what knows only facets that two cells share.
    pub(super) fn without_facet_parts(&self, what: &'static str) -> Result<(), MeshError> {
        match self.parts.facets.first() {
            None => Ok(()),
            Some((small, large, _)) => Err(MeshError::FacetParts { facets: [*small, *large], what }),
        }
    }

    /// Whether no facet of one region, of whatever kind, is a part of a larger one across it.
    ///
    /// # Errors
    /// [`MeshError::FacetParts`] with both facets.
    #[doc(hidden)]
    pub fn without_facet_parts_in(&self, region: &str, what: &'static str) -> Result<(), MeshError> {
        let facets = self.interior_facet_region(region).unwrap_or_default();
        match facets.iter().find(|sides| self.facing_in_part(sides).is_some()) {
            None => Ok(()),
            Some(sides) => {
                let small = self.smaller_side(sides);
                let large = if small == sides[0] { sides[1] } else { sides[0] };
                Err(MeshError::FacetParts { facets: [small, large], what })
            }
        }
    }

    /// The nodes of small facets that the larger cell does not have, each with the larger facet and its reference coordinates there.
    pub(super) fn nodes_on_parts(&self) -> Vec<(u32, Facet, [f64; D])> {
        let mut found = Vec::new();
        let mut tables: HashMap<(CellShape, u8), Vec<NodeOnFacet>> = HashMap::new();
        for (small, large, corners) in self.facet_parts() {
            let shape = self.cell_shape(small.cell as usize);
            let on_facet = tables
                .entry((shape, small.local))
                .or_insert_with(|| facet_coordinates::<D>(&self.element_of(shape), small.local.into()));
            let (own, others) = (self.cell(small.cell as usize), self.cell(large.cell as usize));
            for (local, [s, t]) in on_facet.iter() {
                if !others.contains(&own[*local]) {
                    let [first, second, last] = corners;
                    let t = if D == 2 { 0.0 } else { *t };
                    let place = |k| first[k] + *s * (second[k] - first[k]) + t * (last[k] - first[k]);
                    found.push((own[*local], large, std::array::from_fn(place)));
                }
            }
        }
        found
    }

    /// The nodes that hang on larger facets across small ones: each once, with the first facet.
    pub(super) fn nodes_hanging_on_parts(&self) -> Vec<HangingNode<D>> {
        let vertices = |small: Facet| self.facet_vertices(small).collect::<Vec<_>>();
        let mut found = Vec::new();
        for (small, large, _) in self.facet_parts() {
            let others = vertices(large);
            for node in vertices(small).into_iter().filter(|node| !others.contains(node)) {
                found.push(HangingNode { node, position: self.nodes[node as usize], facet: large });
            }
        }
        found.sort_unstable_by_key(|hanging| (hanging.node, hanging.facet));
        found.dedup();
        found
    }

    /// Check that all nodes of small facets lie on the larger ones.
    pub(super) fn check_parts(&self) -> Result<(), MeshError> {
        for (node, large, reference) in self.nodes_on_parts() {
            let (here, there) = (self.nodes[node as usize], self.map(large.cell as usize, &reference).0);
            let distance = |a: &[f64; D], b: &[f64; D]| -> f64 {
                a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
            };
            if distance(&here, &there) > SAME_PLACE * self.diameter(large.cell as usize) {
                let has = |(small, other, _): &(Facet, Facet, &PartCorners<D>)| {
                    *other == large && self.cell(small.cell as usize).contains(&node)
                };
                let small = self.facet_parts().find(has).map_or(large, |(small, ..)| small);
                return Err(MeshError::NotNested { facets: [small, large], position: here.to_vec() });
            }
        }
        Ok(())
    }
}

/// The nodes of a cell on a facet, with their coordinates on the facet: from its first vertex to its second and to its last.
fn facet_coordinates<const D: usize>(element: &Lagrange, local: usize) -> Vec<NodeOnFacet> {
    let vertices = element.shape.facet_vertices(local);
    let corner = |place: usize| element.shape.vertex_points()[vertices[place]];
    let (first, second, last) = (corner(0), corner(1), corner(vertices.len() - 1));
    let points = element.node_points::<D>();
    // Along an axis of the reference cell a tangent has one component, on the slanting sides of simplices two: by least squares.
    let along = |node: usize, to: [f64; 3]| -> f64 {
        let (mut product, mut square) = (0.0, 0.0);
        for k in 0..D {
            product += (points[node][k] - first[k]) * (to[k] - first[k]);
            square += (to[k] - first[k]) * (to[k] - first[k]);
        }
        product / square
    };
    element
        .facet_nodes(local)
        .into_iter()
        .map(|node| (node, [along(node, second), along(node, last)]))
        .collect()
}

//! The edges and corners at which a surface ends.

use std::collections::HashMap;

use super::surface::SurfaceFacet;

/// The ends of a surface: corners and edges of its facets behind which it does not go on.
#[derive(Clone, Debug, Default)]
pub(super) struct BoundaryEdges {
    edges: HashMap<[u32; 2], usize>,
    vertices: HashMap<u32, bool>,
}

impl BoundaryEdges {
    /// The rim of some facets; each is listed once.
    pub fn of<const D: usize>(facets: &[SurfaceFacet<D>]) -> Self {
        let mut rim = BoundaryEdges::default();
        for facet in facets {
            let corners: Vec<u32> = facet.vertices().collect();
            for (k, &first) in corners.iter().enumerate() {
                let edge = if D == 2 { [first; 2] } else { [first, corners[(k + 1) % corners.len()]] };
                *rim.edges.entry([edge[0].min(edge[1]), edge[0].max(edge[1])]).or_default() += 1;
            }
        }
        for (edge, count) in &rim.edges {
            for vertex in edge {
                *rim.vertices.entry(*vertex).or_default() |= *count < 2;
            }
        }
        rim
    }

    /// Whether the surface ends at a corner.
    pub fn at_vertex(&self, vertex: u32) -> bool {
        self.vertices.get(&vertex).copied().unwrap_or(true)
    }

    /// Whether the surface ends at the edge between two corners.
    pub fn at_edge(&self, a: u32, b: u32) -> bool {
        self.edges.get(&[a.min(b), a.max(b)]).is_none_or(|count| *count < 2)
    }
}

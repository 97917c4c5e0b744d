//! Facets before they are displaced: what all displacements have in common is found once.

use std::sync::{Arc, Mutex, PoisonError};

use super::displacement::Displacement;
use super::frame::{dot, minus};
use super::newest::keep;
use super::traces::{Coefficients, Traces, add_trace};
use crate::element::Elements;
use crate::mesh::{Facet, Mesh};
use crate::space::{Scope, Space};

/// A facet of the undeformed mesh.
#[derive(Clone, Debug)]
pub(super) struct FacetAtRest<const D: usize> {
    pub facet: Facet,
    /// Its first corner and its tangents in the cell's reference coordinates; the second one is zero in the plane.
    pub origin: [f64; D],
    pub tangents: [[f64; D]; 2],
    /// Whether its own reference cell is the unit triangle.
    pub triangle: bool,
    /// The numbers of its corners, as many as it has.
    pub vertices: [u32; 4],
    /// The largest distance between two corners.
    pub diameter: f64,
    /// The position as a polynomial of its own coordinates; zero where the mesh has a higher degree than two.
    pub polynomial: Coefficients<D>,
}

impl<const D: usize> FacetAtRest<D> {
    /// Some facets of a mesh.
    pub fn all(mesh: &Mesh<D>, facets: &[Facet]) -> Vec<Self> {
        let mut traces = Traces::default();
        facets.iter().map(|facet| FacetAtRest::of(mesh, *facet, &mut traces)).collect()
    }

    fn of(mesh: &Mesh<D>, facet: Facet, traces: &mut Traces) -> Self {
        let (cell, local) = (facet.cell as usize, usize::from(facet.local));
        let shape = mesh.cell_shape(cell);
        let (corners, nodes) = (shape.facet_vertices(local), mesh.cell(cell));
        let corner =
            |vertex: usize| -> [f64; D] { std::array::from_fn(|k| shape.vertex_points()[vertex][k]) };
        let origin = corner(corners[0]);
        let along = minus(&corner(corners[1]), &origin);
        let across = if D == 2 { [0.0; D] } else { minus(&corner(corners[corners.len() - 1]), &origin) };
        let tangents = [along, across];
        let vertices: [u32; 4] = std::array::from_fn(|k| corners.get(k).map_or(0, |vertex| nodes[*vertex]));
        let diameter = spread::<D>(corners.len(), |k| mesh.nodes()[vertices[k] as usize]);
        let mut polynomial = Coefficients::ZERO;
        if mesh.degree() <= 2 {
            let trace = traces.of(mesh.element_of(shape), local, &origin, &tangents);
            add_trace(&mut polynomial, trace, |k| mesh.nodes()[nodes[trace[k].node] as usize]);
        }
        let triangle = D == 3 && shape.is_simplex();
        FacetAtRest { facet, origin, tangents, triangle, vertices, diameter, polynomial }
    }
}

/// Surfaces that are remembered, and lists of nodes; the oldest go.
const REMEMBERED: usize = 64;

/// A surface at rest, with the nodes of some spaces whose fields displace it.
#[derive(Clone, Debug)]
pub(super) struct SurfaceAtRest<const D: usize> {
    /// In the order of its region.
    pub facets: Arc<[FacetAtRest<D>]>,
    /// Of each space.
    pub nodes: Vec<Arc<NodesOfFacets>>,
}

/// The nodes of a space that have a trace on the facets of a surface, in the order of [`Traces::of`]; cells' own lists lie far apart.
#[derive(Debug)]
pub(super) struct NodesOfFacets {
    numbers: Vec<u32>,
    /// Entries per facet; one with fewer nodes does not use all.
    stride: usize,
}

impl NodesOfFacets {
    fn new<const D: usize>(space: &Space<D>, mesh: &Mesh<D>, facets: &[FacetAtRest<D>]) -> Self {
        let mut traces = Traces::default();
        let mut lists: Vec<Vec<u32>> = Vec::with_capacity(facets.len());
        for FacetAtRest { facet, origin, tangents, .. } in facets {
            let element = space.traces_of(mesh.cell_shape(facet.cell as usize));
            let nodes = space.nodes_at(facet.cell, Some(facet.local));
            let trace = traces.of(element, usize::from(facet.local), origin, tangents);
            lists.push(trace.iter().map(|of_node| nodes[of_node.node]).collect());
        }
        let stride = lists.iter().map(Vec::len).max().unwrap_or(0);
        let mut numbers = vec![0; stride * facets.len()];
        for (index, list) in lists.iter().enumerate() {
            numbers[index * stride..][..list.len()].copy_from_slice(list);
        }
        NodesOfFacets { numbers, stride }
    }

    /// The nodes of a facet, by its place in the region.
    #[inline]
    pub fn of(&self, facet: usize) -> &[u32] {
        &self.numbers[facet * self.stride..][..self.stride]
    }
}

/// Surfaces of one mesh that were looked at.
#[derive(Debug)]
pub(super) struct SurfacesAtRest<const D: usize> {
    facets: Mutex<Vec<(String, Arc<[FacetAtRest<D>]>)>>,
    nodes: Mutex<Vec<NodesOfSpace>>,
}

#[derive(Debug)]
struct NodesOfSpace {
    surface: String,
    elements: Elements,
    scope: Scope,
    nodes: Arc<NodesOfFacets>,
}

impl<const D: usize> Default for SurfacesAtRest<D> {
    fn default() -> Self {
        SurfacesAtRest { facets: Mutex::default(), nodes: Mutex::default() }
    }
}

impl<const D: usize> SurfacesAtRest<D> {
    /// A surface of that mesh with these facets, and its parts that some fields displace.
    pub fn of(
        &self,
        mesh: &Mesh<D>,
        surface: &str,
        facets: &[Facet],
        displacement: Option<&Displacement<D>>,
    ) -> SurfaceAtRest<D> {
        let facets = {
            let mut known = self.facets.lock().unwrap_or_else(PoisonError::into_inner);
            match known.iter().find(|(name, _)| name == surface) {
                Some((_, facets)) => Arc::clone(facets),
                None => {
                    let found: Arc<[FacetAtRest<D>]> = FacetAtRest::all(mesh, facets).into();
                    keep(&mut known, (surface.to_owned(), Arc::clone(&found)), REMEMBERED, |_| true);
                    found
                }
            }
        };
        // Above degree two facets are no polynomials that are made of traces.
        let is_polynomial = |displacement: &&Displacement<D>| displacement.degree().max(mesh.degree()) <= 2;
        let fields = displacement.filter(is_polynomial).map_or(&[][..], |displacement| &displacement.fields);
        let nodes = fields.iter().map(|field| self.nodes(field.space, mesh, surface, &facets)).collect();
        SurfaceAtRest { facets, nodes }
    }

    fn nodes(
        &self,
        space: &Space<D>,
        mesh: &Mesh<D>,
        surface: &str,
        facets: &[FacetAtRest<D>],
    ) -> Arc<NodesOfFacets> {
        let mut known = self.nodes.lock().unwrap_or_else(PoisonError::into_inner);
        let is_this = |known: &&NodesOfSpace| {
            known.elements == space.elements && known.scope == space.scope && known.surface == surface
        };
        if let Some(known) = known.iter().find(is_this) {
            return Arc::clone(&known.nodes);
        }
        let nodes = Arc::new(NodesOfFacets::new(space, mesh, facets));
        let (elements, scope) = (space.elements.clone(), space.scope.clone());
        let entry = NodesOfSpace { surface: surface.to_owned(), elements, scope, nodes: Arc::clone(&nodes) };
        keep(&mut known, entry, REMEMBERED, |_| true);
        nodes
    }
}

/// The largest distance between two of some points, four at most.
#[inline(always)]
pub(super) fn spread<const D: usize>(count: usize, point: impl Fn(usize) -> [f64; D]) -> f64 {
    let (mut points, mut largest) = ([[0.0; D]; 4], 0.0_f64);
    for k in 0..count {
        points[k] = point(k);
        for other in &points[..k] {
            let off = minus(&points[k], other);
            largest = largest.max(dot(&off, &off));
        }
    }
    largest.sqrt()
}

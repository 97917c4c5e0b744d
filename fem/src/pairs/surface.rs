//! Facets as parametrised surfaces: positions, tangents, normals, and the edges at which a surface ends.

use std::collections::HashMap;

use super::displacement::{CellDisplacement, Displacement};
use crate::element::Lagrange;
use crate::locate::{Corners, box_around};
use crate::mesh::{Facet, Mesh};

/// A facet of a mesh over its own reference cell, whose second coordinate is zero in the plane; where it is displaced, the
/// displaced facet.
#[derive(Clone, Debug)]
pub(super) struct SurfaceFacet<'m, const D: usize> {
    mesh: &'m Mesh<D>,
    pub facet: Facet,
    displacement: Option<CellDisplacement<D>>,
    /// The facet's first corner and tangents in the cell's reference coordinates.
    origin: [f64; D],
    pub tangents: [[f64; D]; 2],
    /// Whether its own reference cell is the unit triangle.
    triangle: bool,
    /// Whether its map is affine.
    pub affine: bool,
    /// The degree of its map, and its nodes.
    degree: usize,
    nodes: Vec<[f64; D]>,
    /// The mean of its nodes, and a radius that holds the facet.
    pub centre: [f64; D],
    pub radius: f64,
}

/// A point of a facet with the derivatives of its position.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfacePoint<const D: usize> {
    pub position: [f64; D],
    /// Derivatives along the facet's own coordinates; the second is zero in the plane.
    pub tangents: [[f64; D]; 2],
}

pub(super) fn dot<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    (0..D).map(|k| a[k] * b[k]).sum()
}

pub(super) fn minus<const D: usize>(a: &[f64; D], b: &[f64; D]) -> [f64; D] {
    std::array::from_fn(|k| a[k] - b[k])
}

pub(super) fn unit<const D: usize>(a: &[f64; D]) -> [f64; D] {
    let length = dot(a, a).sqrt();
    a.map(|a| a / length)
}

impl<const D: usize> SurfacePoint<D> {
    /// The outward unit normal.
    pub fn normal(&self) -> [f64; D] {
        let [s, t] = &self.tangents;
        unit(&std::array::from_fn(|i| match (D, i) {
            (2, 0) => s[1],
            (2, _) => -s[0],
            _ => s[(i + 1) % D] * t[(i + 2) % D] - s[(i + 2) % D] * t[(i + 1) % D],
        }))
    }

    /// The surface element.
    pub fn element(&self) -> f64 {
        let [s, t] = &self.tangents;
        if D == 2 {
            return dot(s, s).sqrt();
        }
        let (first, mixed, last) = (dot(s, s), dot(s, t), dot(t, t));
        (first * last - mixed * mixed).max(0.0).sqrt()
    }
}

impl<'m, const D: usize> SurfaceFacet<'m, D> {
    pub fn new(mesh: &'m Mesh<D>, facet: Facet, displacement: Option<&Displacement<D>>) -> Self {
        let (cell, local) = (facet.cell as usize, usize::from(facet.local));
        let shape = mesh.cell_shape(cell);
        let vertices = shape.facet_vertices(local);
        let corner =
            |vertex: usize| -> [f64; D] { std::array::from_fn(|k| shape.vertex_points()[vertex][k]) };
        let origin = corner(vertices[0]);
        let along = minus(&corner(vertices[1]), &origin);
        let across = if D == 2 { [0.0; D] } else { minus(&corner(vertices[vertices.len() - 1]), &origin) };
        let triangle = D == 3 && shape.is_simplex();
        let degree = displacement.map_or(1, Displacement::degree).max(mesh.degree());
        let mut own = SurfaceFacet {
            mesh,
            facet,
            displacement: displacement.map(|displacement| displacement.on_cell_of(mesh, facet)),
            origin,
            tangents: [along, across],
            triangle,
            affine: degree == 1 && (D == 2 || triangle),
            degree,
            nodes: vec![],
            centre: [0.0; D],
            radius: 0.0,
        };
        let element = Lagrange { shape, degree };
        let references = element.node_points::<D>();
        let on_facet = element.facet_nodes(local).into_iter();
        own.nodes = on_facet.map(|node| own.map(&references[node]).0).collect();
        let count = own.nodes.len() as f64;
        own.centre = std::array::from_fn(|k| own.nodes.iter().map(|x| x[k]).sum::<f64>() / count);
        let reach = |x: &[f64; D]| dot(&minus(x, &own.centre), &minus(x, &own.centre)).sqrt();
        // Quadratic facets bulge beyond their nodes, by less than this.
        let bulge = if degree == 1 { 1.0 + 1e-9 } else { 1.5 };
        own.radius = bulge * own.nodes.iter().map(reach).fold(0.0, f64::max);
        own
    }

    /// Position and Jacobian at a point of the cell.
    fn map(&self, reference: &[f64; D]) -> ([f64; D], [[f64; D]; D]) {
        let (mut position, mut jacobian) = self.mesh.map(self.facet.cell as usize, reference);
        if let Some(displacement) = &self.displacement {
            displacement.add_at(reference, &mut position, &mut jacobian);
        }
        (position, jacobian)
    }

    /// Position and outward normal of the facet before it is displaced.
    pub fn undisplaced(&self, s: &[f64; 2]) -> ([f64; D], [f64; D]) {
        let (position, jacobian) = self.mesh.map(self.facet.cell as usize, &self.reference(s));
        let point = SurfacePoint { position, tangents: self.along(&jacobian) };
        (position, point.normal())
    }

    fn along(&self, jacobian: &[[f64; D]; D]) -> [[f64; D]; 2] {
        self.tangents.each_ref().map(|t| std::array::from_fn(|i| dot(&jacobian[i], t)))
    }

    /// The largest distance between two corners, before they are displaced.
    pub fn diameter(&self) -> f64 {
        let corners: Vec<_> = self.vertices().map(|vertex| self.mesh.nodes()[vertex as usize]).collect();
        let mut largest = 0.0_f64;
        for (index, a) in corners.iter().enumerate() {
            for b in &corners[..index] {
                largest = largest.max(dot(&minus(a, b), &minus(a, b)));
            }
        }
        largest.sqrt()
    }

    /// A box around it.
    pub fn corners(&self) -> Corners<D> {
        let bulge = if self.degree == 1 { 0.0 } else { 0.5 };
        box_around(&self.nodes, bulge)
    }

    /// The numbers of its corners, in the order of [`SurfaceFacet::parameters`].
    pub fn vertices(&self) -> impl Iterator<Item = u32> {
        self.mesh.facet_vertices(self.facet)
    }

    /// Its corners on its own reference cell.
    pub fn parameters(&self) -> &'static [[f64; 2]] {
        match (D, self.triangle) {
            (2, _) => &[[0.0, 0.0], [1.0, 0.0]],
            (_, true) => &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
            (_, false) => &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
        }
    }

    /// The middle of its own reference cell.
    pub fn middle(&self) -> [f64; 2] {
        match (D, self.triangle) {
            (2, _) => [0.5, 0.0],
            (_, true) => [1.0 / 3.0; 2],
            (_, false) => [0.5; 2],
        }
    }

    /// The cell's reference coordinates of a point.
    pub fn reference(&self, s: &[f64; 2]) -> [f64; D] {
        std::array::from_fn(|k| self.origin[k] + s[0] * self.tangents[0][k] + s[1] * self.tangents[1][k])
    }

    pub fn at(&self, s: &[f64; 2]) -> SurfacePoint<D> {
        let (position, jacobian) = self.map(&self.reference(s));
        SurfacePoint { position, tangents: self.along(&jacobian) }
    }

    /// Second derivatives of the position along the facet's own coordinates, before it is displaced.
    pub fn second(&self, s: &[f64; 2]) -> [[[f64; D]; 2]; 2] {
        let cell = self.facet.cell as usize;
        let mut second = [[[0.0; D]; 2]; 2];
        if self.affine {
            return second;
        }
        let hessians = self.mesh.cell_element(cell).hessians(&self.reference(s));
        for (node, hessian) in self.mesh.cell(cell).iter().zip(hessians) {
            let x = &self.mesh.nodes()[*node as usize];
            for a in 0..D - 1 {
                for b in 0..D - 1 {
                    let image: [f64; D] = std::array::from_fn(|k| dot(&hessian[k], &self.tangents[b]));
                    let slope = dot(&self.tangents[a], &image);
                    for k in 0..D {
                        second[a][b][k] += slope * x[k];
                    }
                }
            }
        }
        second
    }

    /// Whether a point lies on the facet, enlarged by `tolerance` in its own coordinates.
    pub fn contains(&self, s: &[f64; 2], tolerance: f64) -> bool {
        let last = if self.triangle { s[0] + s[1] } else { s[0].max(s[1]) };
        s[0] >= -tolerance && s[1] >= -tolerance && last <= 1.0 + tolerance
    }
}

/// The ends of a surface: corners and edges of its facets behind which it does not go on.
#[derive(Clone, Debug, Default)]
pub(super) struct Rim {
    edges: HashMap<[u32; 2], usize>,
    vertices: HashMap<u32, bool>,
}

impl Rim {
    /// That of some facets, each of which is listed once.
    pub fn of<const D: usize>(facets: &[SurfaceFacet<D>]) -> Self {
        let mut rim = Rim::default();
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

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
    /// The position as a polynomial of its own coordinates, of degree two at most: the coefficient of sⁱtʲ at `[i][j]`.
    polynomial: Option<[[[f64; D]; 3]; 3]>,
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
            polynomial: None,
            nodes: vec![],
            centre: [0.0; D],
            radius: 0.0,
        };
        if degree <= 2 {
            own.polynomial = Some(polynomial(|s, t| own.map(&own.reference(&[s, t])).0, degree));
        }
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

    pub fn at(&self, &[s, t]: &[f64; 2]) -> SurfacePoint<D> {
        let Some(polynomial) = &self.polynomial else {
            let (position, jacobian) = self.map(&self.reference(&[s, t]));
            return SurfacePoint { position, tangents: self.along(&jacobian) };
        };
        let [mut position, mut along, mut across] = [[0.0; D]; 3];
        for k in 0..D {
            // Each row with its derivative by t.
            let mut rows = [[0.0; 2]; 3];
            for i in 0..3 {
                let [a, b, c] = [0, 1, 2].map(|j| polynomial[i][j][k]);
                rows[i] = [a + t * (b + t * c), b + 2.0 * t * c];
            }
            let [first, second, third] = rows;
            position[k] = first[0] + s * (second[0] + s * third[0]);
            along[k] = second[0] + 2.0 * s * third[0];
            across[k] = first[1] + s * (second[1] + s * third[1]);
        }
        SurfacePoint { position, tangents: [along, across] }
    }

    /// Second derivatives of the position along the facet's own coordinates; those of facets that are displaced by fields of
    /// higher degree than two are not known, and not read.
    pub fn second(&self, &[s, t]: &[f64; 2]) -> [[[f64; D]; 2]; 2] {
        let mut second = [[[0.0; D]; 2]; 2];
        let Some(polynomial) = &self.polynomial else { return second };
        for k in 0..D {
            let c = |i: usize, j: usize| polynomial[i][j][k];
            second[0][0][k] = 2.0 * (c(2, 0) + t * (c(2, 1) + t * c(2, 2)));
            second[1][1][k] = 2.0 * (c(0, 2) + s * (c(1, 2) + s * c(2, 2)));
            second[0][1][k] = c(1, 1) + 2.0 * (s * c(2, 1) + t * c(1, 2)) + 4.0 * s * t * c(2, 2);
            second[1][0][k] = second[0][1][k];
        }
        second
    }

    /// Whether a point lies on the facet, enlarged by `tolerance` in its own coordinates.
    pub fn contains(&self, s: &[f64; 2], tolerance: f64) -> bool {
        let last = if self.triangle { s[0] + s[1] } else { s[0].max(s[1]) };
        s[0] >= -tolerance && s[1] >= -tolerance && last <= 1.0 + tolerance
    }
}

/// The coefficients of a function that has at most this degree, 1 or 2, in each coordinate.
fn polynomial<const D: usize>(at: impl Fn(f64, f64) -> [f64; D], degree: usize) -> [[[f64; D]; 3]; 3] {
    // From values at 0, 1/2 and 1; of one that is linear its middle says nothing new.
    let through = |[first, middle, last]: [[f64; D]; 3]| -> [[f64; D]; 3] {
        let entry = |k: usize| match degree {
            1 => [first[k], last[k] - first[k], 0.0],
            _ => [
                first[k],
                4.0 * middle[k] - 3.0 * first[k] - last[k],
                2.0 * (first[k] + last[k]) - 4.0 * middle[k],
            ],
        };
        std::array::from_fn(|i| std::array::from_fn(|k| entry(k)[i]))
    };
    let places = [0.0, 0.5, 1.0];
    let across = if D == 2 { [0.0; 3] } else { places };
    // Of each place along s the polynomial of t, then these coefficients as polynomials of s.
    let rows = places.map(|s| through(across.map(|t| at(s, t))));
    let columns = [0, 1, 2].map(|j| through([0, 1, 2].map(|i| rows[i][j])));
    std::array::from_fn(|i| std::array::from_fn(|j| columns[j][i]))
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

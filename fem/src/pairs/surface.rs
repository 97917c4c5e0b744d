//! Facets as parametrised surfaces: positions, tangents, normals, what holds them.

use super::displacement::{CellDisplacement, Displacement};
use super::traces::{Coefficients, Traces};
use crate::element::Lagrange;
use crate::locate::{Corners, box_around};
use crate::mesh::{Facet, Mesh};

/// A facet of a mesh over its own reference cell, whose second coordinate is zero in the plane; where it is displaced, the
/// displaced facet.
#[derive(Clone, Debug)]
pub(super) struct SurfaceFacet<'m, const D: usize> {
    mesh: &'m Mesh<D>,
    pub facet: Facet,
    /// The case of a map that is no polynomial of degree two.
    displacement: Option<CellDisplacement<D>>,
    /// The facet's first corner and tangents in the cell's reference coordinates.
    origin: [f64; D],
    pub tangents: [[f64; D]; 2],
    /// Whether its own reference cell is the unit triangle.
    triangle: bool,
    /// The position as a polynomial of its own coordinates, where its degree is two at most.
    polynomial: Option<Coefficients<[f64; D]>>,
    /// Whether its map is affine.
    pub affine: bool,
    /// A box around it, a point in its middle and a radius that holds it.
    pub corners: Corners<D>,
    pub centre: [f64; D],
    pub radius: f64,
    pub flat: FlatFacet<D>,
}

/// The flat facet that has three of a facet's corners, in the plane both, and how far the facet is from it.
#[derive(Clone, Debug)]
pub(super) struct FlatFacet<const D: usize> {
    origin: [f64; D],
    frame: Frame<D>,
    /// The most that a point of the facet is away from the flat one's of the same coordinates; none where it is not known.
    away: Option<f64>,
    /// The lengths of the dual tangents.
    slopes: [f64; 2],
}

/// The normal of a surface and the vectors dual to its tangents.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame<const D: usize> {
    /// Of the length of the surface element.
    normal: [f64; D],
    dual: [[f64; D]; 2],
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

fn cross<const D: usize>(a: &[f64; D], b: &[f64; D]) -> [f64; D] {
    std::array::from_fn(|i| a[(i + 1) % D] * b[(i + 2) % D] - a[(i + 2) % D] * b[(i + 1) % D])
}

impl<const D: usize> SurfacePoint<D> {
    /// The outward normal, of the length of the surface element.
    pub fn long_normal(&self) -> [f64; D] {
        let [s, t] = &self.tangents;
        match D {
            2 => std::array::from_fn(|i| if i == 0 { s[1] } else { -s[0] }),
            _ => cross(s, t),
        }
    }

    /// The outward unit normal.
    pub fn normal(&self) -> [f64; D] {
        unit(&self.long_normal())
    }

    pub fn frame(&self) -> Frame<D> {
        let normal = self.long_normal();
        let square = dot(&normal, &normal);
        let [s, t] = &self.tangents;
        let dual = match D {
            2 => [s.map(|s| s / square), [0.0; D]],
            _ => [cross(t, &normal).map(|s| s / square), cross(&normal, s).map(|t| t / square)],
        };
        Frame { normal, dual }
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

impl<const D: usize> Frame<D> {
    /// The coordinates along the tangents at which a line through a point along n meets the tangent plane; `off` is the vector
    /// from where the frame stands to the point. No numbers where the line runs along the plane.
    pub fn met_by(&self, off: &[f64; D], n: &[f64; D]) -> [f64; 2] {
        let gap = -dot(&self.normal, off) / dot(&self.normal, n);
        let foot: [f64; D] = std::array::from_fn(|k| off[k] + gap * n[k]);
        self.dual.each_ref().map(|dual| dot(dual, &foot))
    }
}

impl<const D: usize> FlatFacet<D> {
    /// The intersection with a line through x along n, in coordinates of the facet.
    pub fn met_by(&self, x: &[f64; D], n: &[f64; D]) -> [f64; 2] {
        self.frame.met_by(&minus(x, &self.origin), n)
    }

    /// The most by which coordinates at which a line along n meets the facet differ from those at which it meets the flat one.
    pub fn doubt(&self, n: &[f64; D]) -> [f64; 2] {
        let Some(away) = self.away else { return [f64::INFINITY; 2] };
        if away == 0.0 {
            return [0.0; 2];
        }
        let normal = &self.frame.normal;
        let slant = (dot(normal, normal).sqrt() / dot(normal, n)).abs();
        self.slopes.map(|slope| away * slope * (1.0 + slant))
    }
}

impl<'m, const D: usize> SurfaceFacet<'m, D> {
    pub fn new(
        mesh: &'m Mesh<D>,
        facet: Facet,
        displacement: Option<&Displacement<D>>,
        traces: &mut Traces,
    ) -> Self {
        let (cell, local) = (facet.cell as usize, usize::from(facet.local));
        let shape = mesh.cell_shape(cell);
        let vertices = shape.facet_vertices(local);
        let corner =
            |vertex: usize| -> [f64; D] { std::array::from_fn(|k| shape.vertex_points()[vertex][k]) };
        let origin = corner(vertices[0]);
        let along = minus(&corner(vertices[1]), &origin);
        let across = if D == 2 { [0.0; D] } else { minus(&corner(vertices[vertices.len() - 1]), &origin) };
        let tangents = [along, across];
        let triangle = D == 3 && shape.is_simplex();
        let degree = displacement.map_or(1, Displacement::degree).max(mesh.degree());
        let mut polynomial: Option<Coefficients<[f64; D]>> = None;
        if degree <= 2 {
            let sum = polynomial.insert([[[0.0; D]; 3]; 3]);
            let geometry = mesh.element_of(shape);
            traces.learn(geometry, local, &origin, &tangents);
            let nodes = mesh.cell(cell);
            add_trace(sum, traces.get(geometry, local), |node| mesh.nodes()[nodes[node] as usize]);
            for field in displacement.iter().flat_map(|displacement| &displacement.fields) {
                let element = Lagrange { shape, degree: field.space.degree };
                traces.learn(element, local, &origin, &tangents);
                let nodes = field.space.nodes_at(facet.cell, Some(facet.local));
                add_trace(sum, traces.get(element, local), |node| field.value_at(nodes[node]));
            }
        }
        let displacement = displacement.filter(|_| degree > 2);
        let zero = [0.0; D];
        let frame = Frame { normal: zero, dual: [zero; 2] };
        let mut own = SurfaceFacet {
            mesh,
            facet,
            displacement: displacement.map(|displacement| displacement.on_cell_of(mesh, facet)),
            origin,
            tangents,
            triangle,
            affine: degree <= 1 && (D == 2 || triangle),
            polynomial,
            corners: (zero, zero),
            centre: zero,
            radius: 0.0,
            flat: FlatFacet { origin: zero, frame, away: None, slopes: [0.0; 2] },
        };
        own.enclose(degree, local);
        own
    }

    /// Finds what holds the facet.
    fn enclose(&mut self, degree: usize, local: usize) {
        let parameters = self.parameters();
        let mut corners = [[0.0; D]; 4];
        let corners = &mut corners[..parameters.len()];
        for (corner, s) in corners.iter_mut().zip(parameters) {
            *corner = self.at(s).position;
        }
        let tangent = |k: usize| minus(&corners[k], &corners[0]);
        let tangents = [tangent(1), if D == 2 { [0.0; D] } else { tangent(corners.len() - 1) }];
        let frame = SurfacePoint { position: corners[0], tangents }.frame();
        let slopes = frame.dual.each_ref().map(|dual| dot(dual, dual).sqrt());
        let deviations = self.polynomial.as_ref().map(|polynomial| deviations(polynomial, self.triangle));
        self.flat = FlatFacet { origin: corners[0], frame, away: deviations.map(|found| found[0]), slopes };
        let nodes: Vec<[f64; D]>;
        // What is no polynomial of degree two bulges beyond its nodes by less than half of their spread, as far as is known.
        let (held, margin, bulge) = match deviations {
            Some([_, margin]) => (&*corners, margin, 0.0),
            None => {
                let element = Lagrange { shape: self.mesh.cell_shape(self.facet.cell as usize), degree };
                let references = element.node_points::<D>();
                let on_facet = element.facet_nodes(local).into_iter();
                nodes = on_facet.map(|node| self.map(&references[node]).0).collect();
                (&nodes[..], 0.0, 0.5)
            }
        };
        let count = held.len() as f64;
        self.centre = std::array::from_fn(|k| held.iter().map(|x| x[k]).sum::<f64>() / count);
        let (lower, upper) = box_around(held, bulge);
        self.corners = (lower.map(|x| x - margin), upper.map(|x| x + margin));
        let distance = |x: &[f64; D]| dot(&minus(x, &self.centre), &minus(x, &self.centre));
        let furthest = held.iter().map(distance).fold(0.0, f64::max).sqrt();
        self.radius = (1.0 + bulge + 1e-6) * furthest + margin;
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
        let c = |i: usize, j: usize, k: usize| polynomial[i][j][k];
        for k in 0..D {
            // A point is evaluated some ten times: no term that vanishes.
            if D == 2 {
                position[k] = c(0, 0, k) + s * (c(1, 0, k) + s * c(2, 0, k));
                along[k] = c(1, 0, k) + 2.0 * s * c(2, 0, k);
            } else if self.triangle {
                let mixed = c(1, 1, k);
                let (first, second) = (c(1, 0, k) + s * c(2, 0, k), c(0, 1, k) + t * c(0, 2, k));
                position[k] = c(0, 0, k) + s * (first + t * mixed) + t * second;
                along[k] = first + s * c(2, 0, k) + t * mixed;
                across[k] = second + t * c(0, 2, k) + s * mixed;
            } else {
                // Each row with its derivative by t.
                let row = |i: usize| {
                    let [a, b, c] = [0, 1, 2].map(|j| c(i, j, k));
                    [a + t * (b + t * c), b + 2.0 * t * c]
                };
                let [first, second, third] = [0, 1, 2].map(row);
                position[k] = first[0] + s * (second[0] + s * third[0]);
                along[k] = second[0] + 2.0 * s * third[0];
                across[k] = first[1] + s * (second[1] + s * third[1]);
            }
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

    /// Whether coordinates that may be wrong by so much lie beyond an edge.
    pub fn is_missed_by(&self, s: &[f64; 2], doubt: &[f64; 2]) -> bool {
        let beyond = match self.triangle {
            true => s[0] + s[1] > 1.0 + doubt[0] + doubt[1],
            false => s[0] > 1.0 + doubt[0] || s[1] > 1.0 + doubt[1],
        };
        s[0] < -doubt[0] || s[1] < -doubt[1] || beyond
    }

    /// Coordinates on the facet, or near it, that are not far from given ones.
    pub fn clamp(&self, s: &[f64; 2]) -> [f64; 2] {
        s.map(|s| s.clamp(0.0, 1.0))
    }

    /// Whether a point lies on the facet, enlarged by `tolerance` in its own coordinates.
    pub fn contains(&self, s: &[f64; 2], tolerance: f64) -> bool {
        let last = if self.triangle { s[0] + s[1] } else { s[0].max(s[1]) };
        s[0] >= -tolerance && s[1] >= -tolerance && last <= 1.0 + tolerance
    }
}

/// Adds what the nodes of an element make of the position.
fn add_trace<const D: usize>(
    sum: &mut Coefficients<[f64; D]>,
    trace: &[(usize, Coefficients<f64>)],
    value: impl Fn(usize) -> [f64; D],
) {
    let columns = if D == 2 { 1 } else { 3 };
    for (node, polynomial) in trace {
        let value = value(*node);
        for i in 0..3 {
            for j in 0..columns {
                for k in 0..D {
                    sum[i][j][k] += polynomial[i][j] * value[k];
                }
            }
        }
    }
}

/// The most that a polynomial facet is away, at the same coordinates, from the flat one with its first, second and last corner,
/// and from what the corners span: segment, triangle or bilinear quadrilateral.
fn deviations<const D: usize>(polynomial: &Coefficients<[f64; D]>, triangle: bool) -> [f64; 2] {
    let length = |a: [f64; D]| dot(&a, &a).sqrt();
    // s − s² is a quarter at most, and so are the other terms less what they are at the corners.
    let bent = [(2, 0), (0, 2), (2, 1), (1, 2), (2, 2)];
    let spanned = 0.25 * bent.iter().map(|&(i, j)| length(polynomial[i][j])).sum::<f64>();
    if D == 2 {
        return [spanned; 2];
    }
    if triangle {
        return [spanned + 0.25 * length(polynomial[1][1]); 2];
    }
    let terms = [(1, 1), (2, 1), (1, 2), (2, 2)];
    let twist = std::array::from_fn(|k| terms.iter().map(|&(i, j)| polynomial[i][j][k]).sum());
    [spanned + length(twist), spanned]
}

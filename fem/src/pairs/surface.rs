//! Facets as parametrised surfaces: positions, tangents, normals, what holds them.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lanes are plain.
#![allow(clippy::needless_range_loop)]

use forms_core::contract::Lane;

use super::displacement::{CellDisplacement, Displacement};
use super::frame::{FlatFacet, Frame};
pub(super) use super::frame::{SurfacePoint, dot, minus, over, splat, unit};
use super::traces::{Coefficients, NodeTrace, Traces};
use crate::element::Lagrange;
use crate::lanes::WIDEST;
use crate::locate::{Corners, box_around};
use crate::mesh::{CarriedSurface, Facet, Mesh};

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
    /// The numbers of its corners, and how many it has.
    vertices: ([u32; 4], usize),
    /// The outward unit normal before it is displaced, of a facet of a rigid surface.
    pub rigid_normal: Option<[f64; D]>,
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
            let nodes = mesh.cell(cell);
            let trace = traces.of(geometry, local, &origin, &tangents);
            add_trace(sum, trace, |node| mesh.nodes()[nodes[node] as usize]);
            for field in displacement.iter().flat_map(|displacement| &displacement.fields) {
                let element = Lagrange { shape, degree: field.space.degree };
                let nodes = field.space.nodes_at(facet.cell, Some(facet.local));
                let trace = traces.of(element, local, &origin, &tangents);
                add_trace(sum, trace, |node| field.value_at(nodes[node]));
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
            vertices: numbered(mesh.facet_vertices(facet)),
            rigid_normal: None,
        };
        own.enclose(degree, local);
        own
    }

    /// A facet of a rigid surface, whose points have these positions now.
    pub fn rigid(
        mesh: &'m Mesh<D>,
        carried: &CarriedSurface<D>,
        index: usize,
        positions: &[[f64; D]],
    ) -> Self {
        let corners = carried.surface.facets()[index];
        let reference = |k: usize| carried.references[corners[k] as usize];
        let position = |k: usize| positions[corners[k] as usize];
        let (zero, origin) = ([0.0; D], reference(0));
        let across = |first: [f64; D], last: [f64; D]| if D == 2 { zero } else { minus(&last, &first) };
        let tangents = [minus(&reference(1), &origin), across(origin, reference(D - 1))];
        let mut polynomial: Coefficients<[f64; D]> = [[zero; 3]; 3];
        polynomial[0][0] = position(0);
        polynomial[1][0] = minus(&position(1), &position(0));
        polynomial[0][1] = across(position(0), position(D - 1));
        let frame = Frame { normal: zero, dual: [zero; 2] };
        let mut own = SurfaceFacet {
            mesh,
            facet: Facet { cell: carried.cell, local: 0 },
            displacement: None,
            origin,
            tangents,
            triangle: D == 3,
            affine: true,
            polynomial: Some(polynomial),
            corners: (zero, zero),
            centre: zero,
            radius: 0.0,
            flat: FlatFacet { origin: zero, frame, away: None, slopes: [0.0; 2] },
            vertices: numbered(corners.into_iter()),
            rigid_normal: Some(carried.normals[index]),
        };
        own.enclose(1, 0);
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
        let count = self.parameters().len();
        let mut corners = [[0.0; D]; 4];
        for (k, corner) in corners[..count].iter_mut().enumerate() {
            *corner = match self.rigid_normal {
                None => self.mesh.nodes()[self.vertices.0[k] as usize],
                Some(_) => self.undisplaced(&self.parameters()[k]).0,
            };
        }
        let mut largest = 0.0_f64;
        for (index, a) in corners[..count].iter().enumerate() {
            for b in &corners[..index] {
                largest = largest.max(dot(&minus(a, b), &minus(a, b)));
            }
        }
        largest.sqrt()
    }

    /// The numbers of its corners, in the order of [`SurfaceFacet::parameters`].
    pub fn vertices(&self) -> impl Iterator<Item = u32> {
        let (numbers, count) = self.vertices;
        numbers.into_iter().take(count)
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

    /// The point, or points side by side, with these coordinates on its own reference cell.
    #[inline(always)]
    pub fn at<L: Lane>(&self, s: &[L; 2]) -> SurfacePoint<D, L> {
        let Some(polynomial) = &self.polynomial else { return self.at_each(s) };
        let zero = [L::splat(0.0); D];
        let [mut position, mut along, mut across] = [zero; 3];
        let [s, t] = *s;
        let two = L::splat(2.0);
        for k in 0..D {
            let c = |i: usize, j: usize| L::splat(polynomial[i][j][k]);
            // A point is evaluated some ten times: no term that vanishes.
            if D == 2 {
                let bend = c(2, 0);
                position[k] = c(0, 0) + s * (c(1, 0) + s * bend);
                along[k] = c(1, 0) + two * s * bend;
            } else if self.triangle {
                let (mixed, bend, second_bend) = (c(1, 1), c(2, 0), c(0, 2));
                let (first, second) = (c(1, 0) + s * bend, c(0, 1) + t * second_bend);
                position[k] = c(0, 0) + s * (first + t * mixed) + t * second;
                along[k] = first + s * bend + t * mixed;
                across[k] = second + t * second_bend + s * mixed;
            } else {
                // Each row with its derivative by t.
                let mut rows = [[L::splat(0.0); 2]; 3];
                for i in 0..3 {
                    let (constant, linear, bend) = (c(i, 0), c(i, 1), c(i, 2));
                    rows[i] = [constant + t * (linear + t * bend), linear + two * t * bend];
                }
                let [first, second, third] = rows;
                position[k] = first[0] + s * (second[0] + s * third[0]);
                along[k] = second[0] + two * s * third[0];
                across[k] = first[1] + s * (second[1] + s * third[1]);
            }
        }
        SurfacePoint { position, tangents: [along, across] }
    }

    /// The same where the position is no polynomial of degree two, lane by lane.
    #[inline(never)]
    fn at_each<L: Lane>(&self, s: &[L; 2]) -> SurfacePoint<D, L> {
        let mut lanes = [[0.0; WIDEST]; 2];
        s[0].store(&mut lanes[0]);
        s[1].store(&mut lanes[1]);
        let [mut position, mut along, mut across] = [[[0.0; WIDEST]; D]; 3];
        for lane in 0..L::WIDTH {
            let (x, jacobian) = self.map(&self.reference(&[lanes[0][lane], lanes[1][lane]]));
            let tangents = self.along(&jacobian);
            for k in 0..D {
                position[k][lane] = x[k];
                along[k][lane] = tangents[0][k];
                across[k][lane] = tangents[1][k];
            }
        }
        let [position, along, across] = [position, along, across].map(|lanes| lanes.map(|of| L::load(&of)));
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
    #[inline(always)]
    pub fn is_missed_by<L: Lane>(&self, s: &[L; 2], doubt: &[L; 2]) -> L::Mask {
        let one = L::splat(1.0);
        let beyond = match self.triangle {
            true => (one + doubt[0] + doubt[1]).less(s[0] + s[1]),
            false => L::or((one + doubt[0]).less(s[0]), (one + doubt[1]).less(s[1])),
        };
        L::or(L::or(s[0].less(-doubt[0]), s[1].less(-doubt[1])), beyond)
    }

    /// Whether a point lies on the facet, enlarged by `tolerance` in its own coordinates.
    #[inline(always)]
    pub fn contains<L: Lane>(&self, s: &[L; 2], tolerance: f64) -> L::Mask {
        let last = if self.triangle { s[0] + s[1] } else { s[0].maximum(s[1]) };
        let (least, most) = (L::splat(-tolerance), L::splat(1.0 + tolerance));
        L::and(L::and(least.less_equal(s[0]), least.less_equal(s[1])), last.less_equal(most))
    }
}

/// Some corners and their number.
fn numbered(corners: impl Iterator<Item = u32>) -> ([u32; 4], usize) {
    let (mut numbers, mut count) = ([0; 4], 0);
    for (number, corner) in numbers.iter_mut().zip(corners) {
        *number = corner;
        count += 1;
    }
    (numbers, count)
}

/// Adds what the nodes of an element make of the position.
fn add_trace<const D: usize>(
    sum: &mut Coefficients<[f64; D]>,
    trace: &[NodeTrace],
    value: impl Fn(usize) -> [f64; D],
) {
    for of_node in trace {
        let value = value(of_node.node);
        for &(i, j, factor) in of_node.terms() {
            for k in 0..D {
                sum[i][j][k] += factor * value[k];
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

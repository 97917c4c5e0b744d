//! Facets as parametrised surfaces: positions, tangents, normals, what holds them.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lanes are plain.
#![allow(clippy::needless_range_loop)]

use std::ops::Range;

use forms_core::contract::Lane;

use super::displacement::{CellDisplacement, Displacement};
use super::frame::FlatFacet;
pub(super) use super::frame::{SurfacePoint, dot, minus, over, splat, unit};
use super::parabola::Parabola;
use super::rest::{FacetAtRest, SurfaceAtRest, spread};
use super::traces::{Coefficients, Traces, add_trace, deviations};
use crate::element::Lagrange;
use crate::lanes::WIDEST;
use crate::locate::{Corners, box_around};
use crate::mesh::{CarriedSurface, Facet, Mesh};

/// A facet whose position is no polynomial of degree two bulges beyond its nodes by less than this part of their spread, as far as is
/// known.
const BULGE: f64 = 0.5;

/// Facets whose memory stays in the first cache while they are displaced.
const AT_A_TIME: usize = 32;

/// A facet of a mesh over its own reference cell, whose second coordinate is zero in the plane; where it is displaced, the
/// displaced facet.
#[derive(Clone, Debug)]
pub(super) struct SurfaceFacet<'m, const D: usize> {
    mesh: &'m Mesh<D>,
    pub facet: Facet,
    /// The case of a map that is no polynomial of degree two.
    displacement: Option<Box<CellDisplacement<D>>>,
    /// The facet's first corner and tangents in the cell's reference coordinates.
    origin: [f64; D],
    pub tangents: [[f64; D]; 2],
    /// Whether its own reference cell is the unit triangle.
    triangle: bool,
    /// The position as a polynomial of its own coordinates, where its degree is two at most.
    polynomial: Option<Coefficients<D>>,
    /// Whether its map is affine, and its degree, one at least.
    pub affine: bool,
    pub degree: usize,
    /// A point in its middle and a radius that holds it.
    pub centre: [f64; D],
    pub radius: f64,
    /// The largest distance between two corners, before they are displaced; a rigid surface's do not change.
    pub diameter: f64,
    /// None in the plane where its position is a polynomial: rays meet that one in closed form.
    flat: Option<FlatFacet<D>>,
    /// The numbers of its corners, as many as it has.
    vertices: [u32; 4],
    /// The outward unit normal before it is displaced, of a facet of a rigid surface.
    pub rigid_normal: Option<[f64; D]>,
}

impl<'m, const D: usize> SurfaceFacet<'m, D> {
    /// Some facets of a body, displaced.
    pub fn all(
        mesh: &'m Mesh<D>,
        surface: &SurfaceAtRest<D>,
        facets: Range<usize>,
        displacement: Option<&Displacement<D>>,
    ) -> Vec<Self> {
        let mut traces = Traces::default();
        let mut all: Vec<Self> = Vec::with_capacity(facets.len());
        // In place, some at a time: a copy of some hundred bytes would wait for what has just been written.
        for first in facets.clone().step_by(AT_A_TIME) {
            let some = first..facets.end.min(first + AT_A_TIME);
            let at_rest = surface.facets[some.clone()].iter();
            all.extend(at_rest.map(|rest| SurfaceFacet::at_rest(mesh, rest)));
            for (own, index) in all[first - facets.start..].iter_mut().zip(some) {
                own.displace(surface, index, displacement, &mut traces);
            }
        }
        all
    }

    #[inline(always)]
    fn at_rest(mesh: &'m Mesh<D>, rest: &FacetAtRest<D>) -> Self {
        SurfaceFacet {
            mesh,
            facet: rest.facet,
            displacement: None,
            origin: rest.origin,
            tangents: rest.tangents,
            triangle: rest.triangle,
            polynomial: None,
            affine: false,
            degree: 1,
            centre: [0.0; D],
            radius: 0.0,
            diameter: rest.diameter,
            flat: None,
            vertices: rest.vertices,
            rigid_normal: None,
        }
    }

    fn displace(
        &mut self,
        surface: &SurfaceAtRest<D>,
        index: usize,
        displacement: Option<&Displacement<D>>,
        traces: &mut Traces,
    ) {
        let rest = &surface.facets[index];
        let (mesh, Facet { cell, local }) = (self.mesh, rest.facet);
        let local = usize::from(local);
        let degree = displacement.map_or(1, Displacement::degree).max(mesh.degree());
        self.degree = degree.max(1);
        self.affine = degree <= 1 && (D == 2 || self.triangle);
        if degree > 2 {
            self.displacement = displacement.map(|of_cells| Box::new(of_cells.on_cell_of(mesh, rest.facet)));
            return self.enclose_corners(degree, local);
        }
        let mut polynomial = rest.polynomial.clone();
        let fields = displacement.map_or(&[][..], |displacement| &displacement.fields);
        for (field, nodes) in fields.iter().zip(&surface.nodes) {
            let element = field.space.traces_of(mesh.cell_shape(cell as usize));
            let trace = traces.of(element, local, &rest.origin, &rest.tangents);
            let nodes = nodes.of(index);
            add_trace(&mut polynomial, trace, |k| field.value_at(nodes[k]));
        }
        self.enclose(polynomial, degree, local);
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
        let mut polynomial = Coefficients::ZERO;
        if D == 3 {
            *polynomial.of_mut(0, 1) = minus(&position(D - 1), &position(0));
        }
        *polynomial.of_mut(0, 0) = position(0);
        *polynomial.of_mut(1, 0) = minus(&position(1), &position(0));
        let mut vertices = [0; 4];
        vertices[..D].copy_from_slice(&corners[..D]);
        let facet = Facet { cell: carried.cell, local: 0 };
        let diameter = spread(D, position);
        let rest = FacetAtRest { facet, origin, tangents, triangle: D == 3, vertices, diameter, polynomial };
        let mut own = SurfaceFacet {
            affine: true,
            rigid_normal: Some(carried.normals[index]),
            ..SurfaceFacet::at_rest(mesh, &rest)
        };
        own.enclose(rest.polynomial, 1, 0);
        own
    }

    /// Takes its polynomial, and finds what holds it.
    #[inline(always)]
    fn enclose(&mut self, polynomial: Coefficients<D>, degree: usize, local: usize) {
        let polynomial = self.polynomial.insert(polynomial);
        if D == 3 {
            return self.enclose_corners(degree, local);
        }
        let [start, along, bend] = [0, 1, 2].map(|i| *polynomial.of(i, 0));
        let (mut square, mut bent, mut centre) = (0.0, 0.0, [0.0; D]);
        for k in 0..D {
            let half = 0.5 * (along[k] + bend[k]);
            centre[k] = start[k] + half;
            square += half * half;
            bent += bend[k] * bend[k];
        }
        self.centre = centre;
        // A point of the curve is away from its chord by s − s² times the bend, a quarter at most.
        self.radius = (1.0 + 1e-6) * f64::sqrt(square) + 0.25 * f64::sqrt(bent);
    }

    /// The same by corners, or nodes, and the flat facet.
    #[inline(never)]
    fn enclose_corners(&mut self, degree: usize, local: usize) {
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
        self.flat =
            Some(FlatFacet { origin: corners[0], frame, away: deviations.map(|found| found[0]), slopes });
        let nodes: Vec<[f64; D]>;
        let (held, margin, bulge) = match deviations {
            Some([_, margin]) => (&*corners, margin, 0.0),
            None => {
                nodes = self.nodes(degree, local);
                (&nodes[..], 0.0, BULGE)
            }
        };
        let count = held.len() as f64;
        self.centre = std::array::from_fn(|k| held.iter().map(|x| x[k]).sum::<f64>() / count);
        let distance = |x: &[f64; D]| dot(&minus(x, &self.centre), &minus(x, &self.centre));
        let furthest = held.iter().map(distance).fold(0.0, f64::max).sqrt();
        self.radius = (1.0 + bulge + 1e-6) * furthest + margin;
    }

    /// Its nodes of an element of this degree.
    fn nodes(&self, degree: usize, local: usize) -> Vec<[f64; D]> {
        let element = Lagrange { shape: self.mesh.cell_shape(self.facet.cell as usize), degree };
        let references = element.node_points::<D>();
        element.facet_nodes(local).into_iter().map(|node| self.map(&references[node]).0).collect()
    }

    /// A box around it.
    pub fn corners(&self) -> Corners<D> {
        if let Some(polynomial) = &self.polynomial {
            let corners = self.parameters().iter().map(|s| self.at(s).position);
            let (lower, upper) = box_around(&corners.collect::<Vec<_>>(), 0.0);
            let [_, margin] = deviations(polynomial, self.triangle);
            return (lower.map(|x| x - margin), upper.map(|x| x + margin));
        }
        let of_displacement = self.displacement.as_ref().map_or(1, |displacement| displacement.degree());
        let degree = of_displacement.max(self.mesh.degree());
        box_around(&self.nodes(degree, usize::from(self.facet.local)), BULGE)
    }

    /// The curve of a facet in the plane, where its degree is two at most.
    #[inline(always)]
    pub fn parabola(&self) -> Option<Parabola<'_, D>> {
        let polynomial = self.polynomial.as_ref().filter(|_| D == 2)?;
        let [start, along, bend] = [0, 1, 2].map(|i| polynomial.of(i, 0));
        Some(Parabola { start, along, bend })
    }

    /// The flat facet through its corners, where rays do not meet it in closed form.
    #[inline(always)]
    pub fn flat(&self) -> Option<&FlatFacet<D>> {
        self.flat.as_ref()
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

    /// The numbers of its corners, in the order of [`SurfaceFacet::parameters`].
    pub fn vertices(&self) -> impl Iterator<Item = u32> {
        self.vertices.into_iter().take(self.parameters().len())
    }

    /// The corners of the facet on its own reference cell.
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
            let c = |i: usize, j: usize| L::splat(polynomial.of(i, j)[k]);
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
    #[inline(always)]
    pub fn second<L: Lane>(&self, &[s, t]: &[L; 2]) -> [[[L; D]; 2]; 2] {
        let mut second = [[[L::splat(0.0); D]; 2]; 2];
        let Some(polynomial) = &self.polynomial else { return second };
        let two = L::splat(2.0);
        for k in 0..D {
            let c = |i: usize, j: usize| L::splat(polynomial.of(i, j)[k]);
            if D == 2 {
                second[0][0][k] = two * c(2, 0);
                continue;
            }
            if self.triangle {
                (second[0][0][k], second[1][1][k]) = (two * c(2, 0), two * c(0, 2));
                second[0][1][k] = c(1, 1);
            } else {
                second[0][0][k] = two * (c(2, 0) + t * (c(2, 1) + t * c(2, 2)));
                second[1][1][k] = two * (c(0, 2) + s * (c(1, 2) + s * c(2, 2)));
                second[0][1][k] =
                    c(1, 1) + two * (s * c(2, 1) + t * c(1, 2)) + L::splat(4.0) * s * t * c(2, 2);
            }
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

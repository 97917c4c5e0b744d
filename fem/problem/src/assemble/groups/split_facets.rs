//! Facets split where a scalar of the current state changes its sign, so that integrands with a kink or a jump there are
//! integrated exactly: an attribute of the quadrature, not of the form.

use std::sync::Arc;

use crate::contract::Expression;

use crate::assemble::{Assembler, AssemblyError};
use crate::quadrature::{Piece, Quadrature, SplitFacets};

/// Pieces shorter than this part of their facet hold nothing.
const SHORTEST: f64 = 1e-14;

impl<const D: usize> Assembler<D> {
    /// This assembler, with the exterior facets of a region split where a scalar changes its sign; the scalar has no
    /// unknowns, so that the split is that of one state. Every integral over these facets takes one rule per piece,
    /// except those that read a history and those over contact pairs, which have pieces of their own. Facets of the region that were split before are split again.
    ///
    /// In the plane a facet is cut at each zero, found as in [`Assembler::positive_parts`]: `resolution` is the degree of
    /// the interpolation along a facet, and the cut is exact to rounding where the scalar has this degree there. In space a
    /// facet becomes triangles, `resolution` of them along each edge, and those on which the signs of the corners differ are
    /// cut along a straight line: exact where the scalar is affine on the facet.
    ///
    /// # Errors
    /// As [`Assembler::along_facets`], a region of interior facets, and a function that is no scalar.
    pub fn split_at_zeros(
        &self,
        expression: &Expression<D>,
        region: &str,
        resolution: usize,
    ) -> Result<Self, AssemblyError> {
        // An interior facet has two sides, and no single owner whose pieces it could have.
        let missing =
            |source| AssemblyError::Region { form: expression.name(), symbol: "split facets", source };
        self.mesh.facet_region(region).map_err(missing)?;
        let (whole, mut split) = match &self.quadrature {
            Quadrature::Split { whole, facets } => (whole.clone(), SplitFacets::clone(facets)),
            other => (Box::new(other.clone()), SplitFacets::default()),
        };
        if D == 2 {
            for facet in self.facet_zeros(expression, region, resolution)? {
                split.cut(facet.facet, segments(&facet.zeros));
            }
        } else {
            let lattice =
                Lattice::new(self.mesh.shape_of_facets().facet_vertices(0).len() == 3, resolution.max(1));
            self.expect_scalar(expression)?;
            let samples = self.along_facets(expression, region, &lattice.points)?;
            for facet in samples.chunks(lattice.points.len()) {
                let values: Vec<f64> = facet.iter().map(|sample| sample.value[0]).collect();
                split.cut(facet[0].facet, lattice.cut(&values));
            }
        }
        let quadrature = match split.is_empty() {
            true => *whole,
            false => Quadrature::Split { whole, facets: Arc::new(split) },
        };
        Ok(self.clone().with_quadrature(quadrature))
    }
}

/// The parts of \[0, 1\] between zeros; none where there is no zero.
fn segments(zeros: &[f64]) -> Vec<Piece> {
    let ends: Vec<f64> = [0.0].into_iter().chain(zeros.iter().copied()).chain([1.0]).collect();
    let pieces = ends.windows(2).filter(|ends| ends[1] - ends[0] > SHORTEST);
    let pieces: Vec<Piece> = pieces.map(|ends| [[ends[0], 0.0], [ends[1], 0.0], [0.0; 2]]).collect();
    if pieces.len() > 1 { pieces } else { vec![] }
}

/// A triangle or square as triangles.
struct Lattice {
    points: Vec<[f64; 2]>,
    triangles: Vec<[usize; 3]>,
}

impl Lattice {
    fn new(triangle: bool, count: usize) -> Lattice {
        let (mut points, mut triangles) = (Vec::new(), Vec::new());
        let mut number = vec![vec![0; count + 1]; count + 1];
        for (j, row) in number.iter_mut().enumerate() {
            let last = if triangle { count - j } else { count };
            for (i, entry) in row.iter_mut().enumerate().take(last + 1) {
                *entry = points.len();
                points.push([i as f64 / count as f64, j as f64 / count as f64]);
            }
        }
        for j in 0..count {
            for i in 0..if triangle { count - j } else { count } {
                triangles.push([number[j][i], number[j][i + 1], number[j + 1][i]]);
                if !triangle || i + j + 2 <= count {
                    triangles.push([number[j][i + 1], number[j + 1][i + 1], number[j + 1][i]]);
                }
            }
        }
        Lattice { points, triangles }
    }

    /// The pieces for values at the points; none where all have one sign.
    fn cut(&self, values: &[f64]) -> Vec<Piece> {
        let positive = |corner: &usize| values[*corner] > 0.0;
        let all = values.iter().all(|value| *value > 0.0) || values.iter().all(|value| *value <= 0.0);
        if all {
            return vec![];
        }
        let mut pieces = Vec::new();
        for triangle in &self.triangles {
            let corners = triangle.map(|corner| self.points[corner]);
            let signs = triangle.each_ref().map(positive);
            // The corner whose sign the two others do not have.
            let Some(alone) =
                (0..3).find(|k| signs[*k] != signs[(k + 1) % 3] && signs[*k] != signs[(k + 2) % 3])
            else {
                pieces.push(corners);
                continue;
            };
            let [a, b, c] = [alone, (alone + 1) % 3, (alone + 2) % 3];
            let zero = |other: usize| {
                let [here, there] = [values[triangle[a]], values[triangle[other]]];
                let t = here / (here - there);
                [0, 1].map(|k| corners[a][k] + t * (corners[other][k] - corners[a][k]))
            };
            let (first, second) = (zero(b), zero(c));
            pieces.extend([
                [corners[a], first, second],
                [first, corners[b], corners[c]],
                [first, corners[c], second],
            ]);
        }
        pieces
    }
}

//! A plane mesh on the page: curved cells cut into small triangles, curved edges into polylines.

use std::collections::{BTreeMap, BTreeSet};

use super::path::Point;
use super::shading::{ShadedSurface, Shading};
use crate::element::CellShape;
use crate::field::Field;
use crate::mesh::{Facet, Mesh};

/// A mesh in its reference position or displaced by a multiple of a field.
#[derive(Clone, Copy)]
pub(super) struct Body<'a> {
    pub mesh: &'a Mesh<2>,
    pub displacement: Option<(&'a Field<2>, f64)>,
}

/// The cuts of the reference cell of each shape in a mesh.
pub(super) struct Lattices(Vec<(CellShape, Lattice)>);

/// The cut of a reference cell.
pub(super) struct Lattice {
    pub points: Vec<[f64; 2]>,
    triangles: Vec<[u32; 3]>,
}

/// Pairs of triangles, about, into which the cells of a mesh are cut together: on a page each covers a few pixels.
const CUTS: f64 = 60_000.0;
/// Pieces of a curved edge.
const EDGE_PIECES: usize = 8;

impl Lattice {
    /// Cuts the reference cell into `parts` along each edge.
    fn new(shape: CellShape, parts: usize) -> Lattice {
        let simplex = shape == CellShape::Triangle;
        let mut points = Vec::new();
        let mut triangles = Vec::new();
        let step = 1.0 / parts as f64;
        // Row j has parts + 1 points in a square, parts + 1 − j in a triangle.
        let columns = |j: usize| if simplex { parts + 1 - j } else { parts + 1 };
        let mut starts = vec![0];
        for j in 0..=parts {
            points.extend((0..columns(j)).map(|i| [i as f64 * step, j as f64 * step]));
            starts.push(points.len());
        }
        for j in 0..parts {
            let number = |i: usize, j: usize| (starts[j] + i) as u32;
            for i in 0..columns(j) - 1 {
                triangles.push([number(i, j), number(i + 1, j), number(i, j + 1)]);
                if i + 1 < columns(j + 1) {
                    triangles.push([number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)]);
                }
            }
        }
        Lattice { points, triangles }
    }
}

impl Lattices {
    /// Lattices fine enough for the mesh: two to eight parts along each edge of a cell, the fewer the more cells there are.
    pub fn of(mesh: &Mesh<2>) -> Self {
        let parts = (CUTS / mesh.cell_count().max(1) as f64).sqrt() as usize;
        let of_shape = |shape| (shape, Lattice::new(shape, parts.clamp(2, 8)));
        Lattices(mesh.shapes().into_iter().map(of_shape).collect())
    }

    /// The lattice of a shape; `shape` must be one of the mesh's.
    pub fn of_shape(&self, shape: CellShape) -> &Lattice {
        let own = self.0.iter().find(|(known, _)| *known == shape);
        &own.unwrap_or(&self.0[0]).1
    }

    /// Number of points in some cells of the mesh.
    pub fn points_in(&self, mesh: &Mesh<2>, cells: &[u32]) -> usize {
        mesh.runs_of_shape(cells).map(|(shape, run)| run.len() * self.of_shape(shape).points.len()).sum()
    }
}

/// Values of a field's components at given reference points of a cell, point after point.
pub(super) fn field_values(field: &Field<2>, cell: usize, basis: &[f64]) -> Vec<f64> {
    let space = field.space();
    let components = space.components();
    let unknowns = space.cell_nodes(cell);
    let per_cell = unknowns.len();
    let mut values = Vec::with_capacity(basis.len() / per_cell * components);
    for at_point in basis.chunks(per_cell) {
        for component in 0..components {
            let terms = at_point.iter().zip(unknowns);
            values
                .push(terms.map(|(phi, &n)| phi * field.values()[n as usize * components + component]).sum());
        }
    }
    values
}

/// Reference points of a shape with the basis functions there: those of the cells' geometry, and of a displacement.
struct TabulatedPoints {
    geometry: Vec<f64>,
    shift: Vec<f64>,
}

impl<'a> Body<'a> {
    fn tabulated(&self, shape: CellShape, reference: &[[f64; 2]]) -> TabulatedPoints {
        let shift =
            |(field, _): (&Field<2>, f64)| field.space().element_of(shape).tabulate::<2>(reference).value;
        TabulatedPoints {
            geometry: self.mesh.element_of(shape).tabulate::<2>(reference).value,
            shift: self.displacement.map(shift).unwrap_or_default(),
        }
    }

    /// Adds the positions of points in a cell of their shape.
    fn add_positions(&self, points: &TabulatedPoints, cell: usize, positions: &mut Vec<[f64; 2]>) {
        let nodes = self.mesh.cell(cell);
        let start = positions.len();
        for basis in points.geometry.chunks(nodes.len()) {
            let mut position = [0.0; 2];
            for (phi, &node) in basis.iter().zip(nodes) {
                let x = self.mesh.nodes()[node as usize];
                position = [position[0] + phi * x[0], position[1] + phi * x[1]];
            }
            positions.push(position);
        }
        if let Some((field, factor)) = self.displacement {
            let values = field_values(field, cell, &points.shift);
            for (position, u) in positions[start..].iter_mut().zip(values.chunks(2)) {
                *position = [position[0] + factor * u[0], position[1] + factor * u[1]];
            }
        }
    }

    /// Positions of reference points in each of some cells of one shape, cell after cell.
    pub fn positions(
        &self,
        shape: CellShape,
        reference: &[[f64; 2]],
        cells: impl Iterator<Item = usize>,
    ) -> Vec<[f64; 2]> {
        let points = self.tabulated(shape, reference);
        let mut positions = Vec::with_capacity(cells.size_hint().0 * reference.len());
        cells.for_each(|cell| self.add_positions(&points, cell, &mut positions));
        positions
    }

    /// Number of points of an edge's polyline.
    pub fn points_of_edge(&self) -> usize {
        let curved = self.mesh.degree() > 1 || self.displacement.is_some();
        1 + if curved { EDGE_PIECES } else { 1 }
    }

    /// Points along each edge of a shape.
    fn tabulated_edges(&self, shape: CellShape) -> Vec<TabulatedPoints> {
        let pieces = self.points_of_edge() - 1;
        let along = |ends: &[usize; 2]| {
            let [a, b] = ends.map(|vertex| shape.vertex_points()[vertex]);
            let at = |k: usize| {
                let t = k as f64 / pieces as f64;
                [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]
            };
            self.tabulated(shape, &(0..=pieces).map(at).collect::<Vec<_>>())
        };
        shape.edges().iter().map(along).collect()
    }

    /// The polylines of edges, given as cells with the number of an edge in each: equally many points for each edge, one edge after the other.
    fn polylines(&self, edges: impl Iterator<Item = (usize, usize)>) -> Vec<[f64; 2]> {
        let shapes = self.mesh.shapes();
        let tables: Vec<_> = shapes.iter().map(|shape| (*shape, self.tabulated_edges(*shape))).collect();
        let mut points = Vec::with_capacity(edges.size_hint().0 * self.points_of_edge());
        for (cell, local) in edges {
            let own = self.mesh.cell_shape(cell);
            if let Some((_, edges)) = tables.iter().find(|(shape, _)| *shape == own) {
                self.add_positions(&edges[local], cell, &mut points);
            }
        }
        points
    }

    /// The polylines of all edges of the mesh, each edge once: [`Body::points_of_edge`] points for each, one edge after the other.
    pub fn edges(&self) -> Vec<[f64; 2]> {
        let mut sides = Vec::with_capacity(4 * self.mesh.cell_count());
        for cell in self.mesh.body_cells() {
            let nodes = self.mesh.cell(cell);
            for (local, ends) in self.mesh.cell_shape(cell).edges().iter().enumerate() {
                let [a, b] = ends.map(|vertex| nodes[vertex]);
                sides.push(([a.min(b), a.max(b)], cell, local));
            }
        }
        // Of the two sides of an edge the first one is drawn, in the order of the cells.
        sides.sort_unstable();
        sides.dedup_by_key(|side| side.0);
        sides.sort_unstable_by_key(|(_, cell, local)| (*cell, *local));
        self.polylines(sides.into_iter().map(|(_, cell, local)| (cell, local)))
    }

    /// The polylines of facets. In the plane the facets of a cell are its edges, in the same order.
    pub fn facets(&self, facets: &[Facet]) -> Vec<Vec<[f64; 2]>> {
        let points =
            self.polylines(facets.iter().map(|facet| (facet.cell as usize, usize::from(facet.local))));
        points.chunks_exact(self.points_of_edge()).map(<[_]>::to_vec).collect()
    }

    /// The cells as a surface on the page, with one value per lattice point of each cell.
    pub fn surface(
        &self,
        lattices: &Lattices,
        cells: &[u32],
        values: Vec<f32>,
        shading: Shading,
        place: impl Fn([f64; 2]) -> Point,
    ) -> ShadedSurface {
        let mut points: Vec<Point> = Vec::with_capacity(values.len());
        let mut triangles = Vec::with_capacity(values.len() * 2);
        for (shape, run) in self.mesh.runs_of_shape(cells) {
            let lattice = lattices.of_shape(shape);
            let (first, count) = (points.len() as u32, lattice.points.len() as u32);
            let cells = run.iter().map(|&cell| cell as usize);
            points.extend(self.positions(shape, &lattice.points, cells).into_iter().map(&place));
            for cell in 0..run.len() as u32 {
                triangles.extend(lattice.triangles.iter().map(|t| t.map(|n| first + cell * count + n)));
            }
        }
        ShadedSurface::new(points, values, triangles, shading)
    }
}

/// The smallest upright rectangle about polylines: lower left and upper right corner.
pub(super) fn bounds<'p>(polylines: impl IntoIterator<Item = &'p Vec<[f64; 2]>>) -> [[f64; 2]; 2] {
    let mut corners = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    for point in polylines.into_iter().flatten() {
        for k in 0..2 {
            corners[0][k] = corners[0][k].min(point[k]);
            corners[1][k] = corners[1][k].max(point[k]);
        }
    }
    corners
}

/// Joins polylines whose ends meet, so that dashes and corners run on from one facet to the next.
pub(super) fn joined(polylines: &[Vec<[f64; 2]>]) -> Vec<Vec<[f64; 2]>> {
    let key = |point: &[f64; 2]| point.map(|x| (x + 0.0).to_bits());
    let starts: BTreeMap<[u64; 2], usize> = polylines
        .iter()
        .enumerate()
        .filter_map(|(number, line)| line.first().map(|point| (key(point), number)))
        .collect();
    let followed: BTreeSet<[u64; 2]> = polylines.iter().filter_map(|line| line.last().map(key)).collect();
    // Lines that nothing leads to come first; what is left then are closed curves.
    let mut order: Vec<usize> = (0..polylines.len()).collect();
    order
        .sort_by_key(|&number| polylines[number].first().is_some_and(|point| followed.contains(&key(point))));
    let mut used = vec![false; polylines.len()];
    let mut lines = Vec::new();
    for first in order {
        if used[first] {
            continue;
        }
        let mut line: Vec<[f64; 2]> = Vec::new();
        let mut next = Some(first);
        while let Some(number) = next.filter(|&number| !used[number]) {
            used[number] = true;
            line.extend(polylines[number].iter().skip(usize::from(!line.is_empty())));
            next = line.last().and_then(|end| starts.get(&key(end)).copied());
        }
        lines.push(line);
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The triangles of a lattice fill the reference cell, all with the same orientation.
    #[test]
    fn lattices_fill_the_cell() {
        for (shape, area) in [(CellShape::Triangle, 0.5), (CellShape::Quadrilateral, 1.0)] {
            let lattice = Lattice::new(shape, 5);
            let areas = lattice.triangles.iter().map(|t| {
                let [a, b, c] = t.map(|n| lattice.points[n as usize]);
                0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
            });
            let areas: Vec<f64> = areas.collect();
            assert!(areas.iter().all(|&area| area > 0.0));
            assert!((areas.iter().sum::<f64>() - area).abs() < 1e-12);
        }
    }

    /// Four sides of a square, out of order, are one closed line; a lone piece stays alone.
    #[test]
    fn facets_are_joined() {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let side = |k: usize| vec![corners[k % 4], corners[(k + 1) % 4]];
        let lines = joined(&[side(2), side(0), side(3), side(1)]);
        assert_eq!(lines.len(), 1);
        assert_eq!(lines[0].len(), 5);
        let open = joined(&[side(1), side(0), vec![[5.0, 5.0], [6.0, 5.0]]]);
        assert!(open.contains(&vec![corners[0], corners[1], corners[2]]));
        assert_eq!(open.len(), 2);
    }
}

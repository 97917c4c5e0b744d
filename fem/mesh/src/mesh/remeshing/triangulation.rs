//! Triangles inside closed polygons, by Delaunay refinement with sizes and some rounds of smoothing.

use std::collections::BTreeMap;

use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

use super::RemeshingError;
use super::outline::to_segment;
use super::sizes::SizeField;

type Delaunay = ConstrainedDelaunayTriangulation<Point2<f64>>;

/// Rounds of refinement, at most.
const ROUNDS: usize = 60;
/// Rounds of smoothing.
const SMOOTHINGS: usize = 12;
/// The circumradius of an equilateral triangle with edges of length 1.
const EQUILATERAL: f64 = 0.577_350_269_189_625_8;
/// A triangle is too large where its circumradius is this many times that of the size.
const TOO_LARGE: f64 = 1.3;
/// The circumradius over the shortest edge from which on a triangle is thin: 27°.
const THIN: f64 = 1.1;
/// No new vertex comes nearer to an edge of the outline than this part of its length.
const OFF_THE_OUTLINE: f64 = 0.45;
/// The sine of an angle below which a triangle has no area but by rounding.
const SLIVER: f64 = 1e-9;

/// Points, those of the polygons first, and triangles, counter-clockwise.
pub(super) struct Triangles {
    pub points: Vec<[f64; 2]>,
    pub cells: Vec<[usize; 3]>,
}

/// Closed polygons with the body to their left, one point after the other.
pub(super) struct Polygons {
    pub points: Vec<[f64; 2]>,
    /// Edges, as two numbers of points.
    pub edges: Vec<[usize; 2]>,
}

impl Polygons {
    /// Whether a point is inside: a ray to the right leaves the body an odd number of times.
    fn hold(&self, x: &[f64; 2]) -> bool {
        let crosses = |edge: &&[usize; 2]| {
            let [a, b] = edge.map(|point| self.points[point]);
            (a[1] > x[1]) != (b[1] > x[1]) && x[0] < a[0] + (x[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
        };
        self.edges.iter().filter(crosses).count() % 2 == 1
    }

    fn is_off(&self, x: &[f64; 2]) -> bool {
        self.edges.iter().all(|edge| {
            let [a, b] = edge.map(|point| self.points[point]);
            to_segment(x, a, b) >= OFF_THE_OUTLINE * (b[0] - a[0]).hypot(b[1] - a[1])
        })
    }

    /// Triangles of about the requested sizes.
    ///
    /// # Errors
    /// [`RemeshingError`]: the outline cannot be triangulated.
    pub fn triangulate(&self, sizes: &SizeField) -> Result<Triangles, RemeshingError> {
        let mut points = self.points.clone();
        for _ in 0..ROUNDS {
            let delaunay = self.delaunay(&points)?;
            let mut wanted: Vec<(f64, [f64; 2], f64)> = vec![];
            for cell in self.inside(&delaunay) {
                let corners = cell.map(|vertex| points[vertex]);
                let Some((centre, radius, shortest)) = circle(corners) else { continue };
                let size = sizes.at(&middle(corners)) * EQUILATERAL;
                let large = radius / (TOO_LARGE * size);
                // Thin ones are left as they are where their circle is small.
                let thin = if radius > 0.6 * size { radius / (THIN * shortest) } else { 0.0 };
                if large.max(thin) > 1.0 && self.hold(&centre) && self.is_off(&centre) {
                    wanted.push((large.max(thin), centre, radius));
                }
            }
            wanted.sort_by(|a, b| b.0.total_cmp(&a.0));
            let before = points.len();
            for (_, centre, radius) in wanted {
                // Points of this round are nearer than the circle's own; what lies behind the outline may be, too.
                let near = |x: &[f64; 2]| (x[0] - centre[0]).hypot(x[1] - centre[1]) < 0.8 * radius;
                if !points.iter().any(near) {
                    points.push(centre);
                }
            }
            if points.len() == before {
                break;
            }
        }
        self.smoothed(points, sizes)
    }

    /// Inner points go to the middles of what surrounds them, where it makes the worst cell no worse.
    fn smoothed(&self, mut points: Vec<[f64; 2]>, sizes: &SizeField) -> Result<Triangles, RemeshingError> {
        let fixed = self.points.len();
        let mut best: Option<(f64, Triangles)> = None;
        for _ in 0..=SMOOTHINGS {
            let cells = self.inside(&self.delaunay(&points)?);
            let worst =
                cells.iter().map(|cell| quality(cell.map(|v| points[v]))).fold(f64::INFINITY, f64::min);
            if best.as_ref().is_none_or(|(least, _)| worst > *least) {
                best = Some((worst, Triangles { points: points.clone(), cells: cells.clone() }));
            }
            let mut sums: BTreeMap<usize, [f64; 3]> = BTreeMap::new();
            for cell in &cells {
                let corners = cell.map(|vertex| points[vertex]);
                let centre = middle(corners);
                // Small cells count as much as large ones, by area, where the sizes ask for them.
                let weight = area(corners) / sizes.at(&centre).powi(3);
                for vertex in cell.iter().filter(|vertex| **vertex >= fixed) {
                    let sum = sums.entry(*vertex).or_default();
                    (0..2).for_each(|k| sum[k] += weight * centre[k]);
                    sum[2] += weight;
                }
            }
            for (vertex, sum) in sums {
                points[vertex] = [sum[0] / sum[2], sum[1] / sum[2]];
            }
        }
        best.map(|(_, triangles)| triangles)
            .filter(|triangles| !triangles.cells.is_empty())
            .ok_or_else(|| RemeshingError::Triangulation("no triangle lies inside".into()))
    }

    fn delaunay(&self, points: &[[f64; 2]]) -> Result<Delaunay, RemeshingError> {
        let vertices = points.iter().map(|x| Point2::new(x[0], x[1])).collect();
        let mut conflicts = 0;
        let delaunay = Delaunay::try_bulk_load_cdt(vertices, self.edges.clone(), |_| conflicts += 1)
            .map_err(|error| RemeshingError::Triangulation(error.to_string()))?;
        if conflicts > 0 {
            return Err(RemeshingError::Triangulation(format!(
                "{conflicts} edges of the outline cross others"
            )));
        }
        if delaunay.num_vertices() != points.len() {
            return Err(RemeshingError::Triangulation("two nodes of the outline coincide".into()));
        }
        Ok(delaunay)
    }

    /// The triangles of the body, in an order that depends on the points alone.
    fn inside(&self, delaunay: &Delaunay) -> Vec<[usize; 3]> {
        let mut cells: Vec<[usize; 3]> = delaunay
            .inner_faces()
            .map(|face| face.vertices())
            .filter(|corners| {
                let corners = corners.map(|vertex| [vertex.position().x, vertex.position().y]);
                // Nodes of a straight side, which rounding takes off it, have slivers between them, outside the body.
                quality(corners) > SLIVER && self.hold(&middle(corners))
            })
            .map(|corners| corners.map(|vertex| vertex.fix().index()))
            .map(|mut cell| {
                let first = (0..3).min_by_key(|k| cell[*k]).unwrap_or(0);
                cell.rotate_left(first);
                cell
            })
            .collect();
        cells.sort_unstable();
        cells
    }
}

fn middle(corners: [[f64; 2]; 3]) -> [f64; 2] {
    std::array::from_fn(|k| (corners[0][k] + corners[1][k] + corners[2][k]) / 3.0)
}

fn area([a, b, c]: [[f64; 2]; 3]) -> f64 {
    0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
}

fn edges([a, b, c]: [[f64; 2]; 3]) -> [f64; 3] {
    [(a, b), (b, c), (c, a)].map(|(x, y)| (x[0] - y[0]).hypot(x[1] - y[1]))
}

/// The least sine of an angle.
fn quality(corners: [[f64; 2]; 3]) -> f64 {
    let [x, y, z] = edges(corners);
    let longest = (x * y).max(y * z).max(z * x);
    2.0 * area(corners) / longest
}

/// Centre and radius of the circle through the corners, and the shortest edge; none for a triangle without area.
fn circle(corners: [[f64; 2]; 3]) -> Option<([f64; 2], f64, f64)> {
    let [a, b, c] = corners;
    let (u, v) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
    let double = 2.0 * (u[0] * v[1] - u[1] * v[0]);
    let (uu, vv) = (u[0] * u[0] + u[1] * u[1], v[0] * v[0] + v[1] * v[1]);
    let to = [(v[1] * uu - u[1] * vv) / double, (u[0] * vv - v[0] * uu) / double];
    let radius = to[0].hypot(to[1]);
    let shortest = edges(corners).into_iter().fold(f64::INFINITY, f64::min);
    radius.is_finite().then_some(([a[0] + to[0], a[1] + to[1]], radius, shortest))
}

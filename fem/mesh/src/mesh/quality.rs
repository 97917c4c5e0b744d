//! The quality of a mesh's cells: scaled Jacobians, aspect ratios, inverted cells.

use std::fmt;

use super::determinant::{JacobianDeterminant, Sign};
use super::small_matrices::determinant;
use super::{CellBlock, Mesh, MeshError};
use crate::element::{CellShape, Lagrange};
use crate::instantiate;
use crate::quadrature::cell_rule;

/// Quality of one cell, judged at the quarter points of its edges, faces and inside, at points of a quadrature rule, and,
/// if the cell is folded in between, at a point where it is: no folded cell has a positive least determinant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellQuality<const D: usize> {
    /// The least det J over the product of the lengths of edges that meet in a vertex, relative to the ideal cell: 1 for
    /// equilateral simplices and for squares and cubes, 0 for degenerate cells, negative for inverted ones. On cells of
    /// degree 1 this is the scaled Jacobian of C. J. Stimpson et al., The Verdict Geometric Quality Library (2007).
    pub scaled_jacobian: f64,
    /// The largest ratio of the axes of the ellipse or ellipsoid to which the map from the ideal cell stretches a
    /// circle or ball: 1 for the ideal cell, a/b for a rectangle a × b, infinite for degenerate cells.
    pub aspect_ratio: f64,
    /// The least Jacobian determinant \[length^D\].
    pub determinant: f64,
    /// The place of the least scaled Jacobian.
    pub position: [f64; D],
}

/// Quality of the cells of a mesh. Displayed as a table.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshQuality<const D: usize> {
    /// Shapes of the cells.
    pub shapes: Vec<CellShape>,
    /// Degree of the geometry.
    pub degree: usize,
    /// Each cell.
    pub cells: Vec<CellQuality<D>>,
}

/// Lower ends of the classes of the histogram of aspect ratios.
pub const ASPECT_RATIOS: [f64; 8] = [1.0, 1.5, 2.0, 3.0, 5.0, 10.0, 30.0, 100.0];

impl<const D: usize> Mesh<D> {
    /// Quality of the cells.
    pub fn quality(&self) -> MeshQuality<D> {
        let all = self.qualities(&self.nodes);
        MeshQuality { shapes: self.shapes(), degree: self.degree, cells: all }
    }

    /// Quality of the cells with the nodes in other positions, as after a deformation.
    ///
    /// # Errors
    /// [`MeshError::NodeCount`] unless there is a position per node.
    #[inline(never)]
    pub fn quality_at(&self, positions: &[[f64; D]]) -> Result<MeshQuality<D>, MeshError> {
        if positions.len() != self.nodes.len() {
            return Err(MeshError::NodeCount { given: positions.len(), count: self.nodes.len() });
        }
        Ok(MeshQuality { shapes: self.shapes(), degree: self.degree, cells: self.qualities(positions) })
    }

    fn qualities(&self, positions: &[[f64; D]]) -> Vec<CellQuality<D>> {
        self.body_blocks().flat_map(|block| self.qualities_of(&block, positions)).collect()
    }

    fn qualities_of(&self, block: &CellBlock, positions: &[[f64; D]]) -> Vec<CellQuality<D>> {
        let element = self.element_of(block.shape);
        let points = sample_points::<D>(&element);
        let tables = element.tabulate(&points);
        let from_ideal = from_ideal::<D>(block.shape);
        let everywhere = (!self.is_affine_on(block.shape)).then(|| JacobianDeterminant::new(&element));
        let quality = |nodes: &[u32]| {
            let mut worst = CellQuality {
                scaled_jacobian: f64::INFINITY,
                aspect_ratio: 1.0,
                determinant: f64::INFINITY,
                position: [0.0; D],
            };
            let mut judge = |slopes: &[[f64; D]], values: &[f64]| {
                let (mut jacobian, mut position) = ([[0.0; D]; D], [0.0; D]);
                for ((&node, slope), value) in nodes.iter().zip(slopes).zip(values) {
                    let x = &positions[node as usize];
                    for i in 0..D {
                        position[i] += value * x[i];
                        for j in 0..D {
                            jacobian[i][j] += slope[j] * x[i];
                        }
                    }
                }
                let determinant = determinant(&jacobian);
                let scaled = scaled_jacobian(block.shape, &jacobian, determinant);
                // What is not a number is the worst, and stays.
                if scaled < worst.scaled_jacobian || scaled.is_nan() {
                    (worst.scaled_jacobian, worst.position) = (scaled, position);
                }
                worst.determinant =
                    if determinant.is_nan() { f64::NAN } else { worst.determinant.min(determinant) };
                worst.aspect_ratio = worst.aspect_ratio.max(aspect_ratio(&jacobian, &from_ideal));
            };
            let samples = tables.gradient.chunks(tables.nodes).zip(tables.value.chunks(tables.nodes));
            samples.for_each(|(slopes, values)| judge(slopes, values));
            let sign = everywhere.as_ref().map(|determinant| determinant.sign(nodes, positions));
            if let Some(Sign::Folded { reference, .. }) = sign {
                let here = element.tabulate(&[reference]);
                judge(&here.gradient, &here.value);
            }
            worst
        };
        block.cells.clone().map(|cell| quality(self.cell(cell))).collect()
    }
}

// The determinant of a quadratic map can be least between the nodes.
fn sample_points<const D: usize>(element: &Lagrange) -> Vec<[f64; D]> {
    let shape = element.shape;
    if element.degree == 1 && shape.is_simplex() {
        return vec![shape.centre()];
    }
    if element.degree == 1 {
        // A multilinear map has its least determinant over products of lengths at vertices as a rule.
        return Lagrange { shape, degree: 2 }.node_points();
    }
    let mut points = cell_rule::<D>(shape, 4).map(|rule| rule.points).unwrap_or_default();
    let mut quarters = vec![[0.0; D]];
    for k in 0..D {
        quarters = quarters
            .into_iter()
            .flat_map(|point| {
                (0..=4).map(move |step| {
                    let mut point = point;
                    point[k] = f64::from(step) / 4.0;
                    point
                })
            })
            .collect();
    }
    points.extend(quarters.into_iter().filter(|point| shape.contains(point, 0.0)));
    points
}

// Columns are the ideal cell's edges in coordinates of the reference cell: equal lengths, equal angles. For simplices the
// inverse of the map from the reference simplex to the regular one.
fn from_ideal<const D: usize>(shape: CellShape) -> [[f64; D]; D] {
    let mut map = [[0.0; D]; D];
    for (k, row) in map.iter_mut().enumerate() {
        row[k] = 1.0;
    }
    if shape.is_simplex() {
        // The regular simplex with vertices 0, (1, 0), (1/2, √3/2), (1/2, √3/6, √(2/3)), inverted.
        let third = 1.0 / 3.0_f64.sqrt();
        map[0][1] = -third;
        map[1][1] = 2.0 * third;
        if D == 3 {
            let root = 6.0_f64.sqrt();
            (map[0][2], map[1][2], map[2][2]) = (-1.0 / root, -1.0 / root, 3.0 / root);
        }
    }
    map
}

fn scaled_jacobian<const D: usize>(shape: CellShape, jacobian: &[[f64; D]; D], determinant: f64) -> f64 {
    let length = |edge: &[f64; D]| -> f64 {
        let image = jacobian.iter().map(|row| row.iter().zip(edge).map(|(a, b)| a * b).sum::<f64>());
        image.map(|x| x * x).sum::<f64>().sqrt()
    };
    let unit = |k: usize| -> [f64; D] { std::array::from_fn(|i| if i == k { 1.0 } else { 0.0 }) };
    let mut product: f64 = (0..D).map(|k| length(&unit(k))).product();
    let mut ideal = 1.0;
    if shape.is_simplex() {
        ideal = if D == 2 { 2.0 / 3.0_f64.sqrt() } else { 2.0_f64.sqrt() };
        for vertex in 0..D {
            // The edges at vertex + 1: to the origin and to the other vertices.
            let edges = (0..D).map(|other| {
                let (a, b) = (unit(vertex), unit(other));
                if other == vertex { a } else { std::array::from_fn(|i| a[i] - b[i]) }
            });
            product = product.max(edges.map(|edge| length(&edge)).product());
        }
    }
    if product == 0.0 { 0.0 } else { ideal * determinant / product }
}

fn aspect_ratio<const D: usize>(jacobian: &[[f64; D]; D], from_ideal: &[[f64; D]; D]) -> f64 {
    let map: [[f64; D]; D] = std::array::from_fn(|i| {
        std::array::from_fn(|j| (0..D).map(|k| jacobian[i][k] * from_ideal[k][j]).sum())
    });
    let square: [[f64; D]; D] =
        std::array::from_fn(|i| std::array::from_fn(|j| (0..D).map(|k| map[k][i] * map[k][j]).sum()));
    let trace: f64 = (0..D).map(|k| square[k][k]).sum();
    let whole = determinant(&map);
    let (largest, smallest) = if D == 2 {
        let root = (0.5 * (square[0][0] - square[1][1])).hypot(square[0][1]);
        let largest = 0.5 * trace + root;
        (largest, whole * whole / largest)
    } else {
        // The eigenvalues of a symmetric matrix by the cosine formula; the least from the determinant, which is more
        // accurate where it is small.
        let mean = trace / 3.0;
        let deviation: f64 = (0..3)
            .flat_map(|i| (0..3).map(move |j| (i, j)))
            .map(|(i, j)| (square[i][j] - if i == j { mean } else { 0.0 }).powi(2))
            .sum();
        let radius = (deviation / 6.0).sqrt();
        if radius <= 1e-15 * mean {
            return 1.0;
        }
        let mut scaled = square;
        for (k, row) in scaled.iter_mut().enumerate() {
            row[k] -= mean;
            row.iter_mut().for_each(|entry| *entry /= radius);
        }
        let angle = (0.5 * determinant(&scaled)).clamp(-1.0, 1.0).acos() / 3.0;
        let largest = mean + 2.0 * radius * angle.cos();
        let least = mean + 2.0 * radius * (angle + 2.0 * std::f64::consts::FRAC_PI_3).cos();
        let middle = trace - largest - least;
        (largest, whole * whole / (largest * middle))
    };
    let ratio = (largest / smallest).sqrt();
    if ratio.is_nan() { f64::INFINITY } else { ratio }
}

impl<const D: usize> MeshQuality<D> {
    /// Least, mean and largest scaled Jacobian.
    pub fn scaled_jacobian(&self) -> [f64; 3] {
        spread(self.cells.iter().map(|cell| cell.scaled_jacobian))
    }

    /// Least, mean and largest aspect ratio.
    pub fn aspect_ratio(&self) -> [f64; 3] {
        spread(self.cells.iter().map(|cell| cell.aspect_ratio))
    }

    /// The least Jacobian determinant of all cells \[length^D\].
    pub fn smallest_determinant(&self) -> f64 {
        spread(self.cells.iter().map(|cell| cell.determinant))[0]
    }

    /// Number of cells whose Jacobian determinant is not positive somewhere.
    pub fn inverted(&self) -> usize {
        let inverted = |cell: &&CellQuality<D>| cell.determinant <= 0.0 || cell.determinant.is_nan();
        self.cells.iter().filter(inverted).count()
    }

    /// The cell with the least scaled Jacobian; the first one of several.
    pub fn worst_cell(&self) -> usize {
        let value = |cell: usize| self.cells[cell].scaled_jacobian;
        let worse = |a: usize, b: usize| {
            if value(b) < value(a) || value(b).is_nan() && !value(a).is_nan() { b } else { a }
        };
        (0..self.cells.len()).reduce(worse).unwrap_or(0)
    }

    /// Numbers of cells by scaled Jacobian: below 0, and in tenths of \[0, 1\].
    pub fn scaled_jacobian_histogram(&self) -> (usize, [usize; 10]) {
        let (mut negative, mut tenths) = (0, [0; 10]);
        for cell in &self.cells {
            if cell.scaled_jacobian >= 0.0 {
                tenths[((10.0 * cell.scaled_jacobian) as usize).min(9)] += 1;
            } else {
                negative += 1;
            }
        }
        (negative, tenths)
    }

    /// Numbers of cells by aspect ratio, in the classes that begin at [`ASPECT_RATIOS`].
    pub fn aspect_ratio_histogram(&self) -> [usize; 8] {
        let mut classes = [0; 8];
        for cell in &self.cells {
            // 1 may be missed by round-off.
            let class = ASPECT_RATIOS.iter().rposition(|&least| cell.aspect_ratio >= least).unwrap_or(0);
            classes[class] += 1;
        }
        classes
    }
}

fn spread(values: impl Iterator<Item = f64>) -> [f64; 3] {
    let (mut least, mut largest, mut sum, mut count) = (f64::INFINITY, f64::NEG_INFINITY, 0.0, 0.0);
    for value in values {
        // NaN stays.
        least = if value < least || value.is_nan() { value } else { least };
        largest = if value > largest || value.is_nan() { value } else { largest };
        sum += value;
        count += 1.0;
    }
    [least, sum / count, largest]
}

impl<const D: usize> fmt::Display for MeshQuality<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let count = self.cells.len();
        writeln!(
            f,
            "{count} cells, {} of degree {}, {} inverted",
            self.shapes.iter().map(|shape| shape.name()).collect::<Vec<_>>().join(" and "),
            self.degree,
            self.inverted()
        )?;
        writeln!(f, "{:<18}{:>12}{:>12}{:>12}", "", "least", "mean", "largest")?;
        for (name, [least, mean, largest]) in
            [("scaled Jacobian", self.scaled_jacobian()), ("aspect ratio", self.aspect_ratio())]
        {
            writeln!(f, "{name:<18}{least:>12.4}{mean:>12.4}{largest:>12.4}")?;
        }
        writeln!(f, "{:<18}{:>12.4e}", "det J", self.smallest_determinant())?;
        if let Some(worst) = self.cells.get(self.worst_cell()) {
            write!(f, "worst cell {} near (", self.worst_cell())?;
            for (k, x) in worst.position.iter().enumerate() {
                write!(f, "{}{x:.4}", if k == 0 { "" } else { ", " })?;
            }
            writeln!(f, ")")?;
        }
        let bar = |cells: usize| "#".repeat((40 * cells).div_ceil(count.max(1)));
        let mut line = |class: String, cells: usize| match cells {
            0 => Ok(()),
            _ => writeln!(f, "  {class:<12}{cells:>10}  {}", bar(cells)),
        };
        let (negative, tenths) = self.scaled_jacobian_histogram();
        line("below 0".to_owned(), negative)?;
        for (tenth, &cells) in tenths.iter().enumerate() {
            line(format!("{:.1} to {:.1}", tenth as f64 / 10.0, (tenth + 1) as f64 / 10.0), cells)?;
        }
        Ok(())
    }
}

instantiate!(quality: Mesh::<D>::quality_at);

#[cfg(test)]
mod tests;

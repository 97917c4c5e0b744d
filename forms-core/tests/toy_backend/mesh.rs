//! Linear simplices: a square of triangles or a cube of tetrahedra with moved nodes, and their boundary.

use forms_core::contract::{Basis, CellGeometry, Entity, PointGeometry};

use super::random::Random;

/// A cell, or a facet with the cell that owns it.
#[derive(Clone, Debug)]
pub struct Place<const D: usize> {
    /// Nodes of the cell.
    pub nodes: Vec<usize>,
    pub cell: CellGeometry<f64>,
    pub points: Vec<Point<D>>,
}

/// A quadrature point, with the basis functions of the place's nodes.
#[derive(Clone, Debug)]
pub struct Point<const D: usize> {
    pub geometry: PointGeometry<f64, D>,
    pub basis: Vec<Basis<f64, D>>,
}

/// Nodes, cells ("all"), boundary facets ("boundary").
pub struct Mesh<const D: usize> {
    pub nodes: Vec<[f64; D]>,
    cells: Vec<Place<D>>,
    facets: Vec<Place<D>>,
}

impl<const D: usize> Mesh<D> {
    /// The unit square (cube), cut along a diagonal into D! simplices; inner freedom: moved corners.
    pub fn cube(random: &mut Random) -> Self {
        let corner = |number: usize| -> [f64; D] { std::array::from_fn(|axis| (number >> axis & 1) as f64) };
        let mut nodes: Vec<[f64; D]> = (0..1 << D).map(corner).collect();
        for coordinate in nodes.iter_mut().flatten() {
            *coordinate += 0.15 * random.number();
        }
        // Kuhn's simplices: one path from corner 0 to the opposite corner per order of the axes.
        let orders: &[&[usize]] = match D {
            2 => &[&[0, 1], &[1, 0]],
            _ => &[&[0, 1, 2], &[0, 2, 1], &[1, 0, 2], &[1, 2, 0], &[2, 0, 1], &[2, 1, 0]],
        };
        let path = |order: &&[usize]| {
            let mut cell = vec![0];
            for axis in *order {
                cell.push(cell[cell.len() - 1] | 1 << axis);
            }
            cell
        };
        Mesh::new(nodes, orders.iter().map(path).collect())
    }

    /// One simplex.
    pub fn simplex(nodes: Vec<[f64; D]>) -> Self {
        let cell = (0..=D).collect();
        Mesh::new(nodes, vec![cell])
    }

    fn new(nodes: Vec<[f64; D]>, cells: Vec<Vec<usize>>) -> Self {
        let mut facets = Vec::new();
        for (index, cell) in cells.iter().enumerate() {
            for opposite in 0..=D {
                let facet: Vec<usize> = (0..=D).filter(|i| *i != opposite).map(|i| cell[i]).collect();
                let shared = |other: &Vec<usize>| facet.iter().all(|node| other.contains(node));
                if cells.iter().enumerate().all(|(other, cell)| other == index || !shared(cell)) {
                    facets.push(place(&nodes, cell, Some(opposite)));
                }
            }
        }
        let cells = cells.iter().map(|cell| place(&nodes, cell, None)).collect();
        Mesh { nodes, cells, facets }
    }

    /// The places of a region: all cells, or all facets of the boundary.
    pub fn places(&self, entity: Entity, name: &str) -> Vec<&Place<D>> {
        match (entity, name) {
            (Entity::Cells, "all") => self.cells.iter().collect(),
            (Entity::Facets, "boundary") => self.facets.iter().collect(),
            _ => panic!("no region `{name}` of {entity:?}"),
        }
    }
}

/// Points of degree 2 on a simplex with `count` vertices, barycentric, with equal weights.
fn barycentric_points(count: usize) -> Vec<Vec<f64>> {
    let near = match count {
        2 => 0.5 + 0.5 / 3_f64.sqrt(),
        3 => 2.0 / 3.0,
        _ => (5.0 + 3.0 * 5_f64.sqrt()) / 20.0,
    };
    let far = (1.0 - near) / (count - 1) as f64;
    (0..count).map(|point| (0..count).map(|i| if i == point { near } else { far }).collect()).collect()
}

fn place<const D: usize>(nodes: &[[f64; D]], cell: &[usize], opposite: Option<usize>) -> Place<D> {
    let vertices: Vec<[f64; D]> = cell.iter().map(|node| nodes[*node]).collect();
    // φ_i = a + g·x with φ_i(x_j) = δ_ij.
    let system: Vec<Vec<f64>> =
        vertices.iter().map(|x| [1.0].into_iter().chain(x.iter().copied()).collect()).collect();
    let inverse = inverse(&system);
    let gradients: Vec<[f64; D]> =
        (0..=D).map(|i| std::array::from_fn(|axis| inverse[axis + 1][i])).collect();
    let volume = determinant(&system).abs() / if D == 2 { 2.0 } else { 6.0 };
    let mut diameter: f64 = 0.0;
    for a in &vertices {
        for b in &vertices {
            diameter = diameter.max((0..D).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt());
        }
    }
    // |F| = D |T| |∇φ_opposite|, n = −∇φ_opposite / |∇φ_opposite|.
    let (mut facet_area, mut normal) = (0.0, [0.0; D]);
    if let Some(opposite) = opposite {
        let steep = gradients[opposite].iter().map(|g| g * g).sum::<f64>().sqrt();
        facet_area = D as f64 * volume * steep;
        normal = gradients[opposite].map(|g| -g / steep);
    }
    let barycentric: Vec<Vec<f64>> = match opposite {
        None => barycentric_points(D + 1),
        Some(opposite) => {
            let mut points = barycentric_points(D);
            points.iter_mut().for_each(|point| point.insert(opposite, 0.0));
            points
        }
    };
    let measure = if opposite.is_some() { facet_area } else { volume };
    let weight = measure / barycentric.len() as f64;
    let points = barycentric
        .iter()
        .map(|values| {
            let position = std::array::from_fn(|axis| {
                values.iter().zip(&vertices).map(|(value, x)| value * x[axis]).sum()
            });
            let basis = values
                .iter()
                .zip(&gradients)
                .map(|(value, gradient)| Basis { value: *value, gradient: *gradient })
                .collect();
            Point { geometry: PointGeometry { weight, position, normal, curvature: 0.0 }, basis }
        })
        .collect();
    Place {
        nodes: cell.to_vec(),
        cell: CellGeometry {
            diameter,
            cell_volume: volume,
            facet_area,
            opposite_diameter: 0.0,
            opposite_volume: 0.0,
        },
        points,
    }
}

/// det A by expansion along the first row.
pub fn determinant(a: &[Vec<f64>]) -> f64 {
    match a {
        [] => 1.0,
        _ => (0..a.len())
            .map(|j| (if j % 2 == 0 { 1.0 } else { -1.0 }) * a[0][j] * determinant(&minor(a, 0, j)))
            .sum(),
    }
}

fn minor(a: &[Vec<f64>], row: usize, column: usize) -> Vec<Vec<f64>> {
    let keep = |skip: usize| (0..a.len()).filter(move |k| *k != skip);
    keep(row).map(|i| keep(column).map(|j| a[i][j]).collect()).collect()
}

/// A⁻¹ by minors.
pub fn inverse(a: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let determinant_ = determinant(a);
    let entry = |i: usize, j: usize| {
        let sign = if (i + j).is_multiple_of(2) { 1.0 } else { -1.0 };
        sign * determinant(&minor(a, j, i)) / determinant_
    };
    (0..a.len()).map(|i| (0..a.len()).map(|j| entry(i, j)).collect()).collect()
}

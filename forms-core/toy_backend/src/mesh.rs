//! Simplices: a square of triangles or a cube of tetrahedra with moved nodes, their boundary and the facets
//! between them. Basis functions are linear or quadratic; cells are straight.

use forms_core::contract::{Basis, CellGeometry, Entity, Hessian, OppositePoint, PointGeometry, Side};

use super::random::Random;

/// A cell, or a facet with the cell that owns it.
#[derive(Clone, Debug)]
pub struct Element<const D: usize> {
    /// Nodes of the cell.
    pub nodes: Vec<usize>,
    pub cell: CellGeometry<f64>,
    /// Means of the basis functions over the cell.
    pub means: Vec<Basis<f64, D>>,
    pub points: Vec<Point<D>>,
    /// An interior facet seen from its other cell, with the same points; the opposite facet of a pair, with the opposite ones.
    pub across: Option<Box<Element<D>>>,
}

impl<const D: usize> Element<D> {
    /// The element as one of its two cells sees it.
    pub fn on(&self, side: Side) -> &Element<D> {
        match side {
            Side::This => self,
            Side::Other => self.across.as_ref().expect("an interior facet"),
        }
    }
}

/// A quadrature point, with the basis functions of the element's nodes.
#[derive(Clone, Debug)]
pub struct Point<const D: usize> {
    pub geometry: PointGeometry<f64, D>,
    pub basis: Vec<Basis<f64, D>>,
    pub hessians: Vec<Hessian<f64, D>>,
}

/// Nodes, cells ("all"), boundary facets ("boundary"), interior facets ("skeleton"), boundary facets paired with those that face them most.
pub struct Mesh<const D: usize> {
    pub nodes: Vec<[f64; D]>,
    cells: Vec<Element<D>>,
    facets: Vec<Element<D>>,
    skeleton: Vec<Element<D>>,
    pairs: Vec<Element<D>>,
}

impl<const D: usize> Mesh<D> {
    /// The unit square (cube), cut along a diagonal into D! simplices; inner freedom: moved corners.
    pub fn cube(random: &mut Random) -> Self {
        Mesh::cut_cube(random, false)
    }

    /// A mesh of the cube with quadratic basis functions: a node per vertex and per edge.
    pub fn quadratic_cube(random: &mut Random) -> Self {
        Mesh::cut_cube(random, true)
    }

    fn cut_cube(random: &mut Random, quadratic: bool) -> Self {
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
        Mesh::new(nodes, orders.iter().map(path).collect(), quadratic)
    }

    /// This mesh where each cell has nodes of its own: functions may jump.
    pub fn broken(mut self) -> Self {
        let before: Vec<Vec<usize>> = self.cells.iter().map(|cell| cell.nodes.clone()).collect();
        self.nodes = before.iter().flatten().map(|node| self.nodes[*node]).collect();
        let renumber = |element: &mut Element<D>| {
            let cell = before.iter().position(|nodes| *nodes == element.nodes).expect("a cell of the mesh");
            let count = element.nodes.len();
            element.nodes = (cell * count..(cell + 1) * count).collect();
        };
        let two_sided = self.skeleton.iter_mut().chain(&mut self.pairs);
        two_sided.filter_map(|element| element.across.as_mut()).for_each(|element| renumber(element));
        let facets = self.facets.iter_mut().chain(&mut self.skeleton).chain(&mut self.pairs);
        self.cells.iter_mut().chain(facets).for_each(renumber);
        self
    }

    /// One simplex.
    pub fn simplex(nodes: Vec<[f64; D]>) -> Self {
        let cell = (0..=D).collect();
        Mesh::new(nodes, vec![cell], false)
    }

    /// The mesh with its vertices moved; cells stay straight.
    pub fn moved(&self, by: &[[f64; D]]) -> Self {
        let vertices = self.cells.iter().map(|cell| cell.nodes[..=D].to_vec()).collect::<Vec<_>>();
        let count = vertices.iter().flatten().max().map_or(0, |last| last + 1);
        let place = |node: usize| std::array::from_fn(|k| self.nodes[node][k] + by[node][k]);
        Mesh::new((0..count).map(place).collect(), vertices, self.cells[0].nodes.len() > D + 1)
    }

    fn new(mut nodes: Vec<[f64; D]>, cells: Vec<Vec<usize>>, quadratic: bool) -> Self {
        let vertices = nodes.clone();
        let mut edges: Vec<[usize; 2]> = Vec::new();
        let mut node_of_edge = |edge: [usize; 2]| {
            let known = edges.iter().position(|known| *known == edge);
            vertices.len()
                + known.unwrap_or_else(|| {
                    edges.push(edge);
                    nodes.push(std::array::from_fn(|k| 0.5 * (vertices[edge[0]][k] + vertices[edge[1]][k])));
                    edges.len() - 1
                })
        };
        let cells: Vec<Cell> = cells
            .into_iter()
            .map(|vertices| {
                let edges = if quadratic { pairs(D + 1) } else { vec![] };
                // The cells' vertices are in rising order, so that both cells of an edge name it alike.
                let added: Vec<usize> =
                    edges.iter().map(|[i, j]| node_of_edge([vertices[*i], vertices[*j]])).collect();
                let nodes = [&vertices[..], &added].concat();
                Cell { vertices, edges, nodes }
            })
            .collect();
        let (mut facets, mut skeleton) = (Vec::new(), Vec::new());
        for (index, cell) in cells.iter().enumerate() {
            for opposite in 0..=D {
                let facet = cell.facet(opposite);
                let across = cells.iter().enumerate().find_map(|(other, cell)| {
                    let opposite = (0..=D).find(|opposite| cell.facet(*opposite) == facet)?;
                    (other != index).then_some((other, opposite))
                });
                let mut seen = build(&vertices, cell, Some(opposite));
                match across {
                    None => facets.push(seen),
                    Some((other, opposite)) if index < other => {
                        let across = build(&vertices, &cells[other], Some(opposite));
                        seen.cell.opposite_diameter = across.cell.diameter;
                        seen.cell.opposite_volume = across.cell.cell_volume;
                        seen.across = Some(Box::new(across));
                        skeleton.push(seen);
                    }
                    Some(_) => {}
                }
            }
        }
        let cells = cells.iter().map(|cell| build(&vertices, cell, None)).collect();
        let normal = |facet: &Element<D>| facet.points[0].geometry.normal;
        let facing = |own: &Element<D>, other: &Element<D>| -> f64 {
            normal(own).iter().zip(&normal(other)).map(|(a, b)| a * b).sum()
        };
        let opposite = |own: &Element<D>| -> Element<D> {
            let most = facets.iter().min_by(|a, b| facing(own, a).total_cmp(&facing(own, b)));
            paired(own, most.unwrap_or(own))
        };
        let pairs = facets.iter().map(opposite).collect();
        Mesh { nodes, cells, facets, skeleton, pairs }
    }

    /// The elements of a region: all cells, or all facets of the boundary.
    pub fn elements(&self, entity: Entity, name: &str) -> Vec<&Element<D>> {
        match (entity, name) {
            (Entity::Cells, "all") => self.cells.iter().collect(),
            (Entity::Facets, "boundary") => self.facets.iter().collect(),
            (Entity::InteriorFacets, "skeleton") => self.skeleton.iter().collect(),
            (Entity::Pairs, _) => self.pairs.iter().collect(),
            _ => panic!("no region `{name}` of {entity:?}"),
        }
    }
}

/// Point k of a facet with point k of another, wherever that is: kernels do not mind.
fn paired<const D: usize>(own: &Element<D>, opposite: &Element<D>) -> Element<D> {
    let mut pair = own.clone();
    pair.cell.opposite_diameter = opposite.cell.diameter;
    pair.cell.opposite_volume = opposite.cell.cell_volume;
    for (this, other) in pair.points.iter_mut().zip(&opposite.points) {
        let (x, y, toward) = (this.geometry.position, other.geometry.position, this.geometry.normal);
        let gap = (0..D).map(|k| toward[k] * (y[k] - x[k])).sum();
        this.geometry.opposite = OppositePoint {
            gap,
            toward,
            position: y,
            normal: other.geometry.normal,
            ..OppositePoint::none()
        };
    }
    pair.across = Some(Box::new(opposite.clone()));
    pair
}

/// A simplex: its vertices, its edges by local vertices (if they hold nodes), all its nodes.
struct Cell {
    vertices: Vec<usize>,
    edges: Vec<[usize; 2]>,
    nodes: Vec<usize>,
}

impl Cell {
    fn facet(&self, opposite: usize) -> Vec<usize> {
        (0..self.vertices.len()).filter(|i| *i != opposite).map(|i| self.vertices[i]).collect()
    }
}

/// All i < j < count.
pub fn pairs(count: usize) -> Vec<[usize; 2]> {
    (0..count).flat_map(|i| (i + 1..count).map(move |j| [i, j])).collect()
}

/// Basis functions of a simplex at a point, from its barycentric coordinates λ and their gradients g: λ_i, or
/// λ_i (2 λ_i − 1) and 4 λ_i λ_j.
pub fn functions<const D: usize>(
    values: &[f64],
    gradients: &[[f64; D]],
    edges: &[[usize; 2]],
) -> Vec<(Basis<f64, D>, Hessian<f64, D>)> {
    let product = |factor: f64, i: usize, j: usize| -> Hessian<f64, D> {
        std::array::from_fn(|a| {
            std::array::from_fn(|b| {
                factor * 0.5 * (gradients[i][a] * gradients[j][b] + gradients[j][a] * gradients[i][b])
            })
        })
    };
    let mut all = Vec::new();
    for (i, value) in values.iter().enumerate() {
        let (value, slope, curvature) = match edges.is_empty() {
            true => (*value, 1.0, 0.0),
            false => (value * (2.0 * value - 1.0), 4.0 * value - 1.0, 4.0),
        };
        let gradient = gradients[i].map(|g| slope * g);
        all.push((Basis { value, gradient }, product(curvature, i, i)));
    }
    for [i, j] in edges {
        let value = 4.0 * values[*i] * values[*j];
        let gradient =
            std::array::from_fn(|k| 4.0 * (values[*i] * gradients[*j][k] + values[*j] * gradients[*i][k]));
        all.push((Basis { value, gradient }, product(8.0, *i, *j)));
    }
    all
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

/// Means of the basis functions of a simplex, by the points of degree 2.
fn means<const D: usize>(gradients: &[[f64; D]], edges: &[[usize; 2]]) -> Vec<Basis<f64, D>> {
    let points = barycentric_points(D + 1);
    let mut means = vec![Basis { value: 0.0, gradient: [0.0; D] }; D + 1 + edges.len()];
    for values in &points {
        for (mean, (basis, _)) in means.iter_mut().zip(functions(values, gradients, edges)) {
            mean.value += basis.value / points.len() as f64;
            for (entry, slope) in mean.gradient.iter_mut().zip(basis.gradient) {
                *entry += slope / points.len() as f64;
            }
        }
    }
    means
}

fn build<const D: usize>(nodes: &[[f64; D]], cell: &Cell, opposite: Option<usize>) -> Element<D> {
    let vertices: Vec<[f64; D]> = cell.vertices.iter().map(|node| nodes[*node]).collect();
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
            let (basis, hessians) = functions(values, &gradients, &cell.edges).into_iter().unzip();
            Point {
                geometry: PointGeometry {
                    weight,
                    position,
                    normal,
                    curvature: 0.0,
                    opposite: OppositePoint::none(),
                },
                basis,
                hessians,
            }
        })
        .collect();
    Element {
        nodes: cell.nodes.clone(),
        means: means(&gradients, &cell.edges),
        cell: CellGeometry {
            diameter,
            cell_volume: volume,
            facet_area,
            opposite_diameter: 0.0,
            opposite_volume: 0.0,
        },
        points,
        across: None,
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

//! Meshes of triangles and quadrilaterals.

mod assembly;
mod fields;
mod meshes;
mod output;
mod solutions;
mod spaces;

use forms_fem::mesh::{BOUNDARY, MeshError};
use forms_fem::prelude::*;

/// Coefficients without structure.
fn rough(space: &Arc<Space<2>>) -> Field<2> {
    let value = |index: usize| ((index * 7919 + 13) % 1009) as f64 / 1009.0 - 0.5;
    Field::from_values(space, (0..space.unknowns()).map(value).collect()).unwrap()
}

/// The unit square as n × n squares, where every third is two triangles; cells begin at any of their vertices. Of
/// degree 1 its vertices are moved at random, of degree 2 all its nodes by a smooth map, in both cases only inside.
pub fn patchwork(n: usize, degree: usize) -> Mesh<2> {
    let [squares, triangles] = cells(n, degree);
    let blocks = vec![(CellShape::Quadrilateral, squares), (CellShape::Triangle, triangles)];
    with_names(Mesh::from_blocks(degree, nodes(n, degree), blocks).unwrap()).unwrap()
}

fn with_names(mut mesh: Mesh<2>) -> Result<Mesh<2>, MeshError> {
    let name_facets = |mesh: &mut Mesh<2>, name: &str, axis: usize, at: f64| {
        mesh.name_facets(name, BOUNDARY, move |centre| (centre[axis] - at).abs() < 1e-12)
    };
    name_facets(&mut mesh, "left", 0, 0.0)?;
    name_facets(&mut mesh, "right", 0, 1.0)?;
    name_facets(&mut mesh, "bottom", 1, 0.0)?;
    name_facets(&mut mesh, "top", 1, 1.0)?;
    for (name, shape) in [("squares", CellShape::Quadrilateral), ("triangles", CellShape::Triangle)] {
        let own = (0..mesh.cell_count()).filter(|cell| mesh.cell_shape(*cell) == shape);
        let own: Vec<u32> = own.map(|cell| cell as u32).collect();
        mesh.name_listed_cells(name, &own)?;
    }
    let half = (0..mesh.cell_count() as u32).filter(|cell| cell % 2 == 0).collect::<Vec<u32>>();
    mesh.name_listed_cells("every other", &half)?;
    mesh.name_interface("seam", "triangles", "squares")?;
    Ok(mesh)
}

fn nodes(n: usize, degree: usize) -> Vec<[f64; 2]> {
    let steps = n * degree;
    let mut nodes = Vec::new();
    for j in 0..=steps {
        for i in 0..=steps {
            let [x, y] = [i, j].map(|k| k as f64 / steps as f64);
            let inside = i > 0 && j > 0 && i < steps && j < steps;
            let by = |seed: usize| match degree {
                1 if inside => 0.4 / n as f64 * (((i * 613 + j * 379 + seed) % 101) as f64 / 100.0 - 0.5),
                1 => 0.0,
                _ => {
                    let bump = (std::f64::consts::PI * x).sin() * (std::f64::consts::PI * y).sin();
                    0.06 * bump * (1.0 + seed as f64 * x)
                }
            };
            nodes.push([x + by(0), y - by(1)]);
        }
    }
    nodes
}

/// Nodes of the squares that stay squares, and of the triangles.
fn cells(n: usize, degree: usize) -> [Vec<u32>; 2] {
    let row = n * degree + 1;
    let number = |[i, j]: [usize; 2]| (i + j * row) as u32;
    let mut cells = [vec![], vec![]];
    // Vertices in steps of the geometry's nodes; then the nodes half way, and in the middle of a square.
    let mut add = |vertices: &[[usize; 2]], turn: usize| {
        let count = vertices.len();
        let corner = |k: usize| vertices[(k + turn) % count];
        let list = &mut cells[count % 2];
        list.extend((0..count).map(|k| number(corner(k))));
        if degree == 2 {
            let half = |a: [usize; 2], b: [usize; 2]| [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
            list.extend((0..count).map(|k| number(half(corner(k), corner(k + 1)))));
            list.extend((0..count / 4).map(|_| number(half(corner(0), corner(2)))));
        }
    };
    for j in 0..n {
        for i in 0..n {
            let at = |a: usize, b: usize| [(i + a) * degree, (j + b) * degree];
            let square = [at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
            let turn = i + 2 * j;
            match ((i + 2 * j) % 3, (i + j) % 2) {
                (0, 0) => {
                    add(&[square[0], square[1], square[2]], turn);
                    add(&[square[0], square[2], square[3]], turn + 1);
                }
                (0, _) => {
                    add(&[square[0], square[1], square[3]], turn);
                    add(&[square[1], square[2], square[3]], turn + 1);
                }
                _ => add(&square, turn),
            }
        }
    }
    cells
}

//! Contact pairs of fixed points: two bodies whose meshes do not match.

mod assembly;
mod errors;
mod geometry;
mod histories;
mod jumping_data;
mod patch;

use forms_fem::prelude::*;

/// Two meshes as one, the nodes of each moved by a map of its own. The facets of the first one's side are "below", those of
/// the other's are "above".
fn together<const D: usize>(
    [first, second]: [&Mesh<D>; 2],
    [below, above]: [&str; 2],
    maps: [&dyn Fn([f64; D]) -> [f64; D]; 2],
) -> Mesh<D> {
    let shapes = [first.cell_shape(0), second.cell_shape(0)];
    let mut nodes: Vec<[f64; D]> = first.nodes().iter().map(|x| maps[0](*x)).collect();
    let start = nodes.len() as u32;
    nodes.extend(second.nodes().iter().map(|x| maps[1](*x)));
    let others = second.cells().iter().map(|node| node + start).collect();
    let blocks = vec![(shapes[0], first.cells().to_vec()), (shapes[1], others)];
    let mut mesh = Mesh::from_nonconforming_blocks(first.degree(), nodes, blocks).unwrap();
    let count = first.cell_count() as u32;
    mesh.name_listed_facets("below", first.facet_region(below).unwrap()).unwrap();
    for name in second.facet_region_names().filter(|name| *name != "boundary") {
        let facets = second.facet_region(name).unwrap().iter();
        let moved: Vec<Facet> = facets.map(|facet| Facet { cell: facet.cell + count, ..*facet }).collect();
        mesh.name_listed_facets(&format!("second {name}"), &moved).unwrap();
        if name == above {
            mesh.name_listed_facets("above", &moved).unwrap();
        }
    }
    for name in first.facet_region_names().filter(|name| *name != "boundary") {
        mesh.name_listed_facets(&format!("first {name}"), first.facet_region(name).unwrap()).unwrap();
    }
    let number = |cell: usize| cell as u32;
    mesh.name_listed_cells("first", &(0..first.cell_count()).map(number).collect::<Vec<_>>()).unwrap();
    let rest: Vec<u32> = (first.cell_count()..mesh.cell_count()).map(number).collect();
    mesh.name_listed_cells("second", &rest).unwrap();
    mesh
}

/// Unit squares of 3 and 4 cells along their common side, at y = 1, each with nodes moved by a map of its own.
pub(crate) fn squares(
    shapes: [CellShape; 2],
    degree: usize,
    maps: [&dyn Fn([f64; 2]) -> [f64; 2]; 2],
) -> Mesh<2> {
    let first = rectangle([0.0; 2], [1.0, 1.0], [3, 2], shapes[0], degree).unwrap();
    let second = rectangle([0.0, 1.0], [1.0, 2.0], [4, 3], shapes[1], degree).unwrap();
    together([&first, &second], ["top", "bottom"], maps)
}

/// Unit cubes of 2 × 3 and 3 × 2 cells on their common side, at z = 1.
pub(crate) fn cubes(shape: CellShape, degree: usize, maps: [&dyn Fn([f64; 3]) -> [f64; 3]; 2]) -> Mesh<3> {
    let first = cuboid([0.0; 3], [1.0; 3], [2, 3, 1], shape, degree).unwrap();
    let second = cuboid([0.0, 0.0, 1.0], [1.0, 1.0, 2.0], [3, 2, 1], shape, degree).unwrap();
    together([&first, &second], ["top", "bottom"], maps)
}

//! Facets of a mesh of tetrahedra, seen along an axis.

use std::collections::BTreeMap;

use forms_fem::prelude::*;

use crate::Outcome;

/// The facets of a region as triangles in the plane of two of the coordinates; sides are straight.
pub fn facets_in_plane(mesh: &Mesh<3>, region: &str, [x, y]: [usize; 2]) -> Outcome<Mesh<2>> {
    let mut numbers = BTreeMap::new();
    let (mut places, mut triangles) = (vec![], vec![]);
    for facet in mesh.facet_region(region)? {
        let (cell, local) = (facet.cell as usize, usize::from(facet.local));
        let vertices = mesh.cell_shape(cell).facet_vertices(local);
        let mut corners: Vec<u32> = vertices.iter().map(|vertex| mesh.cell(cell)[*vertex]).collect();
        let [a, b, c] = [0, 1, 2].map(|corner| {
            let node = &mesh.nodes()[corners[corner] as usize];
            [node[x], node[y]]
        });
        // Seen from the other side they would turn the wrong way.
        if (b[0] - a[0]) * (c[1] - a[1]) < (c[0] - a[0]) * (b[1] - a[1]) {
            corners.swap(1, 2);
        }
        for corner in corners {
            let number = *numbers.entry(corner).or_insert_with(|| {
                let node = &mesh.nodes()[corner as usize];
                places.push([node[x], node[y]]);
                places.len() as u32 - 1
            });
            triangles.push(number);
        }
    }
    Ok(Mesh::from_parts(CellShape::Triangle, 1, places, triangles)?)
}

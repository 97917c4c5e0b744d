//! Counts, places and sharing of nodes.

use super::*;
use crate::element::CellShape;
use crate::mesh::{annulus, cuboid, rectangle};

#[test]
fn counts_follow_from_euler() -> Result<(), Box<dyn std::error::Error>> {
    // Vertices + edges + faces + centres of structured grids, closed forms.
    for geometry in 1..=2 {
        for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
            let mesh = rectangle([0.0; 2], [1.0; 2], [3, 4], shape, geometry)?;
            assert_eq!(Space::scalar(&mesh, 1)?.node_count(), 4 * 5);
            let space = Space::vector(&mesh, 2)?;
            assert_eq!((space.node_count(), space.unknowns()), (7 * 9, 2 * 7 * 9));
            assert_eq!(space.nodes_on("left")?.len(), 9);
            assert_eq!(space.nodes_on("boundary")?.len(), 2 * (6 + 8));
            assert_eq!(space.nodes_on("all")?.len(), 7 * 9);
        }
        for shape in [CellShape::Tetrahedron, CellShape::Hexahedron] {
            let mesh = cuboid([0.0; 3], [1.0; 3], [1, 2, 3], shape, geometry)?;
            assert_eq!(Space::scalar(&mesh, 1)?.node_count(), 2 * 3 * 4);
            let space = Space::tensor(&mesh, 2)?;
            assert_eq!((space.node_count(), space.components()), (3 * 5 * 7, 9));
            assert_eq!(space.nodes_on("bottom")?.len(), 3 * 5);
        }
    }
    Ok(())
}

// The numbering shares exactly the nodes that coincide, in order of first use.
#[test]
fn nodes_are_shared_where_they_coincide() -> Result<(), Box<dyn std::error::Error>> {
    for (shape, geometry) in [(CellShape::Tetrahedron, 1), (CellShape::Hexahedron, 2)] {
        let mesh = cuboid([0.0; 3], [1.0, 2.0, 4.0], [2, 2, 2], shape, geometry)?;
        let space = Space::scalar(&mesh, 2)?;
        let points = space.cell_element(0).node_points::<3>();
        let mut next = 0;
        for cell in mesh.cell_order().cells().iter().map(|cell| *cell as usize) {
            for (&node, point) in space.cell_nodes(cell).iter().zip(&points) {
                assert!(node <= next);
                next = next.max(node + 1);
                let (x, _) = mesh.map(cell, point);
                let position = space.positions()[node as usize];
                assert!((0..3).all(|k| (x[k] - position[k]).abs() < 1e-14));
            }
        }
        let mut places: Vec<_> = space.positions().iter().map(|x| x.map(|x| (16.0 * x) as i64)).collect();
        places.sort_unstable();
        places.dedup();
        assert_eq!(places.len(), space.node_count());
    }
    Ok(())
}

#[test]
fn positions_follow_the_curved_geometry() -> Result<(), Box<dyn std::error::Error>> {
    let mesh = annulus(1.0, 2.0, 1, 6, CellShape::Quadrilateral, 2)?;
    let space = Space::scalar(&mesh, 2)?;
    for node in space.nodes_on("outer")? {
        let [x, y] = space.positions()[node as usize];
        assert!((x.hypot(y) - 2.0).abs() < 1e-15);
    }
    // On straight cells the midpoints are on chords.
    let mesh = annulus(1.0, 2.0, 1, 6, CellShape::Quadrilateral, 1)?;
    let space = Space::scalar(&mesh, 2)?;
    let radii = space.nodes_on("outer")?;
    let radii = radii.iter().map(|&node| space.positions()[node as usize]).map(|[x, y]| x.hypot(y));
    assert_eq!(radii.filter(|radius| (radius - 3f64.sqrt()).abs() < 1e-14).count(), 6);
    Ok(())
}

#[test]
fn errors_name_degree_and_region() -> Result<(), Box<dyn std::error::Error>> {
    let mesh = rectangle([0.0; 2], [1.0; 2], [1, 1], CellShape::Triangle, 1)?;
    assert!(matches!(Space::scalar(&mesh, 5), Err(SpaceError::Element(_))));
    let message = Space::scalar(&mesh, 1)?.nodes_on("lid").err().map(|error| error.to_string());
    assert_eq!(
        message.as_deref(),
        Some(
            "there is no region \"lid\"; the mesh has the cell regions \"all\", the facet regions \"bottom\", \
             \"boundary\", \"left\", \"right\", \"top\" and the interior facet regions \"interior\""
        )
    );
    Ok(())
}

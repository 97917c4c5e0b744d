//! Cracks, hanging nodes and overlaps, by every way that a mesh can be made.

use super::*;
use crate::element::CellShape;
use crate::mesh::{annulus, cuboid, rectangle};

type Checked = Result<(), MeshError>;
/// Nodes, and blocks of cells.
type Parts<const D: usize> = (Vec<[f64; D]>, Vec<(CellShape, Vec<u32>)>);

/// Cells of two meshes together, nodes and cells of the second one after those of the first.
fn beside<const D: usize>(first: &Mesh<D>, second: &Mesh<D>) -> Parts<D> {
    let shift = first.node_count() as u32;
    let nodes = [first.nodes(), second.nodes()].concat();
    let cells = first.cells().iter().copied().chain(second.cells().iter().map(|node| node + shift));
    (nodes, vec![(first.cell_shape(0), cells.collect())])
}

fn joined<const D: usize>(first: &Mesh<D>, second: &Mesh<D>) -> Result<Mesh<D>, MeshError> {
    let (nodes, blocks) = beside(first, second);
    Mesh::from_blocks(first.degree(), nodes, blocks)
}

#[test]
fn a_crack_is_allowed_and_named() -> Checked {
    for (shape, degree) in [(CellShape::Triangle, 2), (CellShape::Quadrilateral, 1)] {
        let left = rectangle([0.0; 2], [1.0; 2], [2, 3], shape, degree)?;
        let right = rectangle([1.0, 0.0], [2.0, 1.0], [2, 3], shape, degree)?;
        let mesh = joined(&left, &right)?;
        let found = mesh.conformity();
        assert_eq!((found.cracks.len(), found.hanging_nodes.len(), found.overlaps.len()), (3, 0, 0));
        for [a, b] in &found.cracks {
            assert_eq!(mesh.facet_centre(*a), mesh.facet_centre(*b));
            assert_eq!(mesh.facet_centre(*a)[0], 1.0);
        }
        assert!(found.to_string().starts_with("pairs of facets in cracks: 3; the first between cells "));
        assert!(left.conformity().is_conforming());
    }
    for shape in [CellShape::Tetrahedron, CellShape::Hexahedron] {
        let lower = cuboid([0.0; 3], [1.0; 3], [2, 2, 1], shape, 2)?;
        let upper = cuboid([0.0, 0.0, 1.0], [1.0, 1.0, 2.0], [2, 2, 1], shape, 2)?;
        let facets = if shape == CellShape::Hexahedron { 4 } else { 8 };
        assert_eq!(joined(&lower, &upper)?.conformity().cracks.len(), facets);
    }
    Ok(())
}

// Coarse cells next to fine ones: an unreported crack, once.
#[test]
fn a_hanging_node_is_an_error_unless_asked_for() -> Checked {
    for (shape, degree) in [(CellShape::Triangle, 1), (CellShape::Quadrilateral, 2)] {
        let left = rectangle([0.0; 2], [1.0; 2], [1, 1], shape, degree)?;
        let right = rectangle([1.0, 0.0], [2.0, 1.0], [1, 2], shape, degree)?;
        let (nodes, blocks) = beside(&left, &right);
        let error = Mesh::from_blocks(degree, nodes.clone(), blocks.clone()).map(|_| ());
        let Err(MeshError::HangingNode { node, position, facet }) = error else { panic!("{error:?}") };
        assert_eq!((position, nodes[node][0]), (vec![1.0, 0.5], 1.0));
        let mesh = Mesh::from_nonconforming_blocks(degree, nodes, blocks)?;
        assert_eq!(mesh.facet_centre(facet), [1.0, 0.5]);
        let found = mesh.conformity();
        assert_eq!((found.cracks.len(), found.hanging_nodes.len(), found.overlaps.len()), (0, 1, 0));
        assert!(found.to_string().starts_with("hanging nodes: 1; the first is node "), "{found}");
        // What is refined touches as before.
        assert!(!mesh.refined()?.conformity().is_conforming());
    }
    Ok(())
}

// The hanging vertex is shared: a corner of the fine cells, and of the coarse one not at all.
#[test]
fn a_hanging_node_that_other_cells_share() {
    let nodes =
        vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [1.0, 0.5], [2.0, 0.0], [2.0, 0.5], [2.0, 1.0]];
    let cells = vec![0, 1, 2, 3, 1, 5, 6, 4, 4, 6, 7, 2];
    let error = Mesh::from_parts(CellShape::Quadrilateral, 1, nodes, cells).map(|_| ());
    assert_eq!(
        error.map_err(|error| error.to_string()),
        Err("node 4 at [1.0, 0.5] lies on facet 1 of cell 0, which does not have it as a vertex: nothing would hold \
             the two sides together there (`Mesh::from_nonconforming_blocks` takes such meshes)"
            .to_owned())
    );
}

#[test]
fn nodes_hang_in_faces_and_on_edges() -> Checked {
    for shape in [CellShape::Tetrahedron, CellShape::Hexahedron] {
        let lower = cuboid([0.0; 3], [1.0; 3], [1; 3], shape, 1)?;
        let upper = cuboid([0.0, 0.0, 1.0], [1.0, 1.0, 2.0], [2, 2, 1], shape, 1)?;
        let (nodes, blocks) = beside(&lower, &upper);
        assert!(matches!(
            Mesh::from_blocks(1, nodes.clone(), blocks.clone()),
            Err(MeshError::HangingNode { .. })
        ));
        let found = Mesh::from_nonconforming_blocks(1, nodes, blocks)?.conformity();
        let mut nodes: Vec<u32> = found.hanging_nodes.iter().map(|hanging| hanging.node).collect();
        nodes.dedup();
        // Four on edges and one inside.
        assert_eq!((nodes.len(), found.overlaps.len()), (5, 0), "{shape:?}");
    }
    Ok(())
}

// A vertex on a circle between two others hangs on the arc, not on its chord.
#[test]
fn nodes_hang_on_curved_facets() -> Checked {
    let inner = annulus(1.0, 2.0, 1, 8, CellShape::Quadrilateral, 2)?;
    let outer = annulus(2.0, 3.0, 1, 16, CellShape::Quadrilateral, 2)?;
    let (nodes, blocks) = beside(&inner, &outer);
    let error = Mesh::from_blocks(2, nodes, blocks).map(|_| ());
    assert!(matches!(error, Err(MeshError::HangingNode { .. })), "{error:?}");
    // The gap between chords and arcs of a circle is no contact.
    let straight = annulus(1.0, 2.0, 1, 8, CellShape::Quadrilateral, 1)?;
    let (nodes, blocks) = beside(&straight, &annulus(2.2, 3.0, 1, 16, CellShape::Quadrilateral, 1)?);
    assert!(Mesh::from_blocks(1, nodes, blocks)?.conformity().is_conforming());
    Ok(())
}

// The same cells on nodes of their own; and cells that share nothing but space.
#[test]
fn overlaps_are_found() -> Checked {
    let square = rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Triangle, 1)?;
    let error = joined(&square, &square).map(|_| ());
    assert!(matches!(error, Err(MeshError::Overlap { .. })), "{error:?}");
    let aside = rectangle([0.31, 0.27], [1.31, 1.27], [2, 2], CellShape::Triangle, 1)?;
    let found = joined(&square, &aside)?.conformity();
    assert!(found.cracks.is_empty() && found.overlaps.len() > 3, "{found}");
    // Each pair has its point in both cells.
    let mesh = joined(&square, &aside)?;
    let locator = Locator::new(&mesh);
    for Overlap { cells, position } in found.overlaps {
        let around: Vec<u32> = locator.cells_around(&position, 0.0).iter().map(|cell| *cell as u32).collect();
        assert!(cells.iter().all(|cell| around.contains(cell)));
    }
    Ok(())
}

// The work grows with the surface, also where facets differ a lot in size.
#[test]
fn thin_and_graded_meshes_are_looked_through() -> Checked {
    let graded = crate::mesh::structured([200, 3], CellShape::Quadrilateral, 1, |[s, t]| {
        [1e6_f64.powf(s), t * 1e6_f64.powf(s)]
    })?;
    assert!(graded.conformity().is_conforming());
    Ok(())
}

// Vertices of one cell are never at one place, nor on its other facets, however thin it is.
#[test]
fn thin_cells_touch_nothing_but_their_neighbours() -> Checked {
    for thickness in [1e-3, 1e-5, 1e-6, 1e-7, 1e-9, 1e-11] {
        for (shape, degree) in
            [(CellShape::Quadrilateral, 1), (CellShape::Triangle, 1), (CellShape::Quadrilateral, 2)]
        {
            for upper in [[1.0, thickness], [thickness, 1.0]] {
                for divisions in [[1, 1], [3, 1], [1, 3], [2, 2]] {
                    let mesh = rectangle([0.0; 2], upper, divisions, shape, degree)?;
                    assert!(mesh.conformity().is_conforming(), "{shape:?} {upper:?} {divisions:?}");
                }
            }
        }
        for (shape, degree) in [(CellShape::Hexahedron, 1), (CellShape::Tetrahedron, 2)] {
            for thin in 0..3 {
                let mut upper = [1.0, 2.0, 1.5];
                upper[thin] = thickness;
                let mesh = cuboid([0.0; 3], upper, [2, 2, 2], shape, degree)?;
                assert!(mesh.conformity().is_conforming(), "{shape:?} {upper:?}");
            }
        }
    }
    Ok(())
}

// Beyond the end of a large facet lies the vertex of one that is smaller than a millionth of it.
#[test]
fn tiny_cells_next_to_large_ones() -> Checked {
    for smallest in [1e-5, 1e-7, 1e-9] {
        let graded = |[s, t]: [f64; 2]| [if s < 0.6 { s } else { 0.5 + smallest * (s - 0.5) }, t];
        for shape in [CellShape::Quadrilateral, CellShape::Triangle] {
            let mesh = crate::mesh::structured([4, 1], shape, 1, graded)?;
            assert!(mesh.conformity().is_conforming(), "{shape:?} {smallest}");
        }
    }
    Ok(())
}

// What touches is found as before, in thin cells, too.
#[test]
fn thin_bodies_touch() -> Checked {
    for thickness in [1e-3, 1e-6, 1e-8] {
        let layer = |from: f64, cells| {
            let (lower, upper) = ([0.0, from * thickness], [1.0, (from + 1.0) * thickness]);
            rectangle(lower, upper, [cells, 1], CellShape::Quadrilateral, 1)
        };
        let conforming = joined(&layer(0.0, 2)?, &layer(1.0, 2)?)?.conformity();
        assert_eq!((conforming.cracks.len(), conforming.hanging_nodes.len()), (2, 0), "{thickness}");
        let (nodes, blocks) = beside(&layer(0.0, 1)?, &layer(1.0, 2)?);
        let hanging = Mesh::from_nonconforming_blocks(1, nodes.clone(), blocks.clone())?.conformity();
        assert_eq!(hanging.hanging_nodes.len(), 1, "{thickness}");
        assert!(matches!(Mesh::from_blocks(1, nodes, blocks), Err(MeshError::HangingNode { .. })));
    }
    Ok(())
}

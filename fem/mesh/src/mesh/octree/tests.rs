//! Meshes refined by trees compared with the first one: balanced, the same set and regions, hanging nodes on their facets, and back again.

use std::collections::{BTreeMap, BTreeSet};

use super::*;
use crate::mesh::measures::{check_nesting, close, measures, volume};
use crate::mesh::random_markings::{Random, markings};
use crate::mesh::{Facet, INTERIOR, annulus, ball, cuboid, onto_sphere, rectangle, structured};

/// Number of divisions of each cell.
fn levels<const D: usize>(mesh: &OctreeMesh<D>) -> Vec<u32> {
    let mut of_divided: Vec<u32> = Vec::new();
    for origin in &mesh.divided.origins {
        of_divided.push(origin.map_or(0, |origin| of_divided[origin.whole as usize] + 1));
    }
    mesh.origins
        .iter()
        .map(|origin| origin.map_or(0, |origin| of_divided[origin.whole as usize] + 1))
        .collect()
}

/// Asserts 2:1 balance. Neighbours: a vertex of one cell is inside an edge of the other, by the positions of nodes,
/// or they have a common edge; for meshes of degree 1 in which equal places are equal bits.
fn check_balance<const D: usize>(mesh: &OctreeMesh<D>) {
    let levels = levels(mesh);
    let bits = |x: [f64; D]| x.map(f64::to_bits);
    let at: BTreeMap<_, u32> =
        mesh.mesh.nodes.iter().enumerate().map(|(n, x)| (bits(*x), n as u32)).collect();
    let mut level_at_edge: BTreeMap<[u32; 2], BTreeSet<u32>> = BTreeMap::new();
    let edges = || {
        (0..mesh.mesh.cell_count()).flat_map(|cell| {
            let vertices = mesh.mesh.cell_vertices(cell);
            mesh.shape().edges().iter().map(move |edge| (cell, edge.map(|v| vertices[v])))
        })
    };
    for (cell, [a, b]) in edges() {
        level_at_edge.entry([a.min(b), a.max(b)]).or_default().insert(levels[cell]);
    }
    for (cell, [a, b]) in edges() {
        // The halves, if the middle is a node, and the quarters.
        let mut waiting = vec![([a, b], levels[cell])];
        while let Some(([a, b], level)) = waiting.pop() {
            for other in level_at_edge.get(&[a.min(b), a.max(b)]).into_iter().flatten() {
                assert!(*other <= levels[cell] + 1, "levels {} and {other} at one edge", levels[cell]);
            }
            let [x, y] = [a, b].map(|node| mesh.mesh.nodes[node as usize]);
            let middle = std::array::from_fn(|k| 0.5 * (x[k] + y[k]));
            if let Some(node) = at.get(&bits(middle)).filter(|_| level < levels[cell] + 3) {
                waiting.extend([([a, *node], level + 1), ([*node, b], level + 1)]);
            }
        }
    }
}

/// Asserts that interior facets fit: the small facets on a large one cover it, and each cell's facets occur once.
fn check_facets<const D: usize>(mesh: &Mesh<D>, first: &Mesh<D>) -> Result<(), MeshError> {
    mesh.check_places()?;
    let mut covered: BTreeMap<Facet, f64> = BTreeMap::new();
    let (mut smalls, mut sides) = (BTreeSet::new(), BTreeSet::new());
    for (small, large, corners) in mesh.facet_parts() {
        let tangent = |k: usize| -> f64 {
            corners[k].iter().zip(&corners[0]).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
        };
        let part = if D == 2 { tangent(1) } else { tangent(1) * tangent(2) };
        *covered.entry(large).or_default() += part;
        assert!(smalls.insert(small));
    }
    assert!(covered.values().all(|sum| *sum == 1.0), "{covered:?}");
    for [a, b] in mesh.interior_facets() {
        for side in [a, b] {
            assert!(sides.insert(*side) || covered.contains_key(side));
        }
    }
    sides.extend(mesh.boundary_facets());
    assert_eq!(sides.len(), mesh.cell_count() * mesh.cell_shape(0).facets());
    // Nothing hangs on exterior facets but, in space, what hangs on interior ones, too.
    let known: BTreeSet<u32> =
        mesh.nodes_hanging_on_parts().into_iter().map(|hanging| hanging.node).collect();
    assert!(mesh.touching().hanging_nodes.iter().all(|hanging| D == 3 && known.contains(&hanging.node)));
    let outer = |mesh: &Mesh<D>| crate::mesh::measures::surface(mesh, "boundary");
    close(outer(mesh)?.1, outer(first)?.1, 1e-12);
    Ok(())
}

/// Asserts that a mesh covers the same domain and regions as the first one.
fn check<const D: usize>(
    mesh: &OctreeMesh<D>,
    first: &Mesh<D>,
    known: &BTreeMap<String, [f64; 2]>,
) -> Result<(), MeshError> {
    check_facets(&mesh.mesh, first)?;
    if first.degree == 1 {
        check_balance(mesh);
    }
    close(volume(&mesh.mesh), volume(first), 1e-12);
    let now = measures(&mesh.mesh)?;
    assert_eq!(now.keys().collect::<Vec<_>>(), known.keys().collect::<Vec<_>>());
    for (name, [area, flux]) in known {
        let curved = first.degree == 2 && first.cell_region(name).is_err();
        close(now[name][0], *area, if curved { 1e-4 } else { 1e-12 });
        close(now[name][1], *flux, 1e-12);
    }
    let mut used = vec![false; mesh.mesh.node_count()];
    mesh.mesh.cells.iter().for_each(|node| used[*node as usize] = true);
    assert!(used.iter().all(|used| *used));
    Ok(())
}

fn named<const D: usize>(mut mesh: Mesh<D>, middle: f64) -> Result<Mesh<D>, MeshError> {
    mesh.name_cells("part", |x| x[0] < middle)?;
    mesh.name_cells("rest", |x| x[0] >= middle)?;
    mesh.name_interface("seam", "rest", "part")?;
    mesh.name_interior_facets("every other", INTERIOR, |x| (7.0 * x[0]).sin() + x[1] > 0.6)?;
    mesh.name_facets("shelf", "top", |x| x[0] > middle)?;
    Ok(mesh)
}

/// Quadrilaterals: squares in degree 1, so that equal places have equal bits; curved ones in degree 2.
fn plane(degree: usize) -> Result<Mesh<2>, MeshError> {
    named(
        match degree {
            1 => rectangle([0.0; 2], [4.0, 2.0], [4, 2], CellShape::Quadrilateral, 1)?,
            _ => structured([3, 2], CellShape::Quadrilateral, degree, |[s, t]| {
                [3.0 * s + 0.3 * (4.0 * t).sin(), 0.7 * t + 0.1 * (7.0 * s).cos() + 0.2 * s * t]
            })?,
        },
        2.0,
    )
}

fn space(degree: usize) -> Result<Mesh<3>, MeshError> {
    let mesh = cuboid([0.0; 3], [4.0, 2.0, 2.0], [2, 1, 2], CellShape::Hexahedron, degree)?;
    let bent = |x: &[f64; 3]| [x[0] + 0.1 * x[1] * x[2], x[1] + 0.05 * x[0] * x[0], x[2]];
    named(
        if degree == 1 { mesh.clone() } else { mesh.with_nodes(mesh.nodes().iter().map(bent).collect())? },
        2.0,
    )
}

fn assert_same<const D: usize>(a: &OctreeMesh<D>, b: &OctreeMesh<D>) {
    assert_eq!(a.mesh.nodes, b.mesh.nodes);
    assert_eq!(a.mesh.cells, b.mesh.cells);
    assert_eq!(a.mesh.parts, b.mesh.parts);
    assert_eq!(a.mesh.cell_regions, b.mesh.cell_regions);
    assert_eq!(a.mesh.facet_regions, b.mesh.facet_regions);
    assert_eq!(a.mesh.interior_regions, b.mesh.interior_regions);
    assert_eq!((&a.origins, &a.divided), (&b.origins, &b.divided));
}

/// Refined and coarsened at random; and now and then coarsened as far as it goes, to the first mesh.
fn there_and_back<const D: usize>(first: &Mesh<D>, [cells, markings]: [usize; 2]) -> Result<(), MeshError> {
    let known = measures(first)?;
    let root = OctreeMesh::new(first.clone())?;
    let mut random = Random(5 + D as u64);
    let mut mesh = root.clone();
    let mut undone = 0;
    for marking in 0..markings {
        let before = mesh.mesh.cell_count();
        let (next, nesting) = if random.below(3) > 0 && before < cells {
            let marked = random.marking(before);
            let (fine, nesting) = mesh.refined(&marked)?;
            assert!(marked.iter().all(|cell| nesting.fine_cells(*cell as usize).len() == 1 << D));
            if marking % 10 == 0 {
                check_nesting(&mesh.mesh, &fine.mesh, &nesting);
            }
            (fine, nesting)
        } else {
            let marked: Vec<u32> = (0..before as u32).filter(|_| random.below(20) > 0).collect();
            let (coarse, nesting) = mesh.coarsened(&marked)?;
            if marking % 10 == 0 {
                check_nesting(&coarse.mesh, &mesh.mesh, &nesting);
            }
            undone += before - coarse.mesh.cell_count();
            (coarse, nesting)
        };
        assert!((0..nesting.fine_cell_count()).all(|cell| nesting.divisions(cell) <= 1));
        mesh = next;
        if first.degree == 1 {
            check_balance(&mesh);
        }
        if marking % 10 == 9 {
            check(&mesh, first, &known)?;
        }
        if marking % 20 == 19 {
            let mut steps = 0;
            while mesh.mesh.cell_count() > first.cell_count() {
                let all: Vec<u32> = (0..mesh.mesh.cell_count() as u32).collect();
                mesh = mesh.coarsened(&all)?.0;
                steps += 1;
                assert!(steps < 100, "coarsening stops at {} cells", mesh.mesh.cell_count());
            }
            assert_same(&mesh, &root);
        }
    }
    assert!(undone > markings, "{undone} cells were undone");
    Ok(())
}

#[test]
fn octree_coarsening_leads_back_to_the_first_mesh() -> Result<(), MeshError> {
    for degree in 1..=2 {
        there_and_back(&plane(degree)?, [200, markings(40_000, 60)])?;
        there_and_back(&space(degree)?, [200, markings(10_000, 20)])?;
    }
    Ok(())
}

/// Towards a corner: few cells in each level.
#[test]
fn octree_refinement_towards_a_corner_stays_there() -> Result<(), MeshError> {
    let mut mesh = OctreeMesh::new(space(1)?)?;
    for _ in 0..25 {
        let at_corner = (0..mesh.mesh.cell_count() as u32).find(|cell| {
            mesh.mesh
                .cell_vertices(*cell as usize)
                .iter()
                .any(|node| mesh.mesh.nodes[*node as usize] == [0.0; 3])
        });
        mesh = mesh.refined(&[at_corner.unwrap_or(0)])?.0;
    }
    // Seven of each level next to the next one, and the roots' neighbours.
    assert!(mesh.mesh.cell_count() < 25 * 7 + 30, "{}", mesh.mesh.cell_count());
    check_balance(&mesh);
    Ok(())
}

/// New nodes move onto circle and sphere, hanging ones once they do not hang any more; and nothing gapes in between.
#[test]
fn octree_nodes_on_the_exact_boundary() -> Result<(), MeshError> {
    for degree in 1..=2 {
        let first = annulus(1.0, 2.0, 1, 7, CellShape::Quadrilateral, degree)?;
        let mut ring = OctreeMesh::new(first.clone())?;
        let (inner, outer) = (onto_sphere([0.0; 2], 1.0), onto_sphere([0.0; 2], 2.0));
        let error = |mesh: &Mesh<2>| (volume(mesh) - 3.0 * std::f64::consts::PI).abs();
        for _ in 0..3 {
            let all: Vec<u32> = (0..ring.mesh.cell_count() as u32).collect();
            ring = ring.refined_onto(&all, &[("inner", &inner), ("outer", &outer)])?.0;
        }
        let gained = error(&first) / error(&ring.mesh);
        assert!(gained > if degree == 1 { 50.0 } else { 3_000.0 }, "{degree}: {gained}");

        let sphere = onto_sphere([0.0; 3], 1.0);
        let on_sphere = |mesh: &Mesh<3>| -> Result<usize, MeshError> {
            let element = mesh.element_of(CellShape::Hexahedron);
            let mut off = BTreeSet::new();
            for facet in mesh.facet_region("sphere")? {
                for node in element.facet_nodes(facet.local.into()) {
                    let node = mesh.cell(facet.cell as usize)[node];
                    let x = mesh.nodes[node as usize];
                    if (x.iter().map(|x| x * x).sum::<f64>().sqrt() - 1.0).abs() > 1e-12 {
                        off.insert(node);
                    }
                }
            }
            Ok(off.len())
        };
        let first = ball(1.0, [false; 3], 1, 1, CellShape::Hexahedron, degree)?;
        let root = OctreeMesh::new(first.clone())?;
        let marked: Vec<u32> =
            first.facet_region("sphere")?.iter().map(|facet| facet.cell).step_by(3).collect();
        let partly = root.refined_onto(&marked, &[("sphere", &sphere)])?.0;
        assert!(on_sphere(&partly.mesh)? > 0 && partly.mesh.facet_parts().count() > 0);
        check_facets(&partly.mesh, &partly.mesh)?;
        // The others, too.
        let large = partly.mesh.facet_region("sphere")?.iter().map(|facet| facet.cell);
        let large: Vec<u32> = large.filter(|cell| partly.origins[*cell as usize].is_none()).collect();
        let wholly = partly.refined_onto(&large, &[("sphere", &sphere)])?.0;
        assert_eq!(on_sphere(&wholly.mesh)?, 0);
        // Some of them back: what hangs goes to the larger facets; and all back.
        let some: Vec<u32> = (0..wholly.mesh.cell_count() as u32 / 2).collect();
        let back = wholly.coarsened(&some)?.0;
        assert!(back.mesh.cell_count() < wholly.mesh.cell_count() && on_sphere(&back.mesh)? > 0);
        check_facets(&back.mesh, &back.mesh)?;
        let all: Vec<u32> = (0..back.mesh.cell_count() as u32).collect();
        assert_same(&back.coarsened(&all)?.0, &root);
    }
    Ok(())
}

#[test]
fn octree_markings_of_nothing_and_of_what_is_not_there() -> Result<(), MeshError> {
    let mesh = OctreeMesh::new(plane(2)?)?;
    let (same, nesting) = mesh.refined(&[])?;
    assert_same(&same, &mesh);
    assert!((0..6).all(|cell| nesting.coarse_cell(cell) == cell && nesting.divisions(cell) == 0));
    // In whatever order, and twice.
    assert_same(&mesh.refined(&[1, 4])?.0, &mesh.refined(&[4, 1, 4])?.0);
    let message = |error: Option<MeshError>| error.map(|error| error.to_string()).unwrap_or_default();
    assert_eq!(
        message(mesh.refined(&[3, 6]).err()),
        "cell 6 is marked, but the mesh has 6 cells (numbered from 0)"
    );
    let triangles = rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Triangle, 1)?;
    assert_eq!(
        message(OctreeMesh::new(triangles).err()),
        "refinement by trees is of quadrilaterals and hexahedra; this mesh has triangles (`BisectedMesh` refines them)"
    );
    let fine = mesh.refined(&[0])?.0;
    assert_eq!(
        message(fine.mesh.refined().err()),
        "uniform refinement is of meshes whose cells share whole facets; facet 1 of cell 1 is a part of facet 3 of cell 4"
    );
    assert!(message(fine.mesh.simplices().err()).starts_with("division into simplices is of meshes"));
    assert!(
        message(OctreeMesh::new(fine.mesh.clone()).err()).starts_with("refinement by trees is of meshes")
    );
    // A hanging node that leaves its facet.
    let (hanging, ..) = fine.mesh.nodes_on_parts()[0];
    let mut nodes = fine.mesh.nodes.clone();
    nodes[hanging as usize][0] += 1e-3;
    assert!(matches!(fine.mesh.with_nodes(nodes), Err(MeshError::NotNested { .. })));
    assert!(!fine.mesh.conformity().is_conforming());
    Ok(())
}

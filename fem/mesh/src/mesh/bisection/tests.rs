//! Bisected meshes compared with the first one: conforming, the same set and regions, bounded angles and shapes.

mod coarsening;
mod shapes;

use std::collections::{BTreeMap, BTreeSet};

use shapes::{least_angle, similarity_class};

use super::*;
use crate::mesh::measures::{check_nesting, close, measures, volume};
use crate::mesh::random_markings::{Random, markings};
use crate::mesh::{annulus, ball, cuboid, onto_sphere, rectangle, structured};

/// Asserts that a mesh is sound and conforming, and covers the same domain and regions as the first one.
fn check<const D: usize>(mesh: &Mesh<D>, first: &BTreeMap<String, [f64; 2]>) -> Result<(), MeshError> {
    mesh.check_conformity()?;
    // The length of what is curved is no integral of a polynomial; volumes and fluxes are.
    let curved = |name: &str| !mesh.is_affine() && mesh.cell_region(name).is_err();
    let now = measures(mesh)?;
    assert_eq!(now.keys().collect::<Vec<_>>(), first.keys().collect::<Vec<_>>());
    for (name, [area, flux]) in first {
        close(now[name][0], *area, if curved(name) { 1e-5 } else { 1e-12 });
        close(now[name][1], *flux, 1e-12);
    }
    let mut used = vec![false; mesh.node_count()];
    mesh.cells.iter().for_each(|node| used[*node as usize] = true);
    assert!(used.iter().all(|used| *used));
    Ok(())
}

/// Triangles of many shapes: none is alike.
fn crooked(degree: usize) -> Result<Mesh<2>, MeshError> {
    let mut mesh = structured([3, 2], CellShape::Triangle, degree, |[s, t]| {
        [3.0 * s + 0.3 * (4.0 * t).sin(), 0.7 * t + 0.1 * (7.0 * s).cos() + 0.2 * s * t]
    })?;
    mesh.name_cells("part", |x| x[0] < 1.0)?;
    mesh.name_cells("rest", |x| x[0] >= 1.0)?;
    mesh.name_interface("seam", "rest", "part")?;
    mesh.name_facets("shelf", "top", |x| x[0] > 1.0)?;
    Ok(mesh)
}

/// Refines at random until there is the given number of cells, and from the first mesh again, as often as there are markings.
fn refine_at_random<const D: usize>(
    first: &Mesh<D>,
    [cells, markings]: [usize; 2],
    mut look: impl FnMut(&BisectedMesh<D>, &[usize]),
) -> Result<(), MeshError> {
    let known = measures(first)?;
    let mut random = Random(first.cell_count() as u64);
    let mut mesh = BisectedMesh::new(first.clone())?;
    let mut ancestors: Vec<usize> = (0..first.cell_count()).collect();
    for marking in 0..markings {
        let marked = random.marking(mesh.mesh.cell_count());
        let (fine, nesting) = mesh.refined(&marked)?;
        for cell in marked {
            assert!(nesting.fine_cells(cell as usize).len() > 1);
        }
        ancestors = (0..fine.mesh.cell_count()).map(|cell| ancestors[nesting.coarse_cell(cell)]).collect();
        fine.mesh.check_conformity()?;
        if marking % 10 == 0 {
            check(&fine.mesh, &known)?;
            check_nesting(&mesh.mesh, &fine.mesh, &nesting);
        }
        look(&fine, &ancestors);
        mesh = fine;
        if mesh.mesh.cell_count() > cells {
            mesh = BisectedMesh::new(first.clone())?;
            ancestors = (0..first.cell_count()).collect();
        }
    }
    Ok(())
}

#[test]
fn random_markings_of_triangles() -> Result<(), MeshError> {
    for degree in 1..=2 {
        let first = crooked(degree)?;
        let least: Vec<f64> = (0..first.cell_count()).map(|cell| least_angle(&first, cell)).collect();
        refine_at_random(&first, [300, markings(25_000, 100)], |fine, ancestors| {
            // Of straight triangles: curved ones are bisected on their reference cell.
            for (cell, ancestor) in ancestors.iter().enumerate().filter(|_| degree == 1) {
                assert!(least_angle(&fine.mesh, cell) >= 0.5 * least[*ancestor] * (1.0 - 1e-9));
            }
        })?;
    }
    Ok(())
}

/// A box of tetrahedra, most of them of different shapes, on nodes with coordinates of few binary digits.
fn crooked_box(degree: usize) -> Result<Mesh<3>, MeshError> {
    let mut mesh = cuboid([0.0; 3], [64.0, 32.0, 32.0], [2, 1, 1], CellShape::Tetrahedron, degree)?;
    let mut random = Random(11);
    if degree == 1 {
        let shift = |x: &[f64; 3]| x.map(|x| x + random.below(9) as f64 - 4.0);
        mesh = mesh.with_nodes(mesh.nodes().iter().map(shift).collect())?;
    }
    mesh.name_cells("part", |x| x[0] < 32.0)?;
    mesh.name_cells("rest", |x| x[0] >= 32.0)?;
    mesh.name_interface("seam", "part", "rest")?;
    Ok(mesh)
}

#[test]
fn random_markings_of_tetrahedra() -> Result<(), MeshError> {
    for degree in 1..=2 {
        let first = crooked_box(degree)?;
        let mut classes: BTreeSet<(usize, Vec<u64>)> = BTreeSet::new();
        refine_at_random(&first, [400, markings(10_000, 50)], |fine, ancestors| {
            for (cell, ancestor) in ancestors.iter().enumerate().filter(|_| degree == 1) {
                let vertices = fine.mesh.cell_vertices(cell);
                let x = std::array::from_fn(|k| fine.mesh.nodes[vertices[k] as usize]);
                classes.insert((*ancestor, similarity_class(&x)));
            }
        })?;
        for ancestor in 0..first.cell_count() {
            let count = classes.iter().filter(|(of, _)| *of == ancestor).count();
            assert!(count <= 73, "{count} classes of the descendants of cell {ancestor}");
        }
    }
    Ok(())
}

/// Towards a corner, as adaptive refinement does it: cells as small as 2^-40 of the first, and few of them.
#[test]
fn refinement_towards_a_corner_stays_there() -> Result<(), MeshError> {
    let mut mesh = BisectedMesh::new(crooked(1)?)?;
    let corner = mesh.mesh.nodes[0];
    for _ in 0..80 {
        let at_corner = |cell: &u32| {
            let vertices = mesh.mesh.cell_vertices(*cell as usize);
            vertices.iter().any(|node| mesh.mesh.nodes[*node as usize] == corner)
        };
        let marked: Vec<u32> = (0..mesh.mesh.cell_count() as u32).filter(at_corner).collect();
        mesh = mesh.refined(&marked)?.0;
    }
    let smallest = (0..mesh.mesh.cell_count()).map(|cell| mesh.mesh.diameter(cell)).fold(1.0, f64::min);
    assert!(smallest < 1e-11, "{smallest:e}");
    assert!(mesh.mesh.cell_count() < 1_000, "{}", mesh.mesh.cell_count());
    mesh.mesh.check_conformity()
}

/// New nodes of a ring and a ball are on circle and sphere, those that were there stay.
#[test]
fn new_nodes_on_the_exact_boundary() -> Result<(), MeshError> {
    for degree in 1..=2 {
        let first = annulus(1.0, 2.0, 1, 7, CellShape::Triangle, degree)?;
        let mut ring = BisectedMesh::new(first.clone())?;
        let (inner, outer) = (onto_sphere([0.0; 2], 1.0), onto_sphere([0.0; 2], 2.0));
        let error = |mesh: &Mesh<2>| (volume(mesh) - 3.0 * std::f64::consts::PI).abs();
        for _ in 0..6 {
            let all: Vec<u32> = (0..ring.mesh.cell_count() as u32).collect();
            ring = ring.refined_onto(&all, &[("inner", &inner), ("outer", &outer)])?.0;
        }
        assert_eq!(ring.mesh.nodes[..first.node_count()], first.nodes);
        // Three halvings of the edges: chords of order 2, parabolas of order 4.
        let gained = error(&first) / error(&ring.mesh);
        assert!(gained > if degree == 1 { 50.0 } else { 3_000.0 }, "{degree}: {gained}");
        for (name, radius) in [("inner", 1.0), ("outer", 2.0)] {
            let element = ring.mesh.element_of(CellShape::Triangle);
            for facet in ring.mesh.facet_region(name)? {
                for node in element.facet_nodes(facet.local.into()) {
                    let [x, y] = ring.mesh.nodes[ring.mesh.cell(facet.cell as usize)[node] as usize];
                    close(x.hypot(y), radius, 1e-14);
                }
            }
        }
        let sphere = ball(1.0, [false; 3], 1, 1, CellShape::Tetrahedron, degree)?;
        let onto = onto_sphere([0.0; 3], 1.0);
        let marked: Vec<u32> = sphere.facet_region("sphere")?.iter().map(|facet| facet.cell).collect();
        let (fine, _) = BisectedMesh::new(sphere)?.refined_onto(&marked, &[("sphere", &onto)])?;
        let element = fine.mesh.element_of(CellShape::Tetrahedron);
        for facet in fine.mesh.facet_region("sphere")? {
            for node in element.facet_nodes(facet.local.into()) {
                let x = fine.mesh.nodes[fine.mesh.cell(facet.cell as usize)[node] as usize];
                close(x.iter().map(|x| x * x).sum::<f64>().sqrt(), 1.0, 1e-12);
            }
        }
        fine.mesh.check_conformity()?;
    }
    Ok(())
}

#[test]
fn markings_of_nothing_and_of_what_is_not_there() -> Result<(), MeshError> {
    let mesh = BisectedMesh::new(crooked(2)?)?;
    let (same, nesting) = mesh.refined(&[])?;
    assert_eq!((same.mesh.nodes(), same.mesh.cells()), (mesh.mesh.nodes(), mesh.mesh.cells()));
    assert_eq!(same.marks, mesh.marks);
    assert!((0..12).all(|cell| nesting.coarse_cell(cell) == cell && nesting.divisions(cell) == 0));
    // In whatever order, and twice.
    let sorted = mesh.refined(&[2, 5, 7])?.0;
    let given = mesh.refined(&[7, 2, 7, 5])?.0;
    assert_eq!((sorted.mesh.nodes(), sorted.mesh.cells()), (given.mesh.nodes(), given.mesh.cells()));
    let message = |error: Option<MeshError>| error.map(|error| error.to_string()).unwrap_or_default();
    assert_eq!(
        message(mesh.refined(&[3, 12]).err()),
        "cell 12 is marked, but the mesh has 12 cells (numbered from 0)"
    );
    let squares = rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Quadrilateral, 1)?;
    assert_eq!(
        message(BisectedMesh::new(squares).err()),
        "bisection is of triangles and tetrahedra; this mesh has quadrilaterals (`Mesh::simplices` divides them)"
    );
    let far = onto_sphere([0.0; 2], 1e300);
    let boundary: Vec<u32> = (0..12).collect();
    let (fine, _) = mesh.refined(&boundary)?;
    let at_boundary: Vec<u32> = fine.mesh.boundary_facets().iter().map(|facet| facet.cell).collect();
    let outside = fine.refined_onto(&at_boundary, &[("boundary", &far)]).err();
    assert!(matches!(outside, Some(MeshError::Inverted { .. } | MeshError::NotFinite { .. })), "{outside:?}");
    assert!(matches!(mesh.refined_onto(&[0], &[("lid", &far)]), Err(MeshError::UnknownRegion { .. })));
    Ok(())
}

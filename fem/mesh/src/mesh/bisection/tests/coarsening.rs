//! Refinement and coarsening in turn, and back to the first mesh.

use super::*;

/// Asserts that two meshes are equal to the last bit: nodes, cells, regions, and the data of bisections.
fn assert_same<const D: usize>(a: &BisectedMesh<D>, b: &BisectedMesh<D>) {
    assert_eq!(a.mesh.nodes, b.mesh.nodes);
    assert_eq!(a.mesh.cells, b.mesh.cells);
    assert_eq!(a.mesh.cell_regions, b.mesh.cell_regions);
    assert_eq!(a.mesh.facet_regions, b.mesh.facet_regions);
    assert_eq!(a.mesh.interior_regions, b.mesh.interior_regions);
    assert_eq!((&a.marks, &a.origins, &a.bisections), (&b.marks, &b.origins, &b.bisections));
}

/// Refined and coarsened at random; and in the end coarsened as far as it goes, to the first mesh.
fn there_and_back<const D: usize>(first: &Mesh<D>, [cells, markings]: [usize; 2]) -> Result<(), MeshError> {
    let known = measures(first)?;
    let first = BisectedMesh::new(first.clone())?;
    let mut random = Random(5);
    let mut mesh = first.clone();
    let mut undone = 0;
    for marking in 0..markings {
        let before = mesh.mesh.cell_count();
        if random.below(3) > 0 && before < cells {
            mesh = mesh.refined(&random.marking(before))?.0;
        } else {
            let marked: Vec<u32> = (0..before as u32).filter(|_| random.below(8) > 0).collect();
            let (coarse, nesting) = mesh.coarsened(&marked)?;
            check_nesting(&coarse.mesh, &mesh.mesh, &nesting);
            for cell in (0..before).filter(|cell| marked.binary_search(&(*cell as u32)).is_err()) {
                assert_eq!(nesting.divisions(cell), 0);
            }
            undone += before - coarse.mesh.cell_count();
            mesh = coarse;
        }
        mesh.mesh.check_conformity()?;
        if marking % 20 == 19 {
            check(&mesh.mesh, &known)?;
            let mut steps = 0;
            while mesh.mesh.cell_count() > first.mesh.cell_count() {
                let all: Vec<u32> = (0..mesh.mesh.cell_count() as u32).collect();
                mesh = mesh.coarsened(&all)?.0;
                mesh.mesh.check_conformity()?;
                steps += 1;
                assert!(steps < 200, "coarsening stops at {} cells", mesh.mesh.cell_count());
            }
            assert_same(&mesh, &first);
        }
    }
    assert!(undone > markings, "{undone} bisections were undone");
    Ok(())
}

#[test]
fn coarsening_leads_back_to_the_first_mesh() -> Result<(), MeshError> {
    for degree in 1..=2 {
        there_and_back(&crooked(degree)?, [200, markings(10_000, 60)])?;
        there_and_back(&crooked_box(degree)?, [300, markings(5_000, 20)])?;
    }
    Ok(())
}

/// One step of coarsening undoes what one step of refinement did, where it bisected each cell once.
#[test]
fn one_refinement_undone() -> Result<(), MeshError> {
    let mut mesh = BisectedMesh::new(rectangle([0.0; 2], [1.0; 2], [3, 3], CellShape::Triangle, 2)?)?;
    for _ in 0..4 {
        let all: Vec<u32> = (0..mesh.mesh.cell_count() as u32).collect();
        let fine = mesh.refined(&all)?.0;
        let all: Vec<u32> = (0..fine.mesh.cell_count() as u32).collect();
        assert_same(&fine.coarsened(&all)?.0, &mesh);
        // One of two parts, or of four cells at a vertex, is not enough.
        let half: Vec<u32> = all.iter().copied().filter(|cell| cell % 2 == 0).collect();
        assert_same(&fine.coarsened(&half)?.0, &fine);
        assert_same(&fine.coarsened(&[])?.0, &fine);
        mesh = fine;
    }
    let count = mesh.mesh.cell_count();
    let error = mesh.coarsened(&[count as u32]).err();
    assert_eq!(error, Some(MeshError::MarkedCell { cell: count as u32, count }));
    Ok(())
}

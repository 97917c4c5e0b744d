//! Queries and errors of meshes of two shapes.

use forms_fem::mesh::{INTERIOR, MeshError, onto_sphere};
use forms_fem::prelude::*;

use super::{cells, nodes, patchwork, with_names};

#[forms(dimension = 2)]
mod measures {
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Gamma;
    #[interior_facets]
    pub struct Skeleton;

    pub fn area() -> Functional {
        integral(Omega, 1)
    }
    pub fn length() -> Functional {
        integral(Gamma, 1)
    }
    pub fn inner_length() -> Functional {
        integral(Skeleton, 1)
    }
    /// Of both sides, weighted with what tells them apart.
    pub fn sizes() -> Functional {
        integral(Skeleton, this(h) + 10 * other(h) + 100 * this(cell_volume) + 1000 * other(cell_volume))
    }
    /// ∫ n = 0 around every body, and ∫ x · n is twice the area.
    pub fn flux() -> Functional {
        integral(Gamma, dot(x, n))
    }
}

fn close(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-13 * (1.0 + expected.abs()), "{found} instead of {expected}");
}

// On curved cells the estimated degree is not that of the Jacobian.
fn assembler(mesh: &Mesh<2>) -> Assembler<2> {
    Assembler::new(mesh).with_quadrature(Quadrature::Degree(8))
}

fn area(mesh: &Mesh<2>, region: &str) -> f64 {
    assembler(mesh).functional(&measures::area(&measures::Omega::on(region))).unwrap()
}

fn length(mesh: &Mesh<2>, region: &str) -> f64 {
    assembler(mesh).functional(&measures::length(&measures::Gamma::on(region))).unwrap()
}

#[test]
fn areas_and_lengths() {
    for degree in 1..=2 {
        let mesh = patchwork(6, degree);
        assert_eq!(mesh.shapes(), [CellShape::Quadrilateral, CellShape::Triangle]);
        assert_eq!((mesh.blocks()[0].cells.clone(), mesh.blocks()[1].cells.clone()), (0..24, 24..48));
        close(area(&mesh, "all"), 1.0);
        close(area(&mesh, "squares") + area(&mesh, "triangles"), 1.0);
        close(length(&mesh, "boundary"), 4.0);
        close(["left", "right", "bottom", "top"].map(|side| length(&mesh, side)).iter().sum(), 4.0);
        let flux = measures::flux(&measures::Gamma::on("boundary"));
        close(assembler(&mesh).functional(&flux).unwrap(), 2.0);
        let exterior = mesh.boundary_facets().len();
        assert_eq!((exterior, 2 * mesh.interior_facets().len()), (24, 24 * 4 + 24 * 3 - exterior));
        // Areas of the polygons, by their vertices.
        if degree == 1 {
            let of_cell = |&cell: &u32| {
                let corners: Vec<[f64; 2]> =
                    mesh.cell(cell as usize).iter().map(|&node| mesh.nodes()[node as usize]).collect();
                let next = corners.iter().cycle().skip(1);
                corners.iter().zip(next).map(|(a, b)| 0.5 * (a[0] * b[1] - a[1] * b[0])).sum::<f64>()
            };
            for region in ["squares", "triangles", "every other"] {
                let polygons: f64 = mesh.cell_region(region).unwrap().iter().map(of_cell).sum();
                close(area(&mesh, region), polygons);
            }
            let ends = |sides: &[Facet; 2]| {
                let cell = mesh.cell(sides[0].cell as usize);
                let count = cell.len();
                let local = usize::from(sides[0].local);
                [cell[local], cell[(local + 1) % count]].map(|node| mesh.nodes()[node as usize])
            };
            let distance = |[a, b]: [[f64; 2]; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
            for region in [INTERIOR, "seam"] {
                let sum = mesh.interior_facet_region(region).unwrap().iter().map(ends).map(distance).sum();
                let form = measures::inner_length(&measures::Skeleton::on(region));
                close(assembler(&mesh).functional(&form).unwrap(), sum);
            }
        }
    }
}

#[test]
fn sizes_are_those_of_each_side() {
    // A square of width 1 and a triangle of height 2 at its right.
    let nodes = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [3.0, 0.0]];
    let blocks = |first: usize| {
        let mut blocks =
            vec![(CellShape::Quadrilateral, vec![0, 1, 2, 3]), (CellShape::Triangle, vec![4, 2, 1])];
        blocks.rotate_left(first);
        blocks
    };
    let (narrow, wide) = (2.0_f64.sqrt(), 5.0_f64.sqrt());
    for (first, expected) in
        [(0, narrow + 10.0 * wide + 100.0 + 1000.0), (1, wide + 10.0 * narrow + 100.0 + 1000.0)]
    {
        let mesh = Mesh::from_blocks(1, nodes.clone(), blocks(first)).unwrap();
        let form = measures::sizes(&measures::Skeleton::on(INTERIOR));
        close(assembler(&mesh).functional(&form).unwrap(), expected);
    }
}

#[test]
fn the_order_of_blocks_is_the_users() {
    let (points, [squares, triangles]) = (nodes(4, 1), cells(4, 1));
    // Triangles before and after the quadrilaterals, and a block of none.
    let (before, after) = triangles.split_at(6);
    let blocks = vec![
        (CellShape::Triangle, before.to_vec()),
        (CellShape::Quadrilateral, vec![]),
        (CellShape::Quadrilateral, squares.clone()),
        (CellShape::Triangle, after.to_vec()),
    ];
    let mesh = with_names(Mesh::from_blocks(1, points.clone(), blocks).unwrap()).unwrap();
    assert_eq!(mesh.blocks().len(), 3);
    assert_eq!(mesh.shapes(), [CellShape::Triangle, CellShape::Quadrilateral]);
    assert_eq!(
        (mesh.cell(0), mesh.cell(2), mesh.cell(mesh.cell_count() - 1)),
        (&before[..3], &squares[..4], &after[after.len() - 3..])
    );
    close(area(&mesh, "all"), 1.0);
    // Blocks of one shape that follow each other are one: the mesh is that of one shape.
    let (first, rest) = squares.split_at(8);
    let parts = vec![(CellShape::Quadrilateral, first.to_vec()), (CellShape::Quadrilateral, rest.to_vec())];
    let joined = Mesh::from_blocks(1, points.clone(), parts).unwrap();
    let whole = Mesh::from_parts(CellShape::Quadrilateral, 1, points, squares).unwrap();
    assert_eq!((joined.blocks(), joined.cells()), (whole.blocks(), whole.cells()));
    assert_eq!(whole.one_shape("this test").unwrap(), CellShape::Quadrilateral);
}

#[test]
fn wrong_blocks_are_named() {
    let (points, [squares, triangles]) = (nodes(3, 1), cells(3, 1));
    let error = |squares: &[u32], triangles: &[u32]| {
        let blocks =
            vec![(CellShape::Quadrilateral, squares.to_vec()), (CellShape::Triangle, triangles.to_vec())];
        Mesh::<2>::from_blocks(1, points.clone(), blocks).map(|_| ()).unwrap_err()
    };
    let count = squares.len() / 4;
    assert_eq!(error(&[], &[]), MeshError::Empty);
    assert_eq!(
        error(&squares[1..], &triangles),
        MeshError::CellLength { length: squares.len() - 1, per_cell: 4 }
    );
    assert_eq!(
        error(&squares, &triangles[1..]),
        MeshError::CellLength { length: triangles.len() - 1, per_cell: 3 }
    );
    let with = |place: usize, node: u32| {
        let mut changed = triangles.clone();
        changed[place] = node;
        error(&squares, &changed)
    };
    assert_eq!(with(4, 99), MeshError::NodeRange { cell: count + 1, node: 99, count: 16 });
    assert_eq!(with(4, triangles[3]), MeshError::RepeatedNode { cell: count + 1, node: triangles[3] });
    let mut mirrored = triangles.clone();
    mirrored.swap(3, 4);
    assert!(matches!(error(&squares, &mirrored), MeshError::Inverted { cell, .. } if cell == count + 1));
    // A square over two triangles.
    let mut more = squares.clone();
    more.extend([0, 1, 5, 4]);
    assert!(
        matches!(error(&more, &triangles), MeshError::SharedFacet { vertices, .. } if vertices.len() == 2)
    );
    let mixed = Mesh::from_blocks(
        1,
        points.clone(),
        vec![(CellShape::Quadrilateral, squares), (CellShape::Triangle, triangles)],
    );
    assert_eq!(
        mixed.unwrap().one_shape("a grid").unwrap_err().to_string(),
        "a grid needs a mesh of one shape; this one has quadrilaterals and triangles"
    );
}

#[test]
fn shapes_in_space_do_not_mix() {
    let cube = cuboid([0.0; 3], [1.0; 3], [1; 3], CellShape::Hexahedron, 1).unwrap();
    let mut nodes = cube.nodes().to_vec();
    nodes.push([2.0, 0.5, 0.5]);
    let blocks = |second| vec![(CellShape::Hexahedron, cube.cells().to_vec()), second];
    let error =
        Mesh::from_blocks(1, nodes.clone(), blocks((CellShape::Tetrahedron, vec![1, 2, 5, 8]))).unwrap_err();
    assert_eq!(
        error.to_string(),
        "hexahedra and tetrahedra do not make one mesh: only triangles and quadrilaterals do"
    );
    let error = Mesh::from_blocks(1, nodes, blocks((CellShape::Triangle, vec![1, 2, 5]))).unwrap_err();
    assert_eq!(error, MeshError::Dimension { shape: CellShape::Triangle, dimension: 3 });
}

#[test]
fn cells_divide_and_regions_follow() {
    for degree in 1..=2 {
        let coarse = patchwork(3, degree);
        let (fine, simplices) = (coarse.refined().unwrap(), coarse.simplices().unwrap());
        assert_eq!((fine.shapes(), fine.cell_count()), (coarse.shapes(), 4 * coarse.cell_count()));
        let count = |shape| (0..coarse.cell_count()).filter(|cell| coarse.cell_shape(*cell) == shape).count();
        let expected = 2 * count(CellShape::Quadrilateral) + count(CellShape::Triangle);
        assert_eq!((simplices.shapes(), simplices.cell_count()), (vec![CellShape::Triangle], expected));
        for mesh in [&fine, &simplices] {
            close(area(mesh, "all"), 1.0);
            close(length(mesh, "top"), 1.0);
            let sides = |mesh: &Mesh<2>| mesh.interior_facet_region("seam").unwrap().len();
            assert_eq!(sides(mesh), sides(&coarse) * if mesh.is_same(&fine) { 2 } else { 1 });
            for region in ["squares", "triangles", "every other"] {
                // The parts of a curved square are bounded by other parabolas inside.
                let tolerance = if degree == 2 && mesh.is_same(&simplices) { 0.05 } else { 1e-12 };
                assert!((area(mesh, region) - area(&coarse, region)).abs() < tolerance, "{region}");
            }
        }
        let centre = [0.5, 0.5];
        let round = coarse.refined_onto(&[("seam", &onto_sphere(centre, 0.4))]);
        assert!(matches!(round, Ok(_) | Err(MeshError::Inverted { .. })));
    }
}

#[test]
fn the_walk_goes_through_both_shapes() {
    let mesh = patchwork(16, 1);
    let order = mesh.cell_order().cells();
    let mut sorted = order.to_vec();
    sorted.sort_unstable();
    assert!(sorted.into_iter().eq(0..mesh.cell_count() as u32));
    // Neighbours on the curve are near, whatever their shapes.
    let far = order.windows(2).filter(|pair| {
        let [a, b] = [pair[0], pair[1]].map(|cell| mesh.cell_centre(cell as usize));
        (a[0] - b[0]).hypot(a[1] - b[1]) > 3.0 / 16.0
    });
    assert!(far.count() < mesh.cell_count() / 20);
}

#[test]
fn quality_of_each_shape() {
    let height = 0.75_f64.sqrt();
    let nodes = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.5, 1.0 + height]];
    let blocks = vec![(CellShape::Quadrilateral, vec![0, 1, 2, 3]), (CellShape::Triangle, vec![3, 2, 4])];
    let quality = Mesh::from_blocks(1, nodes, blocks).unwrap().quality();
    for cell in &quality.cells {
        close(cell.scaled_jacobian, 1.0);
        close(cell.aspect_ratio, 1.0);
    }
    let table = quality.to_string();
    assert!(table.starts_with("2 cells, quadrilateral and triangle of degree 1, 0 inverted\n"), "{table}");
    let rough = patchwork(6, 1).quality();
    assert!(rough.inverted() == 0 && rough.scaled_jacobian()[0] > 0.2 && rough.scaled_jacobian()[0] < 0.9);
}

//! Known cells, and the report.

use super::*;
use crate::mesh::{annulus, cuboid, rectangle};

fn one<const D: usize>(shape: CellShape, nodes: Vec<[f64; D]>) -> CellQuality<D> {
    let cells = (0..nodes.len() as u32).collect();
    Mesh::from_parts(shape, 1, nodes, cells).expect("the cell is not inverted").quality().cells[0]
}

fn near(a: f64, b: f64) {
    assert!((a - b).abs() <= 1e-14 * b.abs(), "{a} is not {b}");
}

#[test]
fn ideal_and_stretched_cells() {
    let third = 3.0_f64.sqrt() / 2.0;
    let regular = one(CellShape::Triangle, vec![[0.0, 0.0], [1.0, 0.0], [0.5, third]]);
    near(regular.scaled_jacobian, 1.0);
    near(regular.aspect_ratio, 1.0);
    near(regular.determinant, third);
    // Half a square: the best two edges are those at the right angle, but the longest two count.
    let half = one(CellShape::Triangle, vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
    near(half.scaled_jacobian, 2.0 / 3.0_f64.sqrt() / 2.0_f64.sqrt());
    near(half.aspect_ratio, 3.0_f64.sqrt());
    let tall = one(CellShape::Triangle, vec![[0.0, 0.0], [1.0, 0.0], [0.5, 7.0 * third]]);
    near(tall.aspect_ratio, 7.0);

    let height = (2.0_f64 / 3.0).sqrt();
    let tetrahedron = |height: f64| {
        let nodes = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.5, third, 0.0], [0.5, third / 3.0, height]];
        one(CellShape::Tetrahedron, nodes)
    };
    near(tetrahedron(height).scaled_jacobian, 1.0);
    assert!((tetrahedron(height).aspect_ratio - 1.0).abs() < 1e-7);
    // The cosine formula is accurate to the root of round-off where two axes are equal.
    assert!((tetrahedron(5.0 * height).aspect_ratio - 5.0).abs() < 1e-7);
    assert!((tetrahedron(0.2 * height).aspect_ratio - 5.0).abs() < 1e-7);

    let brick = cuboid([0.0; 3], [1.0, 2.0, 6.0], [1; 3], CellShape::Hexahedron, 2).expect("a box");
    let brick = brick.quality().cells[0];
    near(brick.scaled_jacobian, 1.0);
    assert!((brick.aspect_ratio - 6.0).abs() < 1e-13);
    near(brick.determinant, 12.0);
    // A right angle sheared by 45 degrees.
    let sheared = one(CellShape::Quadrilateral, vec![[0.0, 0.0], [1.0, 0.0], [2.0, 1.0], [1.0, 1.0]]);
    near(sheared.scaled_jacobian, 0.5_f64.sqrt());
    // The golden ratio squared.
    near(sheared.aspect_ratio, (3.0 + 5.0_f64.sqrt()) / 2.0);
}

#[test]
fn measures_do_not_depend_on_size_and_place() -> Result<(), MeshError> {
    let mesh = annulus(1.0, 1.5, 2, 12, CellShape::Triangle, 2)?;
    let moved: Vec<[f64; 2]> = mesh.nodes().iter().map(|x| [1e-3 * x[1] + 7.0, -1e-3 * x[0] - 2.0]).collect();
    let (first, second) = (mesh.quality(), mesh.quality_at(&moved)?);
    for (a, b) in first.cells.iter().zip(&second.cells) {
        // Cells of size 1e-4 at a distance of 7: their edges have 11 digits.
        assert!((a.scaled_jacobian - b.scaled_jacobian).abs() < 1e-10);
        assert!((a.aspect_ratio - b.aspect_ratio).abs() < 1e-10);
        assert!((1e-6 * a.determinant - b.determinant).abs() < 1e-16);
    }
    Ok(())
}

#[test]
fn inverted_cells_are_counted_and_the_worst_is_named() -> Result<(), MeshError> {
    let mesh = rectangle([0.0; 2], [2.0, 1.0], [2, 1], CellShape::Quadrilateral, 1)?;
    let mut moved = mesh.nodes().to_vec();
    // The corner of cell 1 goes past the diagonal of the others.
    moved[5] = [1.25, 0.25];
    let quality = mesh.quality_at(&moved)?;
    assert_eq!((quality.inverted(), quality.worst_cell()), (1, 1));
    near(quality.smallest_determinant(), -0.5);
    assert!(quality.scaled_jacobian()[0] < 0.0);
    assert_eq!(quality.cells[1].position, [1.25, 0.25]);
    moved[5][0] = f64::NAN;
    let quality = mesh.quality_at(&moved)?;
    assert_eq!((quality.inverted(), quality.worst_cell()), (1, 1));
    assert!(quality.scaled_jacobian()[0].is_nan() && quality.cells[1].aspect_ratio.is_infinite());
    let error = mesh.quality_at(&moved[..5]).map(|_| ());
    assert_eq!(
        error.map_err(|error| error.to_string()),
        Err("5 positions were given, but the mesh has 6 nodes".into())
    );
    Ok(())
}

// y = η ((ξ − s)² − c): the determinant is negative near ξ = s alone, where no sample is.
#[test]
fn a_fold_between_samples_is_counted() -> Result<(), MeshError> {
    let mesh = rectangle([0.0; 2], [1.0; 2], [1, 1], CellShape::Quadrilateral, 2)?;
    let folded: Vec<[f64; 2]> =
        mesh.nodes().iter().map(|x| [x[0], x[1] * ((x[0] - 0.36).powi(2) - 1e-4)]).collect();
    let quality = mesh.quality_at(&folded)?;
    assert_eq!(quality.inverted(), 1);
    assert!(quality.cells[0].determinant < 0.0 && quality.cells[0].scaled_jacobian < 0.0);
    assert!((quality.cells[0].position[0] - 0.36).abs() < 0.02);
    let error = mesh.with_nodes(folded).map(|_| ());
    assert!(matches!(error, Err(MeshError::Inverted { cell: 0, .. })), "{error:?}");
    Ok(())
}

#[test]
fn the_report_is_a_table() -> Result<(), MeshError> {
    let mesh = rectangle([0.0; 2], [8.0, 1.0], [4, 1], CellShape::Quadrilateral, 1)?;
    let mut moved = mesh.nodes().to_vec();
    moved[9] = [7.0, 1.0];
    let expected = "\
4 cells, quadrilateral of degree 1, 0 inverted
                         least        mean     largest
scaled Jacobian         0.7071      0.9268      1.0000
aspect ratio            2.0000      2.1545      2.6180
det J                 1.0000e0
worst cell 3 near (8.0000, 0.0000)
  0.7 to 0.8           1  ##########
  0.9 to 1.0           3  ##############################
";
    assert_eq!(mesh.quality_at(&moved)?.to_string(), expected);
    assert_eq!(mesh.quality().aspect_ratio_histogram(), [0, 0, 4, 0, 0, 0, 0, 0]);
    Ok(())
}

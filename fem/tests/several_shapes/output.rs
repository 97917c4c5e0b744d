//! Files and pictures of two shapes.

use forms_fem::output::VtuFile;
use forms_fem::output::picture::{FieldMap, MeshDrawing, Picture, Shown};
use forms_fem::prelude::*;
use vtkio::Vtk;
use vtkio::model::{Attribute, CellType, DataSet, UnstructuredGridPiece};

use super::patchwork;

/// A path of this process alone, whose file vanishes.
struct Temporary(std::path::PathBuf);

impl Temporary {
    fn new(name: &str) -> Self {
        Temporary(std::env::temp_dir().join(format!("forms-fem-{}-{name}", std::process::id())))
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

fn written(file: &VtuFile<'_, 2>) -> UnstructuredGridPiece {
    let path = Temporary::new("several-shapes.vtu");
    file.write(&path.0).unwrap();
    let DataSet::UnstructuredGrid { mut pieces, .. } = Vtk::import(&path.0).unwrap().data else {
        panic!("an unstructured grid")
    };
    pieces.remove(0).into_loaded_piece_data(None).unwrap()
}

fn values(attribute: &Attribute) -> Vec<f64> {
    let Attribute::DataArray(array) = attribute else { panic!("{attribute:?}") };
    array.data.cast_into().unwrap()
}

#[test]
fn cells_of_a_vtu_file_have_their_own_types() {
    for (geometry, types) in [
        (1, [CellType::Quad, CellType::Triangle]),
        (2, [CellType::BiquadraticQuad, CellType::QuadraticTriangle]),
    ] {
        let mesh = patchwork(6, geometry);
        let linear = |x: &[f64; 2]| 2.0 * x[0] - x[1];
        let u = Field::interpolate(&Space::scalar(&mesh, 3).unwrap(), linear).unwrap();
        let broken = Field::interpolate(&Space::discontinuous_scalar(&mesh, 2).unwrap(), linear).unwrap();
        let numbers: Vec<f64> = (0..mesh.cell_count()).map(|cell| cell as f64).collect();
        let shared =
            VtuFile::new(&mesh).point_data("u", &u).unwrap().cell_data("number", 1, &numbers).unwrap();
        let separate = shared.clone().point_data("broken", &broken).unwrap();
        for (file, arrays) in [(shared, 1), (separate, 2)] {
            let grid = written(&file);
            assert_eq!(grid.cells.types, [vec![types[0]; 24], vec![types[1]; 24]].concat());
            assert_eq!(values(&grid.data.cell[0]), numbers);
            let positions: Vec<f64> = grid.points.cast_into().unwrap();
            let (connectivity, offsets) = grid.cells.cell_verts.into_xml();
            let mut start = 0;
            for (cell, &end) in offsets.iter().enumerate() {
                let found = &connectivity[start..end as usize];
                start = end as usize;
                let nodes = mesh.cell(cell);
                assert_eq!(found.len(), nodes.len());
                for (&point, &node) in found.iter().zip(nodes) {
                    assert_eq!(positions[3 * point as usize..][..2], mesh.nodes()[node as usize]);
                }
            }
            assert_eq!((start, grid.data.point.len()), (connectivity.len(), arrays));
            for array in &grid.data.point {
                for (value, x) in values(array).iter().zip(positions.chunks(3)) {
                    assert!((value - linear(&[x[0], x[1]])).abs() < 1e-13);
                }
            }
        }
    }
}

#[test]
fn pictures_show_both_shapes() {
    let mesh = patchwork(6, 2);
    let u = Field::interpolate(&Space::scalar(&mesh, 3).unwrap(), |x| (3.0 * x[0]).sin() * x[1]).unwrap();
    let displacement =
        Field::interpolate(&Space::vector(&mesh, 2).unwrap(), |x| [0.2 * x[1] * x[1], 0.0]).unwrap();
    let (of_field, of_mesh) =
        (Temporary::new("several-shapes-field.png"), Temporary::new("several-shapes.png"));
    let map =
        FieldMap::of(&u, Shown::Component(0), "u").deformed(&displacement, 1.0).undeformed_outline("before");
    map.arrows(&displacement, "displacement", "m").write_png(&of_field.0).unwrap();
    assert!(std::fs::metadata(&of_field.0).unwrap().len() > 10_000);
    let drawing = MeshDrawing::new(&mesh).cell_region("squares").unwrap().cell_region("every other").unwrap();
    drawing.region("top").unwrap().write_png(&of_mesh.0).unwrap();
    assert!(std::fs::metadata(&of_mesh.0).unwrap().len() > 10_000);
    // NaN is reported for its own cell, wherever it is.
    for cell in [0, 23, 24, 47] {
        let value = move |number: usize, _: &[f64; 2]| if number == cell { f64::NAN } else { 1.0 };
        let error = FieldMap::cell_by_cell(&mesh, value, "u").draw().map(|_| ()).unwrap_err().to_string();
        assert!(error.contains(&format!("in cell {cell},")), "{error}");
    }
}

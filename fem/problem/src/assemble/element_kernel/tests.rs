//! Cells that a caller lists, and one of them inverted.

use super::*;
use crate::element::Lagrange;
use crate::forms;

#[forms(crate = crate)]
mod listed {
    #[cells]
    pub struct Omega;

    pub fn mass(w: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, w * v)
    }
}

#[test]
fn a_listed_cell_that_is_inverted_is_named() {
    let element = Lagrange { shape: CellShape::Quadrilateral, degree: 1 };
    let layout = ElementLayout {
        geometry: element,
        element,
        coordinate_stride: 8,
        coordinate_offsets: vec![0, 2, 4, 6],
        coefficient_stride: 0,
        fields: vec![],
        rows: vec![0, 1, 2, 3],
    };
    let form = listed::mass(&listed::Omega::on("all"));
    let kernel: ElementKernel<2> =
        ElementKernel::new::<listed::mass::Kernels>(&form, layout, &Quadrature::Degree(2))
            .expect("the layout fits");
    let square = [0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0];
    let dart = [0.0, 0.0, 1.0, 0.0, 0.2, 0.2, 0.0, 1.0];
    let cells = |coordinates: &[f64], count| {
        let cells = ElementCells { count, coordinates, coefficients: &[], facet: 0 };
        kernel.check_cells(&cells).map_err(|error| error.to_string())
    };
    assert_eq!(cells(&[square, square].concat(), 2), Ok(()));
    let error = cells(&[square, dart].concat(), 2).err().unwrap_or_default();
    assert!(
        error.starts_with("form `mass`, the caller's cells: cell 1 is inverted at [0.2, 0.2]"),
        "{error}"
    );
    let short = "form `mass`, element kernel: the list of coordinates ends before cell 1 of 2".to_owned();
    assert_eq!(cells(&square, 2), Err(short));
}

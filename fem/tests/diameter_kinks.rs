//! Taylor tests by the shape where the diameter of cells has a kink.

use forms_fem::movement::MovementError;
use forms_fem::prelude::*;
use forms_fem::verification::{self, TaylorFailure};

#[forms]
mod sizes {
    #[cells]
    pub struct Omega;

    pub fn of_cells() -> Functional {
        integral(Omega, sqr(h))
    }
    pub fn of_cells_along(Theta: State<Vector>, rate: State<Scalar>) -> Functional {
        derivative(of_cells(), shape, Theta) + derivative(of_cells(), h, rate)
    }
}

/// A shear makes one diagonal of a rectangle longer and the other shorter: the test names the kink of h, and not a wrong derivative.
/// On cells that have one longest diagonal it passes, and finds a wrong derivative as before.
#[test]
fn a_taylor_test_names_the_kink_of_the_diameter() {
    let test = |mesh: &Mesh<2>, movement: fn(&[f64; 2]) -> [f64; 2], factor: f64| {
        let along = Field::interpolate(&Space::of_geometry(mesh).unwrap(), movement).unwrap();
        let form = sizes::of_cells_along(&sizes::Omega::on("all"), &along, along.rate_of_diameter().unwrap());
        let slope = factor * Assembler::new(mesh).functional(&form).unwrap();
        let report = verification::shape(&along, 0.1, slope, |moved| {
            let value = Assembler::new(moved).functional(&sizes::of_cells(&sizes::Omega::on("all"))).unwrap();
            Ok::<_, MovementError>(value.into())
        });
        report.unwrap().second_order()
    };
    let rectangles = rectangle([0.0; 2], [2.0, 1.0], [3, 2], CellShape::Quadrilateral, 1).unwrap();
    let shear: fn(&[f64; 2]) -> [f64; 2] = |x| [x[1] + 0.1 * x[1] * x[1], 0.0];
    let failure = test(&rectangles, shear, 1.0).unwrap_err();
    let message = failure.to_string();
    assert!(
        matches!(&failure, TaylorFailure::Diameter { kinked, .. } if kinked.count == 6 && kinked.cell == 0),
        "{message}"
    );
    assert!(
        message.contains("the diameter h of 6 cells has a kink along this movement (cell 0 around [0.333")
            && !message.contains("is not that of the function"),
        "{message}"
    );
    // Diagonals that differ by less than the steps that are judged: the shorter one overtakes the longer one, or it does not.
    let nearly = |step: f64| {
        let along =
            Field::interpolate(&Space::of_geometry(&rectangles).unwrap(), |x| [1e-7 * x[1], 0.0]).unwrap();
        test(&along.move_mesh(step).unwrap(), shear, 1.0)
    };
    assert!(matches!(nearly(-1.0), Err(TaylorFailure::Diameter { .. })));
    assert!(nearly(1.0).is_ok());
    // Along a movement that keeps rectangles there is no kink, and on parallelograms neither.
    let stretch: fn(&[f64; 2]) -> [f64; 2] = |x| [x[0] * x[0], x[1] * x[1]];
    assert!(test(&rectangles, stretch, 1.0).is_ok());
    assert!(matches!(test(&rectangles, stretch, 1.1), Err(TaylorFailure::Order { .. })));
    let along = Field::interpolate(&Space::of_geometry(&rectangles).unwrap(), |x| [x[1], 0.0]).unwrap();
    let parallelograms = along.move_mesh(0.3).unwrap();
    assert!(test(&parallelograms, shear, 1.0).is_ok());
    assert!(matches!(test(&parallelograms, shear, 1.1), Err(TaylorFailure::Order { .. })));
}

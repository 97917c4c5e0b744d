//! Problems that were once answered wrongly or refused.

use forms_fem::prelude::*;

use super::laws::scalar;
use super::solvers::{COUNT, solver};

fn data() -> scalar::Data<2> {
    let one = || Given::constant(1.0);
    scalar::Data { k: one(), c: one(), f: one(), wall: one(), penalty: 1.0, power: 0.0 }
}

/// Two cells that know nothing of each other, one 10¹¹ times as stiff: both are solved.
#[test]
fn a_stiff_cell_does_not_hide_a_soft_one() {
    let mesh = Arc::new(rectangle([0.0; 2], [1.0; 2], [2, 1], CellShape::Quadrilateral, 1).unwrap());
    let space = Space::discontinuous_scalar(&mesh, 0).unwrap();
    let of = |left: f64, right: f64| Given::function(move |x: &[f64; 2]| if x[0] < 0.5 { left } else { right });
    let data = scalar::Data { k: of(1e11, 0.0), c: of(0.0, 1.0), ..data() };
    let form = scalar::Model { data, regions: scalar::Regions::default() }.apart();
    for number in 0..COUNT {
        let (name, mut linear) = solver(number);
        let solved = Problem::new(&form, &space).solver(&mut *linear).solve().unwrap();
        for value in solved.field().values() {
            assert!((value - 1.0).abs() < 1e-9, "{name}: {value}");
        }
    }
}

/// A guess beyond a stiff switch does not end the iteration where the switch is left.
#[test]
fn a_far_guess_does_not_decide_when_to_stop() {
    let mesh = Arc::new(rectangle([0.0; 2], [1.0; 2], [1, 1], CellShape::Quadrilateral, 1).unwrap());
    let space = Space::discontinuous_scalar(&mesh, 0).unwrap();
    let data = scalar::Data { k: Given::constant(1e6), f: Given::constant(1e5), c: Given::constant(0.5), ..data() };
    let form = scalar::Model { data, regions: scalar::Regions::default() }.kinked();
    let far = Field::interpolate(&space, |_| 1e6).unwrap();
    let solved = Problem::new(&form, &space).start(&far).solve().unwrap();
    assert!((solved.field().values()[0] - 0.457_219).abs() < 1e-6, "{:?}", solved.field().values());
}

/// Forces of 10⁻³⁰² are forces.
#[test]
fn tiny_units_do_not_converge_at_once() {
    let mesh = Arc::new(rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Quadrilateral, 1).unwrap());
    let space = Space::scalar(&mesh, 1).unwrap();
    let solved = [1.0, 1e-302].map(|unit| {
        let data =
            scalar::Data { k: Given::constant(unit), c: Given::constant(unit), f: Given::constant(unit), ..data() };
        let form = scalar::Model { data, regions: scalar::Regions::default() }.conduction();
        let mut constraints = Constraints::new(&space);
        constraints.fix("left", |_| 0.0).unwrap();
        Problem::new(&form, &space).constrained(&constraints).solve().unwrap().field().values().to_vec()
    });
    for (one, tiny) in solved[0].iter().zip(&solved[1]) {
        assert!((one - tiny).abs() < 1e-9, "{one} {tiny}");
    }
}

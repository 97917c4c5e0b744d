//! Contact of bodies that are cut from quadrilaterals by a function of degree 2, and from hexahedra, compared with fitted meshes.

use forms_contact::ContactProblem;
use forms_contact::laws::cut_nitsche;
use forms_contact::nitsche;
use forms_fem::prelude::*;

use crate::{cylinder, order};

/// The paper's cylinder with biquadratic displacements and a biquadratic φ.
#[test]
fn cylinder_of_degree_2_comes_to_that_of_fitted_meshes() {
    let found = [16, 31, 62].map(|cells| cylinder::solve(cells, -1.0, 2));
    let errors = found.map(|values| [0, 1].map(|k| (values[k] / cylinder::FITTED[k] - 1.0).abs()));
    println!("{found:?} off by {errors:?}");
    assert!(errors[2][0] < 1e-5 && errors[2][1] < 1e-3, "{errors:?}");
    assert!((0..2).all(|k| errors[2][k] < errors[1][k] && errors[1][k] < errors[0][k]), "{errors:?}");
    // Of degree 1 it is 2.
    let order = order(&errors.map(|of| of[0]));
    assert!(order > 2.5, "order {order} of {errors:?}");
}

const GAMMA0: f64 = 40.0;

/// The rounded bottom of an obstacle, from the body's bottom at 0.13.
fn gap(x: &[f64; 3]) -> f64 {
    x[2] - 0.13 + 0.02 * ((x[0] - 0.4).powi(2) + (x[1] - 0.6).powi(2))
}

/// The data of a law with an obstacle below.
macro_rules! data {
    ($law:ident) => {
        $law::data()
            .lambda(1.0)
            .mu(1.0)
            .gamma0(GAMMA0)
            .obstacle_normal([0.0, 0.0, -1.0])
            .gap(gap)
            .theta(1.0)
            .body_force([0.0, 0.0, -0.02])
            .criterion_force([0.0, 0.0, -1.0])
    };
}

/// Criterion and contact force of a block pressed onto an obstacle that is not flat: on a fitted mesh, or cut by a function of a degree.
fn block(cells: usize, degree_of_function: Option<usize>) -> [f64; 2] {
    let lower = if degree_of_function.is_some() { -0.05 } else { 0.13 };
    let mesh = cuboid([0.0, 0.0, lower], [1.0; 3], [cells; 3], CellShape::Hexahedron, 1).unwrap();
    let space = Space::vector(&mesh, 1).unwrap();
    let mut held = Constraints::new(&space);
    held.fix("top", |x| [0.0, 0.01 * x[0], -0.03]).unwrap();
    let Some(degree) = degree_of_function else {
        let regions = nitsche::Regions::default().gamma_c("bottom").gamma_n("right");
        let law = nitsche::Model { data: data!(nitsche), regions };
        let problem = ContactProblem::new(&space, law.clone(), held);
        let u = problem.direct().unwrap().solve().unwrap().into_field();
        let whole = Assembler::new(&mesh);
        return [law.criterion(&u), law.contact_force(&u)].map(|of| whole.functional(&of).unwrap());
    };
    let phi = Field::interpolate(&Space::scalar(&mesh, degree).unwrap(), |x| 0.13 - x[2]).unwrap();
    let body = Assembler::new(&mesh).cut_by(&phi).unwrap();
    body.cut().unwrap().hold_outside(&mut held).unwrap();
    let regions = cut_nitsche::regions().gamma_c("all").gamma_d("all").gamma_n("right");
    let law = cut_nitsche::Model { data: data!(cut_nitsche), regions };
    let problem = ContactProblem::new(&space, law.clone(), held).assembler(body.clone());
    let u = problem.direct().unwrap().solve().unwrap().into_field();
    [law.criterion(&u), law.contact_force(&u)].map(|of| body.functional(&of).unwrap())
}

#[test]
fn block_of_hexahedra_comes_to_that_of_fitted_meshes() {
    let fitted = [4, 8, 16].map(|cells| block(cells, None));
    let cut = [4, 8, 16].map(|cells| block(cells, Some(1)));
    println!("fitted {fitted:?}\ncut {cut:?}");
    // The same body by a function of degree 2: the same points.
    let curved = block(4, Some(2));
    for (one, other) in curved.iter().zip(cut[0]) {
        assert!((one / other - 1.0).abs() < 1e-11, "{curved:?} is not {:?}", cut[0]);
    }
    // Extrapolated with order 2.
    let exact = [0, 1].map(|k| fitted[2][k] + (fitted[2][k] - fitted[1][k]) / 3.0);
    let errors = |found: &[[f64; 2]; 3], k: usize| found.map(|values| (values[k] / exact[k] - 1.0).abs());
    let [own, of_fitted] = [&cut, &fitted].map(|found| errors(found, 1));
    println!("J off by {:?}, force {own:?}, fitted {of_fitted:?}", errors(&cut, 0));
    assert!(errors(&cut, 0)[2] < 5e-5);
    assert!((order(&own) - 2.0).abs() < 0.4, "order {} of {own:?}", order(&own));
    // A cut cell is no worse than one that is half as large again.
    assert!((0..3).all(|k| own[k] < 2.25 * of_fitted[k]), "{own:?} {of_fitted:?}");
}

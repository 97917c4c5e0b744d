//! Histories at the points of contact pairs: written and read at the same points, and refused elsewhere.

use forms_fem::prelude::*;

use super::squares;

#[forms]
mod wearing {
    pub struct Data {
        pub worn: History<Scalar>,
        pub rate: Param,
    }
    #[pairs]
    pub struct Touch;

    pub fn after() -> Scalar {
        this(worn) + rate * (this(x[0]) + 2 * other(x[1]))
    }
    pub fn amount() -> Functional {
        integral(Touch, this(worn))
    }
    pub fn from_opposite() -> Functional {
        integral(Touch, other(worn))
    }
    pub fn sliding(u: State<Vector>) -> Functional {
        integral(Touch(u), this(worn))
    }
    /// ∫ w (u(X) − u(Y)) v(X), with a matrix.
    pub fn spring(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Touch, this(worn) * jump(u) * jump(v))
    }
}

/// Squares below y = 1 and above y = 1.1, in unlike cells.
fn bodies() -> Mesh<2> {
    squares([CellShape::Quadrilateral; 2], 1, [&|x| x, &|[x, y]| [x, y + 0.1]])
}

#[test]
fn values_stay_at_their_points() {
    let mesh = bodies();
    for (pairing, sides) in [
        (Pairing::onto("below", "above"), [1.0, 0.0]),
        (Pairing::onto("above", "below"), [0.0, 1.0]),
        (Pairing::between("below", "above"), [1.0, 1.0]),
    ] {
        for (degree, quadrature) in [(2, Quadrature::Estimated), (3, Quadrature::Degree(6))] {
            let assembler = Assembler::new(&mesh).with_quadrature(quadrature);
            let worn = assembler.history_on_pairs(&pairing, degree, 0.5).unwrap();
            let data = wearing::data().worn(worn).rate(3.0);
            let amount = || {
                let touch = wearing::Touch::on(pairing.clone());
                assembler.functional(&wearing::amount(&data, &touch)).unwrap()
            };
            // ∫₀¹ (½ + k · 3 (x + 2 y)) dx, y that of the opposite surface.
            let exact = |steps: f64| -> f64 {
                let of = |side: f64, height: f64| side * (0.5 + steps * 3.0 * (0.5 + 2.0 * height));
                of(sides[0], 1.1) + of(sides[1], 1.0)
            };
            assert!((amount() - exact(0.0)).abs() < 1e-13);
            for step in 1..=2 {
                assembler.update_history(&wearing::after(&data), &data.worn).unwrap();
                assert!((amount() - exact(f64::from(step) - 1.0)).abs() < 1e-12, "not yet committed");
                data.worn.commit();
                assert!((amount() - exact(f64::from(step))).abs() < 1e-12, "{} {}", amount(), exact(2.0));
            }
        }
    }
}

/// Each point has its own value, in the residual and in the matrix.
#[test]
fn each_point_reads_its_own_value() {
    let mesh = bodies();
    let pairing = Pairing::onto("below", "above");
    let assembler = Assembler::new(&mesh);
    let worn = assembler.history_on_pairs(&pairing, 4, 0.0).unwrap();
    let data = wearing::data().worn(worn).rate(1.0);
    assembler.update_history(&wearing::after(&data), &data.worn).unwrap();
    data.worn.commit();
    let space = Space::scalar(&mesh, 1).unwrap();
    let below = |x: &[f64; 2]| if x[1] < 1.05 { x[0] } else { 0.0 };
    let u = Field::interpolate(&space, below).unwrap();
    let form = wearing::spring(&data, &wearing::Touch::on(pairing));
    let residual = assembler.residual(&form, &[&u], &[&space]).unwrap();
    let tested: f64 = residual.iter().zip(u.values()).map(|(r, u)| r * u).sum();
    // ∫ (x + 2.2) x² dx.
    assert!((tested - (0.25 + 2.2 / 3.0)).abs() < 1e-12, "{tested}");
    let matrix = assembler.tangent(&form, &[&u], &[&space]).unwrap();
    let product = matrix.multiply(u.values()).unwrap();
    assert!(product.iter().zip(&residual).all(|(a, b)| (a - b).abs() < 1e-12));
}

#[test]
fn histories_of_other_points_are_refused() {
    let mesh = bodies();
    let assembler = Assembler::new(&mesh);
    let pairing = Pairing::onto("below", "above");
    let data = wearing::data().worn(assembler.history_on_pairs(&pairing, 2, 0.0).unwrap()).rate(1.0);
    let touch = |pairing: &Pairing| wearing::Touch::on(pairing.clone());
    let back = Pairing::onto("above", "below");
    let message = |found: Result<f64, AssemblyError>| found.unwrap_err().to_string();
    assert_eq!(
        message(assembler.functional(&wearing::amount(&data, &touch(&back)))),
        "form `amount`, history `worn`: it was made for \"below onto above\", and is read on the pairs above onto below; \
         `history_on_pairs` makes one for a pairing"
    );
    assert_eq!(
        message(assembler.functional(&wearing::from_opposite(&data, &touch(&pairing)))),
        "form `from_opposite`, history `worn`: a history of contact pairs is read from the own side, by `this`"
    );
    let u = Field::zero(&Space::vector(&mesh, 1).unwrap());
    assert_eq!(
        message(assembler.functional(&wearing::sliding(&data, &touch(&pairing), &u))),
        "form `sliding`, history `worn`: it was made for \"below onto above\", and is read at the own points of the sliding pairs \
         below onto above; `history_on_sliding_pairs` makes one for them"
    );
    let missing = assembler.history_on_pairs(&Pairing::onto("below", "sky"), 2, 0.0).unwrap_err().to_string();
    assert!(missing.contains("there is no facet region \"sky\""), "{missing}");
    let twice = pairing.clone().and(pairing.clone());
    let twice = assembler.history_on_pairs(&twice, 2, 0.0).unwrap_err().to_string();
    assert!(twice.contains("has some of them twice"), "{twice}");
    let infinite = assembler.history_on_pairs(&pairing, 2, f64::INFINITY).unwrap_err().to_string();
    assert!(infinite.contains("the initial value"), "{infinite}");
}

//! Positive parts of a scalar along facets, against intervals computed by hand; and fields compared between meshes.

use forms_fem::norms::Comparison;
use forms_fem::prelude::*;

#[forms]
mod along {
    pub struct Data {
        level: Param,
    }

    pub fn above(w: Scalar) -> Scalar {
        w - level
    }
    pub fn to_the_right(w: Scalar) -> Scalar {
        w + x[0] - level
    }
    pub fn slope(w: Scalar) -> Vector {
        grad(w)
    }
}

#[test]
fn both_zeros_within_one_facet_are_found() {
    for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
        let mesh = rectangle([0.0, 0.0], [3.0, 1.0], [3, 1], shape, 1).unwrap();
        let space = Space::scalar(&mesh, 2).unwrap();
        let w = Field::interpolate(&space, |x| (x[0] - 0.3) * (x[0] - 0.55) + 2.0).unwrap();
        let data = along::data().level(2.0);
        let assembler = Assembler::new(&mesh);
        let parts = assembler.positive_parts(&along::above(&data, &w), "bottom", 2).unwrap();
        let mut ends: Vec<f64> = parts.iter().flat_map(|part| part.positions.map(|x| x[0])).collect();
        ends.sort_by(f64::total_cmp);
        let expected = [0.0, 0.3, 0.55, 1.0, 1.0, 2.0, 2.0, 3.0];
        assert_eq!(ends.len(), expected.len(), "{parts:?}");
        for (end, expected) in ends.iter().zip(expected) {
            assert!((end - expected).abs() < 1e-14, "{ends:?}");
        }
        let error = assembler.positive_parts(&along::slope(&data, &w), "bottom", 2).unwrap_err().to_string();
        assert!(error.contains("slope") && error.contains('2'), "{error}");
    }
}

#[test]
fn zeros_on_curved_facets_are_those_of_the_function_itself() {
    let mesh = annulus(20.0, 25.0, 2, 20, CellShape::Quadrilateral, 2).unwrap();
    let zero = Field::zero(&Space::scalar(&mesh, 1).unwrap());
    let level = 7.3;
    let right = along::to_the_right(&along::data().level(level), &zero);
    let parts = Assembler::new(&mesh).positive_parts(&right, "outer", 6).unwrap();
    let mut zeros = 0;
    for part in &parts {
        for (parameter, position) in part.parameters.iter().zip(part.positions) {
            if *parameter != 0.0 && *parameter != 1.0 {
                assert!((position[0] - level).abs() < 1e-13, "{part:?}");
                zeros += 1;
            }
        }
    }
    assert_eq!(zeros, 2);
    let arc = |[a, b]: [[f64; 2]; 2]| 25.0 * (a[1].atan2(a[0]) - b[1].atan2(b[0])).abs();
    let length: f64 = parts.iter().map(|part| arc(part.positions)).sum();
    assert!((length - 50.0 * (level / 25.0).acos()).abs() < 1e-3, "{length}");
}

#[test]
fn quadratic_fields_on_nested_straight_meshes_differ_by_what_was_added() {
    let mesh = |cells| rectangle([0.0; 2], [2.0, 1.0], cells, CellShape::Quadrilateral, 1).unwrap();
    let (fine, coarse) = (mesh([8, 4]), mesh([2, 2]));
    let smooth = |x: &[f64; 2]| [x[0] * x[0] - x[1], x[0] * x[1]];
    let u = Field::interpolate(&Space::vector(&fine, 2).unwrap(), smooth).unwrap();
    let shifted = Field::interpolate(&Space::vector(&coarse, 2).unwrap(), |x| {
        let [a, b] = smooth(x);
        [a + 3.0 * x[0], b - 1.0]
    })
    .unwrap();
    let assembler = Assembler::new(&fine);
    let comparison = Comparison::new(&assembler, shifted.space(), 4).unwrap();
    let errors = comparison.errors(&u, &shifted).unwrap();
    // ∫ 9x² + 1 over 2 × 1, ∫ 9.
    assert!((errors.l2.powi(2) - 26.0).abs() < 1e-12, "{errors:?}");
    assert!((errors.seminorm.powi(2) - 18.0).abs() < 1e-12, "{errors:?}");
    let error = comparison.errors(&u, &u).unwrap_err().to_string();
    assert!(error.contains("the coarse one") && error.contains("another mesh"), "{error}");
    let elsewhere = rectangle([0.0; 2], [1.0, 1.0], [2, 2], CellShape::Quadrilateral, 1).unwrap();
    let error = Comparison::new(&assembler, &Space::vector(&elsewhere, 2).unwrap(), 4).unwrap_err();
    assert!(error.to_string().contains("outside the mesh"), "{error}");
}

//! Fields against the functions that they interpolate, and errors that name the node.

use super::*;
use crate::element::CellShape;
use crate::mesh::{annulus, cuboid, rectangle};

type Outcome = Result<(), Box<dyn std::error::Error>>;

#[test]
fn quadratic_fields_are_exact_on_straight_cells() -> Outcome {
    let function = |x: &[f64; 3]| [x[0] * x[1], x[2] * x[2] - x[0], 1.0 + x[1]];
    for shape in [CellShape::Tetrahedron, CellShape::Hexahedron] {
        let mesh = cuboid([0.0; 3], [1.0, 2.0, 3.0], [2, 2, 2], shape, 1)?;
        let field = Field::interpolate(&Space::vector(&mesh, 2)?, function)?;
        let x = [0.37, 1.21, 2.9];
        let gradient = [x[1], x[0], 0.0, -1.0, 0.0, 2.0 * x[2], 0.0, 1.0, 0.0];
        for (a, b) in field.evaluate(&x)?.into_iter().zip(function(&x)) {
            assert!((a - b).abs() < 1e-13);
        }
        for (a, b) in field.gradient(&x)?.into_iter().zip(gradient) {
            assert!((a - b).abs() < 1e-12);
        }
    }
    Ok(())
}

#[test]
fn linear_fields_are_exact_on_curved_cells() -> Outcome {
    let mesh = annulus(20.0, 25.0, 2, 16, CellShape::Quadrilateral, 2)?;
    let field = Field::interpolate(&Space::scalar(&mesh, 2)?, |x| 2.0 * x[0] - 3.0 * x[1] + 1.0)?;
    for x in [[0.0, -25.0], [25.0, 0.0], [-14.0, 17.3]] {
        assert!((field.evaluate(&x)?[0] - (2.0 * x[0] - 3.0 * x[1] + 1.0)).abs() < 1e-12);
        let gradient = field.gradient(&x)?;
        assert!((gradient[0] - 2.0).abs() < 1e-12 && (gradient[1] + 3.0).abs() < 1e-12);
    }
    let outside = field.evaluate(&[0.0, 0.0]).err().map(|error| error.to_string());
    assert_eq!(outside.as_deref(), Some("the point [0.0, 0.0] lies outside the mesh"));
    Ok(())
}

#[test]
fn the_contract_sees_the_field() -> Outcome {
    let mesh = rectangle([0.0; 2], [1.0; 2], [1, 1], CellShape::Triangle, 1)?;
    let field = Field::interpolate(&Space::tensor(&mesh, 1)?, |x| [[x[0], 1.0], [2.0, x[1]]])?;
    let handle = FieldHandle::from(&field);
    assert_eq!(handle.components(), 4);
    let back = handle.as_any().downcast_ref::<Field<2>>().map(|field| field.values().to_vec());
    assert_eq!(back.as_deref(), Some(field.values()));
    assert_eq!(field.at_node(0), [0.0, 1.0, 2.0, 0.0]);
    Ok(())
}

#[test]
fn errors_name_the_node() -> Outcome {
    let mesh = rectangle([0.0; 2], [1.0; 2], [1, 1], CellShape::Quadrilateral, 1)?;
    let space = Space::vector(&mesh, 1)?;
    let message = |field: Result<Field<2>, FieldError>| field.err().map(|error| error.to_string());
    assert_eq!(
        message(Field::interpolate(&space, |x| [x[0], 1.0 / x[1]])).as_deref(),
        Some("component 1 at node 0, position [0.0, 0.0], is not finite: inf")
    );
    assert_eq!(
        message(Field::interpolate(&space, |x| x[0])).as_deref(),
        Some("the space has 2 components, but the function gives 1")
    );
    assert_eq!(
        message(Field::from_values(&space, vec![0.0; 7])).as_deref(),
        Some("the space has 8 unknowns, but 7 values were given")
    );
    Ok(())
}

//! Fields from lists of values, one for each cell of a mesh or facet of a region, in their order.

use forms_fem::field::FieldError;
use forms_fem::mesh::RigidSurface;
use forms_fem::prelude::*;

type Outcome = Result<(), Box<dyn std::error::Error>>;

/// Each cell, and each facet of a region, has the value of its number.
fn values_stay_on_their_cells<const D: usize>(mesh: &Mesh<D>, region: &str) -> Outcome {
    let scalar = Space::discontinuous_scalar(mesh, 0)?;
    let numbers: Vec<f64> = (0..mesh.cell_count()).map(|cell| cell as f64).collect();
    let field = Field::from_cell_values(&scalar, &numbers)?;
    // The space numbers its nodes along a curve: the list itself would be permuted.
    assert_ne!(field.values(), numbers);
    let vector = Space::discontinuous_vector(mesh, 0)?;
    let pairs: Vec<f64> =
        numbers.iter().flat_map(|number| (0..D).map(move |k| number + 0.1 * k as f64)).collect();
    let vectors = Field::from_cell_values(&vector, &pairs)?;
    for cell in 0..mesh.cell_count() {
        let centre = mesh.cell_shape(cell).centre();
        assert_eq!(field.evaluate_in(cell, &centre), [cell as f64]);
        assert_eq!(vectors.evaluate_in(cell, &centre), pairs[cell * D..(cell + 1) * D]);
    }
    let on_facets = Space::on_facets(mesh, region, 0)?;
    let facets = mesh.facet_region(region)?;
    let numbers: Vec<f64> = (0..facets.len()).map(|facet| facet as f64).collect();
    let field = Field::from_facet_values(&on_facets, &numbers)?;
    for (facet, number) in facets.iter().zip(numbers) {
        let node = on_facets.nearest_node(&mesh.facet_centre(*facet)).ok_or("no node")?;
        assert_eq!(field.at_node(node), [number]);
    }
    Ok(())
}

#[test]
fn values_of_cells_and_facets() -> Outcome {
    for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
        values_stay_on_their_cells(&annulus(1.0, 2.0, 3, 7, shape, 2)?, "outer")?;
    }
    for shape in [CellShape::Tetrahedron, CellShape::Hexahedron] {
        values_stay_on_their_cells(&cuboid([0.0; 3], [1.0; 3], [3, 2, 2], shape, 1)?, "top")?;
    }
    Ok(())
}

#[test]
fn cells_of_rigid_surfaces_are_not_counted() -> Outcome {
    let block = rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Quadrilateral, 1)?;
    let floor = RigidSurface::along(&[[-1.0, 0.0], [2.0, 0.0]])?;
    let mesh = block.with_rigid_surfaces(&[("floor", &floor)])?;
    let field = Field::from_cell_values(&Space::discontinuous_scalar(&mesh, 0)?, &[1.0, 2.0, 3.0, 4.0])?;
    assert_eq!(field.evaluate(&[0.75, 0.25])?, [2.0]);
    Ok(())
}

#[test]
fn other_spaces_and_lengths_are_refused() -> Outcome {
    let mesh = rectangle([0.0; 2], [1.0; 2], [2, 1], CellShape::Quadrilateral, 1)?;
    let message = |result: Result<Field<2>, FieldError>| result.err().map(|error| error.to_string());
    let linear = Space::discontinuous_scalar(&mesh, 1)?;
    assert_eq!(
        message(Field::from_cell_values(&linear, &[0.0; 8])).as_deref(),
        Some(
            "values on cells are those of a space that is constant on each of them; this one has Lagrange elements of degree 1 with discontinuous values"
        )
    );
    let constant = Space::discontinuous_scalar(&mesh, 0)?;
    assert_eq!(
        message(Field::from_cell_values(&constant, &[0.0; 3])).as_deref(),
        Some("the space has 2 unknowns, but 3 values were given")
    );
    assert!(
        message(Field::from_facet_values(&constant, &[0.0; 2]))
            .is_some_and(|m| m.contains("values on facets"))
    );
    let nan = message(Field::from_cell_values(&constant, &[0.0, f64::NAN]));
    assert!(nan.is_some_and(|message| message.contains("[0.75, 0.5]")));
    Ok(())
}

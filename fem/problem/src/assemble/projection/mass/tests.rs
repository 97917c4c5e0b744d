//! Products cell by cell compared with those of the assembled matrix.

use super::*;
use crate::assemble::Assembler;
use crate::dimension::{Dim, Dimension};
use crate::element::CellShape;
use crate::mesh::{annulus, cuboid, rectangle};
use crate::norms::mass_matrix;

type Outcome = Result<(), Box<dyn std::error::Error>>;

fn check<const D: usize>(mesh: &Mesh<D>) -> Outcome
where
    Dim: Dimension<D>,
{
    for degree in 1..=3 {
        for space in [Space::scalar(mesh, degree)?, Space::discontinuous_scalar(mesh, degree)?] {
            let of_rule = 2 * degree + mesh.degree();
            let matrix = mass_matrix(&Assembler::new(mesh), &space, of_rule)?;
            let pieces = Pieces::new(&space);
            let x: Vec<f64> = (0..space.node_count()).map(|node| (node as f64 * 0.7).sin()).collect();
            let wanted = matrix.multiply(&x)?;
            let size = wanted.iter().fold(0.0_f64, |size, value| size.max(value.abs()));
            for set in InstructionSet::available() {
                let mass = MassByCells::new(&space, &pieces, of_rule, set)?;
                let mut found = vec![0.0; x.len()];
                for threads in [1, 3] {
                    mass.on(Threads::new(threads))
                        .apply(&x, &mut found)
                        .map_err(|error| error.to_string())?;
                    for (found, wanted) in found.iter().zip(&wanted) {
                        assert!(
                            (found - wanted).abs() < 1e-13 * size,
                            "{set}, degree {degree}: {found}, {wanted}"
                        );
                    }
                }
                // As many vectors as fill half of the lanes, one more, and more than there are lanes.
                for count in [set.width().div_ceil(2), set.width() / 2 + 1, set.width() + 1] {
                    let multiple = |k: usize| x.iter().map(|x| (k + 1) as f64 * x).collect();
                    let several: Vec<Vec<f64>> = (0..count).map(multiple).collect();
                    let mut images = several.clone();
                    mass.products(Threads::new(3), &several, &mut vec![], &mut images);
                    for (k, image) in images.iter().enumerate() {
                        for (found, wanted) in image.iter().zip(&wanted) {
                            let off = (found - (k + 1) as f64 * wanted).abs();
                            assert!(off < 1e-13 * (k + 1) as f64 * size, "{set}, {count}: {found}, {wanted}");
                        }
                    }
                }
                let (sums, sizes) = mass.on(Threads::ONE).products(&x)?;
                assert_eq!(sums, found);
                // The sizes of a row's terms, by cells, are no less than by the matrix.
                for (row, size) in sizes.iter().enumerate() {
                    let (columns, values) = matrix.row(row);
                    let terms =
                        columns.iter().zip(values).map(|(column, value)| (value * x[*column as usize]).abs());
                    let least: f64 = terms.sum();
                    assert!(*size >= least * (1.0 - 1e-13) && *size < 20.0 * least, "{size}, {least}");
                }
                for (found, wanted) in mass.diagonal().iter().zip(matrix.diagonal()) {
                    assert!((found - wanted).abs() < 1e-13 * wanted, "{found}, {wanted}");
                }
            }
        }
    }
    Ok(())
}

#[test]
fn products_are_those_of_the_matrix() -> Outcome {
    for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
        check(&rectangle([0.0; 2], [2.0, 1.0], [7, 5], shape, 1)?)?;
        check(&annulus(20.0, 30.0, 2, 11, shape, 2)?)?;
    }
    for shape in [CellShape::Tetrahedron, CellShape::Hexahedron] {
        check(&cuboid([0.0; 3], [2.0, 1.0, 0.5], [3, 2, 2], shape, 1)?)?;
        check(&cuboid([0.0; 3], [2.0, 1.0, 0.5], [2, 1, 2], shape, 2)?)?;
    }
    Ok(())
}

/// Several pieces, whose sums meet at nodes that they share: as many as there are threads for, and more.
#[test]
fn pieces_and_threads_change_no_bit() -> Outcome {
    let mesh = rectangle([0.0; 2], [1.0; 2], [130, 70], CellShape::Triangle, 1)?;
    let space = Space::scalar(&mesh, 2)?;
    let pieces = Pieces::new(&space);
    let mass = MassByCells::new(&space, &pieces, 5, InstructionSet::best())?;
    let x: Vec<f64> = (0..space.node_count()).map(|node| (node as f64 * 0.7).sin()).collect();
    let product = |threads| -> Result<Vec<f64>, OperatorError> {
        let mut product = vec![0.0; x.len()];
        mass.on(Threads::new(threads)).apply(&x, &mut product)?;
        Ok(product)
    };
    let alone = product(1).map_err(|error| error.to_string())?;
    let matrix = mass_matrix(&Assembler::new(&mesh), &space, 5)?;
    for (found, wanted) in alone.iter().zip(matrix.multiply(&x)?) {
        assert!((found - wanted).abs() < 1e-18, "{found}, {wanted}");
    }
    for threads in [2, 3, 7] {
        assert!(product(threads).map_err(|error| error.to_string())? == alone, "{threads} threads");
    }
    Ok(())
}

#[test]
fn the_inverse_by_cells_is_near() -> Outcome {
    // The largest eigenvalue of its product with the matrix, by the power method; the smallest is one.
    for (shape, degree, largest) in [
        (CellShape::Quadrilateral, 1, 1.79),
        (CellShape::Quadrilateral, 2, 1.51),
        (CellShape::Triangle, 1, 1.57),
        (CellShape::Triangle, 2, 1.81),
    ] {
        let mesh = rectangle([0.0; 2], [2.0, 1.0], [16, 12], shape, 1)?;
        let space = Space::scalar(&mesh, degree)?;
        let pieces = Pieces::new(&space);
        let mass = MassByCells::new(&space, &pieces, 2 * degree, InstructionSet::best())?;
        let nodes = space.node_count();
        let mut x = vec![(0..nodes).map(|node| (node as f64 * 0.7).sin()).collect::<Vec<f64>>()];
        let (mut image, mut back, mut room) = (x.clone(), x.clone(), vec![]);
        let mut quotient = 0.0;
        for _ in 0..60 {
            mass.products(Threads::ONE, &x, &mut room, &mut image);
            mass.precondition(Threads::ONE, &image, &mut room, &mut back);
            let product = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
            quotient = product(&back[0], &image[0]) / product(&x[0], &image[0]);
            assert!((1.0 - 1e-12..=largest).contains(&quotient), "{shape:?}, degree {degree}: {quotient}");
            let size = product(&back[0], &back[0]).sqrt();
            x[0].iter_mut().zip(&back[0]).for_each(|(x, back)| *x = back / size);
        }
        assert!(quotient > 0.9 * largest, "{shape:?}, degree {degree}: {quotient}");
    }
    Ok(())
}

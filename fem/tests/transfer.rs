//! Fields carried between meshes: polynomials are reproduced, integrals kept, jumps stay on their side, and a point that is too
//! far away is named.

use forms_fem::field::TransferError;
use forms_fem::mesh::structured;
use forms_fem::prelude::*;

#[forms]
mod total {
    #[cells]
    pub struct Omega;
    pub fn amount(w: State<Scalar>) -> Functional {
        integral(Omega, w)
    }
}

type Outcome = Result<(), Box<dyn std::error::Error>>;

/// The largest difference of coefficients.
fn distance<const D: usize>(a: &Field<D>, b: &Field<D>) -> f64 {
    a.values().iter().zip(b.values()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// A polynomial of some degree in all coordinates.
fn polynomial<const D: usize>(degree: usize) -> impl Fn(&[f64; D]) -> f64 {
    move |x| {
        let sum: f64 = (0..D).map(|k| (k as f64 + 0.5) * x[k]).sum();
        1.0 + sum.powi(degree as i32) - x[0] * x[D - 1].powi(degree as i32 - 1)
    }
}

fn polynomials_come_through<const D: usize>(from: &Mesh<D>, to: &Mesh<D>) -> Outcome
where
    Dim: Dimension<D>,
{
    for degree in 1..=4 {
        let function = polynomial::<D>(degree);
        let field = Field::interpolate(&Space::scalar(from, degree)?, &function)?;
        for space in [Space::scalar(to, degree)?, Space::discontinuous_scalar(to, degree)?] {
            let wanted = Field::interpolate(&space, &function)?;
            let size = wanted.values().iter().fold(0.0_f64, |size, value| size.max(value.abs()));
            let found = [
                field.onto(&space).interpolated()?,
                field.onto(&space).projected()?,
                field.onto(&space).conserved()?,
            ];
            for found in found {
                let error = distance(&found, &wanted) / size;
                assert!(error < 1e-12, "degree {degree}, {}: {error:e}", space.scope());
            }
        }
    }
    Ok(())
}

#[test]
fn polynomials_of_degrees_1_to_4_in_the_plane() -> Outcome {
    let mesh = |divisions, shape| rectangle([0.0; 2], [1.5, 1.0], divisions, shape, 1);
    let (triangles, squares) = (mesh([5, 3], CellShape::Triangle)?, mesh([4, 4], CellShape::Quadrilateral)?);
    polynomials_come_through(&triangles, &squares)?;
    polynomials_come_through(&squares, &mesh([3, 7], CellShape::Triangle)?)
}

#[test]
fn polynomials_of_degrees_1_to_4_in_space() -> Outcome {
    let mesh = |divisions, shape| cuboid([0.0; 3], [1.5, 1.0, 0.5], divisions, shape, 1);
    let (tetrahedra, bricks) =
        (mesh([2, 3, 1], CellShape::Tetrahedron)?, mesh([3, 1, 2], CellShape::Hexahedron)?);
    polynomials_come_through(&tetrahedra, &bricks)?;
    polynomials_come_through(&bricks, &tetrahedra)
}

/// On curved cells the isoparametric space holds the linear functions. Each of the two polygons of parabolas reaches beyond the
/// other: there the nearest cell's polynomial goes on.
#[test]
fn linear_vectors_between_curved_meshes() -> Outcome {
    let mesh = |around| annulus(20.0, 25.0, 2, around, CellShape::Triangle, 2);
    let (from, to) = (mesh(16)?, mesh(23)?);
    let function = |x: &[f64; 2]| [2.0 * x[0] - x[1] + 1.0, 0.5 * x[1] - 3.0];
    let (source, space) = (Space::vector(&from, 2)?, Space::vector(&to, 2)?);
    let (field, wanted) = (Field::interpolate(&source, function)?, Field::interpolate(&space, function)?);
    assert!(to.nodes().iter().any(|node| source.locator().find(node).is_none()));
    for found in [field.onto(&space).interpolated()?, field.onto(&space).projected()?] {
        let error = distance(&found, &wanted);
        assert!(error < 1e-12 * 60.0, "{error:e}");
    }
    let refused = field.onto(&space).within(1e-6).interpolated();
    assert!(matches!(refused, Err(TransferError::Outside { reach: 1e-6, .. })), "{refused:?}");
    Ok(())
}

/// |x − 0.4| is no polynomial on any cell that the kink crosses: quadrature alone misses some of its integral.
#[test]
fn integrals_are_kept() -> Outcome {
    let from = rectangle([0.0; 2], [1.0; 2], [5, 4], CellShape::Triangle, 1)?;
    let to = rectangle([0.0; 2], [1.0; 2], [7, 3], CellShape::Quadrilateral, 1)?;
    let kink = |x: &[f64; 2]| (x[0] - 0.4).abs() + x[1];
    let field = Field::interpolate(&Space::scalar(&from, 1)?, kink)?;
    let space = Space::scalar(&to, 2)?;
    let amount = |field: &Field<2>| {
        Assembler::new(field.space().mesh()).functional(&total::Model::default().amount(field))
    };
    let wanted = amount(&field)?;
    // ∫|x − 0.4| = (0.4² + 0.6²)/2: the kink lies on an edge of the first mesh.
    assert!((wanted - 0.76).abs() < 1e-13);
    assert!((amount(&field.onto(&space).conserved()?)? - wanted).abs() < 1e-12 * wanted);
    assert!((amount(&field.onto(&space).projected()?)? - wanted).abs() > 1e-6);
    Ok(())
}

/// A map of the unit square or cube to itself, its boundary to its boundary, that leaves no cell a parallelogram.
fn distorted<const D: usize>(x: &[f64; D]) -> [f64; D] {
    let bump: f64 = x.iter().map(|x| 4.0 * x * (1.0 - x)).product();
    std::array::from_fn(|k| x[k] + (0.03 - 0.05 * k as f64) * bump * (1.0 + x[(k + 1) % D]))
}

/// Integrals before and after, by a rule that is exact for the polynomials of all cells.
fn keeps_integrals<const D: usize>(from: &Mesh<D>, to: &Mesh<D>) -> Outcome
where
    Dim: Dimension<D>,
{
    let amount = |field: &Field<D>| {
        let assembler = Assembler::new(field.space().mesh()).with_quadrature(Quadrature::Degree(20));
        assembler.functional(&total::amount(&total::Omega::on("all"), field))
    };
    let kink = |x: &[f64; D]| (x[0] - 0.4).abs() + x[D - 1];
    for (own, other) in [(1, 1), (2, 1), (1, 2), (2, 0)] {
        let field = Field::interpolate(&Space::scalar(from, own)?, kink)?;
        let wanted = amount(&field)?;
        let found = amount(&field.onto(&Space::discontinuous_scalar(to, other)?).conserved()?)?;
        let error = (found / wanted - 1.0).abs();
        assert!(error < 1e-13, "degrees {own}, {other}: {error:e}");
        if other > 0 {
            let found = amount(&field.onto(&Space::scalar(to, other)?).conserved()?)?;
            let error = (found / wanted - 1.0).abs();
            assert!(error < 1e-13, "degrees {own}, {other}, continuous: {error:e}");
        }
    }
    Ok(())
}

#[test]
fn integrals_are_kept_on_distorted_cells() -> Outcome {
    for degree in 1..=2 {
        let plane = |divisions, shape| structured(divisions, shape, degree, |x| distorted(&x));
        let quadrilaterals = plane([5, 4], CellShape::Quadrilateral)?;
        keeps_integrals(&quadrilaterals, &plane([4, 7], CellShape::Quadrilateral)?)?;
        keeps_integrals(&quadrilaterals, &plane([3, 3], CellShape::Triangle)?)?;
        let space = |divisions, shape| structured(divisions, shape, degree, |x| distorted(&x));
        let hexahedra = space([3, 2, 2], CellShape::Hexahedron)?;
        keeps_integrals(&hexahedra, &space([2, 3, 2], CellShape::Hexahedron)?)?;
        keeps_integrals(&space([2; 3], CellShape::Tetrahedron)?, &hexahedra)?;
    }
    Ok(())
}

/// A field of a mesh on the mesh of some of its cells.
#[test]
fn fields_on_parts_of_a_mesh() -> Outcome {
    for shape in [CellShape::Quadrilateral, CellShape::Triangle] {
        let mut ring = annulus(1.0, 2.0, 4, 16, shape, 2)?;
        ring.name_cells("lining", |x| x[0].hypot(x[1]) < 1.25)?;
        let part = ring.part("lining")?;
        let lining = part.mesh;
        for degree in 1..=4 {
            let wave = |x: &[f64; 2]| (3.0 * x[0]).sin() * x[1];
            let field = Field::interpolate(&Space::scalar(&ring, degree)?, wave)?;
            let space = Space::scalar(&lining, degree)?;
            let found = field.onto(&space).interpolated()?;
            let error = distance(&found, &Field::interpolate(&space, wave)?);
            assert!(error < 1e-11, "{shape:?}, degree {degree}: {error:e}");
            // Cell by cell it is the same polynomial.
            for (cell, own) in part.cells.iter().enumerate() {
                let reference = lining.cell_shape(cell).centre();
                let [a, b] =
                    [found.evaluate_in(cell, &reference)[0], field.evaluate_in(*own as usize, &reference)[0]];
                assert!((a - b).abs() < 1e-11);
            }
        }
    }
    Ok(())
}

/// Of all fields of the target the projection is nearest in L²: nearer than the interpolant, and by more than rounding.
#[test]
fn the_projection_is_nearer_than_the_interpolant() -> Outcome {
    let mesh = |n| rectangle([0.0; 2], [1.0; 2], [n, n], CellShape::Triangle, 1);
    let (from, to) = (mesh(24)?, mesh(6)?);
    let wave = |x: &[f64; 2]| (5.0 * x[0]).sin() * (4.0 * x[1]).cos();
    let field = Field::interpolate(&Space::scalar(&from, 2)?, wave)?;
    let space = Space::scalar(&to, 1)?;
    let error = |found: &Field<2>| norms::errors_between(&Assembler::new(&from), &field, found).map(|e| e.l2);
    let (projected, interpolated) =
        (error(&field.onto(&space).projected()?)?, error(&field.onto(&space).interpolated()?)?);
    assert!(projected < 0.8 * interpolated, "{projected:e}, {interpolated:e}");
    Ok(())
}

/// A field of one constant per cell, on a finer mesh: each fine cell has its coarse cell's, though all its nodes lie on edges.
#[test]
fn jumps_stay_on_their_side() -> Outcome {
    for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
        let coarse = rectangle([0.0; 2], [1.0; 2], [3, 2], shape, 1)?;
        let fine = coarse.refined()?;
        let constants = Space::discontinuous_scalar(&coarse, 0)?;
        let values = (0..constants.unknowns()).map(|cell| (cell * cell) as f64).collect();
        let field = Field::from_values(&constants, values)?;
        let found = field.onto(&Space::discontinuous_scalar(&fine, 1)?).interpolated()?;
        for cell in 0..fine.cell_count() {
            let wanted = field.evaluate(&fine.cell_centre(cell))?[0];
            for &node in found.space().cell_nodes(cell) {
                assert!((found.at_node(node as usize)[0] - wanted).abs() < 1e-14);
            }
        }
    }
    Ok(())
}

#[test]
fn bits_do_not_depend_on_threads() -> Outcome {
    let mesh = |n, shape| rectangle([0.0; 2], [1.0; 2], [n, n], shape, 1);
    same_bits(&mesh(9, CellShape::Triangle)?, &mesh(11, CellShape::Quadrilateral)?)?;
    // Enough unknowns that each loop is cut among threads.
    same_bits(&mesh(40, CellShape::Quadrilateral)?, &mesh(100, CellShape::Triangle)?)
}

fn same_bits(from: &Mesh<2>, to: &Mesh<2>) -> Outcome {
    let field = Field::interpolate(&Space::scalar(from, 2)?, |x| (3.0 * x[0]).exp() * x[1])?;
    let space = Space::scalar(to, 2)?;
    let bits = |field: Field<2>| field.values().iter().map(|value| value.to_bits()).collect::<Vec<_>>();
    let with = |threads| -> Result<_, TransferError> {
        let transfer = field.onto(&space).with_threads(Threads::new(threads));
        Ok((bits(transfer.interpolated()?), bits(transfer.projected()?)))
    };
    let one = with(1)?;
    for threads in [2, 3, 7, 16] {
        assert!(with(threads)? == one, "{threads} threads");
    }
    Ok(())
}

#[test]
fn what_does_not_fit_is_named() -> Outcome {
    let mesh = |width| rectangle([0.0; 2], [width, 1.0], [4, 4], CellShape::Triangle, 1);
    let (small, large) = (mesh(1.0)?, mesh(2.0)?);
    let field = Field::interpolate(&Space::scalar(&small, 1)?, |x| x[0])?;
    let message =
        |transfer: Result<Field<2>, TransferError>| transfer.map_err(|error| error.to_string()).err();
    let target = Space::scalar(&large, 1)?;
    assert_eq!(
        message(field.onto(&target).within(0.25).interpolated()).as_deref(),
        Some("the point [1.5, 0.75] is further than 2.5e-1 from the mesh that the field lives on")
    );
    assert!(matches!(field.onto(&target).projected(), Err(TransferError::Outside { .. })));
    assert_eq!(
        message(field.onto(&Space::vector(&large, 1)?).interpolated()).as_deref(),
        Some("the field has 1 components, but the space has 2")
    );
    assert_eq!(
        message(field.onto(&Space::on_facets(&small, "top", 1)?).interpolated()).as_deref(),
        Some(
            "fields are carried between spaces on cells, but the space lives on the facets of \"top\" alone"
        )
    );
    assert_eq!(
        message(field.onto(&target).within(f64::NAN).interpolated()).as_deref(),
        Some("points outside are to be looked for within NaN, which is no distance")
    );
    Ok(())
}

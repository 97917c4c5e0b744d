//! Cells that are inverted at a quadrature point. A mesh has none; these have been moved without a check.

use crate::contract::Form;

use crate::assemble::{Assembler, AssemblyError};
use crate::element::CellShape;
use crate::field::Field;
use crate::forms;
use crate::mesh::{Mesh, cuboid, rectangle};
use crate::norms;
use crate::quadrature::Quadrature;
use crate::space::Space;
use crate::threads::Threads;

#[forms(crate = crate)]
mod tested {
    #[cells]
    pub struct Omega;

    pub fn mass(w: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, w * v)
    }
}

fn check_error<T: std::fmt::Debug>(result: Result<T, AssemblyError>, expected: usize, position: &[f64]) {
    match result {
        Err(AssemblyError::Weight { cell, determinant, position: found, .. }) => {
            assert_eq!(cell, expected);
            assert!(determinant < 0.0);
            assert!(found.iter().zip(position).all(|(a, b)| (a - b).abs() < 0.6), "{found:?}");
        }
        other => panic!("{other:?}"),
    }
}

// A matrix and a vector.
fn check_all<const D: usize>(
    form: &Form<D>,
    mesh: &Mesh<D>,
    moved: Vec<[f64; D]>,
    expected: usize,
    position: [f64; D],
) {
    let mesh = mesh.with_unchecked_nodes(moved);
    let space = Space::scalar(&mesh, 1).expect("degree 1 exists");
    let field = Field::interpolate(&space, |x| x[0]).expect("finite values");
    for threads in [1, 2] {
        let assembler =
            Assembler::new(&mesh).with_threads(Threads::new(threads)).with_quadrature(Quadrature::Degree(4));
        check_error(assembler.tangent(form, &[&field], &[&space]).map(|_| ()), expected, &position);
        check_error(assembler.residual(form, &[&field], &[&space]).map(|_| ()), expected, &position);
    }
}

#[test]
fn a_cell_that_is_inverted_at_a_point_is_named() {
    // A corner of the last cells passes an edge, or the diagonal between its neighbours.
    let cases = [(CellShape::Triangle, [3.6, 2.9], 30), (CellShape::Quadrilateral, [3.1, 3.1], 15)];
    for (shape, place, expected) in cases {
        let mesh = rectangle([0.0; 2], [4.0; 2], [4, 4], shape, 1).expect("a square");
        let corner = |x: &[f64; 2]| if *x == [4.0; 2] { place } else { *x };
        let moved: Vec<[f64; 2]> = mesh.nodes().iter().map(corner).collect();
        check_all(&tested::mass(&tested::Omega::on("all")), &mesh, moved.clone(), expected, [3.5, 3.0]);
        let mesh = mesh.with_unchecked_nodes(moved);
        let space = Space::scalar(&mesh, 1).expect("degree 1 exists");
        let field = Field::interpolate(&space, |x| x[0]).expect("finite values");
        check_error(norms::l2_norm(&Assembler::new(&mesh), &field), expected, &[3.5, 3.0]);
    }
    let mesh = cuboid([0.0; 3], [3.0; 3], [3; 3], CellShape::Hexahedron, 2).expect("a cube");
    let corner = |x: &[f64; 3]| if *x == [3.0; 3] { [2.1; 3] } else { *x };
    let moved = mesh.nodes().iter().map(corner).collect();
    check_all(&tested::mass(&tested::Omega::on("all")), &mesh, moved, 26, [2.5; 3]);
}

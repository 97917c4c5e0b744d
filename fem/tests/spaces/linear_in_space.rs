//! P₋₁: polynomials of degree 1 of the position on each cell, the pressure of the Q2/P₋₁ element.

use forms_fem::prelude::*;

use crate::shared::*;

#[forms]
mod against {
    pub struct Data {
        pub slope: Given<Vector>,
        pub at_origin: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Gamma;
    #[interior_facets]
    pub struct Skeleton;

    pub fn inside(p: State<Scalar>) -> Functional {
        integral(Omega, sqr(p - at_origin - dot(slope, x)) + dot(grad(p) - slope, grad(p) - slope))
    }
    pub fn outside(p: State<Scalar>) -> Functional {
        integral(Gamma, sqr(p - at_origin - dot(slope, x)) + dot(grad(p) - slope, grad(p) - slope))
    }
    pub fn between(p: State<Scalar>) -> Functional {
        integral(Skeleton, sqr(jump(p)) + dot(jump(grad(p)), jump(grad(p))))
    }
    pub fn curved(p: State<Scalar>) -> Functional {
        integral(Omega, inner(hess(p), hess(p)))
    }
}

fn check_reproduction<const D: usize>(mesh: &Mesh<D>) -> Outcome
where
    Dim: Dimension<D>,
{
    let space = Space::of(mesh, Elements::LinearInSpace, Scope::Cell, &[])?;
    assert_eq!(space.node_count(), (D + 1) * mesh.cell_count());
    let slope: [f64; D] = std::array::from_fn(|k| 1.5 - 0.7 * k as f64);
    let linear = move |x: &[f64; D]| 0.4 + (0..D).map(|k| slope[k] * x[k]).sum::<f64>();
    assert!(largest_error(&space, linear) < 1e-13);
    let p = Field::interpolate(&space, linear)?;
    let found = p.gradient_in(0, &[0.2; D]);
    assert!(found.iter().zip(slope).all(|(a, b)| (a - b).abs() < 1e-12));
    let assembler = Assembler::new(mesh);
    let data = against::data().slope(slope).at_origin(0.4);
    let (omega, gamma) = (against::Omega::on("all"), against::Gamma::on("boundary"));
    let skeleton = against::Skeleton::on("interior");
    for (name, value) in [
        ("cells", assembler.functional(&against::inside(&data, &omega, &p))?),
        ("facets", assembler.functional(&against::outside(&data, &gamma, &p))?),
        ("interior facets", assembler.functional(&against::between(&data, &skeleton, &p))?),
        ("second derivatives", assembler.functional(&against::curved(&data, &omega, &p))?),
    ] {
        assert!(value < 1e-22, "{name}: {value:e}");
    }
    // Values at random have constant gradients in each cell.
    let rough = Field::from_values(&space, noise(space.unknowns()))?;
    let gradients = [[0.1; D], [0.8; D]].map(|point| rough.gradient_in(0, &point));
    assert!(gradients[0].iter().zip(&gradients[1]).all(|(a, b)| (a - b).abs() < 1e-12));
    Ok(())
}

#[test]
fn linear_functions_are_reproduced_on_distorted_and_curved_cells() -> Outcome {
    for degree in [1, 2] {
        check_reproduction(&distorted(3, CellShape::Quadrilateral, degree))?;
        check_reproduction(&distorted(3, CellShape::Triangle, degree))?;
        check_reproduction(&distorted_cube(2, CellShape::Hexahedron, degree))?;
        check_reproduction(&distorted_cube(2, CellShape::Tetrahedron, degree))?;
    }
    Ok(())
}

#[test]
fn stokes_flow_converges_on_distorted_cells() {
    for degree in [1, 2] {
        let errors = [6, 12].map(|n| {
            let mesh = distorted(n, CellShape::Quadrilateral, degree);
            errors_of_stokes(
                &mesh,
                (Elements::Lagrange(2), Scope::Nodes),
                (Elements::LinearInSpace, Scope::Cell),
            )
        });
        for (k, expected) in [3.0, 2.0, 2.0].into_iter().enumerate() {
            let order = (errors[0][k] / errors[1][k]).log2();
            println!("Q2/P-1, geometry {degree}: order {order:.2} of {expected}, error {:.2e}", errors[1][k]);
            assert!(order > expected - 0.25, "{order} instead of {expected}");
        }
    }
}

#[test]
fn tangents_are_symmetric_and_of_second_order() {
    let mesh = distorted(3, CellShape::Quadrilateral, 2);
    check_flow(&mesh, (Elements::Lagrange(2), Scope::Nodes), (Elements::LinearInSpace, Scope::Cell));
}

#[test]
fn what_is_not_supported_is_refused_by_name() -> Outcome {
    let mesh = distorted(2, CellShape::Quadrilateral, 1);
    let error = |scope| Space::of(&mesh, Elements::LinearInSpace, scope, &[]).unwrap_err().to_string();
    assert_eq!(
        error(Scope::Nodes),
        "there is no space of elements that are linear in space with continuous values: all their nodes are inside the \
         cell, and no other cell can share them"
    );
    assert!(error(Scope::EachFacet("boundary".into())).contains("do not determine the values there"));
    let space = Space::of(&mesh, Elements::LinearInSpace, Scope::Cell, &[])?;
    let mut held = Constraints::new(&space);
    assert_eq!(
        held.fix("boundary", |_: &[f64; 2]| 0.0).unwrap_err().to_string(),
        "region \"boundary\" has no nodes of the space, which has elements that are linear in space with discontinuous \
         values"
    );
    // Files have its values in each cell.
    let field = Field::interpolate(&space, |x| x[0] - 2.0 * x[1])?;
    let file = tempfile::NamedTempFile::new()?;
    forms_fem::output::VtuFile::new(&mesh).point_data("p", &field)?.write(file.path())?;
    // It is not carried to another mesh.
    let other = Space::discontinuous_scalar(&distorted(3, CellShape::Quadrilateral, 1), 1)?;
    let message = field.onto(&other).interpolated().unwrap_err().to_string();
    assert!(message.contains("elements that are linear in space with discontinuous values"), "{message}");
    Ok(())
}

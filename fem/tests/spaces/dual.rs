//! Multipliers that are dual to Lagrange elements of degree 1 on facets.

use forms_fem::prelude::*;

use crate::shared::*;

#[forms]
mod held {
    pub struct Data {
        pub source: Given<Scalar>,
        pub wanted: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Gamma;

    /// Poisson's equation whose boundary value is imposed by a multiplier.
    pub fn saddle(u: Unknown<Scalar>, l: Unknown<Scalar>, v: Test<Scalar>, m: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)) - source * v) + integral(Gamma, l * v + m * (u - wanted))
    }
    pub fn product(u: Unknown<Scalar>, m: Test<Scalar>) -> Form {
        integral(Gamma, m * u)
    }
    pub fn weight(m: Test<Scalar>) -> Form {
        integral(Gamma, m)
    }
}

fn check_duality<const D: usize>(mesh: &Mesh<D>, dual: Elements, to: Elements) -> Outcome
where
    Dim: Dimension<D>,
{
    let on_facets = |elements| Space::of(mesh, elements, Scope::Facets("boundary".into()), &[]);
    let (dual, linear) = (on_facets(dual)?, on_facets(to)?);
    assert_eq!(dual.positions(), linear.positions());
    let assembler = Assembler::new(mesh);
    let gamma = held::Gamma::on("boundary");
    let data = held::data().source(0.0).wanted(0.0);
    let zero = Field::zero(&linear);
    let matrix = assembler.tangent(&held::product(&data, &gamma), &[&zero], &[&dual])?;
    let weights = assembler.residual(&held::weight(&data, &gamma), &[], &[&linear])?;
    for (node, weight) in weights.iter().enumerate() {
        for (column, value) in row(&matrix, node) {
            let expected = if column == node { *weight } else { 0.0 };
            assert!((value - expected).abs() < 1e-15, "{node} {column}: {value} instead of {expected}");
        }
    }
    Ok(())
}

#[test]
fn functions_are_dual_on_segments_triangles_and_rectangles() -> Outcome {
    for (dual, to) in
        [(Elements::Dual, Elements::Lagrange(1)), (Elements::DualOfBernstein, Elements::Bernstein(2))]
    {
        for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
            let mesh = rectangle([0.0; 2], [1.0, 2.0], [3, 2], shape, 1)?;
            check_duality(&mesh, dual.clone(), to.clone())?;
        }
        for shape in [CellShape::Tetrahedron, CellShape::Hexahedron] {
            let mesh = cuboid([0.0; 3], [1.0, 2.0, 1.5], [2, 2, 1], shape, 1)?;
            check_duality(&mesh, dual.clone(), to.clone())?;
        }
    }
    Ok(())
}

#[test]
fn boundary_values_converge_as_with_usual_multipliers() -> Outcome {
    let exact = |x: &[f64; 2]| (2.0 * x[0]).sin() * (1.5 * x[1]).cos();
    let errors = [8, 16].map(|n| {
        let mesh = distorted(n, CellShape::Triangle, 1);
        let space = Space::scalar(&mesh, 1).unwrap();
        let dual = Space::of(&mesh, Elements::Dual, Scope::Facets("boundary".into()), &[]).unwrap();
        let source = Given::function(move |x: &[f64; 2]| 6.25 * exact(x));
        let data = held::data().source(source).wanted(exact);
        let form = held::saddle(&data, &held::Omega::on("all"), &held::Gamma::on("boundary"));
        let solved = Problem::new(&form, [&space, &dual]).solve().unwrap();
        let value = move |x: &[f64; 2], value: &mut [f64]| value[0] = exact(x);
        norms::errors(&Assembler::new(&mesh), &solved.fields[0], value, |_, slope| slope.fill(0.0))
            .unwrap()
            .l2
    });
    assert!(orders(&errors)[0] > 1.8, "{errors:?}");
    Ok(())
}

#[test]
fn coefficients_are_no_values() -> Outcome {
    let mesh = distorted(2, CellShape::Triangle, 1);
    let refused = Space::of(&mesh, Elements::Dual, Scope::Nodes, &[]).unwrap_err().to_string();
    assert_eq!(
        refused,
        "there is no space of dual elements of degree 1 with continuous values: dual functions and Bernstein's are those of facets"
    );
    let dual = Space::of(&mesh, Elements::Dual, Scope::EachFacet("boundary".into()), &[])?;
    assert_eq!(dual.node_count(), 2 * 8);
    assert_eq!(dual.local_nodes().len(), 8);
    let message = Field::interpolate(&dual, |x| x[0]).unwrap_err().to_string();
    assert!(
        message.starts_with("a space of dual elements of degree 1 interpolates no function"),
        "{message}"
    );
    let message = Constraints::new(&dual).fix("boundary", |_: &[f64; 2]| 0.0).unwrap_err().to_string();
    assert!(message.contains("are not values that can be prescribed"), "{message}");
    Ok(())
}

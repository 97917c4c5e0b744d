//! Bernstein's polynomials of degree 2 on facets: functions that are nowhere negative and have equal integrals, and coefficients that are no values.

use forms_fem::prelude::*;

use crate::shared::*;

#[forms]
mod read {
    pub struct Data {
        pub wanted: Given<Scalar>,
    }
    #[facets]
    pub struct Gamma;
    #[facets(vertices)]
    pub struct Nodes;

    pub fn area(v: Test<Scalar>) -> Form {
        integral(Gamma, v)
    }
    pub fn error(u: State<Scalar>) -> Functional {
        integral(Gamma, sqr(u - wanted))
    }
    pub fn total(u: State<Scalar>) -> Functional {
        integral(Gamma, u)
    }
    /// Σ D_i \[c_i\]₊ v_i of the coefficients c_i.
    pub fn above(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Nodes, pos_part(u) * v)
    }
    pub fn sum(u: State<Scalar>) -> Functional {
        integral(Nodes, u)
    }
    pub fn product(u: State<Scalar>, w: State<Scalar>) -> Functional {
        integral(Nodes, u * w)
    }
}

fn on_facets<const D: usize>(mesh: &Mesh<D>, elements: Elements) -> Arc<Space<D>> {
    Space::of(mesh, elements, Scope::Facets("boundary".into()), &[]).unwrap()
}

fn check<const D: usize>(mesh: &Mesh<D>) -> Outcome
where
    Dim: Dimension<D>,
{
    let (space, lagrange) = (on_facets(mesh, Elements::Bernstein(2)), on_facets(mesh, Elements::Lagrange(2)));
    assert_eq!(space.positions(), lagrange.positions());
    // A polynomial of degree 2 is interpolated, though its coefficients are no values.
    let quadratic = |x: &[f64; D]| 0.3 + x[0] - 2.0 * x[0] * x[1] + 3.0 * x[D - 1] * x[D - 1];
    let u = Field::interpolate(&space, quadratic)?;
    let values = Field::interpolate(&lagrange, quadratic)?;
    assert!(u.values().iter().zip(values.values()).any(|(a, b)| (a - b).abs() > 0.1));
    let regions = read::Regions::default().gamma("boundary").nodes("boundary");
    let model = read::Model { data: read::data().wanted(quadratic), regions };
    let assembler = Assembler::new(mesh);
    assert!(assembler.functional(&model.error(&u))? < 1e-26);
    // All functions of a facet have the same integral, so that sums over nodes are integrals.
    let areas = assembler.residual(&model.area(), &[], &[&space])?;
    let [total, sum] = [model.total(&u), model.sum(&u)].map(|functional| assembler.functional(&functional));
    let (total, sum) = (total?, sum?);
    assert!((total / sum - 1.0).abs() < 1e-13, "{total} {sum}");
    let rough = (0..space.unknowns()).map(|k| (7.0 * k as f64).sin()).collect();
    let rough = Field::from_values(&space, rough)?;
    let form = model.above();
    let residual = assembler.residual(&form, &[&rough], &[&space])?;
    let tangent = assembler.tangent(&form, &[&rough], &[&space])?;
    for (node, area) in areas.iter().enumerate() {
        assert!(*area > 0.0);
        let coefficient = rough.values()[node];
        assert!((residual[node] - area * coefficient.max(0.0)).abs() < 1e-14, "{node}");
        for (column, found) in row(&tangent, node) {
            let expected = if column == node && coefficient > 0.0 { *area } else { 0.0 };
            assert!((found - expected).abs() < 1e-14, "{node} {column}: {found}");
        }
    }
    // Dual functions have coefficients at vertices, and go with Lagrange's of degree 1. Those of degree 2 have other nodes.
    let dual = Field::from_values(
        &on_facets(mesh, Elements::Dual),
        vec![2.0; on_facets(mesh, Elements::Dual).unknowns()],
    )?;
    let three = Field::interpolate(&Space::on_facets(mesh, "boundary", 1)?, |_| 3.0)?;
    let measure: f64 = areas.iter().sum();
    assert!((assembler.functional(&model.product(&dual, &three))? / measure - 6.0).abs() < 1e-12);
    let refused = assembler.functional(&model.product(&u, &three)).unwrap_err();
    let expected = "`w`, which has Lagrange elements of degree 1: give both the same elements";
    assert!(refused.to_string().contains(expected), "{refused}");
    Ok(())
}

#[test]
fn functions_and_sums_over_nodes() -> Outcome {
    for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
        check(&rectangle([0.0; 2], [1.0, 2.0], [3, 2], shape, 1)?)?;
    }
    for shape in [CellShape::Tetrahedron, CellShape::Hexahedron] {
        check(&cuboid([0.0; 3], [1.0, 2.0, 1.5], [2, 2, 1], shape, 1)?)?;
    }
    Ok(())
}

#[test]
fn coefficients_are_no_values() -> Outcome {
    let mesh = distorted(2, CellShape::Triangle, 1);
    let refused = |elements, scope| Space::of(&mesh, elements, scope, &[]).unwrap_err().to_string();
    assert!(refused(Elements::Bernstein(2), Scope::Nodes).ends_with("Bernstein's are those of facets"));
    let degree = refused(Elements::Bernstein(3), Scope::Facets("boundary".into()));
    assert!(degree.contains("no Bernstein elements of degree 3"), "{degree}");
    let space = on_facets(&mesh, Elements::Bernstein(2));
    let message = Constraints::new(&space).fix("boundary", |_: &[f64; 2]| 0.0).unwrap_err().to_string();
    assert!(message.contains("Bernstein elements of degree 2 are not values"), "{message}");
    // Each facet has nodes of its own.
    let jumping = Space::of(&mesh, Elements::Bernstein(2), Scope::EachFacet("boundary".into()), &[])?;
    assert_eq!(jumping.node_count(), 3 * 8);
    let u = Field::interpolate(&jumping, |x| x[0])?;
    for (position, value) in jumping.positions().iter().zip(u.values()) {
        assert!((position[0] - value).abs() < 1e-15);
    }
    Ok(())
}

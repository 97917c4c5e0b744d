//! Integrals over facets by their vertices: sums over nodes, each with its area.

use forms_fem::prelude::*;

#[forms]
mod nodes {
    pub struct Data {
        pub source: Given<Scalar>,
        #[default(0)]
        pub bound: Param,
    }
    #[facets]
    pub struct Gamma;
    #[facets(vertices)]
    pub struct Nodes;

    pub fn area(v: Test<Scalar>) -> Form {
        integral(Gamma, v)
    }
    /// Σ D_i \[u_i − bound\]₊ v_i.
    pub fn above(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Nodes, pos_part(u - bound) * v)
    }
    pub fn sum(u: State<Scalar>) -> Functional {
        integral(Nodes, u * u + source)
    }
}

/// A function of all coordinates.
fn value<const D: usize>(x: &[f64; D]) -> f64 {
    x.iter().enumerate().map(|(k, x)| (2.0 + k as f64) * (3.0 * x).sin()).sum()
}

fn check<const D: usize>(mesh: &Mesh<D>) -> Result<(), AssemblyError>
where
    Dim: Dimension<D>,
{
    let space = Space::on_facets(mesh, "boundary", 1).unwrap();
    let u = Field::interpolate(&space, value).unwrap();
    let model = nodes::Model {
        data: nodes::data().source(1.0).bound(0.5),
        regions: nodes::Regions::default().gamma("boundary").nodes("boundary"),
    };
    // A rule of the assembler changes nothing.
    let assembler = Assembler::new(mesh).with_quadrature(Quadrature::Degree(5));
    let areas = assembler.residual(&model.area(), &[], &[&space])?;
    let form = model.above();
    let residual = assembler.residual(&form, &[&u], &[&space])?;
    let tangent = assembler.tangent(&form, &[&u], &[&space])?;
    let mut sum = 0.0;
    for (node, area) in areas.iter().enumerate() {
        let at_node = u.values()[node];
        assert!((residual[node] - area * (at_node - 0.5).max(0.0)).abs() < 1e-14, "{node}");
        let of_node = if at_node > 0.5 { *area } else { 0.0 };
        let (columns, values) = tangent.row(node);
        for (column, found) in columns.iter().zip(values) {
            let expected = if *column as usize == node { of_node } else { 0.0 };
            assert!((found - expected).abs() < 1e-14, "{node} {column}");
        }
        sum += area * (at_node * at_node + 1.0);
    }
    assert!((assembler.functional(&model.sum(&u))? / sum - 1.0).abs() < 1e-13);
    Ok(())
}

#[test]
fn integrals_by_vertices_are_sums_over_nodes() -> Result<(), AssemblyError> {
    for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
        check(&rectangle([0.0; 2], [1.0, 2.0], [3, 2], shape, 1).unwrap())?;
    }
    for shape in [CellShape::Tetrahedron, CellShape::Hexahedron] {
        check(&cuboid([0.0; 3], [1.0, 2.0, 1.5], [2, 2, 1], shape, 1).unwrap())?;
    }
    Ok(())
}

/// Histories have values at the points of another rule.
#[test]
fn histories_are_refused() {
    let mesh = rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Quadrilateral, 1).unwrap();
    let assembler = Assembler::new(&mesh);
    let history = assembler.history(Entity::Facets, "boundary", 2, 1.0).unwrap();
    let form = remembered::total(&remembered::data().worn(history), &remembered::Nodes::on("boundary"));
    let refused = assembler.functional(&form).unwrap_err();
    assert!(matches!(refused, AssemblyError::History { .. }), "{refused}");
}

#[forms]
mod remembered {
    pub struct Data {
        pub worn: History<Scalar>,
    }
    #[facets(vertices)]
    pub struct Nodes;
    pub fn total() -> Functional {
        integral(Nodes, worn)
    }
}

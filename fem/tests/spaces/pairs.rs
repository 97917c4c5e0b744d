//! All elements on contact pairs: values on both sides, matrices, surfaces that they displace.

use forms_fem::prelude::*;
use forms_fem::verification;

use crate::shared::*;

#[forms]
mod touch {
    pub struct Data {
        pub slope: Given<Vector>,
    }
    #[pairs]
    pub struct Touch;

    pub fn defect(p: State<Scalar>) -> Functional {
        let own = this(p) - dot(this(slope), x);
        integral(
            Touch,
            sqr(own) + sqr(jump(p) + gap * dot(this(slope), toward)) + dot(jump(grad(p)), jump(grad(p))),
        )
    }
    pub fn square(u: State<Scalar>) -> Functional {
        integral(Touch, sqr(jump(u)))
    }
    pub fn glued(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Touch, jump(u) * jump(v))
    }
    pub fn slopes(u: State<Scalar>) -> Functional {
        integral(Touch, dot(jump(grad(u)), jump(grad(u))) + jump(u) * dot(this(grad(u)), n))
    }
    pub fn by_slopes(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Touch, dot(jump(grad(u)), jump(grad(v))) + jump(u) * dot(this(grad(v)), n))
    }
}

#[forms]
mod sliding {
    #[pairs]
    pub struct Touch;

    pub fn overlap(u: State<Vector>) -> Functional {
        integral(Touch(u), gap * gap)
    }
    pub fn pushed(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Touch(u), gap * dot(toward, jump(v)))
    }
}

/// Two unit squares of 3 and 4 distorted cells along each side, one on top of the other, with a gap.
fn blocks(shape: CellShape, degree: usize, gap: f64) -> Mesh<2> {
    let [lower, upper] = [3, 4].map(|n| distorted(n, shape, degree));
    let mut nodes = lower.nodes().to_vec();
    let first = nodes.len() as u32;
    nodes.extend(upper.nodes().iter().map(|x| [x[0], x[1] + 1.0 + gap]));
    let cells = lower.cells().iter().copied().chain(upper.cells().iter().map(|node| node + first)).collect();
    let mut mesh = Mesh::from_parts(shape, degree, nodes, cells).unwrap();
    mesh.name_cells("upper", |x| x[1] > 1.0 + gap / 2.0).unwrap();
    for (name, height, body) in [("below", 1.0, 0.0), ("above", 1.0 + gap, 1.0)] {
        let upper = mesh.cell_region("upper").unwrap().to_vec();
        let of_body = move |cell: u32| f64::from(u8::from(upper.contains(&cell))) == body;
        let wanted =
            |facet: &&Facet| (mesh.facet_centre(**facet)[1] - height).abs() < 1e-9 && of_body(facet.cell);
        let facets: Vec<Facet> = mesh.boundary_facets().iter().filter(wanted).copied().collect();
        mesh.name_listed_facets(name, &facets).unwrap();
    }
    mesh
}

fn kinds(shape: CellShape) -> Vec<(Elements, Scope)> {
    let nodal = |elements: Elements| (elements, Scope::Nodes);
    match shape.is_simplex() {
        true => vec![
            nodal(Elements::Mini(1)),
            nodal(Elements::Mini(2)),
            nodal(Elements::CrouzeixRaviart),
            (Elements::LinearInSpace, Scope::Cell),
        ],
        false => vec![nodal(Elements::Serendipity), (Elements::LinearInSpace, Scope::Cell)],
    }
}

#[test]
fn both_sides_have_the_elements_functions() -> Outcome {
    let region = || touch::Touch::on(Pairing::between("below", "above"));
    for (shape, degree) in
        [(CellShape::Triangle, 1), (CellShape::Quadrilateral, 1), (CellShape::Quadrilateral, 2)]
    {
        let mesh = blocks(shape, degree, 0.25);
        let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(6));
        for (elements, scope) in kinds(shape) {
            let space = Space::of(&mesh, elements.clone(), scope, &[])?;
            let data = touch::data().slope([1.3, -0.6]);
            let linear = Field::interpolate(&space, |x| 1.3 * x[0] - 0.6 * x[1])?;
            // Cells of 9 nodes have a map that serendipity elements do not hold.
            if !(elements == Elements::Serendipity && degree == 2) {
                let defect = assembler.functional(&touch::defect(&data, &region(), &linear))?;
                assert!(defect.abs() < 1e-20, "{elements}: {defect:e}");
            }
            let rough = Field::from_values(&space, noise(space.unknowns()))?;
            for (form, functional) in [
                (touch::glued(&data, &region()), touch::square(&data, &region(), &rough)),
                (touch::by_slopes(&data, &region()), touch::slopes(&data, &region(), &rough)),
            ] {
                let matrix = assembler.tangent(&form, &[&rough], &[&space])?;
                let product = matrix.multiply(rough.values())?;
                let quadratic: f64 = product.iter().zip(rough.values()).map(|(a, b)| a * b).sum();
                let value = assembler.functional(&functional)?;
                assert!((quadratic - value).abs() < 1e-11 * value.abs(), "{elements}: {quadratic} {value}");
            }
        }
    }
    Ok(())
}

#[test]
fn surfaces_are_displaced_by_the_traces() -> Outcome {
    let region = || sliding::Touch::on(Pairing::between("below", "above"));
    let motion = |x: &[f64; 2]| [0.05 * (2.0 * x[1]).sin(), 0.03 * (3.0 * x[0]).cos() * x[1]];
    for (shape, elements, lagrange) in [
        (CellShape::Triangle, Elements::Mini(1), 1),
        (CellShape::Triangle, Elements::Mini(2), 2),
        (CellShape::Quadrilateral, Elements::Serendipity, 2),
    ] {
        let mesh = blocks(shape, 1, 0.1);
        let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(6));
        let space = Space::of(&mesh, elements.clone(), Scope::Nodes, &[2])?;
        let mut values = Field::interpolate(&space, motion)?.values().to_vec();
        // What bubbles have does not show on surfaces.
        for (_, nodes) in space.local_nodes() {
            nodes.iter().for_each(|node| values[2 * *node as usize] += 1.0);
        }
        let u = Field::from_values(&space, values)?;
        let usual = Field::interpolate(&Space::vector(&mesh, lagrange)?, motion)?;
        let [own, other] =
            [&u, &usual].map(|u| assembler.functional(&sliding::overlap(&region(), u)).unwrap());
        assert!((own - other).abs() < 1e-14, "{elements}: {own} {other}");
        let direction = Field::from_values(&space, noise(space.unknowns()))?;
        let report =
            verification::tangent(&assembler, &sliding::pushed(&region()), &[&u], &[&direction], 1e-3)?;
        assert!(report.second_order()? > 1.9, "{elements}");
    }
    let mesh = blocks(CellShape::Triangle, 1, 0.1);
    let space = Space::of(&mesh, Elements::CrouzeixRaviart, Scope::Nodes, &[2])?;
    let refused = Assembler::new(&mesh).functional(&sliding::overlap(&region(), Field::zero(&space)));
    let message = refused.unwrap_err().to_string();
    assert!(message.contains("`u`") && message.contains("traces of Lagrange elements"), "{message}");
    Ok(())
}

#[test]
fn a_space_on_one_body_is_refused_on_both() -> Outcome {
    let mesh = blocks(CellShape::Triangle, 1, 0.1);
    let space = Space::of(&mesh, Elements::Lagrange(1), Scope::Nodes.within("upper"), &[])?;
    let data = touch::data().slope([0.0; 2]);
    let form = touch::glued(&data, &touch::Touch::on(Pairing::between("below", "above")));
    let refused = Assembler::new(&mesh).tangent(&form, &[&Field::zero(&space)], &[&space]);
    let message = refused.unwrap_err().to_string();
    assert!(message.contains("one with continuous values in the cell region \"upper\""), "{message}");
    Ok(())
}

//! Refusals on cut meshes, by name.

use forms_fem::cut::CutError;
use forms_fem::prelude::*;

use crate::{circle, cut, level, square};

fn text<T, E: std::fmt::Display>(result: Result<T, E>) -> String {
    result.err().map(|error| error.to_string()).unwrap_or_default()
}

#[test]
fn level_set_functions_are_checked() {
    let mesh = square(4, CellShape::Triangle);
    let by = |space: &Arc<Space<2>>| text(Assembler::new(&mesh).cut_by(&Field::zero(space)));
    assert!(by(&Space::vector(&mesh, 1).unwrap()).contains("has 2 components"));
    let error = by(&Space::scalar(&mesh, 2).unwrap());
    assert!(error.contains("of degree 2 does not cut cells of the shape Triangle"), "{error}");
    assert!(by(&Space::scalar(&mesh, 3).unwrap()).contains("continuous and of degree 1 or 2"));
    assert!(by(&Space::discontinuous_scalar(&mesh, 1).unwrap()).contains("continuous and of degree 1 or 2"));
    assert!(text(Assembler::new(&mesh).cut_by(&level(&mesh, |_| 1.0))).contains("nowhere negative"));
    let other = square(4, CellShape::Triangle);
    assert_eq!(Assembler::new(&mesh).cut_by(&level(&other, circle)).err(), Some(CutError::OtherMesh));
    let mut named = mesh.clone();
    named.name_cells("inside", |x| x[0] > 0.0).unwrap();
    assert!(text(Assembler::new(&named).cut_by(&level(&named, circle))).contains("has a region \"inside\""));
    let cube = cuboid([0.0; 3], [1.0; 3], [2; 3], CellShape::Tetrahedron, 1).unwrap();
    let error = text(Assembler::new(&cube).cut_by(&Field::zero(&Space::scalar(&cube, 2).unwrap())));
    assert!(error.contains("of degree 2 does not cut cells of the shape Tetrahedron"), "{error}");
}

#[test]
fn curvatures_and_explicit_points_are_refused_on_hexahedra() {
    let cube = cuboid([0.0; 3], [1.0; 3], [2; 3], CellShape::Hexahedron, 1).unwrap();
    let body = cut(&cube, |x| x[0] - 0.3);
    let bent = form!(|| -> Functional { integral(interface("all"), curvature) });
    let error = text(body.functional(&bent));
    assert!(error.contains("the curvature of an interface in hexahedra"), "{error}");
    let explicit = Quadrature::Explicit {
        cell: QuadratureRule { points: vec![[0.5; 3]], weights: vec![1.0] },
        facet: QuadratureRule { points: vec![[0.5; 2]], weights: vec![1.0] },
    };
    let body = body.with_quadrature(explicit);
    let volume = form!(|| -> Functional { integral(cells("all"), 1) });
    assert!(text(body.functional(&volume)).contains("explicit points say nothing about pieces"));
    let rim = form!(|| -> Functional { integral(facets("boundary"), 1) });
    assert!(!text(body.functional(&rim)).is_empty());
}

#[test]
fn interfaces_need_a_cut() {
    let length = form!(|| -> Functional { integral(interface("all"), 1) });
    let error = text(Assembler::new(&square(4, CellShape::Triangle)).functional(&length));
    assert!(error.contains("there is no interface without a level set function"), "{error}");
}

#[test]
fn histories_rules_and_facets_are_refused() {
    let mesh = square(6, CellShape::Triangle);
    let (whole, body) = (Assembler::new(&mesh), cut(&mesh, circle));
    let error = text(body.history(Entity::Cells, "all", 2, 0.0));
    assert!(error.contains("a history is not available on a cut mesh"), "{error}");
    let kept: History<f64, 2> = whole.history(Entity::Cells, "all", 2, 1.0).unwrap();
    let read = form!(|| -> Functional { integral(cells("all"), kept) }, kept: History<Scalar> = kept);
    assert!(whole.functional(&read).is_ok());
    let error = text(body.functional(&read));
    assert!(error.contains("a history is not available on a cut mesh"), "{error}");

    let jumps = form!(
        |u: State<Scalar>, v: Test<Scalar>| integral(interior_facets("interior"), sqr(jump(u)) * avg(v)),
        level_set_derivatives
    );
    let u = Field::zero(&Space::scalar(&mesh, 1).unwrap());
    let one = Field::interpolate(u.space(), |_| 1.0).unwrap();
    let error = text(body.derivative_by_level_set(&jumps(&u), &[], &[&one]));
    assert!(error.contains("the interface passes through an interior facet"), "{error}");

    let area = form!(|| -> Functional { integral(cells("all"), 1) });
    let explicit = Quadrature::Explicit {
        cell: QuadratureRule { points: vec![[1.0 / 3.0; 2]], weights: vec![0.5] },
        facet: QuadratureRule::on_segment(&[(0.5, 1.0)]),
    };
    let error = text(body.clone().with_quadrature(explicit).functional(&area));
    assert!(error.contains("explicit points say nothing about pieces"), "{error}");
    let value = form!(|u: State<Scalar>| -> Scalar { u });
    let error = text(body.at_quadrature_points(&value(&u), Entity::Cells, "all", 2));
    assert!(error.contains("a list of values at quadrature points is not available"), "{error}");
    let zeros = form!(|u: State<Scalar>| -> Scalar { u + x[0] - 0.11 });
    let split = body.split_at_zeros(&zeros(&u), "boundary", 1).unwrap();
    assert!(text(split.functional(&area)).contains("a rule with split facets"));
}

#[test]
fn pairs_need_whole_facets() {
    let below = rectangle([0.0; 2], [1.0; 2], [4, 4], CellShape::Triangle, 1).unwrap();
    let above = rectangle([0.0, 1.1], [1.0, 2.1], [3, 3], CellShape::Triangle, 1).unwrap();
    let mesh = Mesh::of_bodies(&[("below", &below), ("above", &above)]).unwrap();
    let gaps = form!(|| -> Functional { integral(Touch, gap) }, Touch: Pairs = Pairing::between("below top", "above bottom"));
    // A hole that does not reach the surfaces, and one that does.
    let inner = cut(&mesh, |x| 0.2 - (x[0] - 0.5).hypot(x[1] - 0.5));
    let expected = Assembler::new(&mesh).functional(&gaps).unwrap();
    assert!(expected > 0.09 && inner.functional(&gaps).unwrap() == expected);
    let error = text(cut(&mesh, |x| 0.2 - (x[0] - 0.5).hypot(x[1] - 0.9)).functional(&gaps));
    assert!(error.contains("contact pairs need whole facets"), "{error}");
}

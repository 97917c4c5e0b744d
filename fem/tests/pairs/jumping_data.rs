//! Functions of position that jump at the surfaces of pairs: refused wherever kernels read them there, and nowhere else.

use forms_fem::prelude::*;

use super::{cubes, squares};

#[forms(matrix_free)]
mod springs {
    pub struct Data {
        modulus: Given<Scalar>,
    }
    #[pairs]
    pub struct Touch;

    pub fn own(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Touch, this(modulus) * dot(jump(u), jump(v)))
    }
    pub fn opposite(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Touch, other(modulus) * dot(jump(u), jump(v)))
    }
    pub fn sliding(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Touch(u), this(modulus) * gap * dot(toward, jump(v)))
    }
    pub fn total() -> Functional {
        integral(Touch, this(modulus))
    }
    pub fn own_derived() -> Scalar {
        this(modulus) * gap
    }
    pub fn opposite_derived() -> Scalar {
        other(modulus) * gap
    }
}

/// The errors of each door through which this modulus is read, on the own side and last on the opposite one; empty where there is none.
fn told<const D: usize>(
    mesh: &Mesh<D>,
    modulus: impl Fn(&[f64; D]) -> f64 + Send + Sync + 'static,
) -> [String; 8]
where
    Dim: Dimension<D>,
{
    let space = Space::vector(mesh, 1).unwrap();
    let data = springs::data().modulus(modulus);
    let pairing = Pairing::onto("below", "above");
    let touch = springs::Touch::on(pairing.clone());
    let (own, opposite) = (springs::own(&data, &touch), springs::opposite(&data, &touch));
    let (sliding, total) = (springs::sliding(&data, &touch), springs::total(&data, &touch));
    let (u, spaces) = (Field::zero(&space), [&space]);
    let assembler = Assembler::new(mesh).with_quadrature(Quadrature::Degree(3));
    [
        assembler.residual(&own, &[&u], &spaces).map(|_| ()),
        assembler.tangent(&own, &[&u], &spaces).map(|_| ()),
        assembler.action(&own, &[&u], &[&u], &spaces).map(|_| ()),
        assembler.residual(&sliding, &[&u], &spaces).map(|_| ()),
        assembler.functional(&total).map(|_| ()),
        assembler.at_pairs(&springs::own_derived(&data), &pairing, 3).map(|_| ()),
        assembler.residual(&opposite, &[&u], &spaces).map(|_| ()),
        assembler.at_pairs(&springs::opposite_derived(&data), &pairing, 3).map(|_| ()),
    ]
    .map(|outcome| outcome.map_or_else(|error| error.to_string(), |()| String::new()))
}

#[test]
fn at_every_door() {
    let still = |x| x;
    let mesh = squares([CellShape::Quadrilateral; 2], 1, [&still, &still]);
    // The own surface counts as the upper body's.
    let wrong_below = told(&mesh, |x| if x[1] > 1.0 - 1e-9 { 100.0 } else { 1.0 });
    for error in &wrong_below[..6] {
        assert!(error.contains("`modulus` jumps at the surface \"below\""), "{error}");
        assert!(error.contains("it is 100 on it and 1 in the cell behind it"), "{error}");
    }
    assert!(wrong_below[6..].iter().all(String::is_empty), "{wrong_below:?}");
    // The opposite one counts as the lower body's.
    let wrong_above = told(&mesh, |x| if x[1] > 1.0 + 1e-9 { 100.0 } else { 1.0 });
    assert!(wrong_above[..6].iter().all(String::is_empty), "{wrong_above:?}");
    for error in &wrong_above[6..] {
        assert!(error.contains("`modulus` jumps at the surface \"above\""), "{error}");
    }
}

/// A jump on a part of each facet, next to its centre.
#[test]
fn beside_the_centres_of_facets() {
    let still = |x| x;
    let mesh = squares([CellShape::Quadrilateral; 2], 1, [&still, &still]);
    let part = |x: &[f64; 2]| if x[1] > 1.0 - 1e-9 && (3.0 * x[0]).fract() < 0.4 { 100.0 } else { 1.0 };
    assert!(told(&mesh, part)[0].contains("jumps at the surface \"below\""));
    let still = |x| x;
    let mesh = cubes(CellShape::Tetrahedron, 1, [&still, &still]);
    let part = |x: &[f64; 3]| if x[2] > 1.0 - 1e-9 && (2.0 * x[0]).fract() < 0.25 { 100.0 } else { 1.0 };
    assert!(told(&mesh, part)[0].contains("jumps at the surface \"below\""));
}

/// Smooth functions are none that jump: not where they vanish, and not with an infinite slope.
#[test]
fn smooth_functions_that_vanish_on_the_surface() {
    let still = |x| x;
    let mesh = squares([CellShape::Triangle; 2], 1, [&still, &still]);
    for smooth in [
        |x: &[f64; 2]| 1e3 * (x[1] - 1.0),
        |x: &[f64; 2]| (1.0 - x[1]).abs().sqrt(),
        |x: &[f64; 2]| 1e3 * (x[1] - 1.0).powi(2),
    ] {
        assert!(told(&mesh, smooth).iter().all(String::is_empty));
    }
}

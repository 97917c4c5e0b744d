//! Blocks of rubber whose pressure is the same everywhere: Newton's method ends, whatever the ratio K/μ.

use forms_fem::prelude::*;
use forms_fem::solve::Solved;

use crate::shared::*;

#[forms(dimension = 2)]
mod rubber {
    pub struct Data {
        pub bulk: Param,
    }
    #[cells]
    pub struct Omega;

    pub fn stored(u: Unknown<Vector>, p: Unknown<Scalar>) -> Energy {
        let F = I + grad(u);
        let J = det(F);
        integral(Omega, (pow(J, -2 / 3) * (inner(F, F) + 1) - 3) / 2 + p * (J - 1) - p * p / (2 * bulk))
    }
}

/// A block between walls, whose right one is moved, pressed by a part of its height: the solution is linear, and its pressure uniform.
fn block(
    (shape, of_u, of_p, scope): &(CellShape, Elements, Elements, Scope),
    (bulk, down, aside): (f64, f64, f64),
) -> Result<Solved<2, 2>, Box<dyn std::error::Error>> {
    let mut mesh = distorted(6, *shape, 1);
    mesh.name_facets("top", "boundary", |x| x[1] > 1.0 - 1e-9)?;
    mesh.name_facets("bottom", "boundary", |x| x[1] < 1e-9)?;
    mesh.name_facets("left", "boundary", |x| x[0] < 1e-9)?;
    mesh.name_facets("right", "boundary", |x| x[0] > 1.0 - 1e-9)?;
    let bodies = Space::of(&mesh, of_u.clone(), Scope::Nodes, &[2])?;
    let pressures = Space::of(&mesh, of_p.clone(), scope.clone(), &[])?;
    let mut held = Constraints::new(&bodies);
    held.fix_component("top", 1, |_| -down)?;
    held.fix_component("bottom", 1, |_| 0.0)?;
    held.fix_component("left", 0, |_| 0.0)?;
    held.fix_component("right", 0, |_| aside)?;
    let form = rubber::Model::new(rubber::data().bulk(bulk)).stored().into();
    Ok(Problem::new(&form, [&bodies, &pressures]).constrained(&held).solve()?)
}

fn pairs() -> [(CellShape, Elements, Elements, Scope); 5] {
    let (squares, triangles) = (CellShape::Quadrilateral, CellShape::Triangle);
    [
        (squares, Elements::Lagrange(2), Elements::LinearInSpace, Scope::Cell),
        (squares, Elements::Lagrange(2), Elements::Lagrange(0), Scope::Body),
        (squares, Elements::Lagrange(1), Elements::Lagrange(0), Scope::Cell),
        (triangles, Elements::Lagrange(2), Elements::Lagrange(1), Scope::Nodes),
        (triangles, Elements::Mini(1), Elements::Lagrange(1), Scope::Nodes),
    ]
}

/// The displacement aside is zero. Next to K its rounding is 10⁻¹² to 10⁻¹⁰ of the displacement down.
#[test]
fn the_rounding_of_a_large_pressure_is_no_motion() -> Outcome {
    for pair in pairs() {
        for bulk in [1e5, 1e6] {
            for down in [1e-1, 1e-2, 1e-4] {
                let solved = block(&pair, (bulk, down, 0.0))?;
                let [u, p] = &solved.fields;
                assert!(solved.iterations() <= 9, "{pair:?} {bulk} {down}: {}", solved.iterations());
                let right = |p: &f64| (p / (-bulk * down) - 1.0).abs() < 1e-9;
                assert!(p.values().iter().all(right), "{pair:?} {bulk} {down}");
                for (u, x) in u.values().chunks(2).zip(u.space().positions()) {
                    let off = u[0].abs().max((u[1] + down * x[1]).abs());
                    assert!(off < 1e-10 * down, "{pair:?} {bulk} {down}: {u:?} at {x:?}");
                }
            }
        }
    }
    Ok(())
}

/// A displacement aside that is small, but not zero, has its digits, or there is no answer.
#[test]
fn a_small_displacement_is_not_taken_for_rounding() {
    for pair in pairs() {
        for (bulk, part) in [(1e5, 1e-9), (1e6, 1e-8), (1e5, 1e-5)] {
            let (down, aside) = (1e-2, 1e-2 * part);
            let Ok(solved) = block(&pair, (bulk, down, aside)) else { continue };
            let u = &solved.fields[0];
            // Bubbles are no values at nodes, and zero here.
            let nodes = u.space().mesh().nodes().len().min(u.values().len() / 2);
            for (u, x) in u.values().chunks(2).zip(u.space().positions()).take(nodes) {
                assert!((u[0] - aside * x[0]).abs() < 1e-6 * aside, "{pair:?} {bulk} {part}: {u:?} at {x:?}");
            }
        }
    }
}

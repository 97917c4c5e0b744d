//! Eigenproblems compared with closed forms: membranes, strings, buckling of columns, bodies that nothing holds.

use std::f64::consts::PI;

use forms_fem::constraints::RigidMap;
use forms_fem::linear_algebra::EigenError;
use forms_fem::prelude::*;
use forms_fem::solve::{Eigenmode, EigenproblemError};

#[forms(dimension = 2)]
mod membrane {
    #[cells]
    pub struct Omega;

    pub fn tension(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)))
    }
    pub fn mass(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, u * v)
    }
}

#[forms]
mod body {
    pub struct Data {
        pub lambda: Param,
        pub mu: Param,
        pub pull: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct End;

    fn stress(w: Vector) -> Tensor {
        lambda * tr(eps(w)) * I + 2 * mu * eps(w)
    }
    pub fn stiffness(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v)))
    }
    pub fn mass(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, dot(u, v))
    }
    pub fn pulled(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        stiffness(u, v) - integral(End, pull * dot(n, v))
    }
    pub fn geometric(u: Unknown<Vector>, v: Test<Vector>, loaded: State<Vector>) -> Form {
        integral(Omega, inner(dot(grad(u), stress(loaded)), grad(v)))
    }
    /// ∫ W(E(u)) with Green's strain E: its tangent about a state has both stiffnesses.
    pub fn stored(u: Unknown<Vector>) -> Energy {
        let strain = (transpose(I + grad(u)) * (I + grad(u)) - I) / 2;
        integral(Omega, lambda / 2 * sqr(tr(strain)) + mu * inner(strain, strain))
    }
}

type Outcome = Result<(), Box<dyn std::error::Error>>;

fn values<const D: usize>(modes: &[Eigenmode<D>]) -> Vec<f64> {
    modes.iter().map(|mode| mode.value).collect()
}

/// π² (k² + l²) with biquadratic elements: of order four, and what is double is double.
#[test]
fn a_square_membrane() -> Outcome {
    let exact = [2.0, 5.0, 5.0, 8.0, 10.0, 10.0, 13.0, 13.0];
    let model = membrane::Model::default();
    let mut errors = vec![];
    for cells in [6, 12] {
        let mesh = rectangle([0.0; 2], [1.0; 2], [cells; 2], CellShape::Quadrilateral, 1)?;
        let space = Space::scalar(&mesh, 2)?;
        let mut rim = Constraints::new(&space);
        rim.fix("boundary", |_| 0.0)?;
        let (tension, mass) = (model.tension(), model.mass());
        let mut problem = Eigenproblem::vibration(&tension, &mass, &space).constrained(&rim);
        let modes = problem.smallest(8)?;
        let found: Vec<f64> = modes.iter().map(|mode| mode.value / PI.powi(2)).collect();
        for (mode, (found, exact)) in modes.iter().zip(found.iter().zip(exact)) {
            assert!(mode.residual < 1e-11 && mode.error_bound < 1e-8 * mode.value, "{mode:?}");
            assert!(*found >= exact, "{found} {exact}");
        }
        for double in [1, 4, 6] {
            assert!((found[double] - found[double + 1]).abs() < 1e-10 * found[double], "{found:?}");
        }
        let assembler = Assembler::new(&mesh);
        for (i, one) in modes.iter().enumerate() {
            let weights = assembler.residual(&mass, &[one.field()], &[&space])?;
            for (j, other) in modes.iter().enumerate() {
                let product: f64 = weights.iter().zip(other.field().values()).map(|(m, x)| m * x).sum();
                assert!((product - f64::from(u8::from(i == j))).abs() < 1e-8, "{i} {j} {product}");
            }
        }
        errors.push(found.iter().zip(exact).map(|(found, exact)| found / exact - 1.0).collect::<Vec<_>>());
        // Between the third and the fourth, from there on.
        let above = values(&problem.above(6.5 * PI * PI, 3)?);
        assert!(
            above.iter().zip(&values(&modes)[3..]).all(|(one, other)| (one - other).abs() < 1e-9 * other)
        );
    }
    for (coarse, fine) in errors[0].iter().zip(&errors[1]) {
        let order = (coarse / fine).log2();
        assert!((order - 4.0).abs() < 0.15, "{order}");
    }
    Ok(())
}

/// A closed string: 0, and (2πk)² twice each; one end is eliminated by relations.
#[test]
fn a_closed_string() -> Outcome {
    let mesh = rectangle([0.0; 2], [1.0, 0.1], [20, 1], CellShape::Quadrilateral, 1)?;
    let space = Space::scalar(&mesh, 2)?;
    let mut closed = Constraints::new(&space);
    closed.periodic("right", "left", &RigidMap::translation([-1.0, 0.0]))?;
    let model = membrane::Model::default();
    let (tension, mass) = (model.tension(), model.mass());
    let mut problem = Eigenproblem::vibration(&tension, &mass, &space).constrained(&closed);
    let modes = problem.above(-1.0, 5)?;
    let found: Vec<f64> = modes.iter().map(|mode| mode.value / (2.0 * PI).powi(2)).collect();
    for (found, exact) in found.iter().zip([0.0, 1.0, 1.0, 4.0, 4.0]) {
        assert!((found - exact).abs() < 1e-3, "{found} {exact}");
    }
    assert!(
        found[0].abs() < 1e-10 && (found[1] - found[2]).abs() < 1e-10 && (found[3] - found[4]).abs() < 1e-10
    );
    for mode in &modes {
        let end = |x| mode.field().evaluate(&[x, 0.05]).map(|value| value[0]);
        assert!((end(0.0)? - end(1.0)?).abs() < 1e-12);
    }
    let refused = problem.smallest(2).map(|modes| values(&modes));
    assert!(matches!(refused, Err(EigenproblemError::ShiftIsEigenvalue { shift: 0.0, .. })), "{refused:?}");
    Ok(())
}

/// Three motions in the plane, six in space, in which nothing is strained.
#[test]
fn bodies_that_nothing_holds() -> Outcome {
    fn motions<const D: usize>(mesh: &Mesh<D>, rigid: usize) -> Outcome
    where
        Dim: Dimension<D>,
    {
        let space = Space::vector(mesh, 1)?;
        let model = body::Model::new(body::data().lambda(1.5).mu(1.0).pull(0.0));
        let (stiffness, mass) = (model.stiffness(), model.mass());
        let mut problem = Eigenproblem::vibration(&stiffness, &mass, &space);
        let modes = problem.above(-1.0, rigid + 2)?;
        let found = values(&modes);
        assert!(found[..rigid].iter().all(|value| value.abs() < 1e-10), "{found:?}");
        assert!(found[rigid] > 0.1, "{found:?}");
        let refused = problem.smallest(2).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(refused.contains("the shift 0e0 is an eigenvalue"), "{refused}");
        Ok(())
    }
    motions(&rectangle([0.0; 2], [2.0, 1.0], [6, 3], CellShape::Triangle, 1)?, 3)?;
    motions(&cuboid([0.0; 3], [2.0, 1.0, 1.0], [4, 2, 2], CellShape::Hexahedron, 1)?, 6)
}

/// Columns held at one end, E = 2, ν = 0: with Euler's load P_E = (2k − 1)² π² E I/4L² the load is P_E/(1 + P_E/κGA + P_E/EA), by
/// Engesser for the shear (κ = 5/6), and because the geometric stiffness takes P I/A from E I where cross sections turn. The energy's
/// tangent about a state, which has both stiffnesses, is indefinite beyond the load.
#[test]
fn columns_under_their_loads() -> Outcome {
    let mut errors = vec![];
    for (height, cells) in [(0.1, [24, 2]), (0.05, [40, 2])] {
        let mesh = rectangle([0.0; 2], [1.0, height], cells, CellShape::Quadrilateral, 1)?;
        let space = Space::vector(&mesh, 2)?;
        let mut clamped = Constraints::new(&space);
        clamped.fix("left", |_| [0.0; 2])?;
        let regions = || body::Regions::default().end("right");
        let model =
            body::Model { data: body::data().lambda(0.0).mu(1.0).pull(-1.0 / height), regions: regions() };
        let loaded = Problem::new(&model.pulled(), &space).constrained(&clamped).solve()?.into_field();
        let (stiffness, geometric) = (model.stiffness(), model.geometric(&loaded));
        let mut problem = Eigenproblem::buckling(&stiffness, &geometric, &space).constrained(&clamped);
        let found = values(&problem.smallest(2)?);
        for (k, found) in (1..).zip(&found) {
            let odd = f64::from(2 * k - 1);
            let euler = odd.powi(2) * PI.powi(2) * 2.0 * height.powi(3) / 12.0 / 4.0;
            let corrections = euler / (5.0 / 6.0 * height) + euler / (2.0 * height);
            let exact = euler / (1.0 + corrections);
            println!("{height} {k}: {found:.6e}, Euler {euler:.6e}, corrected {exact:.6e}");
            assert!((found / exact - 1.0).abs() < 0.05 * corrections, "{k}: {found} {euler} {exact}");
            errors.push(1.0 - found / euler);
        }
        // Pulled instead of pressed: there is no load from that side.
        let other =
            body::Model { data: body::data().lambda(0.0).mu(1.0).pull(1.0 / height), regions: regions() };
        let pulled = Problem::new(&other.pulled(), &space).constrained(&clamped).solve()?.into_field();
        let tension = other.geometric(&pulled);
        let none = Eigenproblem::buckling(&stiffness, &tension, &space)
            .constrained(&clamped)
            .above(-1.5 * found[0], 1)?;
        assert!((none[0].value + found[0]).abs() < 1e-8 * found[0], "{} {}", none[0].value, found[0]);
        // At 99.9 % and 100.1 % of the load the energy's tangent has no negative eigenvalue and one.
        let stored = model.stored();
        let mass = model.mass();
        for (part, negative) in [(0.99, 0), (1.01, 1)] {
            let state = Field::combination(&[(part * found[0], &loaded)])?;
            let mut about =
                Eigenproblem::vibration(&stored, &mass, &space).constrained(&clamped).about(&state);
            let lowest = about.above(-1.0, 2)?;
            let below = lowest.iter().filter(|mode| mode.value < 0.0).count();
            assert_eq!(below, negative, "{part} {:?}", values(&lowest));
        }
    }
    assert!(errors[2] < 0.3 * errors[0], "{errors:?}");
    Ok(())
}

#[test]
fn what_does_not_fit_is_told_by_name() -> Outcome {
    let mesh = rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Triangle, 1)?;
    let space = Space::scalar(&mesh, 1)?;
    let mut rim = Constraints::new(&space);
    rim.fix("boundary", |_| 0.0)?;
    let model = membrane::Model::default();
    let (tension, mass) = (model.tension(), model.mass());
    let mut problem = Eigenproblem::vibration(&tension, &mass, &space).constrained(&rim);
    let few = problem.smallest(2).map(|modes| values(&modes));
    let too_few = EigenError::TooFew { asked: 2, found: 1, shift: 0.0 };
    assert!(matches!(&few, Err(EigenproblemError::Eigen(error)) if *error == too_few), "{few:?}");
    let vectors = Space::vector(&mesh, 1)?;
    let elsewhere = Eigenproblem::vibration(&tension, &mass, &vectors).smallest(1).err();
    assert!(matches!(elsewhere, Some(EigenproblemError::Assembly(_))), "{elsewhere:?}");
    Ok(())
}

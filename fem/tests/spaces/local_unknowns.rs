//! Unknowns of one cell each in eigenproblems and under a condensing solver, compared with forms without them and with LU.

use forms_fem::linear_algebra::{BlockMatrix, Transpose};
use forms_fem::prelude::*;
use forms_fem::solve::{Eigenmode, Elimination, LocalUnknowns, SolverPath};

use crate::shared::Outcome;

/// A nearly incompressible body on a rigid floor by Nitsche's method, whose normal stress reads p.
#[forms(dimension = 2)]
mod resting {
    pub struct Data {
        pub bulk: Param,
        pub gap: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Floor;

    fn stress(u: Vector, p: Scalar) -> Tensor {
        2 * eps(u) - p * I
    }
    fn pressing(u: Vector, p: Scalar) -> Scalar {
        neg_part(dot(stress(u, p) * n, n) + 20 / h * (u[1] + gap))
    }
    pub fn balance(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        integral(Omega, inner(stress(u, p), eps(v)) - q * div(u) - p * q / bulk)
            - integral(Floor, pressing(u, p) * v[1])
    }
}

/// Contact is iterated on few unknowns, whatever unknowns have the pressures, and with the factor of a saddle point.
#[test]
fn nearly_incompressible_bodies_condense() -> Outcome {
    let block = |shape| rectangle([0.0; 2], [2.0, 1.0], [16, 8], shape, 1);
    let pairs = [
        (CellShape::Quadrilateral, Elements::Lagrange(2), Elements::LinearInSpace, Scope::Cell),
        (CellShape::Quadrilateral, Elements::Lagrange(2), Elements::Lagrange(0), Scope::Cell),
        (CellShape::Triangle, Elements::Lagrange(2), Elements::Lagrange(1), Scope::Nodes),
        (CellShape::Triangle, Elements::Mini(1), Elements::Lagrange(1), Scope::Nodes),
    ];
    for (shape, of_u, of_p, scope) in pairs {
        for bulk in [10.0, 1e3, 1e5] {
            let mesh = block(shape)?;
            let bodies = Space::of(&mesh, of_u.clone(), Scope::Nodes, &[2])?;
            let pressures = Space::of(&mesh, of_p.clone(), scope.clone(), &[])?;
            let spaces = [&bodies, &pressures];
            let mut held = Constraints::new(&bodies);
            held.fix("top", |_| [0.0, -0.1])?;
            let data = resting::data().bulk(bulk).gap(|x: &[f64; 2]| 0.2 * (x[0] - 0.9).powi(2));
            let regions = resting::Regions::default().floor("bottom");
            let form = resting::Model { data, regions }.balance();
            let mut lu = LuSolver::default();
            let expected = Problem::new(&form, spaces).constrained(&held).solver(&mut lu).solve()?;
            let check = |solver: &mut dyn LinearSolver| -> Outcome {
                let found = Problem::new(&form, spaces).constrained(&held).solver(&mut *solver).solve()?;
                let report = solver.report().ok_or("no report")?;
                assert_eq!(report.path, Some(SolverPath::Condensed));
                assert_eq!((report.factorisations, report.signed_factorisations), (1, 1));
                let sizes = found.history.iter().map(|step| step.condensed_unknowns);
                assert!(sizes.clone().skip(1).all(|size| size.is_some_and(|size| size < 400)));
                assert!(found.iterations() >= 3 && found.iterations() <= expected.iterations() + 2);
                for (one, other) in found.fields.iter().zip(&expected.fields) {
                    let size = other.values().iter().fold(0.0_f64, |most, value| most.max(value.abs()));
                    let pairs = one.values().iter().zip(other.values());
                    let off = pairs.fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
                    println!("{of_u:?} {of_p:?} {bulk}: {:.1e}", off / size);
                    assert!(off < 1e-12 * size);
                }
                Ok(())
            };
            let mut condensed = CondensedSolver::default();
            check(&mut condensed)?;
            check(&mut LocalUnknowns::around(CondensedSolver::default()))?;
            // Another right-hand side, both ways.
            let fields = expected.fields.each_ref();
            let matrix = BlockMatrix::from(Assembler::new(&mesh).tangent(&form, &fields, &spaces)?);
            let free = [held.homogeneous(), Constraints::new(&pressures)];
            let reduced = Elimination::of(&free.each_ref())?.reduce_matrix(&matrix)?;
            let b: Vec<f64> = (0..reduced.rows()).map(|k| (k as f64 * 0.7).sin()).collect();
            lu.set_matrix(reduced.clone())?;
            condensed.set_matrix(reduced)?;
            for transpose in [Transpose::No, Transpose::Yes] {
                let expected = lu.solve_with(&b, 0.0, transpose)?.solution;
                let found = condensed.solve_with(&b, 0.0, transpose)?.solution;
                let size = expected.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
                let off = expected.iter().zip(&found).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
                println!("{transpose:?} {bulk}: {:.1e}", off / size);
                assert!(off < 1e-12 * size);
            }
            assert_eq!(condensed.report().path, Some(SolverPath::Condensed));
        }
    }
    Ok(())
}

/// A nearly incompressible body with one pressure per cell, and with the same strains in displacements only.
#[forms]
mod pressed {
    pub struct Data {
        pub bulk: Param,
        pub pull: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct End;

    pub fn stiffness(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        integral(Omega, 2 * inner(eps(u), eps(v)) - p * div(v) - q * div(u) - p * q / bulk)
    }
    pub fn mass(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        integral(Omega, dot(u, v) + 0 * p * q)
    }
    pub fn pulled(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        stiffness(u, p, v, q) - integral(End, pull * dot(n, v))
    }
    pub fn geometric(
        u: Unknown<Vector>,
        p: Unknown<Scalar>,
        v: Test<Vector>,
        q: Test<Scalar>,
        w: State<Vector>,
        s: State<Scalar>,
    ) -> Form {
        integral(Omega, inner(dot(grad(u), 2 * eps(w) - s * I), grad(v)) + 0 * p * q)
    }

    /// The same with the mean of div u over each cell.
    fn spread(u: Vector) -> Scalar {
        mean(div(u))
    }
    pub fn averaged_stiffness(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, 2 * inner(eps(u), eps(v)) + bulk * spread(u) * spread(v))
    }
    pub fn averaged_mass(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, dot(u, v))
    }
    pub fn averaged_geometric(u: Unknown<Vector>, v: Test<Vector>, w: State<Vector>) -> Form {
        integral(Omega, inner(dot(grad(u), 2 * eps(w) + bulk * spread(w) * I), grad(v)))
    }
}

/// Pressures are eliminated: vibrations and buckling have the eigenvalues and modes of the form without pressures.
#[test]
fn pressures_of_cells_are_eliminated() -> Outcome {
    let mesh = rectangle([0.0; 2], [1.0, 0.2], [12, 3], CellShape::Quadrilateral, 1)?;
    let (bodies, pressures) = (Space::vector(&mesh, 2)?, Space::discontinuous_scalar(&mesh, 0)?);
    let spaces = [&bodies, &pressures];
    let mut clamped = Constraints::new(&bodies);
    clamped.fix("left", |_| [0.0; 2])?;
    for bulk in [1e2, 1e5] {
        let data = pressed::data().bulk(bulk).pull(-1.0);
        let model = pressed::Model { data, regions: pressed::Regions::default().end("right") };
        let loaded = Problem::new(&model.pulled(), spaces).constrained(&clamped).solve()?;
        let [w, s] = &loaded.fields;
        let agree = |mixed: &[Eigenmode<2, 2>], plain: &[Eigenmode<2>]| {
            for (one, other) in mixed.iter().zip(plain) {
                let off = (one.value / other.value - 1.0).abs();
                println!("K = {bulk}: {} and {}, {off:.1e}", one.value, other.value);
                assert!(off < 1e-12 * bulk.max(1e4), "{} is not {}", one.value, other.value);
                assert!(one.residual < 1e-9 && one.error_bound < 1e-7 * one.value, "{one:?}");
                let [u, v] = [one.fields[0].values(), other.field().values()];
                let sign = u.iter().zip(v).map(|(a, b)| a * b).sum::<f64>().signum();
                let size = v.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
                assert!(u.iter().zip(v).all(|(a, b)| (a - sign * b).abs() < 1e-6 * size));
                // p = −K times the mean of div u; the fields are those of the whole problem.
                assert!(one.fields[1].values().iter().any(|p| *p != 0.0));
            }
        };
        let (stiffness, mass) = (model.stiffness(), model.mass());
        let (plain, plain_mass) = (model.averaged_stiffness(), model.averaged_mass());
        let mut vibration = Eigenproblem::vibration(&stiffness, &mass, spaces).constrained(&clamped);
        let modes = vibration.smallest(4)?;
        assert_eq!(vibration.local_unknowns().map(|counts| counts.eliminated), Some(36));
        let mut of_plain = Eigenproblem::vibration(&plain, &plain_mass, &bodies).constrained(&clamped);
        agree(&modes, &of_plain.smallest(4)?);
        let mut buckling =
            Eigenproblem::buckling(&stiffness, &model.geometric(w, s), spaces).constrained(&clamped);
        let modes = buckling.smallest(2)?;
        assert_eq!(buckling.local_unknowns().map(|counts| counts.eliminated), Some(36));
        let of_plain = model.averaged_geometric(w);
        let mut of_plain = Eigenproblem::buckling(&plain, &of_plain, &bodies).constrained(&clamped);
        agree(&modes, &of_plain.smallest(2)?);
    }
    Ok(())
}

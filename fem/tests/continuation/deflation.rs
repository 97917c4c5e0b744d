//! Deflation: all roots of a polynomial, and the solutions of the Allen–Cahn equation.

use std::f64::consts::PI;

use forms_fem::prelude::*;
use forms_fem::solve::NewtonFailure;

use crate::limit_points::strip;

type Outcome = Result<(), Box<dyn std::error::Error>>;

#[test]
fn all_roots_of_a_polynomial() -> Outcome {
    let mesh = rectangle([0.0; 2], [1.0; 2], [1, 1], CellShape::Quadrilateral, 1)?;
    let space = Space::of(&mesh, Elements::Lagrange(0), Scope::Cell, &[])?;
    let form = form!(|u: Unknown<Scalar>, v: Test<Scalar>| {
        integral(cells("all"), u * (u * u - 1) * (u * u - 4) * v)
    });
    let start = Field::interpolate(&space, |_| 0.6)?;
    let (mut known, mut roots) = (Deflation::new(), vec![]);
    let failure = loop {
        match Problem::new(&form, &space).start(&start).deflated(&known).solve() {
            Ok(solved) => {
                roots.push(solved.field().values()[0]);
                // The criterion of convergence is that of the polynomial itself.
                assert!(solved.history.last().is_some_and(|last| last.residual < 1e-9));
                known.add(solved.field());
            }
            Err(error) => break error.why,
        }
        assert!(roots.len() < 6, "{roots:?}");
    };
    println!("{roots:?}, then {failure}");
    roots.sort_by(f64::total_cmp);
    let exact = [-2.0, -1.0, 0.0, 1.0, 2.0];
    assert_eq!(roots.len(), 5, "{roots:?} {failure}");
    assert!(roots.iter().zip(exact).all(|(root, exact)| (root - exact).abs() < 1e-9), "{roots:?}");
    Ok(())
}

/// The amplitude of the solution of ε² u″ = u³ − u with n half waves on (0, 1): a² = 2 k²/(1 + k²) where 2 n ε √(1 + k²) K(k) = 1.
fn amplitude(epsilon: f64, half_waves: f64) -> f64 {
    let elliptic = |k: f64| {
        let (mut a, mut b) = (1.0, (1.0 - k * k).sqrt());
        for _ in 0..40 {
            (a, b) = (0.5 * (a + b), (a * b).sqrt());
        }
        PI / (2.0 * a)
    };
    let (mut low, mut high) = (0.0_f64, 1.0_f64);
    for _ in 0..80 {
        let k = 0.5 * (low + high);
        let length = 2.0 * half_waves * epsilon * (1.0 + k * k).sqrt() * elliptic(k);
        if length < 1.0 { low = k } else { high = k }
    }
    (2.0 * low * low / (1.0 + low * low)).sqrt()
}

/// Below ε = 1/(nπ) there are 2n + 1 solutions: 0 and, of each number of half waves up to n, one of each sign.
#[test]
fn the_solutions_of_the_allen_cahn_equation() -> Outcome {
    let (space, ends) = strip(16)?;
    for (epsilon, count) in [(0.2_f64, 3), (0.12, 5)] {
        let form = form!(
            |u: Unknown<Scalar>, v: Test<Scalar>| {
                integral(cells("all"), sqr(epsilon) * dot(grad(u), grad(v)) + (u * u * u - u) * v)
            },
            epsilon: Param,
        );
        let start = Field::interpolate(&space, |x| {
            0.5 * (x[0] * (1.0 - x[0]) * (1.3 - x[0])) + 0.1 * (2.0 * PI * x[0]).sin()
        })?;
        let mut known = Deflation::new();
        let mut found: Vec<(usize, f64)> = vec![];
        while let Ok(solved) =
            Problem::new(&form, &space).constrained(&ends).start(&start).deflated(&known).solve()
        {
            let u = solved.field();
            let largest = u.values().iter().fold(0.0_f64, |most, u| most.max(u.abs()));
            let values = (1..64).map(|k| u.evaluate(&[f64::from(k) / 64.0, 0.05]).map(|u| u[0]));
            let values: Vec<f64> = values.collect::<Result<_, _>>()?;
            let half_waves = match largest < 1e-6 {
                true => 0,
                false => 1 + values.windows(2).filter(|pair| pair[0] * pair[1] < 0.0).count(),
            };
            let exact = if half_waves == 0 { 0.0 } else { amplitude(epsilon, half_waves as f64) };
            assert!((largest - exact).abs() < 2e-3, "{half_waves}: {largest} {exact}");
            found.push((half_waves, values[3].signum() * largest));
            known.add(u);
            assert!(found.len() <= count, "{found:?}");
        }
        println!("ε = {epsilon}: {found:?}");
        for (number, (waves, value)) in found.iter().enumerate() {
            let again = found[..number].iter().any(|(w, v)| w == waves && (v - value).abs() < 1e-3);
            assert!(!again, "{found:?}");
        }
        assert!(found.len() >= 3, "{found:?}");
        assert!(count > 3 || found.len() == count, "{found:?}");
    }
    Ok(())
}

#[test]
fn known_solutions_are_refused() -> Outcome {
    let mesh = rectangle([0.0; 2], [1.0; 2], [1, 1], CellShape::Quadrilateral, 1)?;
    let space = Space::of(&mesh, Elements::Lagrange(0), Scope::Cell, &[])?;
    let form = form!(|u: Unknown<Scalar>, v: Test<Scalar>| integral(cells("all"), (u * u * u + u) * v));
    let mut known = Deflation::new();
    known.add(&Field::zero(&space));
    let failure = |start: f64| -> Result<NewtonFailure, Box<dyn std::error::Error>> {
        let start = Field::interpolate(&space, |_| start)?;
        let found = Problem::new(&form, &space).start(&start).deflated(&known).solve();
        Ok(found.err().ok_or("it has no other solution")?.why)
    };
    let why = failure(0.0)?;
    assert!(matches!(why, NewtonFailure::StartsAtKnownSolution { number: 0 }), "{why}");
    failure(0.5)?;
    // A linear problem has one solution.
    let form = form!(|u: Unknown<Scalar>, v: Test<Scalar>| integral(cells("all"), (u - 1) * v));
    let mut known = Deflation::new();
    known.add(Problem::new(&form, &space).solve()?.field());
    let why =
        Problem::new(&form, &space).deflated(&known).solve().err().ok_or("it has no other solution")?.why;
    assert!(matches!(why, NewtonFailure::KnownSolution { number: 0 }), "{why}");
    Ok(())
}

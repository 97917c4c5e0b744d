//! Euler's column, clamped at its foot: the buckling load, and the elastica beyond it.

use std::f64::consts::PI;

use forms_fem::prelude::*;
use forms_fem::solve::{EventKind, Inertia};

#[forms(dimension = 2)]
mod column {
    pub struct Data {
        pub young: Param,
        pub load: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Top;

    /// Young's modulus with ν = 0, so that plane strain has the stiffness of a beam.
    pub fn energy(u: Unknown<Vector>) -> Energy {
        let F = I + grad(u);
        let E = (transpose(F) * F - I) / 2;
        integral(Omega, young / 2 * inner(E, E)) + integral(Top, load * u[1])
    }
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        derivative(energy(u), u, v)
    }
    pub fn by_load(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        derivative(balance(u, v), load, 1)
    }
}

type Outcome = Result<(), Box<dyn std::error::Error>>;

fn space(
    thickness: f64,
    cells: usize,
) -> Result<(Arc<Space<2>>, Constraints<2>), Box<dyn std::error::Error>> {
    let (low, high) = ([-thickness / 2.0, 0.0], [thickness / 2.0, 1.0]);
    let mesh = rectangle(low, high, [1, cells], CellShape::Quadrilateral, 1)?;
    let space = Space::vector(&mesh, 2)?;
    let mut foot = Constraints::new(&space);
    foot.fix("bottom", |_| [0.0; 2])?;
    Ok((space, foot))
}

/// Shear and shortening lower the load by a part that is proportional to (t/L)²: what is left for t → 0 is Euler's load.
#[test]
fn the_buckling_load_of_slender_columns() -> Outcome {
    let mut loads = vec![];
    for (thickness, cells) in [(0.1, 32), (0.05, 64), (0.025, 128)] {
        let (space, foot) = space(thickness, cells)?;
        // Euler's load π² E I / (4 L²), as a pressure on the top.
        let scale = PI * PI * thickness.powi(2) / 48.0;
        let pressures = |pressure: f64| {
            let model = column::Model::new(column::data().young(1.0).load(pressure));
            [model.balance(), model.by_load()]
        };
        let branch = Continuation::new(&space, pressures)
            .constrained(&foot)
            .step(0.4 * scale)
            .within(0.0..=1.3 * scale)
            .run(|_, _| Ok(()))?;
        let [event] = &branch.events[..] else {
            return Err(format!("{} events", branch.events.len()).into());
        };
        assert_eq!(event.kind, EventKind::Bifurcation { eigenvalues: 1 });
        assert!(event.uncertainty < 2e-8 * scale, "{}", event.uncertainty / scale);
        assert_eq!(branch.points[0].inertia, Inertia::NegativeEigenvalues(0));
        assert_eq!(branch.points.last().map(|point| point.inertia), Some(Inertia::NegativeEigenvalues(1)));
        loads.push(event.parameter / scale);
    }
    let orders = ((1.0 - loads[0]) / (1.0 - loads[1])).log2();
    let extrapolated = loads[2] + (loads[2] - loads[1]) / 3.0;
    println!("loads in units of Euler's {loads:?}, order {orders}, extrapolated {extrapolated}");
    assert!((orders - 2.0).abs() < 0.05, "{loads:?}");
    assert!((extrapolated - 1.0).abs() < 1e-4, "{loads:?} {extrapolated}");
    Ok(())
}

/// K(k), by the arithmetic-geometric mean.
fn complete_elliptic(k: f64) -> f64 {
    let (mut a, mut b) = (1.0, (1.0 - k * k).sqrt());
    for _ in 0..40 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    PI / (2.0 * a)
}

/// The elastica of a clamped column: P/P₀ = (2 K(k)/π)², sway 2 k L / K(k). Both halves of the branch have it.
#[test]
fn the_branch_of_the_elastica() -> Outcome {
    let mut errors = vec![];
    // Shear and shortening change the ratio by a part of the order (t/L)².
    for (thickness, cells) in [(0.1, 32), (0.05, 64)] {
        errors.push(error_of_elastica(thickness, cells)?);
    }
    println!("largest errors of the load: {errors:?}");
    assert!(errors[1] < 0.3 * errors[0] && errors[1] < 2.5e-3, "{errors:?}");
    Ok(())
}

/// The largest error of P/P₀ on both halves of the branch, up to a sway of about half the length.
fn error_of_elastica(thickness: f64, cells: usize) -> Result<f64, Box<dyn std::error::Error>> {
    let (space, foot) = space(thickness, cells)?;
    let scale = PI * PI * thickness.powi(2) / 48.0;
    let forms = |pressure: f64| {
        let model = column::Model::new(column::data().young(1.0).load(pressure));
        [model.balance(), model.by_load()]
    };
    let straight = Continuation::new(&space, forms)
        .constrained(&foot)
        .step(0.4 * scale)
        .within(0.0..=1.3 * scale)
        .run(|_, _| Ok(()))?;
    let fork = straight.bifurcations().next().ok_or("no bifurcation")?;
    let (mut sides, mut largest) = (vec![], 0.0_f64);
    for amplitude in [0.05, -0.05] {
        let bent = Continuation::new(&space, forms)
            .constrained(&foot)
            .switched(fork, 0, amplitude)
            .step(0.01 * scale)
            .until(|_, solved| solved.field().evaluate(&[0.0, 1.0]).is_ok_and(|u| u[0].abs() > 0.5))
            .run(|_, solved| Ok(solved.field().evaluate(&[0.0, 1.0])?[0]))?;
        assert!(bent.points.len() > 3 && bent.events.is_empty(), "{:?}", bent.points);
        for point in &bent.points {
            let sway = point.measured.abs();
            let (mut low, mut high) = (0.0, 0.7);
            for _ in 0..60 {
                let k = 0.5 * (low + high);
                if 2.0 * k / complete_elliptic(k) < sway { low = k } else { high = k }
            }
            let exact = (2.0 * complete_elliptic(low) / PI).powi(2);
            let found = point.parameter / fork.parameter;
            largest = largest.max((found - exact).abs());
            assert_eq!(point.inertia, Inertia::NegativeEigenvalues(0));
        }
        sides.push(bent.points.last().ok_or("no point")?.measured.signum());
    }
    assert_eq!(sides[0], -sides[1]);
    Ok(largest)
}

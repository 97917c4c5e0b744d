//! Bratu's problem u″ + λ eᵘ = 0 on (0, 1), whose limit point is known: one field, and two.

use forms_fem::prelude::*;
use forms_fem::solve::{BranchEnd, Inertia};

#[forms(dimension = 2)]
pub mod bratu {
    pub struct Data {
        pub rate: Param,
    }
    #[cells]
    pub struct Omega;

    pub fn balance(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)) - rate * exp(u) * v)
    }
    pub fn by_rate(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        derivative(balance(u, v), rate, 1)
    }
    /// The same with w = u as an unknown of its own, so that the tangent is not symmetric.
    pub fn balance_of_two(u: Unknown<Scalar>, w: Unknown<Scalar>, v: Test<Scalar>, q: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)) - rate * exp(w) * v + (w - u) * q)
    }
    pub fn by_rate_of_two(u: Unknown<Scalar>, w: Unknown<Scalar>, v: Test<Scalar>, q: Test<Scalar>) -> Form {
        derivative(balance_of_two(u, w, v, q), rate, 1)
    }
    /// λ is no factor of the whole rate here.
    pub fn wrong_rate(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, exp(u) * v)
    }
    pub fn adjoint(p: Unknown<Scalar>, q: Test<Scalar>, u: State<Scalar>) -> Form {
        derivative(balance(u, p), u, q) + integral(Omega, q)
    }
    pub fn total(u: State<Scalar>) -> Functional {
        integral(Omega, u)
    }
    pub fn by_rate_of_total(u: State<Scalar>, p: State<Scalar>) -> Functional {
        integral(Omega, -exp(u) * p)
    }
}

pub type Outcome = Result<(), Box<dyn std::error::Error>>;

pub fn model(rate: f64) -> bratu::Model<2> {
    bratu::Model::new(bratu::data().rate(rate))
}

pub fn strip(cells: usize) -> Result<(Arc<Space<2>>, Constraints<2>), Box<dyn std::error::Error>> {
    let mesh = rectangle([0.0; 2], [1.0, 0.1], [cells, 1], CellShape::Quadrilateral, 1)?;
    let space = Space::scalar(&mesh, 2)?;
    let mut ends = Constraints::new(&space);
    ends.fix("left", |_| 0.0)?;
    ends.fix("right", |_| 0.0)?;
    Ok((space, ends))
}

/// The solutions are u = 2 ln(cosh(θ/4) / cosh((2x − 1) θ/4)) with θ² = 2 λ cosh²(θ/4): λ = θ² / (2 cosh²(θ/4)) is largest where
/// (θ/4) tanh(θ/4) = 1.
fn largest_rate() -> f64 {
    let mut t = 1.2_f64;
    for _ in 0..50 {
        t = 1.0 / t.tanh();
        t = 0.5 * (t + 1.0 / t.tanh());
    }
    8.0 * t * t / t.cosh().powi(2)
}

fn rate_of_middle(middle: f64) -> f64 {
    // u(½) = 2 ln cosh(θ/4).
    let t = (middle / 2.0).exp().acosh();
    8.0 * t * t / t.cosh().powi(2)
}

#[test]
fn the_limit_point_of_bratus_problem() -> Outcome {
    let exact = largest_rate();
    assert!((exact - 3.513_830_719).abs() < 1e-9, "{exact}");
    let mut errors = vec![];
    for cells in [4, 8, 16] {
        let (space, ends) = strip(cells)?;
        let forms = |rate: f64| [model(rate).balance(), model(rate).by_rate()];
        let branch = Continuation::new(&space, forms)
            .constrained(&ends)
            .quadrature(Quadrature::Degree(8))
            .step(1.0)
            .until(|_, solved| solved.field().values().iter().any(|u| *u > 4.0))
            .run(|_, solved| Ok(solved.field().evaluate(&[0.5, 0.05])?[0]))?;
        assert_eq!((branch.end, branch.events.len()), (Some(BranchEnd::Stopped), 1));
        let limit = branch.limit_points().next().ok_or("no limit point")?;
        errors.push((limit.parameter - exact).abs());
        assert!(limit.uncertainty < 2e-8, "{limit:?}");
        // Stable before, with one negative eigenvalue after.
        for (number, point) in branch.points.iter().enumerate() {
            let negative = usize::from(number > limit.after);
            assert_eq!(point.inertia, Inertia::NegativeEigenvalues(negative), "{number}");
            assert_eq!(point.slope > 0.0, negative == 0);
            if number > 0 && cells == 16 {
                let exact = rate_of_middle(point.measured);
                assert!((point.parameter - exact).abs() < 2e-4 * exact, "{point:?} {exact}");
            }
        }
    }
    println!("errors of the limit point: {errors:?}");
    let orders: Vec<f64> = errors.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect();
    assert!(orders.iter().all(|order| *order > 3.7), "{orders:?}");
    assert!(errors[2] < 1e-5);
    Ok(())
}

#[test]
fn two_fields_have_the_same_limit_point() -> Outcome {
    let (space, ends) = strip(16)?;
    let forms = |rate: f64| [model(rate).balance_of_two(), model(rate).by_rate_of_two()];
    let branch = Continuation::new([&space, &space], forms)
        .constrained(&ends)
        .quadrature(Quadrature::Degree(8))
        .within(-1.0..=10.0)
        .points(14)
        .run(|_, solved| Ok(solved.fields[1].evaluate(&[0.5, 0.05])?[0]))?;
    let limit = branch.limit_points().next().ok_or("no limit point")?;
    assert!((limit.parameter - largest_rate()).abs() < 1e-4, "{}", limit.parameter);
    assert!(branch.points.iter().all(|point| matches!(point.inertia, Inertia::Determinant(_))));
    assert_ne!(branch.points[0].inertia, branch.points[limit.after + 1].inertia);
    Ok(())
}

#[test]
fn a_range_ends_at_its_end() -> Outcome {
    let (space, ends) = strip(8)?;
    let forms = |rate: f64| [model(rate).balance(), model(rate).by_rate()];
    let run = |from: f64, step: f64| {
        Continuation::new(&space, forms)
            .constrained(&ends)
            .from(from)
            .step(step)
            .within(0.5..=3.0)
            .run(|_, _| Ok(()))
    };
    for (from, step, end) in [(0.6, 0.3, 3.0), (2.5, -0.3, 0.5)] {
        let branch = run(from, step)?;
        let last = branch.points.last().ok_or("no point")?;
        assert_eq!((last.parameter, branch.end), (end, Some(BranchEnd::Range)));
        assert!(branch.points.len() > 3 && branch.events.is_empty());
    }
    Ok(())
}

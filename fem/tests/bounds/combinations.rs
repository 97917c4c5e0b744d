//! Bounds with solvers, constraints, several fields, load steps; what is refused; what is reported.

use forms_fem::constraints::RigidMap;
use forms_fem::prelude::*;
use forms_fem::solve::{LocalUnknowns, Solved};

use crate::Outcome;

#[forms(dimension = 2)]
mod models {
    pub struct Data {
        /// Force per area.
        pub load: Given<Scalar>,
        /// Velocity that carries u along.
        pub wind: Param,
        /// Weight of u⁴/4.
        pub bed: Param,
    }
    #[cells]
    pub struct Omega;

    pub fn membrane(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)) + wind * grad(u)[0] * v - load * v)
    }
    pub fn on_a_bed(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)) + bed * u * u * u * v - load * v)
    }
    /// A membrane u with a slave s of each cell that follows it.
    pub fn pair(u: Unknown<Scalar>, s: Unknown<Scalar>, v: Test<Scalar>, w: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)) + (u - s) * v - load * v + (2 * s - u) * w)
    }
}

fn model(load: f64, wind: f64) -> models::Model<2> {
    models::Model::new(models::data().load(load).wind(wind).bed(50.0))
}

fn square(count: usize) -> Outcome<(Arc<Space<2>>, Constraints<2>)> {
    let mesh = rectangle([0.0; 2], [1.0; 2], [count; 2], CellShape::Quadrilateral, 1)?;
    let space = Space::scalar(&mesh, 1)?;
    let mut walls = Constraints::new(&space);
    walls.fix("boundary", |_| 0.0)?;
    Ok((space, walls))
}

/// The largest violation of the Karush-Kuhn-Tucker conditions at free unknowns, of bounds low and high, relative to the largest residual.
fn violation(solved: &Solved<2>, walls: &Constraints<2>, [low, high]: [f64; 2]) -> f64 {
    let most = solved.residual.iter().fold(0.0, |most: f64, residual| most.max(residual.abs()));
    let of = |(unknown, u): (usize, &f64)| {
        let residual = solved.residual[unknown] / most;
        match *u {
            _ if walls.is_prescribed(unknown) => 0.0,
            u if u < low || u > high => f64::INFINITY,
            u if u == low => (-residual).max(0.0),
            u if u == high => residual.max(0.0),
            _ => residual.abs(),
        }
    };
    solved.field().values().iter().enumerate().map(of).fold(0.0, f64::max)
}

#[test]
fn every_solver_comes_to_the_same_solution() -> Outcome {
    let (space, walls) = square(12)?;
    let mut bounds = Bounds::new(&space);
    bounds.at_most("all", |_| 0.02)?;
    for wind in [0.0, 20.0] {
        let (affine, bent) = (model(1.0, wind).membrane(), model(1.0, wind).on_a_bed());
        let mut solvers: Vec<Box<dyn LinearSolver>> = vec![
            Box::new(TangentSolver::default()),
            Box::new(LuSolver::default()),
            Box::new(CondensedSolver::default()),
            Box::new(LocalUnknowns::<TangentSolver>::default()),
        ];
        if wind == 0.0 {
            solvers.push(Box::new(MultigridSolver::new(&walls, MultigridSolverOptions::default())?));
        }
        for form in [&affine, &bent] {
            let mut first: Option<Field<2>> = None;
            for solver in &mut solvers {
                let problem = Problem::new(form, &space).constrained(&walls).bounded(&bounds);
                let solved = problem.solver(&mut **solver).solve()?;
                assert!(!solved.held().is_empty());
                assert!(violation(&solved, &walls, [f64::NEG_INFINITY, 0.02]) < 1e-9);
                let first = first.get_or_insert_with(|| solved.field().clone());
                for (u, known) in solved.field().values().iter().zip(first.values()) {
                    assert!((u - known).abs() < 1e-9, "{u} {known}");
                }
            }
        }
    }
    Ok(())
}

#[test]
fn the_analysis_of_the_pattern_is_made_once() -> Outcome {
    let (space, walls) = square(16)?;
    let mut bounds = Bounds::new(&space);
    bounds.at_most("all", |x| 0.02 + 0.02 * x[0])?;
    let form = model(1.0, 0.0).membrane();
    let mut solver = TangentSolver::default();
    let problem = Problem::new(&form, &space).constrained(&walls).bounded(&bounds);
    let solved = problem.solver(&mut solver).solve()?;
    assert!(solved.iterations() > 2);
    assert_eq!(solver.report().analyses, 1);
    assert_eq!(solver.report().lu_factorisations, 0);
    Ok(())
}

#[test]
fn line_searches_keep_iterates_between_the_bounds() -> Outcome {
    let (space, walls) = square(12)?;
    let mut bounds = Bounds::new(&space);
    bounds
        .at_most("all", |_| 0.04)?
        .at_least("all", |x| x[0] * 0.03 * (1.0 - x[0]) * 4.0 * x[1] * (1.0 - x[1]))?;
    let form = model(10.0, 0.0).on_a_bed();
    let mut found = vec![];
    for line_search in [LineSearch::Off, LineSearch::OnPotential, LineSearch::OnResidual] {
        let options = NewtonOptions { line_search, ..NewtonOptions::default() };
        let problem = Problem::new(&form, &space).constrained(&walls).bounded(&bounds);
        found.push(problem.options(options).solve()?.into_field());
    }
    for other in &found[1..] {
        for (a, b) in found[0].values().iter().zip(other.values()) {
            assert!((a - b).abs() < 1e-11, "{a} {b}");
        }
    }
    Ok(())
}

#[test]
fn bounds_of_one_of_several_fields() -> Outcome {
    let (space, walls) = square(8)?;
    let cells = Space::discontinuous_scalar(space.mesh(), 0)?;
    let mut bounds = Bounds::new(&cells);
    bounds.at_most("all", |_| 0.01)?;
    let form = model(1.0, 0.0).pair();
    let solved = Problem::new(&form, [&space, &cells]).constrained(&walls).bounded(&bounds).solve()?;
    assert!(solved.held_of(0).is_empty() && !solved.held_of(1).is_empty());
    let [_, slaves] = &solved.fields;
    assert!(slaves.values().iter().all(|s| *s <= 0.01));
    for one in solved.held_of(1) {
        assert!(slaves.values()[one.unknown] == 0.01 && one.reaction < 0.0);
        assert_eq!(solved.residual[space.unknowns() + one.unknown], one.reaction);
    }
    // The adjoint's constraints hold these and no others.
    assert_eq!(solved.held_at_bounds_of(1)?.prescribed().len(), solved.held_of(1).len());
    assert_eq!(solved.held_at_bounds_of(0)?.prescribed().len(), walls.prescribed().len());
    assert!(solved.held_at_bounds_of(2).is_err());
    Ok(())
}

#[test]
fn a_bound_from_the_last_step_makes_a_field_grow_only() -> Outcome {
    let (space, walls) = square(8)?;
    let mut last = Field::zero(&space);
    for load in [1.0, 3.0, -2.0, 0.5, 4.0] {
        let mut bounds = Bounds::new(&space);
        bounds.at_least_field(&last)?;
        let form = model(load, 0.0).membrane();
        let solved = Problem::new(&form, &space).constrained(&walls).bounded(&bounds).start(&last).solve()?;
        let next = solved.into_field();
        assert!(next.values().iter().zip(last.values()).all(|(next, last)| next >= last));
        last = next;
    }
    // The last load is the largest, and the step the one without a bound.
    let form = model(4.0, 0.0).membrane();
    let free = Problem::new(&form, &space).constrained(&walls).solve()?.into_field();
    assert!(free.values().iter().zip(last.values()).all(|(free, last)| (free - last).abs() < 1e-13));
    Ok(())
}

#[test]
fn periodic_unknowns_pass_their_bounds_on_and_hanging_ones_are_refused() -> Outcome {
    let mesh = rectangle([0.0; 2], [1.0; 2], [6; 2], CellShape::Quadrilateral, 1)?;
    let space = Space::scalar(&mesh, 1)?;
    let mut constraints = Constraints::new(&space);
    constraints.fix("bottom", |_| 0.0)?;
    constraints.periodic("right", "left", &RigidMap::translation([-1.0, 0.0]))?;
    let mut bounds = Bounds::new(&space);
    // The side that the other one gives has the bound.
    bounds.at_most("left", |_| 0.05)?;
    let form = model(1.0, 0.0).membrane();
    let solved = Problem::new(&form, &space).constrained(&constraints).bounded(&bounds).solve()?;
    for x in [[0.0, 0.5], [1.0, 0.5], [0.0, 1.0]] {
        assert!((solved.field().evaluate(&x)?[0] - 0.05).abs() < 1e-15);
    }
    assert!(solved.field().evaluate(&[0.5, 0.5])?[0] > 0.05);

    let mut tied = Constraints::new(&space);
    tied.fix("bottom", |_| 0.0)?;
    tied.mean_value("all", 0, 0.02)?;
    let mut everywhere = Bounds::new(&space);
    everywhere.at_most("all", |_| 0.03)?;
    let error = Problem::new(&form, &space).constrained(&tied).bounded(&everywhere).solve().unwrap_err();
    let text = error.to_string();
    assert!(
        text.contains("it has a bound, but a condition gives it by") && text.contains("is `u` at ["),
        "{text}"
    );
    Ok(())
}

#[test]
fn contradictions_name_unknown_and_place() -> Outcome {
    let (space, walls) = square(4)?;
    let mut bounds = Bounds::new(&space);
    bounds.at_least("left", |_| 0.5)?;
    let form = model(1.0, 0.0).membrane();
    let error =
        Problem::new(&form, &space).constrained(&walls).bounded(&bounds).solve().unwrap_err().to_string();
    assert!(
        error.contains("its value is prescribed as 0, outside of its bounds 0.5 and inf")
            && error.contains("is `u` at [0.0, "),
        "{error}"
    );
    let (other, _) = square(3)?;
    let mut elsewhere = Bounds::new(&other);
    elsewhere.at_least("all", |_| 0.0)?;
    let error = Problem::new(&form, &space).bounded(&elsewhere).solve().unwrap_err().to_string();
    assert!(error.contains("the bounds given for `u` belong to another space"), "{error}");
    Ok(())
}

#[test]
fn unknowns_that_touch_without_a_force_are_reported() -> Outcome {
    let (space, walls) = square(4)?;
    // The bound is the solution at the middle: it touches, and nothing presses.
    let form = model(1.0, 0.0).membrane();
    let free = Problem::new(&form, &space).constrained(&walls).solve()?.into_field();
    let mut bounds = Bounds::new(&space);
    bounds.at_most("all", |_| free.evaluate(&[0.5, 0.5]).map_or(f64::NAN, |u| u[0]))?;
    let solved = Problem::new(&form, &space).constrained(&walls).bounded(&bounds).solve()?;
    assert_eq!(solved.held().iter().map(|one| one.is_weak).collect::<Vec<_>>(), [true]);
    let notes = solved.notes().join("");
    assert!(
        notes.contains("1 unknowns are at a bound that does not act on them, as `u` at [0.5, 0.5]"),
        "{notes}"
    );
    assert_eq!(solved.held_at_bounds()?.prescribed().len(), walls.prescribed().len());
    Ok(())
}

//! Quantities that stay positive: the volume of a block under an extreme load, and the gap under a barrier.

use forms_fem::prelude::*;
use forms_fem::solve::NewtonFailure;

use crate::Outcome;

#[forms(dimension = 2)]
mod block {
    pub struct Data {
        /// Pressure on the top.
        pub load: Param,
        /// Stiffness of the barrier and the gap at which it begins.
        pub barrier: Param,
        pub range: Param,
        /// Height of a flat under the block.
        pub flat: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Top;
    #[facets]
    pub struct Bottom;

    fn stress(u: Vector) -> Tensor {
        let F = I + grad(u);
        F - inv(transpose(F)) + ln(det(F)) * inv(transpose(F))
    }
    pub fn pressed(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), grad(v))) + integral(Top, load * v[1])
    }
    pub fn volume(u: Unknown<Vector>) -> Functional {
        integral(Omega, det(I + grad(u)))
    }
    fn gap(u: Vector) -> Scalar {
        x[1] + u[1] - flat
    }
    /// −b′(g) of b = −(g − ĝ)² ln(g/ĝ) for g < ĝ.
    fn push(u: Vector) -> Scalar {
        let g = min(gap(u), range);
        barrier * (2 * (g - range) * ln(g / range) + sqr(g - range) / g)
    }
    pub fn on_barrier(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), grad(v))) + integral(Top, load * v[1])
            - integral(Bottom, push(u) * v[1])
    }
    pub fn clearance(u: Unknown<Vector>) -> Functional {
        integral(Bottom, gap(u))
    }
    pub fn pushed(u: State<Vector>) -> Functional {
        integral(Bottom, push(u))
    }
}

fn model(load: f64) -> block::Model<2> {
    block::Model::new(block::data().load(load).barrier(100.0).range(0.05).flat(-0.01))
}

fn space() -> Outcome<Arc<Space<2>>> {
    let mesh = rectangle([0.0; 2], [1.0; 2], [6; 2], CellShape::Quadrilateral, 1)?;
    Ok(Space::vector(&mesh, 1)?)
}

#[test]
fn a_block_under_an_extreme_load_keeps_its_cells_from_turning_inside_out() -> Outcome {
    let space = space()?;
    // Between walls, so that the block is pressed evenly.
    let mut held = Constraints::new(&space);
    held.fix_component("bottom", 1, |_| 0.0)?;
    held.fix_component("left", 0, |_| 0.0)?;
    held.fix_component("right", 0, |_| 0.0)?;
    let (form, volume) = (model(6.0).pressed(), model(6.0).volume());
    let problem = || Problem::new(&form, &space).constrained(&held).quadrature(Quadrature::Degree(4));
    // Whole steps turn cells inside out, where there is no energy.
    assert!(problem().solve().is_err());
    let solved = problem().keep_positive(&volume).solve()?;
    assert!(solved.history.iter().any(|step| step.damping.is_some_and(|part| part < 0.9)));
    // s − 1/s + ln(s)/s = −6 for the height s.
    let stress = |s: f64| s - 1.0 / s + s.ln() / s;
    let (mut low, mut high) = (0.1, 1.0);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if stress(middle) < -6.0 { low = middle } else { high = middle }
    }
    for (u, x) in solved.field().values().iter().skip(1).step_by(2).zip(space.positions()) {
        assert!((x[1] + u - low * x[1]).abs() < 1e-9, "{u} at {x:?}, {low}");
    }
    let jacobian = form!(|u: State<Vector>| -> Scalar { det(I + grad(u)) });
    let found =
        solved.assembler().at_quadrature_points(&jacobian(solved.field()), Entity::Cells, "all", 4)?;
    assert!(found.values.iter().all(|value| value[0] > 0.0));
    // With a line search, too.
    let options = NewtonOptions { line_search: LineSearch::OnPotential, ..NewtonOptions::default() };
    let searched = problem().keep_positive(&volume).options(options).solve()?;
    for (a, b) in searched.field().values().iter().zip(solved.field().values()) {
        assert!((a - b).abs() < 1e-8, "{a} {b}");
    }
    Ok(())
}

#[test]
fn a_start_that_is_inside_out_is_refused_by_name_and_place() -> Outcome {
    let space = space()?;
    let form = form!(|u: Unknown<Vector>, v: Test<Vector>| integral(
        cells("all"),
        inner(grad(u), grad(v)) + dot(u, v)
    ));
    let start = Field::interpolate(&space, |x| [0.0, -2.0 * x[1]])?;
    let volume = model(1.0).volume();
    let error = Problem::new(&form, &space).start(&start).keep_positive(&volume).solve().unwrap_err();
    let text = error.to_string();
    assert!(text.contains("`volume`, which was to be kept positive, is -1"), "{text}");
    Ok(())
}

#[test]
fn prescribed_values_may_lead_out_of_a_start_that_is_inside_out() -> Outcome {
    let space = space()?;
    let form = form!(|u: Unknown<Vector>, v: Test<Vector>| integral(cells("all"), inner(grad(u), grad(v))));
    let mut held = Constraints::new(&space);
    held.fix("bottom", |_| [0.0; 2])?;
    held.fix("top", |_| [0.0, 0.1])?;
    let start = Field::interpolate(&space, |x| [0.0, -2.0 * x[1]])?;
    let volume = model(1.0).volume();
    let problem = Problem::new(&form, &space).start(&start).constrained(&held);
    let solved = problem.keep_positive(&volume).solve()?;
    for (u, x) in solved.field().values().chunks_exact(2).zip(space.positions()) {
        assert!(u[0].abs() < 1e-12 && (u[1] - 0.1 * x[1]).abs() < 1e-12, "{u:?} at {x:?}");
    }
    Ok(())
}

/// The forces are no numbers where ln J is none: the report names what was to be kept positive, and where.
#[test]
fn an_infeasible_start_is_told_from_infeasible_conditions() -> Outcome {
    let space = space()?;
    let (form, volume) = (model(0.0).pressed(), model(0.0).volume());
    let start = Field::interpolate(&space, |x| [0.0, if x[1] > 0.9 { -2.0 } else { 0.0 }])?;
    let error = Problem::new(&form, &space).start(&start).keep_positive(&volume).solve().unwrap_err();
    let text = error.to_string();
    assert!(matches!(error.why, NewtonFailure::InfeasibleStart(_)), "{text}");
    // The upper cells have the height 1/6, and their upper side is 2 lower.
    let named = "the start itself is not feasible: `volume`, which was to be kept positive, is -11";
    assert!(text.contains(named) && text.contains(", 0.8"), "{text}");
    let mut held = Constraints::new(&space);
    held.fix("bottom", |_| [0.0; 2])?;
    held.fix("top", |_| [0.0, -2.0])?;
    let error = Problem::new(&form, &space).constrained(&held).keep_positive(&volume).solve().unwrap_err();
    let text = error.to_string();
    assert!(matches!(error.why, NewtonFailure::InfeasibleConditions(_)), "{text}");
    assert!(text.contains("the start is feasible, but not with the prescribed values"), "{text}");
    Ok(())
}

#[test]
fn a_barrier_carries_a_block_on_a_flat() -> Outcome {
    let space = space()?;
    let mut held = Constraints::new(&space);
    held.fix_component("left", 0, |_| 0.0)?;
    let form = model(0.5).on_barrier();
    let clearance = model(0.5).clearance();
    let problem = || Problem::new(&form, &space).constrained(&held).quadrature(Quadrature::Degree(4));
    let solved = problem().keep_positive(&clearance).keep_positive(&model(0.5).volume()).solve()?;
    let model = model(0.5);
    let pushed = solved.functional(&model.pushed(solved.field()))?;
    assert!((pushed - 0.5).abs() < 1e-9, "{pushed}");
    assert!(
        solved
            .field()
            .values()
            .iter()
            .skip(1)
            .step_by(2)
            .zip(space.positions())
            .all(|(u, x)| x[1] + u > -0.01)
    );
    Ok(())
}

/// The top is moved down at once by more than the gap, outside of the barrier's range: first steps take the body along, and keep the gap open.
#[test]
fn a_prescribed_way_that_closes_a_gap_at_once_is_taken_in_parts() -> Outcome {
    let space = space()?;
    let data = block::data().load(0.0).barrier(100.0).range(0.05).flat(-0.1);
    let model = block::Model::new(data);
    let form = model.on_barrier();
    for (way, prescribed_values) in
        [(0.2, PrescribedValues::AtOnce), (0.2, PrescribedValues::ByTangent), (0.6, PrescribedValues::AtOnce)]
    {
        // Between walls, so that the block is pressed evenly.
        let mut held = Constraints::new(&space);
        held.fix_component("left", 0, |_| 0.0)?;
        held.fix_component("right", 0, |_| 0.0)?;
        held.fix_component("top", 1, |_| -way)?;
        let problem = Problem::new(&form, &space).constrained(&held).quadrature(Quadrature::Degree(4));
        let problem = problem.options(NewtonOptions { prescribed_values, ..NewtonOptions::default() });
        let solved = problem.keep_positive(&model.clearance()).keep_positive(&model.volume()).solve()?;
        assert!(solved.history[0].damping.is_some_and(|part| part < 1.0), "{way}");
        // The height 1 − way + 0.1 − g of the block, and the barrier's pressure at the gap g, balance.
        let stress = |s: f64| s - 1.0 / s + s.ln() / s;
        let push = |g: f64| 100.0 * (2.0 * (g - 0.05) * (g / 0.05).ln() + (g - 0.05).powi(2) / g);
        let (mut low, mut high) = (1e-9, 0.05);
        for _ in 0..200 {
            let g: f64 = 0.5 * (low + high);
            if stress(1.1 - way - g) + push(g) > 0.0 { low = g } else { high = g }
        }
        let pushed = solved.functional(&model.pushed(solved.field()))?;
        assert!((pushed / push(low) - 1.0).abs() < 1e-8, "{way}: {pushed} {}", push(low));
        for (u, x) in solved.field().values().iter().skip(1).step_by(2).zip(space.positions()) {
            let expected = low - 0.1 + (1.1 - way - low) * x[1] - x[1];
            assert!((u - expected).abs() < 1e-9, "{way}: {u} {expected} at {x:?}");
        }
    }
    Ok(())
}

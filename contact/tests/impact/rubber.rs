//! A thrown and spinning block of rubber on a flat: balances of energy, momentum and, before it touches, angular momentum.

use forms_contact::finite_impact::finite_impact;
use forms_fem::prelude::*;
use forms_fem::time::{GeneralisedAlpha, State, Step, TimeLoop};

use super::{Outcome, Pressure};

/// A square of rubber above a flat, with γ₀.
fn rubber_with(
    gamma0: f64,
    step: forms_fem::time::operators::vector::Data<2>,
    direction: [f64; 2],
) -> finite_impact::Model<2> {
    let body = finite_impact::data_from(step)
        .lambda(4.0)
        .mu(1.0)
        .gamma0(gamma0)
        .rho(1.0)
        .obstacle_normal([0.0, -1.0])
        .gap(|x: &[f64; 2]| x[1] + 0.1);
    let data = body.friction(0.4).body_force([0.0, -0.1]).direction(direction);
    finite_impact::Model { data, regions: finite_impact::Regions::default().gamma_c("boundary") }
}

/// With γ₀ = 100 steps of any size end in cells that turn inside out.
fn rubber(step: forms_fem::time::operators::vector::Data<2>, direction: [f64; 2]) -> finite_impact::Model<2> {
    rubber_with(400.0, step, direction)
}

/// In flight, with γ₀ so large that Nitsche's terms vanish, the angular momentum about the body's centre is constant.
#[test]
fn rubber_that_flies_keeps_its_spin() -> Outcome {
    let mesh = rectangle([0.0; 2], [1.0; 2], [3; 2], CellShape::Quadrilateral, 1)?;
    let space = Space::vector(&mesh, 1)?;
    let assembler = Assembler::new(space.mesh()).with_quadrature(Quadrature::Degree(4));
    let velocity = Field::interpolate(&space, |x| [0.6 + 1.5 * (x[1] - 0.5), 0.5 - 1.5 * (x[0] - 0.5)])?;
    let start = State::new(0.0, Field::zero(&space), velocity)?;
    let model = |step| rubber_with(1e13, step, [0.0; 2]);
    let form = |step: &Step<2>| model(step.into()).conserving(&step.before.value);
    let options =
        NewtonOptions { absolute_tolerance: 1e-13, relative_tolerance: 1e-13, ..NewtonOptions::default() };
    let mut motion =
        TimeLoop::new(form, GeneralisedAlpha::mid_point(), start).assembler(&assembler).options(options);
    let spin = |state: &State<2>| -> Outcome<f64> {
        let mean =
            |axis| assembler.functional(&rubber_with(1e13, Default::default(), axis).momentum(&state.value));
        let mut of = model(Default::default());
        of.data.centre = Given::constant([0.5 + mean([1.0, 0.0])?, 0.5 + mean([0.0, 1.0])?]);
        Ok(assembler.functional(&of.spin(&state.value, &state.rate))?)
    };
    let first = spin(motion.state())?;
    assert!((first + 0.25).abs() < 1e-12, "−1.5 / 6: {first}");
    for _ in 0..20 {
        motion.take(0.1)?;
        let found = spin(motion.state())?;
        assert!((found - first).abs() < 1e-11, "{found} after {first}");
    }
    // It has turned by more than a radian, and is stretched.
    let model = model(Default::default());
    let stored = assembler.functional(&model.energy(&motion.state().value, Field::zero(&space)))?;
    assert!(stored.is_finite() && motion.state().value.values()[1].abs() > 0.5);
    Ok(())
}

#[test]
fn rubber_on_a_flat_keeps_its_balances() -> Outcome {
    let mesh = rectangle([0.0; 2], [1.0; 2], [3; 2], CellShape::Quadrilateral, 1)?;
    let space = Space::vector(&mesh, 1)?;
    let assembler = Assembler::new(space.mesh()).with_quadrature(Quadrature::Degree(4));
    let of = |direction| rubber(Default::default(), direction);
    let (size, weight) = (0.01, [0.0, -0.1]);
    for pressure in [Pressure::Hybrid, Pressure::Conserving] {
        // Thrown, with a spin of −½ about the middle.
        let velocity = Field::interpolate(&space, |x| [0.6 + 0.5 * (x[1] - 0.5), -0.3 - 0.5 * (x[0] - 0.5)])?;
        let start = State::new(0.0, Field::zero(&space), velocity)?;
        let mid_point = GeneralisedAlpha::mid_point();
        let conserving = |step: &Step<2>| rubber(step.into(), [0.0; 2]).conserving(&step.before.value);
        let hybrid = |step: &Step<2>| rubber(step.into(), [0.0; 2]).hybrid(&step.before.value);
        let options = NewtonOptions {
            absolute_tolerance: 1e-13,
            relative_tolerance: 1e-13,
            ..NewtonOptions::default()
        };
        let mut motion = match pressure {
            Pressure::Conserving => TimeLoop::new(conserving, mid_point, start),
            Pressure::Hybrid => TimeLoop::new(hybrid, mid_point, start),
        }
        .assembler(&assembler)
        .options(options);
        let (mut touching, mut lost, mut stored) = (0, 0.0, 0.0_f64);
        for _ in 0..200 {
            let before = motion.state().clone();
            motion.take(size)?;
            let after = motion.state();
            let energy =
                |state: &State<2>| assembler.functional(&of([0.0; 2]).energy(&state.value, &state.rate));
            let (u, start) = (&after.value, &before.value);
            let loss = match pressure {
                Pressure::Conserving => assembler.functional(&of([0.0; 2]).conserving_loss(u, start))?,
                Pressure::Hybrid => assembler.functional(&of([0.0; 2]).hybrid_loss(u, start))?,
            };
            let gain = energy(after)? - energy(&before)? + loss;
            assert!(gain < 1e-12 && (pressure == Pressure::Hybrid || gain > -1e-12), "{pressure:?} {gain:e}");
            assert!(loss >= 0.0);
            let mut pressed = false;
            for (axis, direction) in [[1.0, 0.0], [0.0, 1.0]].into_iter().enumerate() {
                let along = of(direction);
                let force = match pressure {
                    Pressure::Conserving => assembler.functional(&along.conserving_force(u, start))?,
                    Pressure::Hybrid => assembler.functional(&along.hybrid_force(u, start))?,
                };
                let momentum = |w: &Field<2>| assembler.functional(&along.momentum(w));
                let change = momentum(&after.rate)? - momentum(&before.rate)?;
                // Of unit mass.
                let off = change - size * (force + weight[axis]);
                assert!(off.abs() < 1e-12, "{pressure:?} {axis} {off:e}");
                pressed = axis == 1 && force > 0.0;
            }
            touching += usize::from(pressed);
            lost += loss;
            let at_rest = Field::zero(&space);
            stored = stored.max(assembler.functional(&of([0.0; 2]).energy(u, &at_rest))?);
        }
        assert!(touching > 5 && lost > 1e-3 && stored > 1e-2, "{pressure:?}: {touching} {lost} {stored}");
    }
    Ok(())
}

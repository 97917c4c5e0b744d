//! Nitsche's method with friction, every θ.

use forms_contact::laws::frictional_nitsche as law;
use forms_contact::theta_path::ThetaPath;
use forms_fem::prelude::*;
use forms_fem::verification;

use crate::block::{Block, plane_block, solid_block};
use crate::layer::{Answer, Inside, Layer, check, plane_layers, solid_layers};
use crate::setting::{Friction, LAMBDA, MU, THETAS, YOUNG, check_tangent, close, data, difference, wave};

fn model<const D: usize>(data: law::Data<D>) -> law::Model<D> {
    law::Model { data, regions: law::Regions::default().gamma_n("right").gamma_c("bottom") }
}

/// p = (λ + 2μ) δ/H; it sticks up to U* = κ p H/μ and slips by U − U* beyond. Steps from a state that has slipped count
/// from there: moved back by less than 2 U* the flat sticks where it is.
fn layers<const D: usize>(layer: &Layer<D>)
where
    Dim: Dimension<D>,
{
    const DOWN: f64 = 0.01;
    let pressure = (LAMBDA + 2.0 * MU) * DOWN;
    let bound = 0.3 * pressure;
    assert!((pressure - 2.692_307_692).abs() < 1e-8 && (bound - 0.807_692_307).abs() < 1e-8);
    let most = bound / MU;
    assert!((most - 0.0105).abs() < 1e-12);
    for theta in THETAS {
        for friction in [Friction::Coulomb(0.3), Friction::Tresca(bound)] {
            let label = format!("{D}D, theta = {theta}, {friction:?}");
            let mut data = data(friction, theta, 20.0 * YOUNG);
            let sticks = Answer { pressure, shear: 0.01 * MU, slip: 0.0 };
            check(&label, layer, model(data.clone()), [0.01, DOWN], sticks, 1e-12);
            let slips = Answer { pressure, shear: bound, slip: 0.02 - most };
            check(&label, layer, model(data.clone()), [0.02, DOWN], slips, 1e-12);
            let problem = layer.problem(model(data.clone()), 0.02, DOWN);
            let before = problem.direct().unwrap().solve().unwrap().into_field();
            data.displacement_before = Given::field(&before);
            let sticks = Answer { pressure, shear: MU * (0.005 - slips.slip), slip: slips.slip };
            check(&label, layer, model(data), [0.005, DOWN], sticks, 1e-12);
        }
    }
}

#[test]
fn a_layer_sticks_and_slips_as_known_in_the_plane() {
    plane_layers(Inside::Distorted).iter().for_each(layers);
}

#[test]
fn a_layer_sticks_and_slips_as_known_in_space() {
    solid_layers(Inside::Distorted).iter().for_each(layers);
}

/// θ = −1 is reached from θ = 1, which has no potential with friction, and is the solution of a direct start.
#[test]
fn a_path_through_theta() {
    let block = plane_block(8);
    let problem = block.problem(model(data(Friction::Coulomb(0.3), -1.0, 20.0 * YOUNG)), 0.01, 0.02);
    let options = NewtonOptions { relative_tolerance: 1e-12, ..NewtonOptions::default() };
    let expected = problem.from_stick().unwrap().solve().unwrap();
    let path = ThetaPath { line_search: LineSearch::OnResidual, ..ThetaPath::default() };
    let mut thetas = vec![];
    let found = problem.solve_through(path, &mut TangentSolver::default(), &options, |theta, step| {
        if step.iteration == 0 {
            thetas.push(theta);
        }
    });
    let found = found.unwrap().state;
    assert_eq!(thetas, [1.0, 0.0, -1.0]);
    for (found, expected) in found.values().iter().zip(expected.field().values()) {
        assert!((found - expected).abs() < 1e-11, "{found} is not {expected}");
    }
}

/// At random displacements, where points of all kinds are: open, stuck, slipping.
fn tangents<const D: usize>(block: &Block<D>)
where
    Dim: Dimension<D>,
{
    let u = wave(&block.space, 0.02, 0.4);
    let direction = wave(&block.space, 0.02, 2.3);
    for theta in THETAS {
        for friction in [Friction::Coulomb(1.5), Friction::Tresca(40.0)] {
            let data = data(friction, theta, 10.0 * YOUNG);
            let problem = block.problem(model(data), 0.0, 0.0);
            let model = &problem.law;
            let sizes = [
                problem.assembler.functional(&model.stick_length(&u)).unwrap(),
                problem.assembler.functional(&model.slip_length(&u)).unwrap(),
                problem.assembler.functional(&model.contact_length(&u)).unwrap(),
            ];
            // Of a base of length 2, or of 2 × 1.
            assert!(sizes[0] > 0.0 && sizes[1] > 0.0 && sizes[2] < 1.99, "{friction:?}: {sizes:?}");
            assert!((sizes[0] + sizes[1] - sizes[2]).abs() < 1e-12, "{sizes:?}");
            let label = format!("{D}D, theta = {theta}, {friction:?}");
            check_tangent(&label, &problem.assembler, &model.direct(), &[&u], &[&direction]);
        }
    }
}

#[test]
fn tangents_pass_their_taylor_test() {
    tangents(&plane_block(4));
    tangents(&solid_block());
}

/// θ = 1 with Tresca's law: the residual is the variation of the energy, and the tangent is symmetric. Coulomb's is not.
#[test]
fn trescas_law_with_theta_1_has_an_energy() {
    let block = plane_block(4);
    let u = wave(&block.space, 0.02, 0.4);
    let asymmetry = |friction, theta| {
        let model = model(data(friction, theta, 10.0 * YOUNG));
        let assembler = Assembler::new(&block.mesh).with_quadrature(Quadrature::Degree(4));
        assembler.tangent(&model.direct(), &[&u], &[&block.space]).unwrap().asymmetry().unwrap()
    };
    let tresca = Friction::Tresca(30.0);
    assert!(asymmetry(tresca, 1.0) < 1e-13, "{}", asymmetry(tresca, 1.0));
    assert!(asymmetry(tresca, 0.0) > 1e-3 && asymmetry(Friction::Coulomb(0.4), 1.0) > 1e-3);
    let model = model(data(tresca, 1.0, 10.0 * YOUNG));
    let assembler = Assembler::new(&block.mesh).with_quadrature(Quadrature::Degree(4));
    let residual = assembler.residual(&model.direct(), &[&u], &[&block.space]).unwrap();
    let varied = assembler.residual(&model.tresca_energy(), &[&u], &[&block.space]).unwrap();
    let scale = residual.iter().fold(0.0_f64, |largest, r| largest.max(r.abs()));
    for (a, b) in residual.iter().zip(&varied) {
        assert!((a - b).abs() < 1e-13 * scale, "{a} {b}");
    }
    // The energy itself, by differences: the residual's first-order term of it.
    let direction = wave(&block.space, 0.02, 2.3);
    let slope = residual.iter().zip(direction.values()).map(|(r, d)| r * d).sum::<f64>();
    let energy = model.tresca_energy();
    let report = verification::taylor(0.05, &[slope], |step| {
        let moved = Field::combination(&[(1.0, &u), (step, &direction)]).unwrap();
        assembler.energy(&energy, &[&moved]).map(verification::Sample::from)
    });
    assert!(report.unwrap().second_order().unwrap() > 1.95);
}

/// dJ/dκ and dJ/ds₀ through the adjoint state, where some points stick and some slip.
#[test]
fn adjoint_gradients_are_those_of_differences() {
    fn check<const D: usize>(block: &Block<D>)
    where
        Dim: Dimension<D>,
    {
        for theta in THETAS {
            for friction in [Friction::Coulomb(0.3), Friction::Tresca(0.6)] {
                let base = data(friction, theta, 20.0 * YOUNG);
                let solve = |data: law::Data<D>| {
                    let problem = block.problem(model(data), 0.008, 0.01);
                    let options = NewtonOptions {
                        relative_tolerance: 1e-13,
                        line_search: LineSearch::OnResidual,
                        ..NewtonOptions::default()
                    };
                    let solved = problem.direct().unwrap().options(options).solve().unwrap();
                    (problem, solved.into_field())
                };
                let (problem, u) = solve(base.clone());
                let p = problem.adjoint(&u).unwrap().solve().unwrap().into_field();
                let (assembler, law) = (&problem.assembler, &problem.law);
                let stuck = assembler.functional(&law.stick_length(&u)).unwrap();
                let slipped = assembler.functional(&law.slip_length(&u)).unwrap();
                assert!(stuck > 0.05 && slipped > 0.05, "{friction:?}: {stuck} sticks, {slipped} slips");
                let (gradient, size) = match friction {
                    Friction::Coulomb(size) => {
                        (assembler.functional(&law.by_friction(&u, &p)).unwrap(), size)
                    }
                    Friction::Tresca(size) => {
                        (assembler.functional(&law.by_slip_stress(&u, &p)).unwrap(), size)
                    }
                };
                let found = difference(2e-4 * size, |change| {
                    let mut data = base.clone();
                    match friction {
                        Friction::Coulomb(_) => data.friction += change,
                        Friction::Tresca(_) => data.slip_stress += change,
                    }
                    let (problem, u) = solve(data);
                    let set = problem.assembler.active_set(&problem.law.direct(), &[&u])?;
                    Ok((problem.criterion(&u)?, set))
                });
                close(&format!("{D}D, theta = {theta}, {friction:?}"), gradient, found, 1e-8);
            }
        }
    }
    check(&plane_block(4));
    check(&solid_block());
}

/// With θ = 1 the consistent adjoint is the discrete one; with other θ it is another, of a similar size. With every
/// θ its matrix is the discrete one's transposed where the law has an energy.
#[test]
fn the_consistent_adjoint_is_the_discrete_one_at_theta_1() {
    let block = plane_block(6);
    for friction in [Friction::Coulomb(0.3), Friction::Tresca(0.6)] {
        for theta in THETAS {
            let problem = block.problem(model(data(friction, theta, 20.0 * YOUNG)), 0.008, 0.01);
            let u = problem.direct().unwrap().solve().unwrap().into_field();
            let p = problem.adjoint(&u).unwrap().solve().unwrap().into_field();
            let form = problem.law.consistent_adjoint(&u);
            let consistent = problem.state(form, &u).unwrap().solve().unwrap().into_field();
            let size = p.values().iter().fold(0.0_f64, |most, p| most.max(p.abs()));
            let apart = p.values().iter().zip(consistent.values()).map(|(a, b)| (a - b).abs());
            let apart = apart.fold(0.0_f64, f64::max) / size;
            println!("theta = {theta}, {friction:?}: {apart:.1e} apart");
            assert!(if theta == 1.0 { apart < 1e-11 } else { apart > 1e-6 && apart < 0.5 });
            let adjoint =
                problem.assembler.tangent(&problem.law.consistent_adjoint(&u), &[&p], &[&block.space]);
            let tangent = problem.assembler.tangent(&problem.law.direct(), &[&u], &[&block.space]).unwrap();
            if matches!(friction, Friction::Tresca(_)) {
                let (a, b) = (adjoint.unwrap(), tangent);
                let largest = b.values().iter().fold(0.0_f64, |most, k| most.max(k.abs()));
                assert!(a.values().iter().zip(b.values()).all(|(a, b)| (a - b).abs() < 1e-13 * largest));
            }
        }
    }
}

/// A pressed and sheared block from zero, by the line search that the law asks for, for γ₀ = 10 E and 20 E: half of the cases take
/// at most 12 steps, nine in ten at most 20. How many the slowest takes, the last digits decide (24, 28); none needs the 50 that are allowed.
#[test]
fn newtons_method_converges_from_zero() {
    let block = plane_block(8);
    let mut steps = vec![];
    for theta in THETAS {
        for coefficient in [0.3, 0.6] {
            for over_young in [10.0, 20.0] {
                for aside in [0.003, 0.006, 0.02] {
                    let data = data(Friction::Coulomb(coefficient), theta, over_young * YOUNG);
                    let problem = block.problem(model(data), aside, 0.01);
                    steps.push(problem.direct().unwrap().solve().unwrap().iterations());
                }
            }
        }
    }
    steps.sort_unstable();
    let among = |part: usize, of: usize| steps[steps.len() * part / of];
    assert!(among(1, 2) <= 12 && among(9, 10) <= 20, "{steps:?}");
}

/// From stick it takes at most 16 steps in all cases, also for larger γ₀ and finer meshes, where from zero it takes more or goes
/// back and forth: which of the two, the last digits decide. FORMS_SWEEPS=1: three coefficients, three γ₀,
/// three ways to shear, three meshes.
#[test]
fn newtons_method_converges_from_stick() {
    let all = std::env::var_os("FORMS_SWEEPS").is_some();
    let (mut failed_from_zero, mut most_from_zero, mut most) = (0, 0, 0);
    for cells in if all { vec![8, 10, 16] } else { vec![8] } {
        let block = plane_block(cells);
        for theta in THETAS {
            for coefficient in [0.1, 0.3, 0.6] {
                for over_young in if all { vec![10.0, 20.0, 100.0] } else { vec![100.0] } {
                    for aside in if all { vec![0.003, 0.006, 0.02] } else { vec![0.006] } {
                        let data = data(Friction::Coulomb(coefficient), theta, over_young * YOUNG);
                        let problem = block.problem(model(data), aside, 0.01);
                        match problem.direct().unwrap().solve() {
                            Ok(solved) => most_from_zero = most_from_zero.max(solved.iterations()),
                            Err(_) => failed_from_zero += 1,
                        }
                        let mut solver = TangentSolver::default();
                        let solved = problem.from_stick().unwrap().solver(&mut solver).solve().unwrap();
                        most = most.max(solved.iterations());
                    }
                }
            }
        }
    }
    println!("{most} steps at most from stick; from zero {most_from_zero}, {failed_from_zero} failures");
    let harder_from_zero = failed_from_zero > 0 || most_from_zero > most;
    assert!(
        most <= 16 && harder_from_zero,
        "{most} steps; from zero {most_from_zero}, {failed_from_zero} failures"
    );
}

#[test]
fn parameters_out_of_range_are_named() {
    let block = plane_block(1);
    let good = data::<2>(Friction::Coulomb(0.3), 0.0, YOUNG);
    let error = |change: fn(&mut law::Data<2>)| {
        let mut data = good.clone();
        change(&mut data);
        let problem = block.problem(model(data), 0.0, 0.01);
        problem.direct().err().expect("an error").to_string()
    };
    assert_eq!(
        error(|data| data.friction = -0.1),
        "form `direct`: the parameter `friction` is -0.1; it must be zero or positive"
    );
    assert_eq!(
        error(|data| data.slip_stress = -2.0),
        "form `direct`: the parameter `slip_stress` is -2; it must be zero or positive"
    );
    assert_eq!(
        error(|data| data.gamma0 = 0.0),
        "form `direct`: the parameter `gamma0` is 0; it must be positive"
    );
}

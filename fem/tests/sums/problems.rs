//! Problems, histories, motions and eigenproblems of sums.

use forms_fem::prelude::*;
use forms_fem::time::{GeneralisedAlpha, State, Step, TimeLoop};
use forms_fem::verification;

use super::*;
use crate::time_schemes::{OSCILLATOR, Oscillator, cell, same};

/// Elasticity, contact and a load of three modules give the solution of one module, in as many steps of Newton's method.
#[test]
fn parts_of_several_modules_are_one_problem() -> Outcome {
    let (assembler, space) = setting()?;
    let mut held = Constraints::new(&space);
    held.fix("left", |_| [0.0; 2])?;
    let sum = solid().elasticity() + touch("bottom", 0.01) + load(Side::Top, 0.1);
    let pull = |x: &[f64; 2]| [0.1 * x[1], -0.1];
    let gap = |x: &[f64; 2]| 0.01 * (1.0 + x[0]);
    let data = whole::data().lambda(LAMBDA).mu(MU).theta(1.0).gamma0(GAMMA0).gap(gap).pull(pull);
    let one = whole::balance(
        &data,
        &whole::Omega::on("all"),
        &whole::Contact::on("bottom"),
        &whole::Loaded::on("top"),
    );
    let solve = |form: &Form<2>| Problem::new(form, &space).constrained(&held).assembler(&assembler).solve();
    let (found, expected) = (solve(&sum)?, solve(&one)?);
    assert!(expected.history.len() > 2);
    assert_eq!(found.history.len(), expected.history.len());
    let (found, expected) = (found.into_field(), expected.into_field());
    let size = expected.values().iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    let difference =
        found.values().iter().zip(expected.values()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    println!("solutions of size {size} differ by {difference:e}");
    assert!(size > 0.05 && difference < 1e-12 * size);

    // The same with a factor on everything, as weights of energies are.
    let scaled = solve(&(3.0 * &sum))?.into_field();
    let difference =
        scaled.values().iter().zip(expected.values()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(difference < 1e-12 * size);

    // On paths: the load grows.
    let path = forms_fem::solve::LoadSteps::uniform(3, 1.0).advance(Field::zero(&space), |step| {
        let form = solid().elasticity() + touch("bottom", 0.01) + step.factor * load(Side::Top, 0.1);
        let solved =
            Problem::new(&form, &space).constrained(&held).assembler(&assembler).increment(step).solve()?;
        Ok::<_, SolveError>(solved.into_field())
    });
    let reached = path.map_err(|error| error.to_string())?.state;
    let difference =
        reached.values().iter().zip(expected.values()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(difference < 1e-11 * size, "{difference:e}");
    Ok(())
}

/// A list of loads that is made at run time, from none to many.
#[test]
fn loads_are_chosen_at_run_time() -> Outcome {
    let (assembler, space) = setting()?;
    let u = wave(&space, 0.37, 0.03);
    let residual = |form: &Form<2>| assembler.residual(form, &[&u], &[&space]);
    let elasticity = solid().elasticity();
    for count in [0, 1, 3, 200] {
        let sides = [Side::Top, Side::Right];
        let loads: Vec<Form<2>> = (0..count).map(|k| load(sides[k % 2], 0.01 * k as f64)).collect();
        let sum = &elasticity + loads.iter().sum::<Form<2>>();
        let mut expected = vec![(1.0, residual(&elasticity)?)];
        for load in &loads {
            expected.push((1.0, assembler.linear_form(load, &space)?));
        }
        let (expected, size) = combined(&expected);
        assert_near(&residual(&sum)?, (expected, size * (1.0 + count as f64)));
        assert!(sum.is_affine());
        let found = residual(&loads.into_iter().fold(elasticity.clone(), |sum, load| sum + load))?;
        assert_same(&found, residual(&sum)?);
    }
    let name = |count: usize| {
        let loads = (0..count).map(|_| load(Side::Top, 1.0));
        (&elasticity + loads.sum::<Form<2>>()).name()
    };
    assert_eq!(
        [name(0), name(2), name(8)],
        ["elasticity", "elasticity + form + form", "elasticity + form + form + form + 5 more"]
    );
    assert_eq!((&elasticity - touch("bottom", 0.0)).name(), "elasticity - nitsche");

    // Loads that only tests read, and their sum, without a body.
    let loads = load(Side::Top, 1.0) - 2.0 * load(Side::Right, 0.5);
    let vectors =
        [load(Side::Top, 1.0), load(Side::Right, 0.5)].map(|load| assembler.linear_form(&load, &space));
    let [top, right] = vectors;
    assert_near(&assembler.linear_form(&loads, &space)?, combined(&[(1.0, top?), (-2.0, right?)]));
    Ok(())
}

/// The arguments in another order: pressure and velocity are matched by their numbers among unknowns and tests.
#[forms]
mod moving {
    pub struct Data {
        force: Given<Vector>,
        inertia: Param,
    }
    #[cells]
    pub struct Omega;

    pub fn convection(v: Test<Vector>, w: Unknown<Vector>, q: Test<Scalar>, p: Unknown<Scalar>) -> Form {
        integral(Omega, inertia * dot(grad(w) * w, v) + 0 * p * q)
    }
    pub fn gravity(v: Test<Vector>, q: Test<Scalar>) -> Form {
        integral(Omega, -dot(force, v) + 0 * q)
    }
}

#[test]
fn mixed_problems_match_fields_by_their_numbers() -> Outcome {
    let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 3], CellShape::Triangle, 1)?;
    let (velocities, pressures) = (Space::vector(&mesh, 2)?, Space::scalar(&mesh, 1)?);
    let spaces = [&velocities, &pressures];
    let flow = viscous::flow(&viscous::data().viscosity(0.7), &viscous::Omega::on("all"));
    let data = moving::data().force(|x: &[f64; 2]| [x[1], -x[0]]).inertia(3.0);
    let (convection, gravity) = (
        moving::convection(&data, &moving::Omega::on("all")),
        moving::gravity(&data, &moving::Omega::on("all")),
    );
    let assembler = Assembler::new(&mesh);
    let (u, p) = (wave(&velocities, 0.37, 0.4), wave(&pressures, 0.51, 0.3));
    for sum in
        [&flow + &convection + &gravity, &gravity + &convection + &flow, (&gravity + &flow) + &convection]
    {
        let residual = |form: &Form<2>| assembler.residual(form, &[&u, &p], &spaces);
        let parts = [residual(&flow)?, residual(&convection)?, assembler.residual(&gravity, &[], &spaces)?];
        assert_near(&residual(&sum)?, combined(&parts.map(|part| (1.0, part))));
        let directions = [&wave(&velocities, 0.91, 1.0), &wave(&pressures, 0.77, 1.0)];
        verification::tangent(&assembler, &sum, &[&u, &p], &directions, 1e-3)?.second_order()?;
        let mut walls = Constraints::new(&velocities);
        walls.fix("boundary", |x| [x[1] * (1.0 - x[1]), 0.0])?;
        let mut level = Constraints::new(&pressures);
        level.fix_nearest(&[0.0, 0.0], 0.0)?;
        let solved =
            Problem::new(&sum, spaces).start([&u, &p]).constrained(&walls).constrained(&level).solve()?;
        let at = [&solved.fields[0], &solved.fields[1]];
        let mut rest = assembler.residual(&sum, &at, &spaces)?;
        walls.homogeneous().apply(&mut rest[..velocities.unknowns()]);
        level.homogeneous().apply(&mut rest[velocities.unknowns()..]);
        assert!(rest.iter().all(|value| value.abs() < 1e-12));
    }
    Ok(())
}

#[forms(dimension = 2)]
mod creeping {
    pub struct Data {
        rate: Param,
        strain: History<Scalar>,
    }
    #[cells]
    pub struct Omega;

    pub fn creep(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, -rate * strain * v)
    }
    pub fn new_strain(u: Scalar) -> Scalar {
        strain + u
    }
}

/// Each part keeps its history: what is committed is read by the sum.
#[test]
fn histories_in_parts_are_read_and_committed() -> Outcome {
    let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 3], CellShape::Quadrilateral, 1)?;
    let (assembler, space) = (Assembler::new(&mesh), Space::scalar(&mesh, 1)?);
    let history = |value: f64| assembler.history(Entity::Cells, "all", 4, value);
    let parts =
        [creeping::data().rate(2.0).strain(history(1.0)?), creeping::data().rate(3.0).strain(history(0.5)?)];
    let omega = creeping::Omega::on("all");
    let mass = form!(|u: Unknown<Scalar>, v: Test<Scalar>| integral(cells("all"), u * v));
    let sum = &mass + parts.iter().map(|data| creeping::creep(data, &omega)).sum::<Form<2>>();
    let mut problem = Problem::new(&sum, &space).assembler(&assembler);
    let first = problem.solve()?.into_field();
    assert!(first.values().iter().all(|value| (value - 3.5).abs() < 1e-12));
    for data in &parts {
        assembler.update_history(&creeping::new_strain(data, &first), &data.strain)?;
        data.strain.commit();
    }
    // 2 (1 + 3.5) + 3 (0.5 + 3.5).
    let second = problem.solve()?.into_field();
    assert!(second.values().iter().all(|value| (value - 21.0).abs() < 1e-11));
    Ok(())
}

/// Oscillators of half the mass move as the whole one does; a shift of the stiffness by the mass shifts the eigenvalues.
#[test]
fn motions_and_eigenproblems_take_sums() -> Outcome {
    let space = cell()?;
    let run = |form: &dyn Fn(&Step<2>) -> Form<2>| -> Result<Vec<f64>, Box<dyn std::error::Error>> {
        let start = State::at_rest(0.0, same(&space, 1.0));
        let mut motion = TimeLoop::new(form, GeneralisedAlpha::trapezoidal(), start);
        for _ in 0..20 {
            motion.take(0.1)?;
        }
        Ok(motion.state().value.values().to_vec())
    };
    let Oscillator { mass, damping, stiffness, force } = OSCILLATOR;
    let halves = |share: f64| {
        let part = |value: f64| share * value;
        Oscillator {
            mass: part(mass),
            damping: part(damping),
            stiffness: part(stiffness),
            force: part(force),
        }
    };
    let whole = run(&|step| OSCILLATOR.form(0.8)(step).hardening())?;
    let sum = run(&|step| halves(0.25).form(0.8)(step).hardening() + halves(0.75).form(0.0)(step).motion())?;
    let scaled = run(&|step| 4.0 * halves(0.25).form(0.2)(step).hardening())?;
    for found in [sum, scaled] {
        assert!(
            found.iter().zip(&whole).all(|(found, whole)| (found - whole).abs() < 1e-12),
            "{found:?} {whole:?}"
        );
    }

    let mesh = rectangle([0.0; 2], [1.0; 2], [6; 2], CellShape::Quadrilateral, 1)?;
    let space = Space::scalar(&mesh, 2)?;
    let mut rim = Constraints::new(&space);
    rim.fix("boundary", |_| 0.0)?;
    let tension = form!(|u: Unknown<Scalar>, v: Test<Scalar>| integral(cells("all"), dot(grad(u), grad(v))));
    let mass = form!(|u: Unknown<Scalar>, v: Test<Scalar>| integral(cells("all"), u * v));
    let values = |stiffness: &Form<2>| -> Result<Vec<f64>, Box<dyn std::error::Error>> {
        let modes = Eigenproblem::vibration(stiffness, &mass, &space).constrained(&rim).smallest(3)?;
        Ok(modes.iter().map(|mode| mode.value).collect())
    };
    let (plain, shifted) = (values(&tension)?, values(&(2.0 * &tension + 3.0 * &mass))?);
    for (plain, shifted) in plain.iter().zip(shifted) {
        assert!((2.0 * plain + 3.0 - shifted).abs() < 1e-9 * shifted, "{plain} {shifted}");
    }
    Ok(())
}
